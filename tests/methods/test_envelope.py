"""The envelope: what it says, who leaves it, and that a user is told."""

import dataclasses
import json
import shutil

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from steadyload.atomic import manifest_text
from steadyload.cli import main
from steadyload.engines.registry import ENGINES, EngineEntry
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods import envelope as module
from steadyload.methods.contract.verdict import Verdict
from steadyload.methods.doubt import doubt
from steadyload.methods.envelope import (
    Envelope,
    Limit,
    beyond,
    envelope,
    envelope_of,
    extent,
    farthest,
    leaves,
)
from steadyload.methods.registry import make_method
from steadyload.reports.pages.writing import write_page
from steadyload.runs.definition import load_study
from steadyload.runs.results import load_manifest
from steadyload.runs.runner import run_study
from steadyload.studies.report.comparing import compare
from steadyload.studies.report.study import RunReport

HELD = Envelope(3, 10.0, 100.0, 2.0, 50.0, 20, True)


def layout(*items, name="mine"):
    """Items as (position, size, weight)."""
    made = tuple(Item(step, *item) for step, item in enumerate(items))
    return Layout(name, Pallet(500.0, 500.0, 500.0), made)


def cube(x, level, weight=1.0):
    return (x, 10.0 * level, 0.0), (10.0, 10.0, 10.0), weight


HEAVY_ON_LIGHT = layout(cube(0.0, 0, 0.001), cube(0.0, 1, 1000.0), name="heavy")
FLAT = layout(cube(0.0, 0), cube(50.0, 0), name="flat")


# --- what was measured --------------------------------------------------------------------------


MEASURED = ("bullet", "mujoco", "dart", "chipmunk", "reference")
"""Engines of every installation when envelopes were made; a new one has none before
`steadyload study extremes` has measured it.
"""


@pytest.mark.parametrize("name", MEASURED)
def test_engines_that_were_measured_have_an_envelope(name):
    assert envelope(name, 1000.0) is not None


def test_the_row_at_or_below_a_frequency_counts():
    assert envelope("bullet", 100.0) == envelope("bullet", 90.0)
    assert envelope("bullet", 1e6) == envelope("bullet", 1000.0)
    assert envelope("bullet", 90.0) != envelope("bullet", 1000.0)
    assert envelope("bullet", 4.9) is None
    assert envelope("bullet", None) is None
    assert envelope("nobody", 240.0) is None


def test_what_rests_is_less_than_what_holds():
    for name in MEASURED:
        for frequency in (60.0, 240.0, 1000.0):
            holds, rests = envelope(name, frequency), envelope(name, frequency, at_rest=True)
            assert rests.tower_height <= holds.tower_height
            assert rests.heavy_on_light <= holds.heavy_on_light
            assert rests.item_count <= holds.item_count
    assert envelope("bullet", 480.0, at_rest=True) != envelope("bullet", 480.0)
    layout = tower(45)
    method = make_method("label@bullet")
    assert leaves(layout, method) == ()
    assert "45 items on top of each other" in leaves(layout, method, at_rest=True)[0]


def test_a_frequency_means_nothing_to_an_engine_with_its_own_steps():
    assert envelope("reference", None) == envelope("reference", 1.0) is not None


def test_more_substeps_hold_more():
    """Of engines with fixed substeps, at frequencies people use."""
    for name in ("bullet", "mujoco", "dart", "chipmunk"):
        coarse, fine = envelope(name, 30.0), envelope(name, 1000.0)
        assert coarse.tower_height < fine.tower_height
        assert coarse.heavy_on_light < fine.heavy_on_light
        assert coarse.least_size > fine.least_size


def test_a_method_brings_its_engine_and_frequency():
    assert envelope_of(make_method("ps_opt-paper@bullet")) == envelope("bullet", 90.0)
    assert envelope_of(make_method("sme")) is None


# --- how far a layout goes ----------------------------------------------------------------------


