"""Tables in a pipe are those of Rich, which takes far longer, on a terminal without an end."""

from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console
from rich.table import Table

from steadyload.cli.terminal import _aligned

CELL = st.text(st.sampled_from("ab .,-%äß木箱"), max_size=12)


@settings(deadline=None)
@given(rows=st.integers(1, 4).flatmap(lambda n: st.lists(st.tuples(*[CELL] * n), min_size=1)))
def test_a_table_in_a_pipe_is_that_of_rich(rows):
    header = tuple(f"title {k}" for k in range(len(rows[0])))
    table = Table(*header, box=None, pad_edge=False)
    for row in rows:
        table.add_row(*row)
    console = Console(width=4000, highlight=False, markup=False)
    with console.capture() as capture:
        console.print(table)
    expected = [line.rstrip() for line in capture.get().splitlines()]
    assert _aligned([header, *rows]).split("\n") == expected
