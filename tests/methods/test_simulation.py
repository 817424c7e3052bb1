"""The loading loop itself, on an engine whose motion is prescribed, and on real ones."""

import math
import sys

import numpy as np
import pytest

from steadyload.engines import registry
from steadyload.engines.registry import EngineEntry
from steadyload.engines.world import (
    Capabilities,
    EngineError,
    FixedStepWorld,
    Poses,
    SettingSupport,
    Support,
    Velocities,
    declare,
)
from steadyload.layouts import Item, Layout, Pallet
from steadyload.methods import Status, make_method
from steadyload.methods.contract import stopwatch
from steadyload.methods.contract.method import Stopwatch
from steadyload.methods.simulation.criteria import euler_angles
from steadyload.methods.simulation.scene import boxes


class ScriptedWorld(FixedStepWorld):
    """Nothing falls; the test says how each box moves with the time since it was last seated."""

    capabilities = Capabilities(
        title="scripted",
        dimensions=3,
        settings=declare(
            friction=SettingSupport(Support.HONOURED),
            restitution=SettingSupport(Support.ON_REQUEST),
            linear_damping=SettingSupport(Support.EMULATED),
            angular_damping=SettingSupport(Support.IGNORED),
            margin=SettingSupport(Support.IGNORED),
            broad_phase=SettingSupport(Support.HONOURED, values=("dbvt",)),
            solver_iterations=SettingSupport(Support.IGNORED),
        ),
    )
    drift = (0.0, 0.0, 0.0)
    spin = 0.0
    fault = None

    def __init__(self, settings):
        super().__init__(settings)
        self.time, self.resets, self.calls = 0.0, 0, []
        type(self).last = self

    def _add(self, box):
        pass

    def _advance(self, substeps, length):
        self.calls.append((len(self.boxes), substeps))
        self.time += substeps * length
        if self.fault:
            raise EngineError(self.fault)

    def _poses(self):
        centres = np.array([b.centre for b in self.boxes])
        centres[-1] += self.time * np.array(self.drift)
        half = 0.5 * self.time * self.spin
        quaternions = np.tile([1.0, 0.0, 0.0, 0.0], (len(self.boxes), 1))
        quaternions[-1] = math.cos(half), 0.0, 0.0, math.sin(half)
        return Poses(centres, quaternions)

    def _velocities(self):
        zeros = np.zeros((len(self.boxes), 3))
        return Velocities(zeros, zeros)

    def _set_velocities(self, velocities):
        pass

    def _reset(self):
        self.time = 0.0
        self.resets += 1

    def _close(self):
        pass


@pytest.fixture
def scripted(monkeypatch):
    """Registers the scripted engine: its own class and one registry line."""
    # Under --import-mode=importlib this module is importable only by the name it runs under.
    monkeypatch.setitem(sys.modules, __name__, sys.modules[ScriptedWorld.__module__])
    monkeypatch.setitem(registry.ENGINES, "scripted", EngineEntry(f"{__name__}:ScriptedWorld"))
    for name, value in (("drift", (0.0, 0.0, 0.0)), ("spin", 0.0), ("fault", None)):
        monkeypatch.setattr(ScriptedWorld, name, value)
    return ScriptedWorld


def judge(values, layout):
    return make_method(f"simulation@scripted:{values}").judge(layout)


def test_a_layout_becomes_boxes_by_a_rotation():
    items = (Item(0, (1.0, 2.0, 3.0), (10.0, 20.0, 30.0), 5.0, (0.5, -1.0, 1.5)),)
    (box,) = boxes(Layout("a", Pallet(50.0, 50.0, 50.0), items))
    # World (x, y, z) = layout (z, x, y), in metres; centre = (6, 12, 18) cm in layout axes.
    assert box.size == pytest.approx((0.30, 0.10, 0.20))
    assert box.centre == pytest.approx((0.18, 0.06, 0.12))
    assert box.mass_offset == pytest.approx((0.015, 0.005, -0.01))
    assert box.mass == 5.0


def test_every_placement_runs_t_max_times_frequency_substeps(scripted, stack):
    verdict = judge("t_max=0.3,frequency=90,samples=10", stack(0.0, 0.0, 0.0))
    assert verdict.failing_step is None
    assert verdict.effort.substeps == 3 * 27
    per_step = [sum(n for j, n in scripted.last.calls if j == k) for k in (1, 2, 3)]
    assert per_step == [27, 27, 27]


def test_reseat_resets_between_placements_and_carry_never(scripted, stack):
    judge("between_steps=carry", stack(0.0, 0.0, 0.0))
    assert scripted.last.resets == 0
    judge("between_steps=reseat", stack(0.0, 0.0, 0.0))
    assert scripted.last.resets == 2


def test_carried_motion_adds_up_and_reseated_motion_does_not(scripted, stack):
    # 4 cm a placement against a threshold of 10 cm: 12 cm after the third.
    scripted.drift = (0.4, 0.0, 0.0)
    values = "t_max=0.1,frequency=100,samples=1,eps_t=10"
    assert judge(f"{values},between_steps=carry", stack(*[0.0] * 5)).failing_step == 2
    assert judge(f"{values},between_steps=reseat", stack(*[0.0] * 5)).failing_step is None


def test_any_sample_counts_for_the_paper_and_only_the_last_for_adams(scripted, stack, monkeypatch):
    # There and back: 12 cm off in the middle of the placement, at home at its end.
    def poses(self):
        centres = np.array([b.centre for b in self.boxes])
        centres[-1, 0] += 0.12 * math.sin(math.pi * self.time / 0.1)
        return Poses(centres, np.tile([1.0, 0.0, 0.0, 0.0], (len(self.boxes), 1)))

    monkeypatch.setattr(scripted, "_poses", poses)
    values = "t_max=0.1,frequency=100,between_steps=reseat,eps_t=10"
    assert judge(f"{values},criterion=paper,samples=10", stack(0.0)).failing_step == 0
    assert judge(f"{values},criterion=paper,samples=1", stack(0.0)).failing_step is None
    assert judge(f"{values},criterion=adams,samples=10", stack(0.0)).failing_step is None


