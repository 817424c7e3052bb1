"""Engines against mechanics: the expected values, the measuring, and what is compared."""

import dataclasses
import math
import tempfile
from pathlib import Path

import numpy as np
import pytest

from steadyload.engines.registry import ENGINES, EngineEntry, world_class
from steadyload.engines.world import GRAVITY, SettingSupport, Support
from steadyload.properties import mechanics
from steadyload.properties.closed_form_tests import ClosedFormResult, closed_form_tests
from steadyload.properties.closed_forms import NoValueError, boundary
from steadyload.studies.closed_form_errors import errors_by_argument, errors_by_frequency
from steadyload.studies.closed_forms import measuring
from steadyload.studies.closed_forms.comparing import compare
from steadyload.studies.closed_forms.measuring import measured as results_of
from steadyload.studies.closed_forms.study import ClosedForms
from steadyload.studies.kit import Lab

TESTS = {test.name: test for test in closed_form_tests()}


def measured(name, engine="bullet", frequency=240):
    with tempfile.TemporaryDirectory() as work:
        (result,) = results_of(Lab(Path(work), 0), [engine], (frequency,), [TESTS[name]])
    return result


# --- what is expected ---------------------------------------------------------------------------


@pytest.mark.parametrize("past", [1e-3, 1e-5])
def test_tipping_starts_as_a_linear_pendulum(past):
    """At small angles a'' = g (d + h a) / s has the solution (d / h) (cosh t sqrt(g h / s) - 1)."""
    angle, above = 1e-4, 0.05
    rate = math.sqrt(GRAVITY * above / ((0.1**2 + 0.1**2) / 12 + past**2 + above**2))
    linear = math.acosh(1.0 + angle * above / past) / rate
    assert mechanics.tipping_time((0.1, 0.1), past, angle) == pytest.approx(linear, rel=1e-6)


def test_tipping_keeps_its_energy():
    """The speed at an angle follows from the height lost; the time is the sum of da / speed."""
    past, above, end = 0.01, 0.05, math.radians(10.0)
    square = 0.02 / 12 + past**2 + above**2
    # a = end u^2 takes the singularity at rest out of the integral.
    u = (np.arange(200_000) + 0.5) / 200_000
    a = end * u**2
    fallen = past * np.sin(a) + above * (1.0 - np.cos(a))
    time = (2.0 * end * u / np.sqrt(2.0 * GRAVITY * fallen / square)).mean()
    assert mechanics.tipping_time((0.1, 0.1), past, end) == pytest.approx(time, rel=1e-8)


def test_a_spinning_body_keeps_energy_and_momentum():
    inertia, start = mechanics.box_inertia((0.1, 0.2, 0.3), 3.0), np.array((0.1, 10.0, 0.1))
    assert inertia == pytest.approx((0.0325, 0.025, 0.0125))
    state = mechanics.spun(inertia, start, 1.0)
    (w, *v), spin = state[:4], state[4:]
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    rotation = np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross
    assert spin @ (inertia * spin) == pytest.approx(start @ (inertia * start), rel=1e-10)
    assert rotation @ (inertia * spin) == pytest.approx(inertia * start, rel=1e-9)
    assert abs(spin[0]) > 5.0, "it should be turning over"


def test_a_body_that_spins_about_a_main_axis_just_turns():
    state = mechanics.spun(np.array((1.0, 2.0, 3.0)), (0.0, 0.0, 0.5), 2.0)
    assert state[:4] == pytest.approx((math.cos(0.5), 0.0, 0.0, math.sin(0.5)))


def test_harmonic_overhangs_balance_every_upper_part():
    over = mechanics.harmonic_overhangs(6, 0.2)
    places = np.concatenate(([0.0], np.cumsum(over[::-1])))
    for level in range(1, 6):
        assert places[level:].mean() == pytest.approx(places[level - 1] + 0.1)


def test_falling_and_sliding_by_hand():
    assert TESTS["free fall"].expected == pytest.approx(-441.0)
    # 3-4-5: sin 0.6, cos 0.8, friction 0.5: 9.8 * 0.2 / 2
    assert mechanics.slid(0.75, 0.5, 1.0) == pytest.approx(0.98)
    assert mechanics.slid(0.5, 0.5, 1.0) == pytest.approx(0.0)


# --- how it is measured -------------------------------------------------------------------------


