"""README says what the published pages say."""

import re
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

from steadyload.runs.costs import MARK

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "reports" / "published"


README = (ROOT / "README.md").read_text()
NUMBER = r"-?\d+(?:,\d{3})*(?:\.\d+)?"


def page(name):
    """A published page, with the tables and sections of its file of details."""
    return "".join(
        file.read_text()
        for form in ("report.md", "report-details.*.md")
        for file in (PAGES / name).glob(form)
    )


def tables(text):
    """Rows of every table of a text, by title of their columns."""
    for found in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
        header, _, *lines = (
            [cell.strip() for cell in line.strip("|").split("|")] for line in found.splitlines()
        )
        yield [dict(zip(header, line, strict=False)) for line in lines]


def of_method(text, method, column):
    """What the first table with this column says of a method."""
    for rows in tables(text):
        for row in rows:
            if row.get("method") == method and column in row:
                return row[column]
    raise AssertionError(f"no table has {column!r} of {method!r}")


RESULTS = next(rows for rows in tables(README) if "paper %" in rows[0])


@pytest.mark.parametrize("row", RESULTS, ids=lambda row: row["method"])
def test_the_table_of_the_readme_is_that_of_the_published_pages(row):
    within, stands = page("evaluation"), page("evaluation_stands")
    method = row["method"]
    other = f"{method} (question=stands)"
    other = other if other in stands else method
    assert list(row) == ["method", "paper %", "within 0.3 s %", "stands %", "median CPU ms"]
    assert row["paper %"] == of_method(within, method, "paper %")
    assert row["within 0.3 s %"] == of_method(within, method, "accuracy %")
    assert row["stands %"] == of_method(stands, other, "accuracy %")
    assert row["median CPU ms"] == of_method(within, method, "median CPU ms").split()[0]


def test_the_readme_is_a_screen_and_a_half():
    assert len(README.split()) <= 900
    assert len(RESULTS) == 6
    assert all(len(re.findall(r"\[[^]]*\]", cell)) <= 1 for row in RESULTS for cell in row.values())


FINDINGS = re.findall(r"^- .*$", README[README.index("## What came out") :], re.MULTILINE)


@pytest.mark.parametrize("finding", FINDINGS)
def test_a_finding_is_one_sentence_with_one_interval_and_one_page(finding):
    assert len(FINDINGS) == 6
    (name,) = re.findall(r"\]\(reports/published/(\w+)/report\.md\)", finding)
    (interval,) = re.findall(rf"{NUMBER} \[[^]]*\]", finding)
    assert interval in page(name)
    assert len(re.findall(r"[.?!](?:\s|$)", finding)) == 1


def paragraphs():
    """Paragraphs of the readme that have a number, and the tables that are no results."""
    text = re.sub(r"```.*?```", "", README, flags=re.DOTALL)
    for block in re.split(r"\n\n|\n(?=- )", text):
        words = re.sub(r"`[^`]*`|\]\([^)]*\)|Zen \d|[A-Za-z_]\w*|Python 3.*?3\.11 alone", "", block)
        if re.search(NUMBER, words) and "median CPU ms" not in block and "![" not in block:
            yield block, set(re.findall(NUMBER, words))


@pytest.mark.parametrize(("block", "figures"), list(paragraphs()))
def test_every_number_of_the_readme_is_on_a_page_that_its_paragraph_links(block, figures):
    names = re.findall(r"\]\((?:reports/published/(\w+)/report|(docs/\w+))\.md", block)
    known = "".join(
        page(name) if name else (ROOT / f"{file}.md").read_text() for name, file in names
    )
    known = {float(number.replace(",", "")) for number in re.findall(NUMBER, known)}
    found = {float(number.replace(",", "")) for number in figures}
    assert found <= known | {round(number) for number in known}


def test_a_picture_of_the_readme_is_there_and_is_the_leading_one_of_its_page():
    pictures = re.findall(r"!\[[^]]*\]\(([^)]*)\)", README)
    assert len(pictures) == 2
    assert all((ROOT / picture).is_file() for picture in pictures)
    leading = re.search(r"!\[[^]]*\]\((figures/[^)]*)\)", page("evaluation"))
    assert pictures[1] == f"reports/published/evaluation/{leading[1]}"


def test_no_time_of_the_readme_was_taken_on_a_busy_machine():
    for name in ("evaluation", "evaluation_stands"):
        assert MARK not in page(name)


def test_a_script_without_this_package_recomputes_ten_figures():
    script = ROOT / "docs" / "recompute.py"
    text = script.read_text()
    assert text.count("\n") <= 55
    assert not re.search(r"^\s*(?:from|import) steadyload", text, re.MULTILINE)
    ran = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    found = dict(line.rsplit(": ", 1) for line in ran.stdout.splitlines())
    assert len(found) == 10
    lists, real, engines = page("evaluation"), page("evaluation_real"), page("engines")
    within = {
        "sme": "SME", "equilibrium:time=0.3": "Equilibrium (time=0.3)", "lstm_e": "LSTM_e",
        "ps_opt@mujoco": "PS_opt @ mujoco", "cascade@mujoco": "Cascade @ mujoco",
    }  # fmt: skip
    for spec, name in within.items():
        assert of_method(lists, name, "accuracy %").split()[0] == found[spec], spec
    assert (
        of_method(page("evaluation_stands"), "Cascade @ mujoco (question=stands)", "accuracy %")
        .split()[0] == found["cascade@mujoco:question=stands"]
    )  # fmt: skip
    for spec in ("ps_opt@rapier", "ps_opt@rapier:question=stands"):
        assert f"{found[f'{spec}, 25 to 61 boxes']} [" in real, spec
    for sets in (4, 2):
        shares = found[f"parameters, engine, both; {sets} sets"].split(", ")
        assert all(f"{share} [" in engines for share in shares), sets


def test_a_question_that_no_page_asks_is_answered_from_the_rows():
    script = ROOT / "docs" / "own_question.py"
    assert script.read_text().count("\n") <= 22
    ran = subprocess.run(
        [sys.executable, script], capture_output=True, text=True, check=True, cwd=ROOT
    )
    head, *rest = ran.stdout.splitlines()
    assert head.split() == ["class", "1", "2", "3"]
    assert [line.split()[0] for line in rest[1:]] == ["bullet", "dart", "mujoco", "physx", "rapier"]
    assert all(len(re.findall(r"[\d.]+% \[[\d.]+%, [\d.]+%\]", line)) == 3 for line in rest[1:])


def test_of_two_failing_steps_the_label_names_that_of_the_cascade():
    """The figures of docs/check.md, from the rows of the page of real size."""
    rows = pd.read_parquet(ROOT / "reports" / "rows" / "evaluation_real.parquet")
    rows = rows[rows["run"] == "real"]
    case = ["layout", "scenario"]
    labels = rows.drop_duplicates(case).set_index(case)["label_stands"]
    found = rows.pivot(index=case, columns="method", values="failing_step")
    balance, cascade = found["equilibrium"], found["cascade@rapier:question=stands"]
    later = (cascade > balance).fillna(False).to_numpy(bool)
    label = labels.reindex(found.index)
    right = [int((label[later] == own[later]).sum()) for own in (cascade, balance)]
    said = " ".join((ROOT / "docs" / "check.md").read_text().split())
    assert f"of the {later.sum()} cases of real size on which both" in said
    assert "agrees with the cascade on {} and with equilibrium on {}".format(*right) in said
    assert f"(test part, {len(found)} cases)" in said
