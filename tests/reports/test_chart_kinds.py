"""Kinds of charts draw the values of their rows, and name the field that rows do not have."""

import dataclasses
import re
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.colors import to_hex
from matplotlib.container import BarContainer

from steadyload.layouts import Item, Layout, Pallet
from steadyload.methods.naming import MethodKey
from steadyload.reports.charts.bars import bars
from steadyload.reports.charts.change import change
from steadyload.reports.charts.columns import columns
from steadyload.reports.charts.curves import curves
from steadyload.reports.charts.ecdf import ecdf
from steadyload.reports.charts.forest import forest
from steadyload.reports.charts.front import front
from steadyload.reports.charts.heat import heat
from steadyload.reports.charts.kinds import KINDS
from steadyload.reports.charts.outcomes import outcomes
from steadyload.reports.charts.rows import ChartError
from steadyload.reports.charts.scene import scene
from steadyload.reports.style import engine_colour
from steadyload.statistics.estimate import NOTHING, Estimate

PS3 = MethodKey("PS_3", "ps3@bullet", "ps3", "bullet")
SME = MethodKey("SME", "sme", "sme", None)

numbers = st.floats(0.01, 0.99)
estimates = st.builds(
    lambda low, value, high: Estimate(*sorted((low, value, high))[1::-1], max(low, value, high), 9),
    numbers, numbers, numbers,
)  # fmt: skip
few = settings(max_examples=20)


def line_data(axes):
    return [np.asarray(line.get_xydata(), dtype=float) for line in axes.lines]


def interval_ends(axes):
    """Ends of all intervals that are drawn, as sets of rounded numbers (x, y)."""
    return {
        tuple(np.round(end, 9))
        for bars_ in axes.collections
        for segment in bars_.get_segments()
        for end in segment
    }


@dataclass(frozen=True)
class Point:
    method: MethodKey
    cpu: Estimate
    accuracy: Estimate
    budget: str = ""


@few
@given(st.lists(st.tuples(estimates, estimates), min_size=1, max_size=5))
def test_a_front_has_points_and_intervals_of_its_rows(values):
    rows = [Point(PS3, cost, share) for cost, share in values]
    figure, interactive = front(rows)
    [axes] = figure.axes
    points = {tuple(np.round(xy[0], 9)) for xy in line_data(axes) if len(xy)}
    ends = interval_ends(axes)
    assert interactive is None
    for cost, share in values:
        assert tuple(np.round((cost.value, 100 * share.value), 9)) in points
        for x in (cost.low, cost.high):
            assert tuple(np.round((x, 100 * share.value), 9)) in ends
        for y in (share.low, share.high):
            assert tuple(np.round((cost.value, 100 * y), 9)) in ends


def test_a_front_joins_the_rows_of_a_line_and_leaves_out_those_without_a_share():
    cost, share = Estimate(2.0, 1.0, 3.0, 9), Estimate(0.9, 0.8, 0.95, 9)
    rows = [Point(SME, cost, NOTHING), Point(SME, cost, share)]
    line = [Point(PS3, Estimate(ms, ms, ms, 9), share, f"{ms:g}") for ms in (0.5, 1.0, 4.0)]
    [axes] = front(rows, lines={"by budget": line}, note="budget").figure.axes
    assert [text.get_text() for text in axes.texts] == ["0.5", "1", "4"]
    assert [[0.5, 90.0], [1.0, 90.0], [4.0, 90.0]] in [xy.tolist() for xy in line_data(axes)]
    assert [text.get_text() for text in axes.get_legend().texts] == ["SME", "by budget"]