@pytest.mark.parametrize("place", [1.0, 0.99, 1.4, 0.5003])
def test_a_boundary_is_found_from_either_side(place):
    assert boundary(lambda x: x > place, 1.0, 1e-4, 1e-5, (0.3, 1.5)) == pytest.approx(
        place, abs=1e-5
    )


def test_a_boundary_that_is_not_there_is_said():
    for answer, word in ((True, "down to 0.3"), (False, "up to 1.5")):
        with pytest.raises(NoValueError, match=word):
            boundary(lambda x, answer=answer: answer, 1.0, 1e-4, 1e-5, (0.3, 1.5))


def test_free_fall_shows_the_order_of_the_integrator(engine):
    """Semi-implicit or explicit Euler: g t h / 2 off, unless the engine controls its error."""
    result = measured("free fall", engine)
    own_steps = world_class(engine).capabilities.error_controlled
    expected = 0.0 if own_steps else 1e3 * GRAVITY * 0.3 / 240 / 2
    assert abs(result.error) == pytest.approx(expected, rel=1e-6, abs=1e-3)
    assert result.found == pytest.approx(TESTS["free fall"].expected + result.error)


@pytest.mark.parametrize(
    ("name", "largest"),
    [
        ("sliding distance", 5.0),
        ("sliding threshold", 5.0),
        ("creep", 20.0),
        ("tipping offset", 10.0),
        ("time to 10 degrees, 10 mm", 10.0),
        ("time to 10 degrees, 1 mm", 20.0),
        ("overhang of 3", 5.0),
        ("sink under 10", 1.0),
    ],
)
def test_every_engine_is_roughly_right(engine, name, largest):
    result = measured(name, engine)
    assert result.note == ""
    assert abs(result.error) < largest


def test_a_spin_needs_three_dimensions(engine):
    result, facts = measured("intermediate-axis spin", engine), world_class(engine).capabilities
    if facts.dimensions == 2:
        assert result.found is None
        assert result.note.startswith("not defined")
        return
    finer = measured("intermediate-axis spin", engine, 1000)
    assert finer.error < 0.5 * result.error < 5.0 or facts.error_controlled
    assert 0.0 <= finer.error < 1.0


def test_a_bounce_needs_restitution(engine, monkeypatch):
    facts = world_class(engine).capabilities
    if facts.settings["restitution"].support is not Support.IGNORED:
        assert measured("bounce", engine).found == pytest.approx(0.25, rel=0.4)
    without = dict(facts.settings) | {"restitution": SettingSupport(Support.IGNORED)}
    ignoring = dataclasses.replace(facts, settings=without)
    monkeypatch.setattr(world_class(engine), "capabilities", ignoring)
    result = measured("bounce", engine)
    assert (result.found, result.note) == (None, "not defined: no restitution")


def test_a_light_cube_gives_way_under_a_load_too_heavy_for_the_solver():
    light, heavy = measured("sink under 10"), measured("sink under 10000", frequency=90)
    assert light.found < 1.0 < heavy.found <= 100.0


@pytest.mark.parametrize("name", ["free fall", "tipping offset", "bounce"])
def test_failures_are_rows(name, broken_bullet):
    result = measured(name)
    assert (result.found, result.error, result.note) == (None, None, broken_bullet)


def test_an_engine_with_its_own_steps_runs_once(monkeypatch, tmp_path):
    base, said = world_class("mujoco"), []

    class OwnSteps(base):
        capabilities = dataclasses.replace(base.capabilities, error_controlled=True)

    monkeypatch.setattr("steadyload.engines.with_mujoco.OwnSteps", OwnSteps, raising=False)
    monkeypatch.setitem(ENGINES, "own", EngineEntry("steadyload.engines.with_mujoco:OwnSteps"))
    tests = [TESTS["free fall"], TESTS["sink under 10"], TESTS["sink under 100"]]
    lab = Lab(tmp_path / "work", 0, lambda *of: said.append(of))
    results = results_of(lab, ["bullet", "own"], (90, 240), tests)
    assert [(r.engine, r.frequency) for r in results[:3]] == [
        ("bullet", 90), ("bullet", 240), ("own", None),
    ]  # fmt: skip
    assert len(results) == 9
    assert said == [("measuring", done, 9) for done in range(10)]
    found = compare(results, {})
    assert [*found.overview] == [
        "test", "error_unit", "error_of:bullet, 240 Hz", "error_of:own, own",
    ]  # fmt: skip
    assert len(found.overview) == 3
    alone = compare([r for r in results if r.engine == "own"], {})
    assert (alone.points, len(alone.beaten)) == ([], 0), "errors over frequency need one"


