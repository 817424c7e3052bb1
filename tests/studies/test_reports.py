"""Pages: what they must say, and that the same rows give the same bytes."""

import re
from dataclasses import dataclass

import pytest

from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods.naming import MethodKey
from steadyload.reports.charts.front import front
from steadyload.reports.interactive import CostPoint
from steadyload.reports.pages.writing import write_page
from steadyload.reports.style import colour, face, marker
from steadyload.reports.table import (
    Column,
    Table,
    columns_for,
    estimates_table,
    markdown_table,
    milliseconds,
    percent,
    significant,
    words,
    yes_no,
)
from steadyload.runs.definition import load_study
from steadyload.runs.runner import run_study
from steadyload.statistics.estimate import Estimate
from steadyload.studies.engines.settings import engine_records
from steadyload.studies.engines.settings_page import engines_markdown
from steadyload.studies.report.comparing import compare
from steadyload.studies.report.study import RunReport


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A finished study with a static method and one tuning on three engines."""
    folder = tmp_path_factory.mktemp("study")
    write_layouts(folder / "layouts.json", random_layouts(6, seed=20), Format.NATIVE)
    (folder / "study.toml").write_text(
        'name = "small"\nlayouts = ["layouts.json"]\nscenarios = ["S1", "S2b"]\n'
        'methods = ["sme", "ps_opt-paper@bullet", "ps_opt-paper@mujoco", "ps_opt-paper@dart"]\n'
    )
    run_study(load_study(folder / "study.toml"), folder / "run")
    return folder / "run"


def test_a_page_names_engines_settings_and_what_was_ignored(run, tmp_path, undrawn):
    text = write_page(RunReport(directory=run).page(compare(run)), tmp_path).read_text()
    [beside] = tmp_path.glob("report-details.*.md")
    details = beside.read_text()
    tuning = details.partition("## The same tuning on every engine")[2].partition("\n## ")[0]
    rows = {line.split("|")[1].strip(): line for line in tuning.splitlines() if "|" in line}
    assert set(rows) >= {"bullet", "mujoco", "dart"}
    assert "restitution, broad_phase" in rows["mujoco"]
    assert "margin, broad_phase" in rows["dart"]
    assert rows["bullet"].rstrip(" |").endswith("-")
    assert "eps_t 22" in tuning
    assert "There are no reference labels on this page" in text
    assert "## Accuracy" not in text
    assert "## Made with" in text
    assert "mujoco" in text.partition("## Made with")[2]


@pytest.fixture(scope="module")
def drawn_twice(run, tmp_path_factory):
    """The page of the study in two folders."""
    folders = [tmp_path_factory.mktemp(name) for name in ("one", "two")]
    for folder in folders:
        write_page(RunReport(directory=run).page(compare(run)), folder)
    return folders


def test_every_picture_of_a_page_is_there_and_not_blank(drawn_twice, assert_drawn):
    folder, _ = drawn_twice
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", (folder / "report.md").read_text())
    assert len(pictures) >= 3
    for name in pictures:
        assert_drawn(folder / name)


def test_the_same_rows_give_the_same_bytes(drawn_twice):
    one, two = drawn_twice
    files = sorted(p.relative_to(one) for p in one.rglob("*.*"))
    assert files
    for name in files:
        assert (one / name).read_bytes() == (two / name).read_bytes()


def test_the_comparison_counts_by_hand(run):
    from steadyload.runs.results import load_results

    comparison = compare(run)
    frame = load_results(run)
    assert (comparison.cases, comparison.layouts, comparison.scenarios) == (12, 6, ("S1", "S2b"))
    pair = frame.pivot(index=["layout", "scenario"], columns="method", values="score")
    same = (pair["ps_opt-paper@bullet"] == pair["ps_opt-paper@mujoco"]).mean()
    titles = [m.spec for m in comparison.matrix.methods]
    i, j = titles.index("ps_opt-paper@bullet"), titles.index("ps_opt-paper@mujoco")
    assert comparison.matrix.shares[i][j].value == pytest.approx(same)
    (tuning,) = comparison.tunings
    agrees = next(own.agrees for own in tuning.rows if own.engine == "bullet")
    assert agrees["mujoco"].value == pytest.approx(same)
    disputed = (pair.nunique(axis=1) > 1).sum()
    assert comparison.disputed == disputed


def test_no_method_is_compared_with_itself(run, tmp_path, undrawn):
    comparison = compare(run)
    text = write_page(RunReport(directory=tmp_path).page(comparison), tmp_path).read_text()
    table = text.partition("## Agreement between every two methods")[2].partition("\n## ")[0]
    rows = [line.split("|")[2:-1] for line in table.splitlines() if line.startswith("| ")][2:]
    assert len(rows) == len(comparison.matrix.titles) == 4
    for at, cells in enumerate(rows):
        assert [place for place, cell in enumerate(cells) if cell.strip() == "-"] == [at]


def test_the_caption_of_a_chart_says_what_its_cells_are(run, tmp_path, undrawn):
    """The picture has shares that are equal; the chart in its place, cases that differ."""
    path = write_page(RunReport(directory=run).page(compare(run)), tmp_path)
    same, differ = "Share of cases on which two methods name the same", "Number of cases on which"
    assert same in path.read_text()
    assert differ not in path.read_text()
    page = path.with_suffix(".html").read_text()
    assert differ in page
    assert same not in page


@pytest.mark.engine("bullet")
def test_the_engine_page_states_every_answer():
    text = engines_markdown(engine_records())
    table = {
        line.split("|")[1].strip(): [c.strip() for c in line.split("|")[2:-1]]
        for line in text.splitlines()
        if line.startswith("|")
    }
    margin = dict(zip(table["setting"], table["margin"], strict=True))
    assert [margin[n] for n in ("bullet", "mujoco", "dart")] == ["honoured", "emulated", "ignored"]
    assert table["restitution"][table["setting"].index("mujoco")] == "emulated on request"


@pytest.mark.engine("bullet")
def test_the_published_engine_page_is_up_to_date():
    from pathlib import Path

    page = Path(__file__).parents[2] / "docs" / "engines.md"
    listed = engines_markdown(engine_records()) + "\n"
    assert page.read_text() == listed, "an engine or what it declares is new: run `make docs`"


def test_rules_against_simulations_are_disagreements(tmp_path, stack):
    """One simulation, or several that agree, do not make the rules' answers disappear."""
    # Two boxes of which the upper stands 6 of 10 cm out with its centre of mass over the lower.
    items = stack(0.0, 6.0, offset=-3.0)
    write_layouts(tmp_path / "layouts.json", [items], Format.NATIVE)
    (tmp_path / "s.toml").write_text(
        'layouts = ["layouts.json"]\n'
        'methods = ["fbs", "ps_opt-paper@bullet", "ps_opt-paper@mujoco"]\n'
    )
    run_study(load_study(tmp_path / "s.toml"), tmp_path / "run")
    comparison = compare(tmp_path / "run")
    assert comparison.disputed == len(comparison.disagreements) == 1
    assert list(comparison.disagreements[0].said.values()) == ["1", "stable", "stable"]


