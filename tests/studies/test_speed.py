"""The benchmark measures what it says: phases lie within the total, the floor is stepping alone."""

import json
from itertools import permutations

import numpy as np
import pandas as pd
import pytest

from steadyload.engines.registry import engines_here, world_class
from steadyload.methods.simulation.scene import planar_scene
from steadyload.runs.results import load_results
from steadyload.studies.engines import agreeing, speed
from steadyload.studies.engines.agreeing import (
    OPTIONS,
    Drawn,
    engine_agreement,
    option_effects,
    without_and_with,
)
from steadyload.studies.engines.speed import (
    ITEM_COUNTS,
    brick_wall,
    random_pile,
    speed_curves,
)
from steadyload.studies.kit import Lab


def test_scenes_hold_as_many_items_as_asked():
    assert [len(random_pile(count)) for count in ITEM_COUNTS] == list(ITEM_COUNTS)
    assert random_pile(20).items == random_pile(50).first(20).items
    assert planar_scene(brick_wall(30)).across == "depth"


def test_curves_cover_every_engine_and_add_up(tmp_path, monkeypatch):
    """One wall is too large for 3-D engines, as one of 25 bricks is in the published curves."""
    monkeypatch.setattr(speed, "_LARGEST_SPATIAL_WALL", 10)
    monkeypatch.setattr(speed, "_REPEATS", 1)
    curves = speed_curves(Lab(tmp_path), (4, 10, 11))
    assert {(c.engine, c.scene): len(c.points) for c in curves} == {
        (engine, scene): 2 if scene == "wall" and spatial else 3
        for engine in engines_here()
        for spatial in [world_class(engine).capabilities.dimensions == 3]
        for scene in (["wall", "pile"] if spatial else ["wall"])
    }
    assert {c.engine for c in curves} == set(engines_here())
    assert {c.scope for c in curves if c.scene == "pile"} == {"all", "local"}
    for curve in curves:
        assert curve.exponent is not None or len(curve.points) < 3
        for point in curve.points:
            assert 0.0 < point.step <= point.total
            assert max(point.build, point.read) <= point.total
            assert (point.floor is None) == (curve.scope == "local")


def test_the_floor_is_the_time_of_steps_alone(engine, told_time):
    told_time(engine, speed)
    stepping, adding = speed._floor(engine, brick_wall(5))
    assert stepping == pytest.approx(5 * 27 * 1e-3), "27 substeps for every placement"
    assert adding == pytest.approx(5 * 20e-3)


def test_agreement_and_options_are_counted_on_the_same_layouts(tmp_path, monkeypatch):
    drawn, lab = Drawn(4, seed=1, most_items=5), Lab(tmp_path, 0)
    found = engine_agreement(lab, drawn, (60, 90))
    pairs = found["pairs"].set_index("pair")
    assert list(pairs) == ["same:60", "same:90"]
    assert {share.n for share in pairs.to_numpy().ravel()} == {4}
    frame = load_results(tmp_path / "agreement")
    finest = frame[frame["parameters"].map(json.loads).str["frequency"] == 90]
    said = finest.pivot(index="layout", columns="engine", values="failing_step").fillna(-1)
    for pair, share in pairs["same:90"].items():
        first, second = pair.split(" and ")
        assert share.value == (said[first] == said[second]).mean()
    cpu = 1e3 * finest.pivot(index="layout", columns="engine", values="cpu_total")
    for kind, of in (("stable", said.eq(-1)), ("cpu", cpu)):
        shown = found[kind].set_index("engine")[f"{kind}_at:90"]
        assert {engine: one.value for engine, one in shown.items()} == pytest.approx(
            dict(of.mean())
        )
    engines = list(found["stable"]["engine"])
    assert {(p["engine"], p["other"]) for p in found["points"]} == {*permutations(engines, 2)}
    few = {title: OPTIONS[title] for title in ("10 solver iterations", "carry instead of reseat")}
    monkeypatch.setattr(agreeing, "OPTIONS", few)
    effects = option_effects(lab, drawn)
    changed = effects["changed"].set_index("option")["option_changed:dart"]
    assert pd.isna(changed["10 solver iterations"])  # DART ignores it
    assert 0.0 <= changed["carry instead of reseat"].value <= 1.0
    ratios = effects["ratio"].set_index("option").to_numpy(float)
    assert (ratios[~np.isnan(ratios)] > 0).all()


@pytest.mark.parametrize("title", OPTIONS)
def test_methods_with_an_option_and_without_are_two(title):
    without, given = without_and_with("mujoco", *OPTIONS[title])
    assert without != given