def test_a_front_by_groups_is_a_chart_of_the_html_page_and_marks_what_no_cheaper_one_beats():
    def point(spec, ms, share):
        key = MethodKey(spec, spec, spec, None)
        return Point(key, Estimate(ms, ms, ms, 9), Estimate(share, share, share, 9))

    rows = [point("a", 1.0, 0.7), point("b", 2.0, 0.6), point("c", 3.0, 0.9), point("d", 3.0, 0.8)]
    shown = front(rows, groups={"S1": rows, "S2": rows[:2]}, more={"accuracy": ", again"})
    data = shown.interactive.data()
    assert [group["title"] for group in data["groups"]] == ["S1, again", "S2, again"]
    points = data["groups"][0]["points"]
    assert [(p["title"], p["front"]) for p in points] == [
        ("a", True), ("b", False), ("c", True), ("d", False),
    ]  # fmt: skip
    assert points[0]["told"] == "70.0 [70.0, 70.0] %, 1.00 [1.00, 1.00] ms"
    told = [dataclasses.replace(rows[0], budget="median 0.5 ms")]
    [group] = front(told, beside_cost="budget", groups={"S1": told}).interactive.data()["groups"]
    assert group["points"][0]["told"].endswith(" ms (median 0.5 ms)")


def test_lines_of_a_front_can_look_like_engines_without_a_point_beside_them():
    share = Estimate(0.5, 0.4, 0.6, 9)
    members = [Point(PS3, Estimate(ms, ms, ms, 9), share, str(ms)) for ms in (1.0, 2.0)]
    lines = dict.fromkeys(("bullet", "mujoco"), members)
    [axes] = front([], lines=lines, look="engine", of="method.engine", note="budget").figure.axes
    assert axes.get_xscale() == "log"
    drawn = {line.get_color() for line in axes.lines}
    assert drawn == {text.get_color() for text in axes.texts} == {engine_colour("bullet")}


def test_changes_stand_in_a_panel_each_with_what_they_are_compared_with():
    share, cost = Estimate(0.2, 0.1, 0.3, 9), Estimate(0.5, 0.4, 0.6, 9)
    tables = [
        {"question": name, "options": [
            {"title": f"`{option}`", "method": SME, "cost": cost, "changed": share}
            for option in ("one", "two")]}
        for name in ("within", "stands")
    ]  # fmt: skip
    figure = change(
        tables, "cost", "changed", within="options", panel="question", panel_title="question {}",
        x_label="x", y_label="y",
    ).figure  # fmt: skip
    assert [axes.get_title() for axes in figure.axes] == ["question within", "question stands"]
    for axes in figure.axes:
        *points, reference = line_data(axes)
        assert [xy.tolist() for xy in points] == [[[0.5, 20.0]], [[0.5, 20.0]]]
        assert {x for x, _ in reference} == {1.0}
    assert [text.get_text() for text in figure.legends[0].texts] == ["one", "two"]


@few
@given(
    st.dictionaries(
        st.sampled_from("abc"),
        st.dictionaries(st.integers(1, 500), estimates, min_size=1, max_size=4),
        min_size=1,
    ),
    st.randoms(use_true_random=False),
)
def test_curves_are_the_points_of_a_title_in_order_of_x(lines, random):
    rows = [
        {"title": title, "n": n, "share": share}
        for title, points in lines.items()
        for n, share in points.items()
    ]
    random.shuffle(rows)
    order = list(dict.fromkeys(row["title"] for row in rows))
    [axes] = curves(rows, "n", "share", percent="y", log="x", ticks="all").figure.axes
    handles = axes.get_legend_handles_labels()[0]
    for handle, title in zip(handles, order, strict=True):
        points = sorted(lines[title].items())
        expected = [[n, 100.0 * share.value] for n, share in points]
        assert np.allclose(handle.lines[0].get_xydata(), expected)
    assert sorted(axes.get_xticks()) == sorted({row["n"] for row in rows})


