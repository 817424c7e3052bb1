"""Rocking: the closed forms against other ways to them, and every engine against the forms."""

import dataclasses
import math

import numpy as np
import pytest

from steadyload.engines.capabilities import SettingSupport, Support
from steadyload.engines.registry import ENGINES, engines_here, world_class
from steadyload.engines.world import GRAVITY
from steadyload.properties import closed_forms as runs
from steadyload.properties import rocking
from steadyload.properties.closed_form_tests import ClosedFormResult, result_of, rocking_tests
from steadyload.studies.closed_forms.comparing import compare
from steadyload.studies.closed_forms.study import ClosedForms
from steadyload.studies.kit import Lab

TESTS = {test.name: test for test in rocking_tests()}
BLOCK = rocking.Block(0.1, 0.4)
SLENDER = rocking.Block(0.001, 1.0)


def swing(block, accelerated, seconds):
    """Angle over alpha of a block after some time, by small steps, until it is back or is over.

    ``accelerated``: the acceleration of the ground over g, by time.
    """
    alpha, square = block.slenderness, 0.75 * GRAVITY / (0.5 * math.hypot(*block))
    angle, speed, h = 0.0, 0.0, 1e-5
    for step in range(round(seconds / h)):
        push = accelerated((step + 0.5) * h)
        left = alpha - angle
        gain = square * (push * math.cos(left) - math.sin(left))
        if angle <= 0.0 and gain <= 0.0 and speed <= 0.0:
            angle = speed = 0.0
            continue
        speed += h * gain
        angle += h * speed
        if angle > 3.0 * alpha:
            break
    return angle / alpha


def half_sine(block, peak, seconds):
    height = peak * block.width / block.height
    return lambda t: height * math.sin(math.pi * t / seconds) if t < seconds else 0.0


# --- the forms ----------------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_the_period_of_a_slender_block_is_housners(share):
    expected = math.acosh(1.0 / (1.0 - share)) / SLENDER.rate
    assert rocking.time_to_impact(SLENDER, share) == pytest.approx(expected, rel=1e-5)


def test_the_period_follows_from_energy():
    """The time is the sum of da / w, with the speed w from the height lost."""
    start = 0.5 * BLOCK.slenderness
    # a = start (1 - u^2) takes the singularity at rest out of the integral.
    u = (np.arange(200_000) + 0.5) / 200_000
    lost = np.cos(BLOCK.slenderness - start) - np.cos(BLOCK.slenderness - start * (1.0 - u**2))
    speed = BLOCK.rate * np.sqrt(2.0 * lost)
    expected = (2.0 * start * u / speed).mean()
    assert rocking.time_to_impact(BLOCK, 0.5) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("block", [BLOCK, rocking.Block(0.3, 0.4)])
def test_an_impact_keeps_the_momentum_about_the_edge_that_is_struck(block):
    """Summed over the parts of the block, which turns about the one edge, then about the other."""
    width = block.width
    x, z = np.meshgrid(*((np.arange(400) + 0.5) / 400 * edge for edge in block))
    before = (x * (x - width) + z * z).sum()  # about the edge at `width`, at unit speed about 0
    after = ((x - width) ** 2 + z * z).sum()
    left = rocking.energy_after_impact(block)
    assert left == pytest.approx((before / after) ** 2, rel=1e-4)


@pytest.mark.parametrize("seconds", [0.2, 0.5])
def test_a_pulse_overturns_from_its_limit_on(seconds):
    limit = rocking.overturning_pulse(BLOCK, seconds)
    assert swing(BLOCK, half_sine(BLOCK, 0.999 * limit, seconds), 5.0) < 1.0
    assert swing(BLOCK, half_sine(BLOCK, 1.001 * limit, seconds), 5.0) > 2.0


@pytest.mark.parametrize("seconds", [0.1, 0.5, 2.0])
def test_the_limit_of_a_slender_block_has_a_closed_form(seconds):
    expected = rocking.slender_overturning_pulse(SLENDER.rate, seconds)
    assert rocking.overturning_pulse(SLENDER, seconds) == pytest.approx(expected, rel=1e-6)
    # Housner's own condition, which starts the pulse with the block in motion, is higher.
    assert expected < math.hypot(1.0, math.pi / seconds / SLENDER.rate)


def test_long_pulses_overturn_as_a_push_and_short_ones_as_a_blow():
    assert rocking.overturning_pulse(BLOCK, 20.0) == pytest.approx(1.0, abs=1e-3)
    # A blow gives the speed p^2 cos(alpha) tan(alpha) q 2 T / pi, and needs 2 p sin(alpha / 2).
    alpha, seconds = BLOCK.slenderness, 0.005
    blow = math.pi * math.sin(0.5 * alpha) / (BLOCK.rate * math.sin(alpha) * seconds)
    assert rocking.overturning_pulse(BLOCK, seconds) == pytest.approx(blow, rel=0.02)


# --- engines ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "largest"),
    [
        ("rocking from 0.2 alpha", 2.5),
        ("rocking from 0.5 alpha", 1.5),
        ("rocking from 0.8 alpha", 1.0),
        ("energy after rocking from 0.2 alpha", 20.0),
        ("energy after rocking from 0.5 alpha", 15.0),
        ("energy after rocking from 0.8 alpha", 15.0),
        ("overturning by a pulse of 0.2 s", 1.0),
        ("overturning by a pulse of 0.5 s", 1.0),
    ],
)
def test_every_engine_rocks_roughly_right(engine, name, largest):
    result = result_of(TESTS[name], runs.Stage(engine, 240), 240)
    assert result.note == ""
    assert abs(result.error) < largest


