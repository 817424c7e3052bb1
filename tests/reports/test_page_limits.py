"""Every published page begins with its answer, a figure of it, and how it was found."""

import re
from pathlib import Path

import pytest

PAGES = Path(__file__).parents[2] / "reports" / "published"
FOLDERS = sorted(page.parent.name for page in PAGES.glob("*/report.md"))
NUMBER = re.compile(r"(?<![\w.])\d+(?:,\d{3})*(?:\.\d+)?")
"""A number; digits of a name, as in PS_3 or R1, are none."""


def numbers(paragraph):
    """All numbers of a paragraph, outside of code and of addresses of links."""
    return NUMBER.findall(re.sub(r"`[^`]*`|\]\([^)]*\)", "", paragraph))


def faults(text):
    """The limits of the first blocks of a page that its text does not keep."""
    blocks = [*text.strip().split("\n\n"), *[""] * 5]
    title, answer, figure, caption, method = blocks[:5]
    if not caption.startswith("*"):  # the picture may stand without its caption
        method = caption
    return [
        fault
        for fault, holds in {
            "block 1 is the title": title.startswith("# ") and "\n" not in title,
            "block 2 is one paragraph": re.match(r"[\w`*\[]", answer) and "\n" not in answer,
            f"block 2 has at most 60 words: {len(answer.split())}": len(answer.split()) <= 60,
            f"block 2 has at most 6 numbers: {numbers(answer)}": len(numbers(answer)) <= 6,
            "block 3 is a figure": figure.startswith("!["),
            "block 4 is one paragraph": re.match(r"[\w`*\[]", method) and "\n" not in method,
            f"block 4 has at most 120 words: {len(method.split())}": len(method.split()) <= 120,
        }.items()
        if not holds
    ]


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_page_begins_with_its_answer_one_figure_and_its_method(folder):
    found = faults((PAGES / folder / "report.md").read_text())
    assert not found, found


def unfounded(text, details):
    """Measured figures of the answer of a page, with a decimal point, that nothing below has."""
    _, answer, *below = text.split("\n\n")
    known = numbers("\n\n".join([*below, details]))
    return [number for number in numbers(answer) if "." in number and number not in known]


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_figure_of_an_answer_stands_below_it_or_in_the_details(folder):
    page = PAGES / folder
    details = "".join(file.read_text() for file in page.glob("report-details.*.md"))
    assert unfounded((page / "report.md").read_text(), details) == []


def test_a_figure_that_only_the_answer_has_is_found():
    text = "# A?\n\n97.0 [95.4, 98.0] % of 900.\n\n| 97.0 [95.4, 98.1] |\n"
    assert unfounded(text, "") == ["98.0"]
    assert unfounded(text, "| 98.0 |") == []


FIGURE = "![Accuracy.](figures/a.svg)\n\n*Accuracy.*"


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (f"# Is it so?\n\nYes, by PS_3 `x=1`.\n\n{FIGURE}\n\nOn 900 cases.\n\n## More\n", None),
        (f"# Is it so?\n\n{FIGURE}\n\nOn cases.\n", "block 2 is one paragraph"),
        (f"# Is it so?\n\n{'so ' * 61}\n\n{FIGURE}\n\nOn cases.\n", "at most 60 words: 61"),
        (f"# A?\n\n97.0 [9, 1,000] % of 30 to 40, 2 ms.\n\n{FIGURE}\n\nOn.\n", None),
        (f"# A?\n\n9 [9, 1] % of 3 to 4, 2 ms, 1.\n\n{FIGURE}\n\nOn.\n", "at most 6 numbers"),
        ("# A?\n\nYes.\n\nOn 900 cases.\n\n## More\n", "block 3 is a figure"),
        (f"# A?\n\nYes.\n\n{FIGURE}\n\n## More\n", "block 4 is one paragraph"),
        (f"# A?\n\nYes.\n\n{FIGURE}\n\n{'on ' * 121}\n", "at most 120 words: 121"),
    ],
)
def test_a_page_that_keeps_no_limit_is_found(text, fault):
    found = faults(text)
    assert [f for f in found if fault in f] if fault else not found