def test_an_unfinished_study_names_what_is_missing(run, tmp_path, undrawn):
    import shutil

    from steadyload.atomic import manifest_text
    from steadyload.runs.results import load_manifest, result_store

    shutil.copytree(run, tmp_path / "run")
    manifest = load_manifest(run) | {"finished": None}
    (tmp_path / "run" / "manifest.json").write_text(manifest_text(manifest))
    for shard in manifest["shards"][-1:]:
        result_store(tmp_path / "run").drop(shard)
    text = write_page(
        RunReport(directory=tmp_path / "run").page(compare(tmp_path / "run")), tmp_path / "page"
    ).read_text()
    assert "**Partial: 12 rows are still missing.**" in text
    assert "without ps_opt-paper@dart, which have judged none" in text


def test_numbers_read_the_same_everywhere():
    assert percent(Estimate(0.8356, 0.81, 0.859, 900)) == "83.6 [81.0, 85.9]"
    assert percent(None) == percent(Estimate(float("nan"), 0, 0, 0)) == "-"
    assert milliseconds(Estimate(0.01234, 0.012, 0.0131, 9)) == "0.0123 [0.0120, 0.0131]"
    assert [significant(v) for v in (1234.5, 12.345, 0.0012345, 0.0)] == [
        "1234", "12.3", "0.00123", "0",
    ]  # fmt: skip