def test_numbers_over_texts_stand_in_lines_of_panels_and_titles_at_the_ends_of_lines():
    rows = [
        {"title": title, "rule": rule, "rank": rank, "by": by, "told": told}
        for told, by, rules in (
            ("no", "time", ("1 s", "label")), ("no", "limit", ("label", "5 cm")),
            ("yes", "time", ("1 s", "label")),
        )
        for place, rule in enumerate(rules)
        for title, rank in (("a", 1), ("b", 2 - place))
    ]  # fmt: skip
    figure = curves(
        rows, "rule", "rank", panel="by", above="told", ends=True
    ).figure  # fmt: skip
    first, second, _, empty = figure.axes
    assert [axes.get_title() for axes in figure.axes] == ["no: time", "no: limit", "yes: time", ""]
    assert [[text.get_text() for text in axes.get_xticklabels()] for axes in figure.axes[:3]] == [
        ["1 s", "label"], ["label", "5 cm"], ["1 s", "label"],
    ]  # fmt: skip
    assert [xy.tolist() for xy in line_data(second)] == [[[0, 1], [1, 1]], [[0, 2], [1, 1]]]
    assert not empty.axison
    assert not first.texts
    ends = [(text.get_text(), text.xy, text.get_position()[1]) for text in second.texts]
    assert ends == [("a", (1.0, 1.0), 0.0), ("b", (1.0, 1.0), -11.0)]
    assert second.get_legend() is None


def test_titles_at_ends_are_of_lines_with_intervals_and_never_over_another():
    rows = [
        {"title": title, "rule": rule, "share": Estimate(share, share - 0.1, share + 0.05, 9)}
        for title, share in (("a", 0.9), ("b", 0.899), ("c", 0.898), ("d", 0.2))
        for rule in ("1 s", "2 s")
    ]
    [axes] = curves(rows, "rule", "share", percent="y", ends=True).figure.axes
    assert [text.get_text() for text in axes.texts] == ["a", "b", "c", "d"]
    offsets = [text.get_position()[1] for text in axes.texts]
    assert offsets[0] == offsets[3] == 0.0
    assert -12.0 < offsets[1] < -9.0
    assert -23.0 < offsets[2] < -18.0


def test_curves_of_plain_numbers_have_no_intervals_and_skip_what_is_not_there():
    rows = [
        {"title": "a", "points": [{"n": 1, "ms": 2.0}, {"n": 2, "ms": None}, {"n": 3, "ms": 4.0}]},
        {"title": "b", "points": [{"n": 1, "ms": None}]},
    ]
    [axes] = curves(rows, "n", "ms", within="points").figure.axes
    assert [xy.tolist() for xy in line_data(axes)] == [[[1.0, 2.0], [3.0, 4.0]]]
    assert not axes.collections


def test_a_logarithmic_x_has_plain_numbers():
    rows = [{"title": "a", "n": n, "ms": 1.0} for n in (3, 20, 700)]
    figure = curves(rows, "n", "ms", log="x").figure
    figure.draw_without_rendering()
    labels = {label.get_text() for label in figure.axes[0].get_xticklabels()}
    assert {"10", "100"} <= labels
    assert not any("$" in label for label in labels)


def test_curves_over_several_numbers_have_a_panel_each():
    rows = [{"title": "a", "cases": n, "lists": 2 * n, "share": 0.1 * n} for n in (1, 2)]
    figure = curves(
        rows, ("cases", "lists"), "share", percent="y", x_label=("cases", "lists")
    ).figure  # fmt: skip
    assert [axes.get_xlabel() for axes in figure.axes] == ["cases", "lists"]
    assert [line_data(axes)[0].tolist() for axes in figure.axes] == [
        [[1.0, 10.0], [2.0, 20.0]], [[2.0, 10.0], [4.0, 20.0]],
    ]  # fmt: skip


def test_panels_of_curves_wrap_and_have_ticks_of_their_own():
    rows = [{"what": w, "n": k * n, "share": 0.1} for k, w in enumerate("abc", 1) for n in (1, 9)]
    figure = curves(
        rows, "n", "share", title="", panel="what", across=2, log="x", ticks="all", y_label="y"
    ).figure  # fmt: skip
    assert [list(axes.get_xticks()) for axes in figure.axes] == [[1, 9], [2, 18], [3, 27]]
    assert [axes.get_ylabel() for axes in figure.axes] == ["y", "", "y"]
    places = [axes.get_subplotspec() for axes in figure.axes]
    assert [(place.rowspan.start, place.colspan.start) for place in places] == [
        (0, 0), (0, 1), (1, 0),
    ]  # fmt: skip