def test_the_longest_chain_counts_items_that_stand_on_each_other():
    tower = [cube(0.0, level) for level in range(4)]
    beside = [cube(30.0, level) for level in range(2)]
    assert extent(layout(*tower, *beside)).height == 4
    assert extent(FLAT).height == 1
    # A tall item beside a chain reaches as high and is one item.
    assert extent(layout(*tower[:2], ((30.0, 0.0, 0.0), (10.0, 90.0, 10.0), 1.0))).height == 2


def test_a_chain_may_go_over_a_bridge():
    bridge = ((0.0, 10.0, 0.0), (30.0, 10.0, 10.0), 1.0)
    found = extent(layout(cube(0.0, 0), cube(20.0, 0), bridge, cube(10.0, 2), cube(10.0, 3)))
    assert found.height == 4


def test_mass_ratios_are_those_of_items_in_contact():
    found = extent(layout(cube(0.0, 0, 2.0), cube(0.0, 1, 8.0), cube(0.0, 2, 1.0), cube(40.0, 0)))
    assert (found.heavy_on_light, found.light_on_heavy) == (4.0, 8.0)
    assert found.load == pytest.approx(4.5)
    apart = extent(layout(cube(0.0, 0, 1.0), cube(40.0, 0, 1000.0)))
    assert (apart.heavy_on_light, apart.light_on_heavy, apart.load) == (1.0, 1.0, 0.0)


def test_a_load_spreads_by_contact_area():
    """12 kg over 10 x 10 and 5 x 10 cm2: 8 and 4 kg, the latter on 2 kg and then on 1 kg."""
    plank = ((0.0, 20.0, 0.0), (35.0, 10.0, 10.0), 12.0)
    block = ((0.0, 0.0, 0.0), (10.0, 20.0, 10.0), 100.0)
    found = extent(layout(block, cube(30.0, 0, 1.0), cube(30.0, 1, 2.0), plank))
    assert found.load == pytest.approx(6.0)  # 4 + 2 kg on 1 kg
    assert found.heavy_on_light == pytest.approx(6.0)  # 12 kg on 2 kg


def test_edges_and_items():
    found = extent(layout(((0.0, 0.0, 0.0), (120.0, 1.0, 80.0), 5.0), cube(0.0, 0.1)))
    assert (found.thinnest, found.longest, found.item_count) == (1.0, 120.0, 2)


# --- leaving ------------------------------------------------------------------------------------


@pytest.fixture
def measured(monkeypatch):
    monkeypatch.setattr(module, "envelopes", lambda at_rest: {"bullet": ((60.0, HELD),)})
    return make_method("simulation@bullet:frequency=240")


def tower(count, weights=(1.0,)):
    return layout(*(cube(0.0, k, weights[min(k, len(weights) - 1)]) for k in range(count)))


@pytest.mark.parametrize(
    ("judged", "said"),
    [
        (tower(3), []),
        (tower(4), ["4 items on top of each other; measured to hold up to 3"]),
        (tower(2, (1.0, 10.0)), []),
        (
            tower(2, (1.0, 11.0)),
            [
                "an item 11 times as heavy as one below it; measured to hold up to 10",
                "a load of 11 times the weight of the item below it; measured to hold up to 10",
            ],
        ),
        (
            tower(3, (1.0, 6.0, 6.0)),
            ["a load of 12 times the weight of the item below it; measured to hold up to 10"],
        ),
        (tower(2, (100.0, 1.0)), []),
        (
            tower(2, (101.0, 1.0)),
            ["an item 101 times as heavy as one on top of it; measured to hold up to 100"],
        ),
        (
            layout(((0.0, 0.0, 0.0), (60.0, 1.0, 10.0), 1.0)),
            [
                "a thinnest edge of 1 cm; measured to hold down to 2",
                "a longest edge of 60 cm; measured to hold up to 50",
            ],
        ),
        (
            layout(*(cube(15.0 * k, 0) for k in range(21))),
            ["21 items; measured to hold up to 20"],
        ),
    ],
)
def test_a_layout_leaves_in_so_many_ways(measured, judged, said):
    assert list(leaves(judged, measured)) == said


