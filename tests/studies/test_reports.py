"""Methods compared on a run; the same rows give the same bytes; how numbers and tables read."""

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from steadyload.atomic import manifest_text
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods.naming import MethodKey
from steadyload.reports.charts.front import front
from steadyload.reports.pages.writing import write_page
from steadyload.reports.style import colour, face, marker
from steadyload.reports.table import (
    Column,
    Table,
    columns_for,
    compact,
    markdown_table,
    milliseconds,
    percent,
    significant,
    yes_no,
)
from steadyload.runs.definition import load_study
from steadyload.runs.results import load_manifest, load_results, result_store
from steadyload.runs.runner import run_study
from steadyload.statistics.estimate import Estimate
from steadyload.studies.engines.settings_page import engine_records, engines_markdown
from steadyload.studies.report.comparing import compare
from steadyload.studies.report.study import RunReport

CUBE = (10.0, 10.0, 10.0)
HANGING = Layout(
    "hanging",
    Pallet(100.0, 100.0, 100.0),
    (Item(0, (40.0, 0.0, 40.0), CUBE, 1.0), Item(1, (44.0, 10.0, 40.0), CUBE, 1.0)),
)
"""The upper cube is not fully supported, and stands."""
BULLET, MUJOCO, DART = (f"ps_opt-paper@{engine}" for engine in ("bullet", "mujoco", "dart"))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A finished study with a static method and one tuning on three engines."""
    folder = tmp_path_factory.mktemp("study")
    layouts = [HANGING, *random_layouts(5, seed=20)]
    write_layouts(folder / "layouts.json", layouts, Format.NATIVE)
    (folder / "study.toml").write_text(
        'name = "small"\nlayouts = ["layouts.json"]\nscenarios = ["S1", "S2b"]\n'
        f'methods = ["fbs", "{BULLET}", "{MUJOCO}", "{DART}"]\n'
    )
    run_study(load_study(folder / "study.toml"), folder / "run")
    return folder / "run"


@pytest.fixture(scope="module")
def found(run):
    return compare(run)


def test_the_comparison_counts_by_hand(run, found):
    frame = load_results(run)
    assert (found.cases, found.layouts, found.scenarios) == (12, 6, ("S1", "S2b"))
    said = frame.assign(failing_step=frame["failing_step"].fillna(-1)).pivot(
        index=["layout", "scenario"], columns="method", values="failing_step"
    )
    same = (said["fbs"] == said[BULLET]).mean()
    assert 0.0 < same < 1.0
    agree = found.agree["agrees:PS_opt, paper @ bullet"]
    assert agree["fbs"].value == pytest.approx(same)
    assert agree.index[agree.isna()].tolist() == [BULLET]
    assert found.disputed == (said.nunique(axis=1) > 1).sum()
    assert found.labelled is None
    for spec, own in found.rows.iterrows():
        rows = frame[frame["method"] == spec]
        assert own["fully_stable"].value == pytest.approx((rows["score"] == 1.0).mean())
        assert own["score"].value == pytest.approx(rows["score"].mean())
        others = {BULLET, MUJOCO, DART} - {spec}
        agreement = np.mean([(said[spec] == said[other]).mean() for other in others])
        assert own["agreement"].value == pytest.approx(agreement)


def test_settings_that_an_engine_does_not_honour_are_named(run, found):
    (tuning,) = found.tunings
    rows = tuning["rows"].set_index("engine")
    assert dict(rows["ignored"]) == {
        "bullet": "-", "mujoco": "restitution, broad_phase", "dart": "margin, broad_phase",
    }  # fmt: skip
    scores = load_results(run).pivot(index=["layout", "scenario"], columns="method", values="score")
    same = (scores[BULLET] == scores[MUJOCO]).mean()
    assert rows["agrees_with:mujoco"]["bullet"].value == pytest.approx(same)
    assert rows["agrees_with:bullet"]["bullet"] is None
    assert "eps_t 22" in tuning["settings"]
    assert "mujoco" in found.made_with["versions"]


def test_rules_against_simulations_are_disagreements(found):
    """Simulations that agree do not make the rules' answers disappear."""
    cases = found.disagreements.set_index(["layout", "scenario"]).filter(like="said_of:")
    assert list(cases.loc[("hanging", "S1")]) == ["1", "stable", "stable", "stable"]