def test_the_legend_of_curves_names_lines_of_every_panel():
    rows = [
        {"title": f"line {k}", "what": f"panel {k}", "n": n, "ms": n}
        for k in (1, 2)
        for n in (1, 2)
    ]
    *_, last = curves(rows, "n", "ms", panel="what").figure.axes
    legend = last.get_legend()
    assert [text.get_text() for text in legend.get_texts()] == ["line 1", "line 2"]


def test_curves_can_stand_aside_and_what_is_true_is_dashed():
    rows = [
        {"title": str(is_), "is": is_, "n": n, "ms": 1.0} for is_ in (True, False) for n in (1, 9)
    ]
    [axes] = curves(rows, "n", "ms", dash="is", apart=1.04).figure.axes
    assert [line.get_linestyle() for line in axes.lines] == ["--", "-"]
    first, second = (line.get_xdata() for line in axes.lines)
    assert np.allclose(second / first, 1.04)
    assert np.allclose(np.sqrt(first * second), [1, 9])


def test_curves_have_hollow_points_a_limit_and_a_y_of_their_own():
    rows = [
        {"title": "a", "what": w, "n": n, "ms": ms, "below": n == 9, "least": least}
        for w, least, sizes in (("x", None, (1, 2)), ("y", 0.5, (1, 2)), ("z", 1e-6, (1e-6, 1e-6)))
        for n, ms in zip((1, 9), sizes, strict=True)
    ]  # fmt: skip
    figure = curves(
        rows, "n", "ms", panel="what", across=2, own_y=True, hollow="below", limit="least", log="y"
    ).figure
    first, second, last = figure.axes
    line, hollow = first.lines
    assert (hollow.get_markerfacecolor(), hollow.get_color()) == ("white", line.get_color())
    assert hollow.get_xydata().tolist() == [[9.0, 2.0]]
    assert [set(line.get_ydata()) for line in second.lines] == [{1.0, 2.0}, {2.0}, {0.5}]
    low, high = first.get_ylim()
    assert (high / low, low * high) == pytest.approx((100.0, 2.0))
    [legend] = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["a"]
    assert last.get_legend() is None


def test_curves_of_one_engine_look_alike_and_dashes_show_another_field():
    rows = [
        {"title": f"{engine} {scope}", "engine": engine, "scope": scope, "n": n, "ms": n}
        for engine in ("bullet", "mujoco") for scope in ("all", "local") for n in (1, 2)
    ]  # fmt: skip
    [axes] = curves(rows, "n", "ms", look="engine", of="engine", dash="scope").figure.axes
    colours = [line.get_color() for line in axes.lines]
    assert colours[0] == colours[1] != colours[2] == colours[3]
    assert [line.get_linestyle() for line in axes.lines] == ["-", "--", "-", "--"]


@few
@given(st.lists(st.tuples(numbers, numbers), min_size=1, max_size=4))
def test_stacked_bars_begin_where_the_part_before_ends(parts):
    rows = [{"title": str(k), "a": a, "b": b} for k, (a, b) in enumerate(parts)]
    [axes] = bars(rows, {"a": "first", "b": "second"}, x_label="x").figure.axes
    first, second = (c for c in axes.containers if isinstance(c, BarContainer))
    assert np.allclose([bar.get_width() for bar in first], [100 * a for a, _ in parts])
    assert np.allclose([bar.get_x() for bar in second], [100 * a for a, _ in parts])
    assert np.allclose([bar.get_width() for bar in second], [100 * b for _, b in parts])
    assert [text.get_text() for text in axes.get_yticklabels()] == [r["title"] for r in rows]
    [axes] = bars(rows, {"a": "1", "b": "2"}, percent=False, x_label="x").figure.axes
    sums = [float(text.get_text()) for text in axes.texts]
    assert np.allclose(sums, [a + b for a, b in parts], rtol=0.01)