def test_static_methods_and_unmeasured_engines_leave_nothing(measured):
    assert leaves(tower(9), make_method("sme")) == ()
    assert leaves(tower(9), make_method("simulation@mujoco")) == ()
    assert leaves(tower(9), make_method("simulation@bullet:frequency=30")) == ()


def test_the_load_of_the_tallest_tower_is_no_news():
    """19 equal cubes on one are 19 times its weight, and were measured as a tower of 20."""
    held = Envelope(20, 10.0, 100.0, 2.0, 50.0, 20, True)
    assert beyond(extent(tower(20)), held) == {}
    assert set(beyond(extent(tower(21)), held)) == {Limit.HEIGHT, Limit.LOAD, Limit.COUNT}


def test_an_engine_that_holds_nothing_is_left_by_everything():
    nothing = Envelope(0, 0.0, 0.0, 0.0, 0.0, 0, False)
    said = beyond(extent(FLAT), nothing)
    assert set(said) == set(Limit) - {Limit.THIN, Limit.LOAD}
    assert said[Limit.FALLS] == "a plate beyond an edge is not seen to fall"
    assert said[Limit.COUNT] == "2 items; measured to hold at none"


def test_rounding_takes_nothing_out():
    """Edges are differences of corners: (z + 49.9) - z may be more than 49.9, or less."""
    places = [k / 10.0 for k in range(1, 400)]
    longer = next(z for z in places if (z + 49.9) - z > 49.9)
    thinner = next(x for x in places if (x + 2.1) - x < 2.1)
    shifted = layout(((thinner, 0.0, longer), (2.1, 30.0, 49.9), 1.0))
    held = dataclasses.replace(HELD, least_size=2.1, most_size=49.9)
    assert beyond(extent(shifted), held) == {}


def test_generated_layouts_are_inside_a_fine_engine():
    found = [leaves(one, make_method("simulation@bullet")) for one in random_layouts(30, seed=3)]
    assert sum(map(bool, found)) <= 3


# --- who is told --------------------------------------------------------------------------------