def test_results_are_kept_and_measured_by_processes_alike(tmp_path, monkeypatch):
    tests = [TESTS[name] for name in ("free fall", "creep")]
    here = results_of(Lab(tmp_path / "here", 0), ["mujoco"], (90, 240), tests)
    beside = results_of(Lab(tmp_path / "beside", 2), ["mujoco"], (90, 240), tests)
    assert here == beside
    monkeypatch.setattr("steadyload.properties.closed_form_tests.result_of", None)
    assert results_of(Lab(tmp_path / "here", 0), ["mujoco"], (90, 240), tests) == here


# --- what is compared ---------------------------------------------------------------------------


@pytest.mark.exact("an error that is less than moved starts make")
def test_errors_are_compared_with_what_engines_resolve(tmp_path, assert_shown):
    names = ("free fall", "intermediate-axis spin", "creep", "sink under 10", "sink under 100")
    chosen = [TESTS[name] for name in names]
    results = results_of(Lab(tmp_path / "work", 0), ["bullet", "chipmunk"], (90, 240), chosen)
    found = compare(results, {"made": "here"})
    scores = [(own["engine"], own["right"], own["of"]) for own in found.scores]
    assert scores == [("bullet", 3, 5), ("chipmunk", 3, 4)]
    assert [own["tests"] for own in found.series] == [[test] for test in chosen[:3]] + [chosen[3:]]
    fall, spin, creep, sink = (own["runs"] for own in found.series)
    first = fall.iloc[0]
    assert (first.engine, first.rate, first.error) == ("bullet", "90 Hz", "-16")
    assert first.value == pytest.approx(-457.333, abs=1e-3)
    by_engine = spin.groupby("engine")["error"].agg(set)
    assert by_engine["chipmunk"] == {"not defined: two dimensions"}
    assert "< 1e-06" in creep.groupby("engine")["error"].agg(set)["chipmunk"]
    assert [*sink][2:] == ["error_of:mass ratio 10", "error_of:mass ratio 100"]
    assert_shown(
        ClosedForms(),
        found,
        answer=["3 of 5", "3 of 4"],
        charts=["right", "closed-forms", "sink-under-a-heavy-load"],
    )


def test_the_study_measures_every_test(tmp_path, monkeypatch):
    monkeypatch.setattr(measuring, "with_second_model", lambda: (("chipmunk",), {}))
    found = ClosedForms().run(Lab(tmp_path, 0))
    assert [*found.overview["test"]] == list(TESTS)
    assert [*found.overview][2:] == ["error_of:chipmunk, 1000 Hz"]
    assert [*found.rocked["rate"]] == ["90 Hz", "240 Hz", "1000 Hz"]


def test_points_are_the_errors_in_their_panels():
    tests = [TESTS["sink under 10"], TESTS["sink under 100"]]
    least = tests[0].resolution
    results = [
        ClosedFormResult(tests[0].name, "mujoco", 90, 2.0, 2.0),
        ClosedFormResult(tests[0].name, "mujoco", 240, -0.5, -0.5),
        ClosedFormResult(tests[0].name, "reference", None, 0.0, 0.0),
        ClosedFormResult(tests[1].name, "mujoco", 90, None, None, "diverged"),
        ClosedFormResult(tests[1].name, "mujoco", 240, 3.0, 3.0),
        ClosedFormResult(tests[1].name, "reference", None, 1.0, 1.0),
    ]
    assert errors_by_frequency(tests[:1], results) == [
        (panel, title, engine, title != engine, place, size, negative, least)
        for panel in ["Sink under a heavy load: mass ratio 10 (mm)"]
        for title, engine, place, size, negative in [
            ("mujoco", "mujoco", 90, 2.0, False), ("mujoco", "mujoco", 240, 0.5, True),
            ("reference (own steps)", "reference", 90, least, False),
            ("reference (own steps)", "reference", 240, least, False),
        ]
    ]  # fmt: skip
    shown = [(p.panel, p.engine, p.place, p.size) for p in errors_by_argument(tests, results)]
    assert shown == [
        ("90 Hz", "mujoco", 10.0, 2.0), ("90 Hz", "reference", 10.0, least),
        ("90 Hz", "reference", 100.0, 1.0),
        ("240 Hz", "mujoco", 10.0, 0.5), ("240 Hz", "reference", 10.0, least),
        ("240 Hz", "mujoco", 100.0, 3.0), ("240 Hz", "reference", 100.0, 1.0),
    ]  # fmt: skip