def test_columns_of_numbers_stand_at_their_place_and_others_in_groups():
    counts = {5: 2, 9: 3}
    rows = [{"title": items, "layouts": n} for items, n in counts.items()]
    [axes] = columns(rows, {"layouts": ""}, x_label="x", y_label="y").figure.axes
    places = [bar.get_x() + 0.5 * bar.get_width() for bar in axes.patches]
    assert dict(zip(places, [bar.get_height() for bar in axes.patches], strict=True)) == counts
    rows = [{"title": t, "S1": a, "S2": b} for t, a, b in (("low", 0.1, 0.2), ("all", 0.3, 0.4))]
    heights = {"S1": "first", "S2": "second"}
    [axes] = columns(rows, heights, percent=True, x_label="x", y_label="y").figure.axes
    drawn = [[bar.get_height() for bar in c] for c in axes.containers]
    assert np.allclose(drawn, [[10.0, 30.0], [20.0, 40.0]])
    first, second = ([bar.get_x() for bar in c] for c in axes.containers)
    width = axes.patches[0].get_width()
    assert np.allclose(np.subtract(second, first), width)


@few
@given(st.lists(estimates, min_size=1, max_size=5))
def test_a_forest_has_a_row_a_title_and_a_panel_a_value(shares):
    rows = [
        {"title": str(k), "panel": panel, "share": share, "seeds": (share.low, share.high)}
        for k, share in enumerate(shares)
        for panel in ("S1", "S2")
    ]
    figure = forest(rows, "share", panel="panel", dots="seeds", x_label="x").figure
    assert [axes.get_title() for axes in figure.axes] == ["S1", "S2"]
    for axes in figure.axes:
        drawn = line_data(axes)
        assert np.allclose(
            [xy[0] for xy in drawn[::2]], [(100 * s.value, -k) for k, s in enumerate(shares)]
        )
        assert np.allclose(
            [xy[:, 0] for xy in drawn[1::2]], [(100 * s.low, 100 * s.high) for s in shares]
        )


def test_a_forest_marks_a_share():
    rows = [{"title": "one", "share": 0.5}]
    [axes] = forest(rows, "share", marks={"the paper": 0.8}, x_label="x").figure.axes
    assert [line.get_xdata()[0] for line in axes.lines if line.get_linestyle() == ":"] == [80.0]
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["the paper"]
    [bare] = forest(rows, "share", x_label="x").figure.axes
    assert bare.get_legend() is None


def test_rows_of_a_forest_look_like_their_group():
    rows = [{"title": str(k), "kind": kind, "share": 0.5} for k, kind in enumerate("abba")]
    [axes] = forest(rows, "share", of="kind", x_label="x").figure.axes
    first, second, third, fourth = (line.get_color() for line in axes.lines)
    assert first == fourth != second == third