TOLD = "simulation@bullet:frequency=60"


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A layout far out, one inside, and an engine that nobody has measured: a study that has run,
    with a method that is spelt otherwise.
    """
    folder = tmp_path_factory.mktemp("outside")
    write_layouts(folder / "layouts.json", [FLAT, HEAVY_ON_LIGHT], Format.NATIVE)
    (folder / "study.toml").write_text(
        'name = "outside"\nlayouts = ["layouts.json"]\n'
        'methods = ["sme", "simulation@bullet:frequency=60", "simulation@own:frequency=60"]\n'
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(ENGINES, "own", EngineEntry("steadyload.engines.with_bullet:BulletWorld"))
        asked = load_study(folder / "study.toml")
        methods = tuple(f"{spec}.0" if spec == TOLD else spec for spec in asked.methods)
        run_study(dataclasses.replace(asked, methods=methods), folder / "run")
        yield folder


@pytest.fixture
def study(ran, tmp_path):
    """A copy of its folder."""
    return shutil.copytree(ran, tmp_path / "outside")


def page_of(study):
    """The page and its details."""
    found = compare(study / "run")
    write_page(RunReport(directory=study / "run").page(found), study / "page")
    return "".join(path.read_text() for path in (study / "page").glob("report*.md"))


def test_a_manifest_says_how_many_cases_are_outside(ran):
    use = load_manifest(ran / "run")["envelope"]
    assert list(use) == [TOLD, "simulation@own:frequency=60"]
    assert use["simulation@own:frequency=60"] == {"measured": False}
    found = use[TOLD]
    assert (found["measured"], found["cases"], found["of"]) == (True, 1, 2)
    first = found["reasons"][0]
    assert (first["limit"], first["cases"], first["example"]) == ("heavy on light", 1, "heavy")
    assert first["sentence"].startswith("an item 1e+06 times as heavy as one below it; ")


def test_a_new_envelope_is_news_to_a_finished_run(study, monkeypatch):
    generous = Envelope(100, 1e6, 1e6, 0.1, 1000.0, 200, True)
    monkeypatch.setattr(module, "envelopes", lambda at_rest: {"bullet": ((60.0, generous),)})
    assert run_study(load_study(study / "study.toml"), study / "run") == 0
    found = load_manifest(study / "run")["envelope"][TOLD]
    assert (found["cases"], found["reasons"]) == (0, [])


def test_the_most_frequent_reason_comes_first(study):
    high = layout(*(cube(0.0, k) for k in range(40)), name="high")
    light = layout(cube(0.0, 0, 1e-6), cube(0.0, 1), cube(0.0, 2), name="light")
    write_layouts(study / "layouts.json", [high, HEAVY_ON_LIGHT, light], Format.NATIVE)
    run_study(load_study(study / "study.toml"), study / "run")
    found = load_manifest(study / "run")["envelope"][TOLD]
    counts = [reason["cases"] for reason in found["reasons"]]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > counts[-1]


def test_a_page_says_it_too(study, undrawn):
    text = page_of(study)
    part = text.partition("## Beyond the engines' envelopes")[2].partition("\n## ")[0]
    assert "| 1 of 2" in part
    assert "heavy: an item 1e+06 times as heavy" in part
    assert "Nothing was measured of the engine and frequency of PS @ own" in part
    manifest = load_manifest(study / "run")
    del manifest["envelope"]
    (study / "run" / "manifest.json").write_text(manifest_text(manifest))
    assert "envelopes" not in page_of(study), "a run without envelopes has no such part"


def test_a_study_warns_on_stderr(study, capsys):
    run = ("study", "run", str(study / "study.toml"), "-o", str(study / "run"))
    for more in (["--rerun"], []):  # also where nothing is computed
        assert main((*run, "--executor", "serial", *more)) == 0
        out, err = capsys.readouterr()
        assert err.count("warning: ") == 1
        assert f"warning: {TOLD}: 1 of 2 cases lie beyond" in err
        assert 'for example layout "heavy": an item 1e+06 times as heavy' in err
        assert "warning" not in out


def test_a_score_warns_on_stderr_and_in_its_records(study, capsys):
    file, method = str(study / "layouts.json"), f"{TOLD},question=within"
    assert main(("score", file, "-m", method, "-m", "sme", "--json")) == 0
    out, err = capsys.readouterr()
    assert err.count("warning: ") == 1
    assert f"{method}: 1 of 2 cases lie beyond" in err
    outside = {(r["layout"], r["method"]): r["outside"] for r in json.loads(out)}
    assert outside["flat", method] == outside["heavy", "sme"] == []
    assert len(outside["heavy", method]) >= 2
    write_layouts(study / "layouts.json", [FLAT], Format.NATIVE)
    assert main(("score", file, "-m", method)) == 0
    assert "warning: " not in capsys.readouterr().err


def test_extents_agree_with_a_slow_count():
    """The chain by recursion, the load by a loop over contacts."""
    for one in random_layouts(8, seed=11):
        contacts = one.contacts
        areas = np.zeros(contacts.carries.shape)
        areas[contacts.below, contacts.above] = contacts.areas

        def height(j, areas=areas):
            below = np.flatnonzero(areas[:, j])
            return 1 + max((height(i) for i in below), default=0)

        def load(i, one=one, areas=areas):
            above = np.flatnonzero(areas[i])
            return sum((load(j) + one.weights[j]) * areas[i, j] / areas[:, j].sum() for j in above)

        found = extent(one)
        assert found.height == max(height(j) for j in range(len(one)))
        worst = max(load(i) / one.weights[i] for i in range(len(one)))
        assert found.load == pytest.approx(worst)


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["bullet", "dart", "mujoco"]))
@example(56085, "bullet")  # the inverse of a rounded ratio was farther by a rounding
def test_no_extent_is_farther_than_the_farthest(seed, engine):
    """So that contacts are looked for where that exceeds an envelope, and nowhere else."""
    held, scale = envelope(engine, 240), np.random.default_rng(seed).uniform(-3.0, 3.0, 40)
    (drawn,) = random_layouts(1, seed=seed)
    heavier = zip(drawn.items, 10.0**scale, strict=False)
    items = [dataclasses.replace(item, weight=item.weight * by) for item, by in heavier]
    one = dataclasses.replace(drawn, items=tuple(items))
    found, most = extent(one), farthest(one)
    assert found.height <= most.height
    assert found.heavy_on_light <= most.heavy_on_light
    assert found.light_on_heavy <= most.light_on_heavy
    assert found.load <= most.load * (1.0 + 1e-9)
    assert (found.thinnest, found.longest) == (most.thinnest, most.longest)
    assert beyond(found, held).keys() <= beyond(most, held).keys()


# --- a fall that closed forms deny ---------------------------------------------------------------


def tall(count, size, top, name="tower"):
    """Cubes on top of each other, the uppermost of another weight."""
    weights = [1.0] * (count - 1) + [top]
    boxes = (((40.0, size * k, 40.0), (size,) * 3, weight) for k, weight in enumerate(weights))
    return layout(*boxes, name=name)


@pytest.mark.parametrize("spec", ["ps_opt@mujoco:question=stands", "label@bullet"])
def test_a_fall_within_the_envelope_that_closed_forms_deny_is_doubted(spec):
    """Small cubes and a large load are each within what was measured, and together they are not."""
    load, method = tall(12, 1.0, 900.0), make_method(spec)
    verdict = method.judge(load)
    assert verdict.failing_step == 11
    assert leaves(load, method) == ()
    engine = method.spec.engine
    assert f"moves too far in {engine} when item 11 is placed" in doubt(load, method, verdict)


def test_what_does_not_balance_is_not_doubted():
    falling = layout(cube(0.0, 0), cube(7.0, 1))
    hovering = layout(cube(0.0, 0), ((0.0, 25.0, 0.0), (10.0, 10.0, 10.0), 1.0))
    barely = layout(cube(0.0, 0), cube(4.9, 1))
    for load in (falling, hovering, barely):
        said = Verdict(2, failing_step=1, moved_item=1, displacement=12.0, rotation=3.0)
        assert doubt(load, make_method("label@mujoco"), said) == ""
    load, standing = tall(12, 1.0, 900.0), make_method("equilibrium")
    assert doubt(load, standing, standing.judge(load)) == ""
    static = Verdict(12, failing_step=11)
    assert doubt(load, make_method("cascade@mujoco"), static) == ""


def test_check_and_score_warn_of_a_fall_that_closed_forms_deny(tmp_path, capsys, in_this_process):
    file, spec = tmp_path / "loads.json", "ps_opt@mujoco:question=stands"
    write_layouts(file, [tall(12, 1.0, 900.0), tall(3, 10.0, 1.0, "plain")], Format.NATIVE)
    warning = f"warning: {spec}: 1 of 2 cases fail although the load is in balance; for example"
    for words in (["score", str(file)], ["check", str(file)]):
        main([*words, "-m", spec, "--json"])
        told = capsys.readouterr()
        assert warning in told.err
        doubts = [record["doubt"] for record in json.loads(told.out)]
        assert ["when box 12 of 12 is placed" in doubt for doubt in doubts] == [True, False]


@pytest.mark.parametrize(
    ("load", "spec"),
    [
        (layout(cube(0.0, 0, 1.0), cube(0.0, 1, 1e6)), "ps_opt@mujoco:question=stands"),
        (layout(cube(0.0, 0, 1.0), cube(0.0, 1, 1e6)), "label@mujoco"),
        (layout(cube(0.0, 0, 1.0), cube(0.0, 1, 1e6)), "label@bullet"),
        (layout(((5.0, 0.0, 30.0), (100.0, 0.05, 0.05), 1.0)), "label@bullet"),
        (layout(((5.0, 0.0, 30.0), (100.0, 0.05, 0.05), 1.0)), "label@dart"),
        (tall(80, 5.0, 1.0), "ps_opt@mujoco"),
    ],
)
def test_extremes_that_balance_are_warned_of_and_doubted(load, spec):
    method = make_method(spec)
    verdict = method.judge(load)
    assert verdict.failing_step is not None
    assert leaves(load, method)
    assert "contact forces balance the load" in doubt(load, method, verdict)
