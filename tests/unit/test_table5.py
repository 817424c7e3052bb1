"""Table 5: every method on the same cases, judged once, timed apart, and told with its n."""

import re

import pandas as pd
import pytest

from harness.cli import main
from harness.layouts.benchmark import load_benchmark
from harness.methods.registry import make_method
from harness.studies.front import measured_in
from harness.studies.table5 import study as table5
from harness.studies.table5.study import Questions

SPECS = ("fbs", "sme", "equilibrium")
FEW = ("--limit", "3", "--timed", "2", "--repeats", "1", "-j", "1")
ASKED = ("table5", *(word for spec in SPECS for word in ("-m", spec)), *FEW, "--views", "1")


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The folder of a page, and of what it was made from."""
    folder = tmp_path_factory.mktemp("table5")
    assert main([*ASKED, "--work", str(folder / "work"), "-o", str(folder / "page")]) == 0
    return folder


def rows(text, heading):
    """Cells of the first table below a heading, header first."""
    table = re.search(r"(?:^\|.*\n)+", text[text.index(heading) :], re.MULTILINE)
    header, _, *lines = table[0].splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in (header, *lines)]


def test_accuracies_are_those_of_the_methods_on_the_labels(written):
    text = (written / "page" / "report.md").read_text()
    benchmark = load_benchmark()
    chosen = benchmark.select("test", limit=3)
    header, *lines = rows(text, "## Accuracy and cost")
    told = {line[0]: dict(zip(header, line, strict=True)) for line in lines}
    for spec, title in zip(SPECS, ("FBS", "SME", "Equilibrium"), strict=True):
        method, right = make_method(spec), 0
        for name, scenario, label in zip(
            chosen["layout"], chosen["scenario"], chosen["failing_step"], strict=True
        ):
            said = method.judge(benchmark.layout(name, scenario)).failing_step
            right += said == (None if pd.isna(label) else label)
        assert told[title]["n"] == "9"
        assert told[title]["accuracy %"].startswith(f"{100 * right / 9:.1f} [")


def test_all_tables_say_how_many(written):
    text = (written / "page" / "report.md").read_text()
    headers = re.findall(r"^\| .*(?=\n\| -)", text, re.MULTILINE)
    assert len(headers) > 8
    for header in headers:
        cells = [cell.strip() for cell in header.strip("|").split("|")]
        # Where a row is a layout, the row is what is counted.
        assert "n" in cells or "(n " in header or cells[0] == "layout"


def test_a_case_to_watch_is_linked_where_it_was_written(written):
    text = (written / "page" / "report.md").read_text()
    linked = dict(re.findall(r"\[(\w+)\]\((views/\w+\.html)\)", text))
    assert len(linked) == 1
    for layout, view in linked.items():
        page = (written / "page" / view).read_text()
        assert layout in page
        assert "THREE" in page
        # The case is among those that the methods part on, and both sides are played.
        row = next(line for line in text.splitlines() if f"[{layout}]" in line)
        right, wrong = (row.split("|")[k].strip() for k in (5, 6))
        for title in (right, wrong.split(":")[0]):
            assert title.lower() in page.lower()


def test_a_method_is_recommended_by_the_times_of_the_timing_pass(written):
    text = (written / "page" / "report.md").read_text()
    header, *lines = rows(text, "## Accuracy and cost")
    told = {line[0]: dict(zip(header, line, strict=True)) for line in lines}
    front = measured_in(written / "work")
    assert [m.title for m in front.measured] == ["FBS", "SME", "Equilibrium"]
    for entry in front.measured:
        shown = told[entry.title]
        assert shown["accuracy %"].startswith(f"{100 * entry.accuracy.value:.1f} [")
        cpu = next(cell for name, cell in shown.items() if name.startswith("CPU"))
        assert float(cpu.split()[0]) == pytest.approx(entry.cpu.value, rel=0.01)
    assert front.about["measured on"].startswith("part test, 9 cases")


def test_an_interrupted_run_goes_on_to_the_same_page(written):
    again = [*ASKED, "--work", str(written / "work"), "-o", str(written / "again")]
    (written / "again").mkdir()
    shards = sorted((written / "work").rglob("results/*.parquet"))
    shards[0].unlink()
    assert main(again) == 0
    pages = [(written / name / "report.md").read_text() for name in ("page", "again")]
    first, second = (page[: page.index("## Made with")] for page in pages)
    assert second == first


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("-m", "ps3@chipmunk"), "none judges layouts in space"),
        (("-m", "smee"), "did you mean 'sme'"),
        (("-m", "cascade@dart"), "cascade@dart"),
    ],
)
def test_a_method_that_cannot_judge_is_an_error_where_it_is_named(
    capsys, tmp_path, arguments, message
):
    assert main(["table5", *arguments, *FEW, "--work", str(tmp_path / "work")]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "work").exists()


def test_a_method_that_cannot_judge_is_left_out_where_nobody_named_it(monkeypatch):
    monkeypatch.setattr(table5, "METHODS", ("sme", "cascade@dart"))
    asked = Questions()
    assert asked.spatial == ("sme",)
    assert "steadyload cascade fit --engine dart" in asked.left_out["cascade@dart"]
