"""The page of tuning: it says what its records hold, and nothing of what they do not."""

import re
from pathlib import Path

from steadyload.methods.tuned import TUNED, tuned


def test_the_published_page_and_docs_give_the_start_as_its_rows_do():
    root = Path(__file__).parents[2]
    published = (root / "reports" / "published" / "tuning" / "report.md").read_text()
    docs = (root / "docs" / "tuning.md").read_text()
    rows = re.findall(r"^\| start of the search @ (\w+) +\|(.*)", published, re.MULTILINE)
    assert {engine for engine, _ in rows} == set(tuned()[TUNED])
    for engine, row in rows:
        accuracy, gain = (cell.strip() for cell in row.split("|")[1:3])
        assert f"{gain} points on {engine}" in published
        if engine != "chipmunk":
            assert re.search(rf"{accuracy.split()[0]} % \({engine}\)", docs, re.I)