def test_of_own_steps_an_impact_takes_the_same_share_at_every_amplitude():
    """At fixed substeps it depends on where within one the edge strikes."""
    own, fixed = (
        [runs.energy_after_impact(runs.Stage(engine, 240), share) for share in (0.2, 0.5, 0.8)]
        for engine in ("reference", "mujoco")
    )
    assert own == pytest.approx([rocking.energy_after_impact(BLOCK)] * 3, rel=5e-3)
    assert np.ptp(fixed) > 4 * np.ptp(own) > 0.0


@pytest.mark.parametrize("installed", [True, False])
def test_drake_is_measured_where_it_is_here(installed, monkeypatch, tmp_path):
    """Where it is not here, the page and the command say why."""
    packages = () if installed else ("no-such-package",)
    entry = dataclasses.replace(ENGINES["drake"], packages=packages)
    monkeypatch.setitem(ENGINES, "drake", entry)
    asked = []

    def measured(lab, engines, frequencies):
        assert frequencies == (90,)
        asked.extend(engines)
        return results("mujoco", 240, [1.0] * len(TESTS))

    monkeypatch.setattr("steadyload.studies.closed_forms.measuring.measured", measured)
    study = ClosedForms(limit=1)
    found = study.run(Lab(tmp_path, 0))
    assert asked == [*engines_here(), *(("drake",) if installed else ())]
    told = list(study.remarks(found))
    if installed:
        assert told == []
    else:
        reason = "engine 'drake' needs the package no-such-package: pip install 'steadyload[drake]'"
        assert told == [f"left out: {reason}"]
        assert f"Left out: {reason}." in study.page(found).summary


def results(engine, frequency, errors):
    """One a test, with these errors in the order of the tests; a text is a reason why not."""
    return [
        ClosedFormResult(name, engine, frequency, None, None, error)
        if isinstance(error, str)
        else ClosedFormResult(name, engine, frequency, TESTS[name].expected, error)
        for name, error in zip(TESTS, errors, strict=True)
    ]


def test_the_page_shows_the_largest_error_of_every_series_at_every_frequency():
    nine, one = [9.0] * len(TESTS), [1.0] * len(TESTS)
    back = "not back on its base"
    found = compare(
        [
            *results("mujoco", 240, nine),
            *results("mujoco", 1000, [0.5, -2.0, 1.0, -0.0004, 0.0, 0.0002, 3.0, -3.5]),
            *results("reference", None, [0.1, back, -7.0, 2.0, -1.0, 0.5, 0.001, 0.002]),
            *results("dart", 1000, one)[1:],
        ],
        {},
    )
    assert found.rocked.to_numpy().tolist() == [
        ["mujoco", "240 Hz", "9.0", "9.0", "9.0"],
        ["mujoco", "1000 Hz", "-2.0", "< 0.001", "-3.5"],
        ["reference", "own", back, "2.0", "< 0.01"],
    ]
    series = dict.fromkeys(f"error_of:{test.series}" for test in TESTS.values())
    assert [*found.rocked] == ["engine", "rate", *series]
    page = ClosedForms().page(found)
    assert "A block that rocks" in [section.title for section in page.sections]
    bare = compare(results("dart", 1000, one)[1:], {})
    assert bare.rocked.empty
    assert "A block that rocks" not in [own.title for own in ClosedForms().page(bare).sections]


@pytest.mark.parametrize(
    ("name", "capability", "note"),
    [
        ("rocking from 0.5 alpha", "in_flight", "not defined: boxes start upright"),
        ("energy after rocking from 0.2 alpha", "in_flight", "not defined: boxes start upright"),
        (
            "overturning by a pulse of 0.5 s",
            "changing_gravity",
            "not defined: gravity does not change",
        ),
    ],
)
def test_what_an_engine_does_not_have_is_not_defined(name, capability, note, monkeypatch):
    facts = world_class("mujoco").capabilities
    lacking = dataclasses.replace(facts, **{capability: SettingSupport(Support.IGNORED)})
    monkeypatch.setattr(world_class("mujoco"), "capabilities", lacking)
    result = result_of(TESTS[name], runs.Stage("mujoco", 240), 240)
    assert (result.found, result.note) == (None, note)


def test_a_block_that_is_stopped_keeps_no_energy(monkeypatch):
    """It comes to rest on its base, as if the impact had taken all."""
    base = runs.Stage.samples

    def stopped(self, world, seconds):
        for time, poses in base(self, world, seconds):
            poses.quaternions[:, 2] = np.maximum(poses.quaternions[:, 2], 0.0)
            yield time, poses

    monkeypatch.setattr(runs.Stage, "samples", stopped)
    assert runs.energy_after_impact(runs.Stage("mujoco", 240), 0.5) == 0.0


def test_a_block_that_does_not_fall_has_no_period(monkeypatch):
    weightless = dataclasses.replace(runs.WorldSettings(), gravity=(0.0, 0.0, 0.0))
    monkeypatch.setattr(runs, "WorldSettings", lambda **of: weightless)
    with pytest.raises(runs.NoValueError, match="not back on its base"):
        runs.time_to_impact(runs.Stage("mujoco", 240), 0.5)
