"""Recordings: what is shown is what was judged."""

import numpy as np
import pytest

from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods.contract.method import Status, Verdict
from steadyload.methods.registry import make_method
from steadyload.methods.session.recording import (
    RecordingError,
    record_failure,
    record_loading,
    simulation_of,
)
from steadyload.methods.simulation.criteria import Criterion

SPECS = [
    "ps3@bullet",
    "label@mujoco",
    "label@mujoco:criterion=paper,early_exit=0,between_steps=carry",
    "label@mujoco:frequency=77,samples=7",
    "label@mujoco:scope=local",
    "label@mujoco:scope=widening,rest_speed=0.02",
    "label@dart",
]


def record(layout, spec):
    return record_loading(layout, make_method(spec))


@pytest.mark.parametrize("spec", SPECS)
def test_a_recording_ends_where_the_judgement_does_with_its_displacement(spec, stack):
    method, failed = make_method(spec), 0
    for layout in (*random_layouts(5, seed=11), stack(0.0, 9.0)):
        said, seen = method.judge(layout), record_loading(layout, method)
        assert seen.verdict.failing_step == said.failing_step
        if said.failing_step is None:
            continue
        failed += 1
        last = seen.steps[-1]
        assert len(seen.steps) - 1 == said.failing_step
        moved = last.most_moved[last.judged - 1]
        assert moved.item == said.moved_item
        assert moved.displacement == pytest.approx(said.displacement, rel=1e-9)
        assert moved.rotation == pytest.approx(said.rotation, rel=1e-9)
        poses = last.poses.centres[last.judged - 1, moved.item]
        shift = poses - seen.planned[moved.item]
        if method.parameters.criterion is Criterion.PAPER:
            assert np.linalg.norm(shift) == pytest.approx(said.displacement, rel=1e-9)
        assert last.times[-1] == pytest.approx(method.parameters.t_max)
    assert failed > 0


def test_free_fall_is_seen_past_the_verdict_and_in_the_axes_of_the_layout():
    items = (Item(0, (0, 0, 0), (10, 10, 20), 1.0), Item(1, (40, 60, 70), (10, 10, 20), 1.0))
    seen = record(Layout("in the air", Pallet(100, 100, 100), items), "label@mujoco:frequency=2000")
    fall = seen.steps[1]
    assert fall.judged <= len(fall.times)
    expected = 65.0 - 100.0 * 0.5 * 9.8 * fall.times**2
    np.testing.assert_allclose(fall.poses.centres[:, 1, 1], expected, atol=0.3)
    np.testing.assert_allclose(fall.poses.centres[:, 1, [0, 2]], [[45.0, 80.0]] * len(fall.times))
    np.testing.assert_allclose(fall.poses.centres[:, 0], [[5.0, 5.0, 10.0]] * len(fall.times),
                               atol=0.01)  # fmt: skip


@pytest.mark.parametrize(
    ("size", "shift", "axis", "sign"),
    [((10, 10, 10), (6.5, 0, 0), 3, -1), ((10, 10, 10), (0, 0, 6.5), 1, 1)],
)
@pytest.mark.parametrize("engine", ["mujoco", "chipmunk"])
def test_what_tips_turns_about_the_axis_that_it_tips_over(size, shift, axis, sign, engine):
    """Tipping towards +x turns about -z, and towards +z about +x; also in a 2-D engine."""
    items = tuple(
        Item(n, tuple(30.0 + n * s + 10.0 * n * (a == 1) - 30.0 * (a == 1)
                      for a, s in enumerate(shift)), size, 1.0)
        for n in range(2)
    )  # fmt: skip
    seen = record(Layout("tips", Pallet(100, 100, 100), items), f"label@{engine}:t_max=0.4")
    turned = seen.steps[1].poses.quaternions[-1, 1]
    assert seen.verdict.failing_step == 1
    assert sign * turned[axis] > 0.05
    others = [a for a in (1, 2, 3) if a != axis]
    assert np.abs(turned[others]).max() < 0.01


def test_the_reference_is_recorded_too(stack):
    seen = record(stack(0.0, 7.0), "label@reference")
    assert seen.verdict.failing_step == 1
    assert seen.steps[1].most_moved[-1].item == 1


def test_what_simulates_nothing_has_no_steps(stack):
    seen = record(stack(0.0, 7.0), "sme")
    assert (seen.steps, seen.verdict.failing_step) == ((), 1)


def test_steps_that_need_no_simulation_are_empty(stack):
    seen = record(stack(0.0, 7.0), "label@mujoco:scope=widening,rest_speed=0.02")
    assert [len(step.times) > 0 for step in seen.steps] == [False, True]


def test_what_is_refused_is_one_sentence(plate):
    with pytest.raises(RecordingError, match="refuses layout 'plate': the layout is not planar"):
        record(plate(0.0), "label@chipmunk")


def test_a_state_that_is_not_finite_is_not_shown(monkeypatch, stack):
    from steadyload.engines.with_mujoco import MujocoWorld
    from steadyload.engines.world import Poses

    poses = MujocoWorld.poses

    def blow_up(self):
        seen = poses(self)
        lost = np.arange(len(seen.centres)) == 1  # the second box alone
        return Poses(np.where(lost[:, None], np.nan, seen.centres), seen.quaternions)

    monkeypatch.setattr(MujocoWorld, "poses", blow_up)
    seen = record(stack(0.0, 1.0), "label@mujoco")
    assert seen.verdict.status is Status.DIVERGED
    assert [len(step.times) > 0 for step in seen.steps] == [True, False]


def test_of_a_cascade_the_failing_step_is_shown_by_its_last_stage():
    cascade = make_method("cascade@mujoco:question=stands")
    layout = Layout(
        "falls",
        Pallet(100, 60, 100),
        tuple(
            Item(n, (40.0 + x, 10.0 * n, 40.0), (10, 10, 10), 1.0)
            for n, x in enumerate((0, 3, 9, 9))
        ),
    )
    found = record_loading(layout, cascade)
    assert found.method == "cascade@mujoco:question=stands"
    assert found.verdict.failing_step == 2
    assert found.simulates
    assert [len(step.times) > 0 for step in found.steps] == [False, False, True]
    # Its movement at the verdict is that of the simulation by itself.
    alone = record_loading(layout, cascade.stage_methods[-1])
    assert alone.verdict.failing_step == 2
    assert np.array_equal(found.steps[2].poses.centres, alone.steps[2].poses.centres)


def test_a_failure_that_the_simulation_does_not_see_is_shown_as_planned():
    layout = Layout(
        "stands", Pallet(100, 60, 100), (Item(0, (40.0, 0.0, 40.0), (10, 10, 10), 1.0),)
    )
    said = Verdict(1, failing_step=0)
    shown_by = simulation_of(make_method("ps_opt@mujoco:question=stands"))
    found = record_failure(layout, "sme", said, shown_by)
    assert not found.simulates
    assert found.steps == ()
    assert (found.method, found.verdict) == ("sme", said)


@pytest.mark.parametrize(("spec", "shown"), [
    ("sme", None),
    ("ps3@mujoco:between_steps=carry", None),
    ("ps_opt@mujoco", "ps_opt@mujoco"),
    ("cascade@mujoco", "ps_opt@mujoco"),
])  # fmt: skip
def test_only_what_begins_a_step_as_planned_shows_one(spec, shown):
    found = simulation_of(make_method(spec))
    assert (None if found is None else str(found.spec)) == shown
