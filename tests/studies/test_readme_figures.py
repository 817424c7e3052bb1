"""README says what the published pages say."""

import re
import subprocess
import sys
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


def test_a_script_without_this_package_recomputes_ten_figures():
    script = ROOT / "docs" / "recompute.py"
    text = script.read_text()
    assert text.count("\n") <= 60
    assert not re.search(r"^\s*(?:from|import) steadyload", text, re.MULTILINE)
    ran = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    found = dict(line.rsplit(": ", 1) for line in ran.stdout.splitlines())
    assert len(found) == 10
    readme = (ROOT / "README.md").read_text()
    _, rows = table(readme, "## What came out")
    _, answers = table(readme, "| question")
    within = {
        "sme": "SME", "equilibrium:time=0.3": "Equilibrium (time=0.3)", "lstm_e": "LSTM_e",
        "ps_opt@mujoco": "PS_opt @ mujoco", "cascade@mujoco": "Cascade @ mujoco",
    }  # fmt: skip
    for spec, name in within.items():
        assert rows[name][2].split()[0] == found[spec], spec
    assert rows["Cascade @ mujoco"][6].split()[0] == found["cascade@mujoco:question=stands"]
    _, real = answers["Which method for layouts of real size?"]
    for spec, words in (
        ("ps_opt@rapier", "for *within 0.3 s* `ps_opt@rapier` is right on {} %"),
        ("ps_opt@rapier:question=stands", "for *stands* on {} %"),
    ):
        assert words.format(found[f"{spec}, real size"]) in real
    _, engines = answers["Does the engine matter?"]
    for sets, words in (
        (
            4,
            "our parameters {} % come with the parameters, {} % with the engine and {} % with both",
        ),
        (2, "`ps_opt` and `label` alone {}, {} and {} %"),
    ):
        shares = found[f"parameters, engine, both; {sets} sets"].split(", ")
        assert words.format(*shares) in engines
