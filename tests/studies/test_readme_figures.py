"""README says what the published pages say."""

import re
import subprocess
import sys
import tarfile
from itertools import product
from pathlib import Path

import pandas as pd
import pytest

from steadyload.runs.costs import MARK

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
        "method", "paper %", "within 0.3 s %", "over / under %", "by class %",
        "CPU ms, mean / median / 90 %", "times SME", "stands %", "CPU ms",
    ]  # fmt: skip
    pages = {
        name: (PAGES / name / "report.md").read_text()
        for name in ("evaluation", "evaluation_stands")
    }
    titles, within = table(pages["evaluation"], "## Accuracy and cost")
    also, stands = table(pages["evaluation_stands"], "## Accuracy and cost")
    named, classes = table(pages["evaluation"], "## By class of items")
    timed, times = table(pages["evaluation"], "## Time a layout")
    columns = [timed.index(name) for name in ("CPU ms", "median CPU ms", "90 % CPU ms")]
    by_class = [k for k, title in enumerate(named) if title.startswith("class ")]
    assert len(by_class) == 3
    (details,) = (PAGES / "evaluation").glob("report-details.*.md")
    every, of_errors = table(details.read_text(), "## Accuracy and cost")
    wrong = [every.index(f"{how}estimated %") for how in ("over", "under")]
    for method, (_, paper, accuracy, errors, parts, cpu, sme, other, other_cpu) in rows.items():
        one = within[method]
        asked = stands.get(f"{method} (question=stands)") or stands[method]
        assert (paper, accuracy) == (one[titles.index("paper %")], one[titles.index("accuracy %")])
        assert errors == " / ".join(of_errors[method][k].split()[0] for k in wrong)
        assert parts == " / ".join(classes[method][k].split()[0] for k in by_class)
        assert cpu.split(" / ")[0] == one[titles.index("CPU ms")].split()[0]
        assert cpu == " / ".join(times[method][k].split()[0] for k in columns)
        assert sme == times[method][timed.index("times SME")].split()[0]
        assert other == asked[also.index("accuracy %")]
        assert other_cpu == asked[also.index("CPU ms")].split()[0]


def answers():
    """Answer and measured on, by question, of the table of the readme."""
    _, rows = table((ROOT / "README.md").read_text(), "| question")
    return {question: (answer, cases) for question, answer, cases in rows.values()}


def test_layouts_of_real_size_are_as_on_their_page():
    text = (PAGES / "evaluation_real" / "report.md").read_text()
    _, within, stands = text.split("\n## Accuracy and cost")
    readme = (ROOT / "README.md").read_text()
    (header, _, *lines) = readme[readme.index("| question | method ") :].splitlines()[:6]
    _, _, *sizes = (cell.strip() for cell in header.strip("|").split("|"))
    titles = {"`ps_opt@rapier`": "PS_opt @ rapier", "`cascade@rapier`": "Cascade @ rapier"}
    for line, (question, method) in zip(lines, product((within, stands), titles), strict=True):
        asked, own, *cells = (cell.strip() for cell in line.strip("|").split("|"))
        suffix = "" if question is within else " (question=stands)"
        assert (asked, own) == ("*stands*" if suffix else "*within*", method)
        title = titles[method] + suffix
        bins, accuracies = table(question, "Accuracy in per cent, by boxes, all scenarios:")
        _, times = table(question, "Mean CPU time a layout in ms, by boxes:")
        for size, cell in zip(sizes, cells, strict=True):
            boxes, cases = re.fullmatch(r"(.*) boxes \(n (\d+)\)", size).groups()
            at = bins.index(f"{boxes} (n {cases})")
            mean = times[title][at].split()[0]
            assert cell == f"{accuracies[title][at]} % in {mean} ms"


NUMBER = r"-?\d+(?:,\d{3})*(?:\.\d+)?"


