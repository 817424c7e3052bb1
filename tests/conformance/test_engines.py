"""Every engine, optional ones where installed, against every check of the conformance suite."""

from dataclasses import replace
from functools import cache

import pytest

from steadyload.engines.capabilities import SettingSupport, Support
from steadyload.engines.checks import changing_gravity, flight, landing, launching
from steadyload.engines.checks.conformance import CHECKS, NotApplicable
from steadyload.engines.checks.scenes import fill, turned_about, two_cubes
from steadyload.engines.registry import world_class
from steadyload.engines.with_mujoco import MujocoWorld
from steadyload.engines.world import EngineError, WorldSettings

MEMORY = "many_worlds_leave_no_memory"
OF_PLANNED_POSES = (
    "velocities_can_be_set",
    "poses_are_of_the_geometric_centre",
    "fixed_boxes_carry_and_never_move",
    "reseat_equals_a_fresh_world",
    "a_subset_equals_a_world_of_its_own",
    "a_box_starts_as_it_was_added",
    "a_subset_holds_boxes_in_motion",
    "motion_in_space_is_read_back",
)
OF_GRAVITY = {name for name in CHECKS if CHECKS[name].__module__ == changing_gravity.__name__}
OF_FLIGHT = {
    name
    for name in CHECKS
    if CHECKS[name].__module__ in (launching.__name__, flight.__name__, landing.__name__)
}
IN_SPACE = {
    "tipping_about_the_other_axis",
    "motion_in_space_is_read_back",
    "a_fast_spin_is_kept",
    "free_rotation",
    "free_rotation_of_stated_moments",
    "free_rotation_keeps_energy_and_momentum",
    "a_spinning_box_falls_along_a_parabola",
    "a_corner_drop_ends_on_the_nearest_face",
}
WITH_SUBSETS = {"a_subset_equals_a_world_of_its_own", "a_subset_holds_boxes_in_motion"}


@cache
def outcome(engine, name):
    """What a check raises, or None; every test below reads the same run of it."""
    try:
        CHECKS[name](world_class(engine))
    except (NotApplicable, AssertionError) as error:
        return error
    return None


def checks():
    """All but the one of memory, which is deep."""
    marks = pytest.mark.exact("compares with poses as they are planned")
    return [
        pytest.param(name, marks=marks if name in OF_PLANNED_POSES else ())
        for name in CHECKS
        if name != MEMORY
    ]


@pytest.mark.parametrize("name", checks())
def test_conformance(any_engine, name):
    answer(any_engine, name)


def test_many_worlds_leave_no_memory(any_engine):
    answer(any_engine, MEMORY)


def answer(engine, name):
    """Pass, fail, or say why not: the engine does not declare it, or is known to fail."""
    known = {failure.check: failure for failure in world_class(engine).capabilities.known_failures}
    error = outcome(engine, name)
    if isinstance(error, NotApplicable):
        pytest.skip(f"not applicable: {error}")
    if error is not None:
        if name not in known:
            raise error
        pytest.xfail(f"{known[name].kind}: {known[name].reason} ({error})")
    assert name not in known, "a known failure passes: take it from the adapter's list"


def test_boxes_are_left_out_only_where_declared(any_engine):
    engine = world_class(any_engine)
    with engine(WorldSettings()) as world:
        fill(world, two_cubes(0.01))
        world.reset_poses(only=[0, 1])
        if engine.capabilities.subsets:
            world.reset_poses(only=[1])
            assert len(world.poses().centres) == 1
        else:
            with pytest.raises(EngineError, match="cannot leave out boxes"):
                world.reset_poses(only=[1])
            assert len(world.poses().centres) == 2


def test_known_failures_are_few_and_explained(any_engine):
    failures = world_class(any_engine).capabilities.known_failures
    assert len(failures) <= 3
    for failure in failures:
        assert failure.check in CHECKS
        assert failure.reason
        assert failure.evidence


def test_an_engine_skips_only_what_it_declares_to_ignore(any_engine):
    """Were an engine skipped by every check, nothing would have been tested."""
    facts = world_class(any_engine).capabilities
    names = set(CHECKS) - {MEMORY, "repeat_in_a_fresh_process"}
    skipped = {name for name in names if isinstance(outcome(any_engine, name), NotApplicable)}
    assert skipped <= may_skip(facts)


def may_skip(facts):
    """Names of the checks that are about what an engine declares to be without."""
    skipped = {name for name, answer in facts.settings.items() if answer.support == "ignored"}
    skipped |= {"solver_iterations_count"} if "solver_iterations" in skipped else set()
    skipped |= IN_SPACE if facts.dimensions == 2 else set()
    skipped |= set() if facts.subsets else WITH_SUBSETS
    skipped |= OF_FLIGHT if facts.in_flight.support == "ignored" else set()
    return skipped | (OF_GRAVITY if facts.changing_gravity.support == "ignored" else set())


def test_an_engine_may_leave_gravity_as_it_is():
    """As one does that declares nothing about it."""

    class Still(MujocoWorld):
        capabilities = replace(
            MujocoWorld.capabilities, changing_gravity=SettingSupport(Support.IGNORED)
        )

    for name in OF_GRAVITY:
        with pytest.raises(NotApplicable, match="Still declares that its gravity cannot change"):
            CHECKS[name](Still)
    assert may_skip(MujocoWorld.capabilities) == may_skip(Still.capabilities) - OF_GRAVITY
    assert len(OF_GRAVITY) > 5


def test_an_engine_may_have_boxes_at_rest_alone():
    """As one does that declares nothing about them: it refuses others, in one sentence."""

    class Still(MujocoWorld):
        capabilities = replace(MujocoWorld.capabilities, in_flight=SettingSupport(Support.IGNORED))

    for name in OF_FLIGHT:
        with pytest.raises(NotApplicable, match="Still declares that its boxes start at rest"):
            CHECKS[name](Still)
    turned = turned_about((0.0, 1.0, 0.0), 10.0)
    with Still(WorldSettings()) as world:
        for more in ({"attitude": turned}, {"velocity": (1.0, 0.0, 0.0)}):
            with pytest.raises(EngineError, match="MuJoCo takes boxes upright and at rest alone"):
                world.add_box(replace(two_cubes(0.0)[0], **more))
        assert not world.boxes
    assert (
        may_skip(MujocoWorld.capabilities)
        == may_skip(Still.capabilities) - OF_FLIGHT | WITH_SUBSETS
    )
    assert len(OF_FLIGHT) > 10
