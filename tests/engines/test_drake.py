"""Drake's process: it may die, wear out or be missing, and nobody else does."""

import signal

import numpy as np
import pytest

from steadyload.engines import registry
from steadyload.engines.registry import EngineEntry, engine_names, engines, world_class
from steadyload.engines.world import (
    Box,
    EngineError,
    EngineNotInstalledError,
    Velocities,
    WorldSettings,
)
from steadyload.layouts.model.question import Question
from steadyload.methods import make_method
from steadyload.studies.convergence.judging import judged
from steadyload.studies.kit import Lab

NEEDS_DRAKE = pytest.mark.deep("needs the extra drake")
CUBE = Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.05))


@pytest.fixture
def drake():
    try:
        world_class("drake")
    except EngineNotInstalledError as error:
        pytest.skip(str(error))
    from steadyload.engines import with_drake

    return with_drake


def test_optional_engines_are_known_but_not_compared_unasked():
    assert "drake" in engines()
    assert "drake" not in engine_names()


def test_a_missing_optional_engine_is_one_sentence_before_anything_is_judged(monkeypatch, stack):
    entry = EngineEntry(
        "steadyload.engines.with_drake:DrakeWorld", ("no-such-package",), extra="drake"
    )
    monkeypatch.setitem(registry.ENGINES, "drake", entry)
    method = make_method("simulation@drake")
    with pytest.raises(EngineNotInstalledError, match=r"pip install 'steadyload\[drake\]'"):
        method.prepare()
    assert registry.capabilities("drake").dimensions == 3


@NEEDS_DRAKE
def test_verdicts(drake, stack):
    method = make_method("simulation@drake:between_steps=reseat")
    assert method.judge(stack(0.0, 4.0, 0.0)).stable
    assert method.judge(stack(0.0, 6.0)).failing_step == 1


@NEEDS_DRAKE
def test_a_death_is_an_error_and_the_next_layout_has_its_verdict(drake, stack, monkeypatch):
    method = make_method("simulation@drake")
    advance = drake.DrakeWorld._advance

    def killed_first(world, substeps, length):
        world._prepare()
        world._holder._process.kill()
        advance(world, substeps, length)

    with monkeypatch.context() as patched:
        patched.setattr(drake.DrakeWorld, "_advance", killed_first)
        verdict = method.judge(stack(0.0))
    assert verdict.status == "error"
    assert "Drake's process ended (-9)" in verdict.reason
    assert method.judge(stack(0.0)).stable


@NEEDS_DRAKE
def test_silence_is_an_error(drake, monkeypatch):
    with drake.DrakeWorld(WorldSettings()) as world:
        world.add_box(CUBE)
        world.prepare()
        monkeypatch.setattr("steadyload.engines.child._PATIENCE", 0.0)
        drake.DrakeWorld.children.current()._process.send_signal(
            signal.SIGSTOP
        )  # else it may be quick enough
        with pytest.raises(EngineError, match="no answer"):
            world.stepSimulation(0.1, 100, 0.01)
        monkeypatch.undo()
        world.stepSimulation(0.1, 100, 0.01)
        assert world.poses().centres[0, 2] == pytest.approx(0.05, abs=1e-4)


@NEEDS_DRAKE
def test_an_invariant_of_drake_that_fails_says_which(drake):
    with drake.DrakeWorld(WorldSettings()) as world:
        bad = Box(CUBE.size, float("nan"), CUBE.centre)
        world._add(bad)  # add_box would refuse it
        world.boxes.append(bad)
        with pytest.raises(EngineError, match="Drake"):
            world.stepSimulation(0.1, 100, 0.01)


@NEEDS_DRAKE
def test_worlds_outlive_the_change_of_the_process(drake, monkeypatch):
    def fall(world):
        world.stepSimulation(0.1, 100, 0.01)
        return world.poses().centres

    with drake.DrakeWorld(WorldSettings()) as first:
        first.add_box(Box(CUBE.size, 1.0, (0.0, 0.0, 3.0)))
        before = fall(first)
        monkeypatch.setattr(drake.DrakeWorld.children, "most_builds", 0)
        with drake.DrakeWorld(WorldSettings()) as second:
            second.add_box(Box(CUBE.size, 1.0, (0.0, 0.0, 3.0)))
            assert (fall(second) == before).all()
            assert second._holder is not first._holder
        after = fall(first)
    assert after[0, 2] == pytest.approx(3.0 - 0.5 * 9.8 * 0.2**2, abs=0.02)


@NEEDS_DRAKE
def test_a_box_that_is_added_keeps_the_motion_of_the_others(drake):
    with drake.DrakeWorld(WorldSettings()) as world:
        world.add_box(Box(CUBE.size, 1.0, (0.0, 0.0, 3.0)))
        world.stepSimulation(0.1, 100, 0.01)
        before = world.poses().centres[0], world.velocities().linear[0]
        world.add_box(CUBE)
        assert (world.poses().centres[0] == before[0]).all()
        world.stepSimulation(0.1, 100, 0.01)
        assert world.velocities().linear[0, 2] == pytest.approx(before[1][2] - 0.98)


@NEEDS_DRAKE
def test_velocities_can_be_set(drake):
    with drake.DrakeWorld(WorldSettings(gravity=(0.0, 0.0, 0.0))) as world:
        world.add_box(Box(CUBE.size, 1.0, (5.0, 0.0, 3.0), fixed=True))
        world.add_box(Box(CUBE.size, 1.0, (0.0, 0.0, 3.0), (0.01, 0.0, 0.0)))
        world.stepSimulation(0.1, 100, 0.01)
        linear, angular = np.zeros((2, 2, 3))
        linear[1], angular[1] = (1.0, 2.0, 3.0), (0.0, 0.0, 0.5)
        world._set_velocities(Velocities(linear, angular))
        world.stepSimulation(0.1, 100, 0.01)
        assert world.velocities().linear == pytest.approx(linear)
        assert world.velocities().angular == pytest.approx(angular)
        assert world.poses().centres[1] == pytest.approx((0.1, 0.2, 3.3), abs=1e-3)


def test_a_missing_judge_shows_before_anything_is_computed(monkeypatch, tmp_path):
    entry = EngineEntry(
        "steadyload.engines.with_drake:DrakeWorld", ("no-such-package",), extra="drake"
    )
    monkeypatch.setitem(registry.ENGINES, "drake", entry)
    with pytest.raises(EngineNotInstalledError, match="drake"):
        judged(Lab(tmp_path / "work"), ("label@drake",), Question.WITHIN, 1)
    assert not (tmp_path / "work").exists()
