"""What Rapier and PhysX need beyond the conformance suite: their own options, and shared state."""

import numpy as np
import pytest

from steadyload.engines.registry import EngineNotInstalledError, world_class
from steadyload.engines.world import Box, Velocities, WorldSettings
from steadyload.methods import make_method

CUBE = (0.1, 0.1, 0.1)


@pytest.fixture
def world_of():
    def found(name):
        try:
            return world_class(name)
        except EngineNotInstalledError as error:
            pytest.skip(str(error))

    return found


def moved(world, boxes, settings):
    """How far any of some boxes is from its place after 0.3 s at 240 Hz [m]."""
    with world(settings) as made:
        for box in boxes:
            made.add_box(box)
        made.stepSimulation(0.3, 10**6, 1.0 / 240.0)
        return float(np.abs(made.poses().centres - [box.centre for box in boxes]).max())


def test_a_higher_frequency_of_contacts_lets_a_pile_sink_less(world_of):
    rapier = world_of("rapier")
    from steadyload.engines.rapier_options import RapierOptions

    pile = [Box(CUBE, 1.0, (0.0, 0.0, 0.05 + 0.1 * level)) for level in range(10)]
    sunk = [
        moved(rapier, pile, WorldSettings(options=RapierOptions(contact_frequency=frequency)))
        for frequency in (30.0, 120.0)
    ]
    # A spring of frequency f sinks by g / (2 pi f)^2: a sixteenth, and the depth that it lets be.
    assert 8.0 < sunk[0] / sunk[1] < 16.0
    with pytest.raises(TypeError, match="allowed: RapierOptions"):
        rapier(WorldSettings(options=object()))


def test_small_boxes_are_pushed_apart_unless_they_are_simulated_larger(world_of):
    rapier = world_of("rapier")
    from steadyload.engines.rapier_options import RapierOptions

    side = 0.01
    wall = [
        Box((side, side, side), 0.001, (side * i, 0.0, side * (0.5 + k)))
        for k in range(3)
        for i in range(4)
    ]
    as_it_is, larger = (
        moved(rapier, wall, WorldSettings(options=RapierOptions(length_scale=scale)))
        for scale in (1.0, 10.0)
    )
    assert larger < 3e-4 < 2e-3 < as_it_is


def test_options_of_rapier_are_parameters_of_a_simulation(world_of, stack):
    world_of("rapier")
    method = make_method("simulation@rapier:contact_frequency=200,length_scale=1")
    assert method.judge(stack(0.0, 4.0)).stable
    assert not method.judge(stack(0.0, 6.0)).stable


@pytest.mark.deep("needs the extra physx")
def test_what_others_set_for_the_whole_process_moves_no_world(world_of):
    world = world_of("physx")
    from sapien import physx

    boxes = [Box(CUBE, 1.0, (0.0, 0.0, 0.05)), Box(CUBE, 2.0, (0.06, 0.0, 0.15))]
    expected = moved(world, boxes, WorldSettings())
    assert expected > 0.01, "the upper one should fall"
    kept = physx.get_scene_config(), physx.get_body_config(), physx.get_shape_config()
    try:
        physx.set_scene_config(gravity=[3.0, 0.0, 5.0], enable_tgs=False, enable_pcm=False)
        physx.set_body_config(
            solver_position_iterations=1, solver_velocity_iterations=9, sleep_threshold=1e3
        )
        physx.set_shape_config(contact_offset=0.05, rest_offset=0.03)
        assert moved(world, boxes, WorldSettings()) == expected
    finally:
        physx.set_scene_config(kept[0])
        physx.set_body_config(kept[1])
        physx.set_shape_config(kept[2])


@pytest.mark.deep("needs the extra physx, and rapier")
@pytest.mark.parametrize("name", ["physx", "rapier"])
def test_numbers_of_single_precision_are_told(world_of, name):
    world = world_of(name)
    assert world.capabilities.single_precision
    with world(WorldSettings(gravity=(0.0, 0.0, 0.0))) as made:
        made.add_box(Box(CUBE, 1.0, (0.11, 0.23, 0.31)))
        assert made.poses().centres.tolist() == [[0.11, 0.23, 0.31]], "as planned, to the last bit"
        made.stepSimulation(0.1, 10, 0.01)
        centre = made.poses().centres[0]
    assert 0.0 < np.abs(centre - (0.11, 0.23, 0.31)).max() < 1e-7


@pytest.mark.parametrize("name", ["rapier", "physx"])
def test_what_starts_with_a_fast_turn_keeps_it(world_of, name):
    world = world_of(name)
    fast = Box(CUBE, 1.0, (0.0, 0.0, 5.0), angular_velocity=(0.0, 1000.0, 0.0))
    with world(WorldSettings(gravity=(0.0, 0.0, 0.0))) as made:
        made.add_box(fast)
        made.stepSimulation(0.1, 10**6, 1.0 / 480.0)
        assert made.velocities().angular[0] == pytest.approx((0.0, 1000.0, 0.0), abs=0.1)


def test_rapier_cuts_a_turn_that_is_given_later(world_of):
    """As its declaration says: by an eighth of a turn a substep."""
    with world_of("rapier")(WorldSettings(gravity=(0.0, 0.0, 0.0))) as made:
        made.add_box(Box(CUBE, 1.0, (0.0, 0.0, 5.0)))
        spin = Velocities(np.zeros((1, 3)), np.array([(0.0, 1000.0, 0.0)]))
        made.set_velocities(spin)
        made.stepSimulation(0.1, 10**6, 1.0 / 480.0)
        assert made.velocities().angular[0, 1] == pytest.approx(480.0 * np.pi / 4.0, rel=0.01)
