"""Tables in a pipe are those of Rich, which takes far longer, on a terminal without an end."""

from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console
from rich.table import Table

from steadyload.cli.score_tables import _row
from steadyload.cli.terminal import _aligned, _folded

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


def test_a_table_on_a_terminal_has_no_colours_but_of_its_titles(monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    told = _folded(("name", "score"), [("[red]one[/red]", "0.75"), ("'two'", "True")])
    titles, *rows = told.split("\n")
    assert "\x1b[1m" in titles
    assert [row.split() for row in rows] == [["[red]one[/red]", "0.75"], ["'two'", "True"]]


def test_shares_of_uncertain_verdicts_are_in_per_cent():
    record = {
        "layout": "one", "method": "sme", "items": 3, "score": 1.0, "failing_step": None,
        "status": "done", "reason": "", "failing_box": None,
    }  # fmt: skip
    found = {
        "stands": 0.875, "interval": (0.5, 0.9375), "distribution": {"none": 0.875, "1": 0.125},
        "expected_score": 0.9, "samples": 16, "wall_seconds": 0.25, "status": "done",
        "without_verdict": {}, "ending": "narrow", "why": "",
    }  # fmt: skip
    cells = _row(record, found)
    assert cells[5:10] == ("87.5 [50.0, 93.8]", "none (88 %), 2 (12 %)", "0.900", "16", "0.25")
