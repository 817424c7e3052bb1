"""Limits by simulation against closed forms, and what cannot be asked."""

import time

import pytest
from tested_engines import TESTED

from steadyload.engines.registry import capabilities
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.simulation_parameters import SimulationParameters
from steadyload.transport.balance import Mode
from steadyload.transport.errors import TransportError
from steadyload.transport.history import constant, trapezoid
from steadyload.transport.limits import RESOLUTION, around, limits
from steadyload.transport.recording import record_ride
from steadyload.transport.riding import LoadedWorld
from steadyload.transport.rules import Rule, rules
from steadyload.transport.trials import under_history, under_rule
from steadyload.transport.whole_load import whole_load_limit

PALLET = Pallet(120.0, 200.0, 80.0)
FLAT = Layout("flat", PALLET, (Item(0, (40.0, 0.0, 30.0), (30.0, 10.0, 30.0), 8.0),))
TALL = Layout("tall", PALLET, (Item(0, (40.0, 0.0, 30.0), (12.0, 40.0, 30.0), 8.0),))
SPATIAL = [e for e in TESTED if capabilities(e).dimensions == 3]


@pytest.mark.parametrize("engine", SPATIAL)
def test_a_box_slides_at_its_friction_and_tips_over_its_edge_on_every_engine(engine):
    method = f"simulation@{engine}:frequency=480,friction=0.4"
    (slides,) = limits(FLAT, method, directions=(90.0,))
    assert slides.limit_g == pytest.approx(0.4, abs=0.02 * 0.4 + RESOLUTION)
    assert slides.mode is Mode.SLIDES
    (tips,) = limits(TALL, method, directions=(180.0,))
    assert tips.limit_g == pytest.approx(0.3, abs=0.02 * 0.3 + RESOLUTION)
    assert tips.mode is Mode.TIPS
    assert tips.moved_item == slides.moved_item == 0


def test_exact_limits_name_direction_box_and_cost():
    found = limits(TALL, directions=4)
    assert [one.direction_deg for one in found] == [0.0, 90.0, 180.0, 270.0]
    assert [one.limit_g for one in found] == pytest.approx([0.3, 0.5, 0.3, 0.5], abs=1e-6)
    assert all(one.displacement_cm is None and one.cpu_ms > 0.0 for one in found)


def test_the_cost_of_a_simulated_limit_is_nearly_all_cpu_time_that_was_spent():
    method = make_method("simulation@mujoco:frequency=480")
    limits(TALL, method, directions=(0.0,))
    start = time.process_time()
    (found,) = limits(TALL, method, directions=(0.0,))
    spent = 1e3 * (time.process_time() - start)
    assert 0.3 * spent < found.cpu_ms <= spent


def test_a_load_that_falls_at_rest_holds_nothing_by_any_method():
    tips = Layout(
        "tips", PALLET,
        (Item(0, (0.0, 0.0, 0.0), (20.0, 10.0, 20.0), 5.0),
         Item(1, (17.0, 10.0, 0.0), (20.0, 10.0, 20.0), 5.0)),
    )  # fmt: skip
    for method in ("equilibrium:sides=frictionless", "simulation@mujoco:frequency=480"):
        (found,) = limits(tips, method, directions=(0.0,))
        assert found.limit_g == pytest.approx(0.0, abs=RESOLUTION), method
        assert found.moved_item == 1


@pytest.mark.parametrize(
    ("method", "message"),
    [
        ("sme", "method sme: does not know friction; allowed: equilibrium:sides=frictionless"),
        ("equilibrium", "has vertical forces alone; allowed: sides=frictionless"),
        ("simulation@chipmunk", "engine chipmunk: has two dimensions; allowed: one of three"),
    ],
)
def test_a_method_that_cannot_answer_is_refused(method, message):
    with pytest.raises(TransportError, match=message):
        limits(FLAT, method)


@pytest.mark.parametrize("count", [0, -1, 361])
def test_a_number_of_directions_that_cannot_be_is_refused(count):
    with pytest.raises(TransportError, match="allowed: 1 to 360"):
        around(count)


def test_no_directions_at_all_are_refused():
    with pytest.raises(TransportError, match="no directions; allowed: one or more"):
        limits(FLAT, directions=())


def test_a_box_that_slides_before_it_is_pushed_has_not_fallen():
    """A flat box on a floor without friction, beside one that leans on it and pushes it away."""
    ramp = Layout(
        "leaning", Pallet(200, 200, 200),
        (
            Item(0, (60.0, 0.0, 60.0), (40.0, 2.0, 40.0), 0.5),
            Item(1, (60.0, 2.0, 60.0), (40.0, 20.0, 40.0), 50.0, mass_offset=(19.9, 0.0, 0.0)),
        ),
    )  # fmt: skip
    with LoadedWorld(ramp, "mujoco", SimulationParameters(frequency=480, friction=0.0)) as world:
        ride = world.ride(constant(0.0, 1.0), 0.0, displacement=0.01, rotation=0.01)
    assert not ride.held
    assert ride.fell == ()


def test_a_box_slides_as_far_as_a_pulse_pushes_it():
    """By a - mu g while the pulse is on, and is braked by mu g after it."""
    friction, level, hold, g = 0.3, 0.5, 0.4, 9.8
    parameters = SimulationParameters(frequency=960, friction=friction)
    with LoadedWorld(FLAT, "mujoco", parameters) as world:
        pulse = constant(level, hold)
        ride = world.ride(pulse, 0.0, displacement=500.0, rotation=30.0, rest=1.0)
        again = world.ride(pulse, 0.0, displacement=500.0, rotation=30.0, rest=1.0)
        short = world.ride(pulse, 0.0, displacement=1.0, rotation=30.0, rest=1.0)
    pushed = (level - friction) * g
    speed = pushed * hold
    expected = 0.5 * pushed * hold**2 + 0.5 * speed**2 / (friction * g)
    assert ride.held
    assert ride.displacement == pytest.approx(100.0 * expected, rel=0.03)
    assert ride.left == pytest.approx(ride.displacement, rel=1e-3)
    assert ride == again
    assert (short.held, short.mode) == (False, Mode.SLIDES)
    assert short.seconds == pytest.approx((0.02 / pushed) ** 0.5, abs=0.011)


