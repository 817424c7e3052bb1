"""The page on wrong input states the limits that there are."""

from pathlib import Path

from steadyload import reading
from steadyload.layouts.files import limits

PAGE = Path(__file__).parents[2] / "docs" / "wrong_input.md"


def test_the_page_states_every_limit_as_it_is():
    rows = [line for line in PAGE.read_text().splitlines() if "`MAX_" in line]
    stated = {}
    for row in rows:
        most, name = (cell.strip() for cell in row.strip("| ").split("|")[1:])
        number, _, unit = most.partition(" ")
        stated[name.strip("`")] = int(number.replace(",", "")) * (1024**2 if unit == "MiB" else 1)
    known = {**vars(limits), **vars(reading)}
    assert stated == {name: most for name, most in known.items() if name.startswith("MAX_")}