def test_the_page_shows_what_was_found(run, found, assert_shown):
    assert_shown(
        RunReport(directory=run),
        found,
        answer=[len(found.rows), found.cases, found.layouts, found.disputed],
        charts=["trade_off", "phases", "agreement", "disagreement_1", "disagreement_2"],
    )


def test_the_same_rows_give_the_same_bytes(run, found, tmp_path):
    one, two = (tmp_path / name for name in ("one", "two"))
    for folder, same in ((one, found), (two, compare(run))):
        write_page(RunReport(directory=run).page(same), folder)
    files = sorted(p.relative_to(one) for p in one.rglob("*.*"))
    assert len(files) > 5
    for name in files:
        assert (one / name).read_bytes() == (two / name).read_bytes()


def test_a_chart_in_the_place_of_a_picture_has_its_own_caption(run, found, tmp_path, undrawn):
    """The picture has shares that are equal; the chart in its place, cases that differ."""
    page = RunReport(directory=run).page(found)
    (picture,) = (p for section in page.sections for p in section.drawn if p.name == "agreement")
    path = write_page(page, tmp_path)
    captions = picture.caption, picture.interactive.caption
    for file, expected in ((path, [True, False]), (path.with_suffix(".html"), [False, True])):
        assert [caption in file.read_text() for caption in captions] == expected


def test_an_unfinished_study_names_what_is_missing(run, tmp_path):
    folder = tmp_path / "run"
    shutil.copytree(run, folder)
    manifest = load_manifest(run) | {"finished": None}
    (folder / "manifest.json").write_text(manifest_text(manifest))
    for shard in manifest["shards"][-1:]:
        result_store(folder).drop(shard)
    part = compare(folder)
    assert (part.missing_rows, part.missing_methods) == (12, [DART])


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
    page = Path(__file__).parents[2] / "docs" / "engines.md"
    listed = engines_markdown(engine_records()) + "\n"
    assert page.read_text() == listed, "an engine or what it declares is new: run `make docs`"


def test_numbers_read_the_same_everywhere():
    assert percent(Estimate(0.8356, 0.81, 0.859, 900)) == "83.6 [81.0, 85.9]"
    assert percent(None) == percent(Estimate(float("nan"), 0, 0, 0)) == "-"
    assert milliseconds(Estimate(0.01234, 0.012, 0.0131, 9)) == "0.0123 [0.0120, 0.0131]"
    assert [significant(v) for v in (1234.5, 12.345, 0.0012345, 0.0)] == [
        "1234", "12.3", "0.00123", "0",
    ]  # fmt: skip
    found = [compact(v) for v in (0.09998, -1.47, 441.2, 1.44e-5, 0.0, -16.33)]
    assert found == ["0.10", "-1.5", "440", "1.4e-05", "0", "-16"]


def test_a_table_escapes_what_would_break_it():
    table = markdown_table(("a", "b"), [("x|y", "1\n2")])
    assert table.splitlines()[2] == "| x\\|y | 1 2 |"
    assert len({len(line) for line in table.splitlines()}) == 1


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
        Column("name", "name", str, left=True),
        *columns_for(("S1", "S2"), "{} %", "shares", percent),
        *columns_for(("S1",), str.lower, lambda row, key: key in row.shares, yes_no),
    ]
    assert str(Table(rows, columns, "Shares:")) == "Shares:\n\n" + markdown_table(
        ("name", "S1 %", "S2 %", "s1"),
        [("a", "80.0 [70.0, 90.0]", "-", "yes"), ("b", "-", "50.0 [40.0, 60.0]", "no")],
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