def test_outcomes_have_a_colour_and_a_sign_each_at_its_place():
    titles = {"best": "best", "good": "held", "bad": "failed", "late": "no verdict"}
    rows = [
        {"engine": engine, "rate": rate, "cubes": cubes, "came": came}
        for engine, rate, cubes, came in (
            ("a", "60", 1e5, "bad"), ("a", "60", 2, "good"), ("a", "240", 2, "late"),
            ("b", "own", 2, "good"), ("b", "own", 1e5, "good"),
        )
    ]  # fmt: skip
    figure = outcomes(
        rows, "rate", "cubes", "came", titles=titles, panel="engine", x_label="Hz", y_label="n"
    ).figure
    first, second = figure.axes
    assert [axes.get_title() for axes in figure.axes] == ["a", "b"]
    assert [t.get_text() for t in first.get_xticklabels()] == ["60", "240"]
    assert [t.get_text() for t in first.get_yticklabels()] == ["2", "1e5"]
    assert [t.get_text() for t in second.get_xticklabels()] == ["own"]
    places = [tuple(np.add(patch.get_xy(), 0.5)) for patch in first.patches]
    assert places == [(0, 1), (0, 0), (1, 0)]
    bad, good, late = (to_hex(patch.get_facecolor()) for patch in first.patches)
    assert len({bad, good, late}) == 3
    assert {to_hex(patch.get_facecolor()) for patch in second.patches} == {good}
    signs = [text.get_text() for text in first.texts]
    assert signs[1] == ""
    assert len(set(signs)) == 3
    shown = {
        text.get_text(): to_hex(patch.get_facecolor())
        for legend in figure.legends
        for text, patch in zip(legend.get_texts(), legend.get_patches(), strict=True)
    }
    named = {"held": good, f"{signs[0]} failed": bad, f"{signs[2]} no verdict": late}
    assert {title: shown.pop(title) for title in named} == named
    assert [*shown] == ["not measured"]


def test_an_outcome_without_a_title_is_named():
    row = {"x": "a", "y": 1, "o": "held"}
    with pytest.raises(ChartError, match="outcome='held'"):
        outcomes([row], "x", "y", "o", titles={"bad": "bad"}, x_label="", y_label="")


@few
@given(st.lists(st.lists(numbers, min_size=2, max_size=2), min_size=2, max_size=2))
def test_heat_has_a_cell_a_row_at_its_place(values):
    rows = [
        {"of": f"row {i}", "and": f"column {j}", "share": value}
        for i, line in enumerate(values)
        for j, value in enumerate(line)
    ]
    axes = heat(rows, "and", "of", "share", label="z").figure.axes[0]
    assert np.allclose(axes.images[0].get_array(), 100 * np.array(values))
    assert [t.get_text() for t in axes.texts] == [f"{100 * v:.0f}" for v in np.ravel(values)]
    assert [t.get_text() for t in axes.get_xticklabels()] == ["column 0", "column 1"]
    assert [t.get_text() for t in axes.get_yticklabels()] == ["row 0", "row 1"]


def test_heat_of_differences_leaves_pale_cells_without_colour():
    rows = [
        {"of": "a", "minus": "b", "points": Estimate(0.5, 0.4, 0.6, 9), "open": False},
        {"of": "b", "minus": "a", "points": Estimate(-0.02, -0.1, 0.1, 9), "open": True},
    ]  # no cell of a thing and itself
    axes = heat(
        rows, "minus", "of", "points", pale="open", differences=True, label="z"
    ).figure.axes[0]  # fmt: skip
    coloured = np.ma.filled(axes.images[0].get_array().astype(float), np.nan)
    assert coloured[0, 1] == 50.0
    assert np.isnan(coloured[1, 0])
    assert [t.get_text() for t in axes.get_xticklabels()] == ["a", "b"]
    assert [t.get_text() for t in axes.texts] == ["50", "-2.0"]
    assert axes.texts[1].get_color() == "#a0a0a0"


@few
@given(st.lists(numbers, max_size=5).map(sorted), st.integers(1, 3))
def test_an_ecdf_rises_by_a_member_at_each_end(ends, further):
    count = len(ends) + further
    rows = [{"title": "all", "ends": ends, "n": count}]
    figure = ecdf(rows, "ends", of="n", x_label="x", y_label="y").figure
    [drawn] = line_data(figure.axes[0])
    assert np.allclose(drawn[:, 0], [0.0, *(100 * end for end in ends), 100.0])
    steps = [100 * k / count for k in range(len(ends) + 1)]
    assert np.allclose(drawn[:, 1], [*steps, steps[-1]])