@pytest.mark.parametrize("question", answers())
def test_every_figure_of_an_answer_is_on_a_page_that_it_links(question):
    answer, cases = answers()[question]
    pages = re.findall(r"\]\(((?:reports/published/\w+/report|docs/\w+)\.md)", answer)
    assert pages
    details = [f for page in pages for f in (ROOT / page).parent.glob("report-details.*.md")]
    text = "".join(path.read_text() for path in (*(ROOT / page for page in pages), *details))
    known = set(re.findall(NUMBER, re.sub(r"(\d) to ", r"\1, ", text)))
    figures = re.findall(
        NUMBER, re.sub(r"`[^`]*`|\[[^]]*\]\([^)]*\)|Zen \d", "", f"{answer} {cases}")
    )
    assert set(figures) - {"900", "95"} <= known  # those of the table above


@pytest.mark.parametrize("question", answers())
def test_every_share_of_an_answer_has_its_interval_and_cases_and_every_time_its_clock(question):
    answer, cases = answers()[question]
    stated = re.sub(r"\[[^]]*\]\([^)]*\)", "", answer)
    for before in re.findall(r"(\S+ \S+ \S+|^\S+) %", stated):
        assert before.endswith("]") or " to " in before, before
    assert re.search(r"\d", cases) or "known" in cases
    if re.search(r"\d\]? ms", stated):
        assert "CPU" in cases


def test_no_time_of_the_readme_was_taken_on_a_busy_machine():
    """Tables of cases have times of three pages; an answer has them where it states a clock."""
    timed = {"evaluation", "evaluation_stands", "evaluation_real"}
    for answer, cases in answers().values():
        if "CPU" in answer + cases:
            timed |= set(re.findall(r"reports/published/(\w+)/", answer))
    assert len(timed) > 3
    for name in timed:
        for page in (PAGES / name).glob("report*.md"):
            assert MARK not in page.read_text(), page


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
    within = {
        "sme": "SME", "equilibrium:time=0.3": "Equilibrium (time=0.3)", "lstm_e": "LSTM_e",
        "ps_opt@mujoco": "PS_opt @ mujoco", "cascade@mujoco": "Cascade @ mujoco",
    }  # fmt: skip
    for spec, name in within.items():
        assert rows[name][2].split()[0] == found[spec], spec
    assert rows["Cascade @ mujoco"][7].split()[0] == found["cascade@mujoco:question=stands"]
    real, _ = answers()["Which method for layouts of real size?"]
    for spec, words in (
        ("ps_opt@rapier", "For *within 0.3 s* `ps_opt@rapier` is right on {} ["),
        ("ps_opt@rapier:question=stands", "for *stands* on {} ["),
    ):
        assert words.format(found[f"{spec}, 25 to 61 boxes"]) in real
    engines, _ = answers()["Does the engine matter?"]
    engines = re.sub(r" \[[^]]*\]", "", engines)
    for sets, words in (
        (
            4,
            "our parameters {} % come with the parameters, {} % with the engine and {} % with both",
        ),
        (2, "`ps_opt-equal` and `label` alone {}, {} and {} %"),
    ):
        shares = found[f"parameters, engine, both; {sets} sets"].split(", ")
        assert words.format(*shares) in engines


def test_of_two_failing_steps_the_label_names_that_of_the_cascade():
    """The figures of docs/check.md, from the rows of the page of real size."""
    with tarfile.open(ROOT / "reports" / "rows" / "evaluation_real.tar.xz") as archive:
        read = {
            name: pd.read_parquet(archive.extractfile(name))
            for name in archive.getnames()
            if name.startswith("real/") and name.endswith(".parquet")
        }
    case = ["layout", "scenario"]
    labels = read.pop("real/labels.parquet").set_index(case)["failing_step_stands"]
    found = pd.concat(read.values()).pivot(index=case, columns="method", values="failing_step")
    balance, cascade = found["equilibrium"], found["cascade@rapier:question=stands"]
    later = (cascade > balance).fillna(False).to_numpy(bool)
    label = labels.reindex(found.index)
    right = [int((label[later] == own[later]).sum()) for own in (cascade, balance)]
    said = " ".join((ROOT / "docs" / "check.md").read_text().split())
    assert f"of the {later.sum()} cases of real size on which both" in said
    assert "agrees with the cascade on {} and with equilibrium on {}".format(*right) in said
    assert f"(test part, {len(found)} cases)" in said