def test_the_paper_measures_the_centre_and_adams_an_axis_of_the_corner(scripted, stack):
    # 8 cm along two axes: 11.3 cm Euclidean, 8 cm along an axis.
    scripted.drift = (0.8, 0.8, 0.0)
    values = "t_max=0.1,frequency=100,eps_t=10"
    paper = judge(f"{values},criterion=paper", stack(0.0))
    assert paper.failing_step == 0
    assert judge(f"{values},criterion=adams", stack(0.0)).failing_step is None
    # Half a turn about the vertical: the centre stays, the corner moves by a side (10 cm) along
    # both axes.
    scripted.drift, scripted.spin = (0.0, 0.0, 0.0), 10.0 * math.pi
    turn = "t_max=0.1,frequency=100,eps_t=9,eps_r=1000"
    assert judge(f"{turn},criterion=paper", stack(0.0)).failing_step is None
    adams = judge(f"{turn},criterion=adams", stack(0.0))
    assert adams.failing_step == 0
    assert adams.displacement == pytest.approx(10.0, abs=1e-6)


def test_rotation_counts_in_either_direction(scripted, stack):
    for spin in (2.0, -2.0):  # 0.2 rad = 11.5 degrees in 0.1 s
        scripted.spin = spin
        verdict = judge("t_max=0.1,frequency=100,eps_r=10,samples=1", stack(0.0))
        assert verdict.failing_step == 0
        assert verdict.rotation == pytest.approx(math.degrees(0.2), abs=1e-6)
    assert judge("t_max=0.1,frequency=100,eps_r=12", stack(0.0)).failing_step is None


def test_the_last_item_is_examined_too(scripted, stack):
    """The printed Algorithm 1 looks before it steps and never after the last item."""
    scripted.drift = (2.0, 0.0, 0.0)
    verdict = judge("t_max=0.1,frequency=100", stack(0.0))
    assert (verdict.failing_step, verdict.score) == (0, 0.0)


def test_a_state_that_is_not_finite_is_diverged_and_has_no_score(scripted, stack):
    scripted.drift = (math.nan, 0.0, 0.0)
    verdict = judge("t_max=0.1", stack(0.0, 0.0))
    assert verdict.status is Status.DIVERGED
    assert (verdict.score, verdict.failing_step, verdict.stable) == (None, None, False)
    assert "item 0" in verdict.reason


def test_an_engine_error_is_a_verdict_and_the_world_is_closed(scripted, stack):
    scripted.fault = "out of memory for contacts"
    verdict = judge("t_max=0.1", stack(0.0))
    assert (verdict.status, verdict.reason) == (Status.ERROR, "out of memory for contacts")
    assert scripted.last._closed


def test_an_engine_error_at_a_step_is_its_finding_and_no_score(scripted, stack):
    scripted.fault = "out of memory for contacts"
    steps = make_method("simulation@scripted:t_max=0.1,between_steps=reseat").steps(
        stack(0.0), Stopwatch()
    )
    assert math.isnan(steps.step_score(0))
    found = steps.finding(0)
    assert (found.status, found.reason) == (Status.ERROR, "out of memory for contacts")


def test_settings_that_an_engine_ignores_are_in_the_verdict(scripted, stack):
    values = "restitution=0.5,linear_damping=0.1,margin=0.01,broad_phase=sweep"
    verdict = judge(values, stack(0.0))
    assert verdict.ignored == ("restitution", "margin", "broad_phase")
    assert verdict.emulated == ("linear_damping",)
    asked = judge("restitution=0.5,emulate=restitution,broad_phase=dbvt", stack(0.0))
    assert (asked.ignored, asked.emulated) == ((), ("restitution",))
    assert judge("", stack(0.0)).ignored == ()


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("angle", [-0.7, 0.1, 1.2])
def test_euler_angles_of_a_turn_about_one_layout_axis(axis, angle):
    # Layout x, y, z are world y, z, x.
    quaternion = [math.cos(angle / 2), 0.0, 0.0, 0.0]
    quaternion[1 + (axis + 1) % 3] = math.sin(angle / 2)
    expected = [0.0, 0.0, 0.0]
    expected[axis] = abs(angle)
    assert euler_angles(np.array([quaternion]))[0] == pytest.approx(expected, abs=1e-12)


def test_repeated_judgements_are_identical(engine, stack):
    method = make_method(f"simulation@{engine}:frequency=90")
    layouts = [stack(0.0, 2.0, 4.5), stack(0.0, 6.0), stack(0.0, 2.0, 4.5)]
    first, _, third = method.judge_many(layouts)
    again = make_method(f"simulation@{engine}:frequency=90").judge(layouts[0])
    for verdict in (third, again):
        assert (verdict.failing_step, verdict.displacement) == (
            first.failing_step,
            first.displacement,
        )


def test_steps_and_building_are_told_apart(engine, stack, told_time):
    told_time(engine, stopwatch)
    verdict = make_method(f"simulation@{engine}").judge(stack(0.0, 0.0))
    build, step = 2 * 20e-3, verdict.effort.substeps * 1e-3
    for seconds in (verdict.cpu, verdict.wall):
        assert (seconds.build, seconds.read) == (pytest.approx(build), 0.0)
        assert seconds.step == pytest.approx(step)
        assert seconds.total == pytest.approx(build + step)