def test_a_line_of_an_ecdf_is_that_of_its_title_among_all():
    def colour(titles):
        rows = [{"title": t, "ends": [0.5], "n": 2} for t in titles]
        axes = ecdf(rows, "ends", of="n", among="abc", x_label="x", y_label="y").figure.axes[0]
        return {line.get_label()[0]: line.get_color() for line in axes.lines}

    assert colour("c")["c"] == colour("abc")["c"] != colour("abc")["b"]


def test_an_ecdf_of_values_spans_them_and_lines_have_the_look_of_engines():
    rows = [
        {"title": title, "ends": [-0.3, 0.1], "n": 2, "engine": engine, "basis": basis}
        for title, engine, basis in (("a", "mujoco", "some"), ("b", None, "none"))
    ]
    axes = ecdf(
        rows, "ends", of="n", look="engine", by="engine", dash="basis", span=(-0.2, 0.2),
        x_label="x", y_label="y",
    ).figure.axes[0]  # fmt: skip
    first, second, zero = axes.lines
    assert first.get_xydata().tolist() == [[-0.3, 0], [-0.3, 50], [0.1, 100], [0.2, 100]]
    assert axes.get_xlim() == (-0.2, 0.2)
    assert list(zero.get_xdata()) == [0.0, 0.0]
    assert (first.get_color(), first.get_linestyle()) == (engine_colour("mujoco"), "-")
    assert (second.get_color(), second.get_linestyle()) == (engine_colour(None), "--")


def test_a_scene_shows_the_number_of_each_item():
    box = Item(0, (0.0, 0.0, 0.0), (20.0, 10.0, 10.0), 1.0)
    layout = Layout("one", Pallet(60.0, 40.0, 30.0), (box,))
    axes = scene(layout, marked=[0]).figure.axes[0]
    assert [text.get_text() for text in axes.texts] == ["0"]


CALLS = {
    "front": ((), {"y": "acuracy"}),
    "change": (("cpu", "acuracy"), {"x_label": "", "y_label": ""}),
    "curves": (("n", "acuracy"), {}),
    "forest": (("acuracy",), {"x_label": ""}),
    "bars": (({"acuracy": ""},), {"x_label": ""}),
    "columns": (({"acuracy": ""},), {"x_label": "", "y_label": ""}),
    "heat": (("title", "title", "acuracy"), {"label": ""}),
    "outcomes": (("title", "n", "acuracy"), {"titles": {}, "x_label": "", "y_label": ""}),
    "ecdf": (("acuracy",), {"of": "n", "x_label": "", "y_label": ""}),
}


@pytest.mark.parametrize("name", sorted(KINDS.keys() - {"scene"}))
def test_a_field_that_rows_do_not_have_is_named_with_the_nearest_one(name):
    share = Estimate(0.2, 0.1, 0.3, 9)
    row = {"title": "a", "method": SME, "n": 2, "cpu": share, "accuracy": share}
    positional, named = CALLS[name]
    with pytest.raises(ChartError, match="no field 'acuracy'; did you mean 'accuracy'"):
        KINDS[name]([row], *positional, **named)


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ({"look": "methods"}, "look='methods'; did you mean 'method'? allowed: engine, method"),
        ({"ticks": "some"}, "ticks='some'; "),
    ],
)
def test_an_option_that_is_not_allowed_is_named(option, message):
    with pytest.raises(ChartError, match=re.escape(message)):
        curves([{"title": "a", "n": 1, "ms": 2.0}], "n", "ms", **option)


@pytest.mark.parametrize(
    "name", sorted(KINDS.keys() & {"curves", "forest", "bars", "heat", "outcomes"})
)
def test_a_chart_of_no_rows_is_refused(name):
    positional, named = CALLS[name]
    with pytest.raises(ChartError, match="chart of no rows; allowed: one row or more"):
        KINDS[name]([], *positional, **named)


@pytest.mark.parametrize("wrong", ["text", None, (1, 2)])
def test_a_field_that_is_no_number_is_named(wrong):
    with pytest.raises(ChartError, match="allowed: a number or an estimate"):
        forest([{"title": "a", "share": wrong}], "share", x_label="")
