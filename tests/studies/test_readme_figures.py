"""README says what the published pages say."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "reports" / "published"


def table(text, start):
    """Cells by the first one, of the first table after some words."""
    found = re.search(r"(?:^\|.*\n)+", text[text.index(start) :], re.MULTILINE)
    header, _, *lines = (
        [cell.strip() for cell in line.strip("|").split("|")] for line in found[0].splitlines()
    )
    return header, {line[0]: line for line in lines}


def test_the_table_of_the_readme_is_that_of_the_published_pages():
    header, rows = table((ROOT / "README.md").read_text(), "## What came out")
    assert header == [
        "method", "paper %", "within 0.3 s %", "over / under %", "by class %", "CPU ms",
        "stands %", "CPU ms",
    ]  # fmt: skip
    pages = {
        name: (PAGES / name / "report.md").read_text()
        for name in ("evaluation", "evaluation_stands")
    }
    titles, within = table(pages["evaluation"], "## Accuracy and cost")
    also, stands = table(pages["evaluation_stands"], "## Accuracy and cost")
    named, classes = table(pages["evaluation"], "## By class of items")
    by_class = [k for k, title in enumerate(named) if title.startswith("class ")]
    assert len(by_class) == 3
    (details,) = (PAGES / "evaluation").glob("report-details.*.md")
    every, of_errors = table(details.read_text(), "## Accuracy and cost")
    wrong = [every.index(f"{how}estimated %") for how in ("over", "under")]
    for method, (_, paper, accuracy, errors, parts, cpu, other, other_cpu) in rows.items():
        one = within[method]
        asked = stands.get(f"{method} (question=stands)") or stands[method]
        assert (paper, accuracy) == (one[titles.index("paper %")], one[titles.index("accuracy %")])
        assert errors == " / ".join(of_errors[method][k].split()[0] for k in wrong)
        assert parts == " / ".join(classes[method][k].split()[0] for k in by_class)
        assert cpu == one[titles.index("CPU ms")].split()[0]
        assert other == asked[also.index("accuracy %")]
        assert other_cpu == asked[also.index("CPU ms")].split()[0]


def test_every_figure_of_an_answer_of_the_readme_is_on_the_page_that_it_links():
    _, rows = table((ROOT / "README.md").read_text(), "| question")
    told = 0
    for question, answer in rows.values():
        pages = re.findall(r"\]\(((?:reports/published/\w+/report|docs/\w+)\.md)", answer)
        assert pages, question
        figures = re.findall(r"\d+(?:\.\d+)?", re.sub(r"`[^`]*`|\[[^]]*\]\([^)]*\)", "", answer))
        text = "".join((ROOT / page).read_text() for page in pages)
        known = set(re.findall(r"\d+(?:\.\d+)?", text))
        assert set(figures) <= known, question
        told += len(figures)
    assert told > 15