def test_a_table_escapes_what_would_break_it():
    table = markdown_table(("a", "b"), [("x|y", "1\n2")])
    assert table.splitlines()[2] == "| x\\|y | 1 2 |"
    assert len({len(line) for line in table.splitlines()}) == 1


def test_a_declared_table_reads_as_the_same_rows_written_by_hand():
    rows = [
        CostPoint(
            MethodKey("SME", "sme", "sme"), Estimate(0.8, 0.7, 0.9, 100), Estimate(2, 1, 3, 9)
        ),
        CostPoint(MethodKey("a|b", "x", "x"), Estimate(0.5, 0.4, 0.6, 50), Estimate(1, 1, 1, 9)),
    ]
    columns = [
        Column("method", "method.title", left=True),
        Column("n", "share.n"),
        Column("accuracy %", "share", percent),
        Column("cheap", lambda row: row.cost.value < 2.0),
    ]
    assert str(Table(rows, columns)) == markdown_table(
        ("method", "n", "accuracy %", "cheap"),
        [("SME", "100", "80.0 [70.0, 90.0]", "False"), ("a|b", "50", "50.0 [40.0, 60.0]", "True")],
    )


def test_a_column_stands_for_every_key_that_rows_have():
    @dataclass
    class Row:
        name: str
        shares: dict

    rows = [
        Row("a", {"S1": Estimate(0.8, 0.7, 0.9, 9)}),
        Row("b", {"S2": Estimate(0.5, 0.4, 0.6, 9)}),
    ]
    columns = [
        words("name"),
        *columns_for(("S1", "S2"), "{} %", "shares", percent),
        *columns_for(("S1",), str.lower, lambda row, key: key in row.shares, yes_no),
    ]
    assert str(Table(rows, columns, "Shares:")) == "Shares:\n\n" + markdown_table(
        ("name", "S1 %", "S2 %", "s1"),
        [("a", "80.0 [70.0, 90.0]", "-", "yes"), ("b", "-", "50.0 [40.0, 60.0]", "no")],
    )


def test_estimates_by_name_are_a_table_of_their_own():
    found = {"half": Estimate(0.5, 0.4, 0.6, 9), "none": Estimate(0.0, 0.0, 0.1, 7)}
    assert str(estimates_table("part", found, "share %")) == markdown_table(
        ("part", "n", "share %"),
        [("half", "9", "50.0 [40.0, 60.0]"), ("none", "7", "0.0 [0.0, 10.0]")],
    )


def test_style_is_fixed_by_method_and_engine():
    known = MethodKey("PS_3", "ps3@bullet", "ps3", "bullet")
    assert (colour(known), marker(known)) == ("#1f77b4", "s")
    varied = MethodKey("PS_3 (friction=1)", "ps3@bullet:friction=1", "ps3", "bullet")
    assert (colour(varied), marker(varied)) == (colour(known), marker(known))
    assert (face(known), face(varied)) == (colour(known), "white")
    unknown = MethodKey("X", "x@y", "x", "y")
    assert (colour(unknown), marker(unknown)) == (colour(unknown), marker(unknown))


def test_times_within_a_decade_have_plain_ticks():
    key = MethodKey("SME", "sme", "sme", None)
    share = Estimate(0.8, 0.7, 0.9, 100)
    costs = [Estimate(ms, ms - 0.1, ms + 0.1, 100) for ms in (2.0, 4.0)]
    figure = front([{"method": key, "accuracy": share, "cpu": cost} for cost in costs]).figure
    figure.draw_without_rendering()
    [axes] = figure.axes
    labels = [label.get_text() for label in axes.xaxis.get_ticklabels(which="both")]
    assert "2" in labels
    assert not any("$" in label for label in labels)