@pytest.mark.parametrize(("level", "hold"), [(20.0, 0.004), (10.0, 0.015), (5.0, 0.014)])
def test_a_short_blow_pushes_a_box_as_far_as_its_impulse(level, hold):
    friction, g = 0.5, 9.8
    pushed = (level - friction) * g
    expected = 0.5 * pushed * hold**2 + 0.5 * (pushed * hold) ** 2 / (friction * g)
    parameters = SimulationParameters(frequency=2000, friction=friction)
    with LoadedWorld(FLAT, "mujoco", parameters) as world:
        ride = world.ride(constant(level, hold), 0.0, displacement=500.0, rotation=30.0, rest=1.0)
    # The impulse is spread over spans of 10 ms: up to so much longer under way.
    assert ride.displacement == pytest.approx(100.0 * expected, rel=0.15)


@pytest.mark.parametrize("engine", ["mujoco", "dart"])
def test_a_flat_box_that_tips_is_said_to_tip(engine):
    """Its centre of mass is 3 cm from its edge and 10 cm high."""
    flat = Layout(
        "flat", Pallet(400, 300, 400),
        (Item(0, (150.0, 0.0, 150.0), (40.0, 20.0, 40.0), 5.0, (17.0, 0.0, 0.0)),),
    )  # fmt: skip
    (found,) = limits(flat, f"label@{engine}", directions=(0.0,))
    assert found.mode == Mode.TIPS
    assert found.limit_g == pytest.approx(0.3, abs=0.015)


def test_a_load_that_falls_holds_not_even_a_level_of_nothing():
    overhanging = Layout(
        "falls", Pallet(400, 300, 400),
        (
            Item(0, (100.0, 0.0, 100.0), (20.0, 20.0, 20.0), 5.0),
            Item(1, (115.0, 20.0, 100.0), (40.0, 20.0, 20.0), 5.0),
        ),
    )  # fmt: skip
    still = Rule("still", "", "", {"forwards": 0.0}, 0.0, 0.5, 0.1, 10.0, displacement=5.0)
    for method in ("equilibrium:sides=frictionless", "label@mujoco"):
        assert under_rule(overhanging, still, method)[0].held is False, method


def test_a_box_that_overhangs_the_deck_tips_over_the_edge_of_the_deck():
    box = Item(0, (-9.0, 0.0, 10.0), (20.0, 20.0, 20.0), 5.0)
    layout = Layout("over", Pallet(120, 200, 80), (box,))
    assert whole_load_limit(layout, 0.5, 180.0) == pytest.approx(0.1, abs=1e-3)
    assert limits(layout, directions=(180.0,))[0].limit_g == pytest.approx(0.1, abs=1e-3)


def test_a_tilted_deck_is_held_to_the_angle_of_friction():
    parameters = SimulationParameters(frequency=480, friction=0.4)
    with LoadedWorld(FLAT, "mujoco", parameters) as world:
        held = [
            world.ride(
                trapezoid(level, 0.5, 1.5, tilted=True), 45.0, displacement=5.0, rotation=10.0
            ).held
            for level in (0.38, 0.42)
        ]
    assert held == [True, False]


def test_a_rule_is_held_by_what_holds_its_levels():
    rule = rules()["eumos40509"]
    for method in ("equilibrium:sides=frictionless,friction=0.6", "label@mujoco:friction=0.6"):
        flat, tall = (under_rule(layout, rule, make_method(method)) for layout in (FLAT, TALL))
        assert [one.held for one in flat] == [True] * 4, method
        assert [one.held for one in tall] == [False, True, False, True], method
        assert {one.level_g for one in flat} == {0.5}
    lying = tall[0]
    assert (lying.mode, lying.moved_item, lying.fell) == (Mode.TIPS, 0, ())
    assert lying.rotation_deg == pytest.approx(90.0, abs=3.0)


def test_a_ride_is_recorded_for_as_long_as_its_rule_lasts_and_then_watches():
    rule, method = rules()["en12195"], make_method("simulation@mujoco:frequency=480")
    times = record_ride(FLAT, rule, 0.0, method).steps[-1].times
    lasts = rule.history(rule.level(0.0)).duration
    assert len(times) > 20
    assert lasts < times[-1] <= lasts + rule.rest + 0.1


def test_a_history_needs_a_method_that_knows_time():
    with pytest.raises(TransportError, match="knows no time; allowed: a simulation such as"):
        under_history(FLAT, constant(0.1, 1.0), (0.0,), "equilibrium:sides=frictionless")
    (found,) = under_history(FLAT, constant(-0.3, 1.0), (0.0,), "label@mujoco")
    assert (found.held, found.level_g) == (True, -0.3)


def test_poses_that_are_no_numbers_are_an_error_with_a_reason(monkeypatch):
    from steadyload.engines.with_mujoco import MujocoWorld

    real = MujocoWorld._poses

    def broken(self):
        poses = real(self)
        return poses._replace(centres=poses.centres + (float("nan") if self.gravity[1] else 0.0))

    monkeypatch.setattr(MujocoWorld, "_poses", broken)
    (found,) = limits(FLAT, "simulation@mujoco:frequency=480", directions=(0.0,))
    assert (found.limit_g, found.mode) == (None, None)
    assert found.reason == "the simulation diverged: a pose is not finite"
