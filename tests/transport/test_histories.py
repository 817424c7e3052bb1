"""Histories and rules: what they say at a time, and what they refuse."""

import math

import pytest

from steadyload.engines.world import EngineError
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.methods.simulation.simulation_parameters import SimulationParameters
from steadyload.transport.balance import Mode
from steadyload.transport.errors import TransportError
from steadyload.transport.history import History, constant, half_sine, recorded, trapezoid
from steadyload.transport.riding import LoadedWorld
from steadyload.transport.rules import rule_named, rules
from steadyload.transport.trials import under_history, under_rule


def test_a_pulse_rises_is_held_and_ends():
    pulse = trapezoid(0.5, 0.05, 0.3)
    levels = [pulse.gravity(t, 0.0, 0.0, 10.0)[0] for t in (0.0, 0.025, 0.05, 0.3, 0.36)]
    assert levels == pytest.approx([0.0, 2.5, 5.0, 5.0, 0.0])
    assert pulse.duration == pytest.approx(0.35)


def test_directions_are_seen_from_above():
    push = constant(0.4, 1.0)
    assert push.gravity(0.5, 0.0, 0.0, 10.0) == pytest.approx((4.0, -10.0, 0.0))
    assert push.gravity(0.5, 0.0, 90.0, 10.0) == pytest.approx((0.0, -10.0, 4.0))
    assert push.gravity(0.5, 0.0, 180.0, 10.0) == pytest.approx((-4.0, -10.0, 0.0))


def test_a_tilt_turns_gravity_and_keeps_its_size():
    across, up, along = trapezoid(0.5, 1.0, 1.0, tilted=True).gravity(1.5, 0.0, 0.0, 9.8)
    assert math.hypot(across, up, along) == pytest.approx(9.8)
    assert across / -up == pytest.approx(0.5)


def test_half_a_sine_has_the_impulse_of_one():
    wave = half_sine(0.8, 0.5)
    moments = [wave.gravity(0.5 * (k + 0.5) / 500, 0.0, 0.0, 1.0)[0] for k in range(500)]
    assert sum(moments) * 0.5 / 500 == pytest.approx(0.8 * 0.5 * 2.0 / math.pi, rel=1e-3)
    assert max(moments) == pytest.approx(0.8, rel=1e-3)


@pytest.mark.parametrize("history", [constant(7.0, 0.013), half_sine(5.0, 0.011),
                                     trapezoid(2.0, 0.004, 0.0151)])  # fmt: skip
def test_means_over_any_spans_have_the_impulse_of_the_history(history):
    impulse = sum(
        0.5 * (b - a) * (p + q)
        for a, b, p, q in zip(
            history.times, history.times[1:], history.levels, history.levels[1:], strict=False
        )
    )
    for span in (0.001, 0.01, 0.03):
        count = math.ceil(history.duration / span)
        found = sum(history.mean(k * span, span) for k in range(count)) * span
        assert found == pytest.approx(impulse, rel=1e-9)


def test_a_recorded_history_is_read(tmp_path):
    file = tmp_path / "truck.csv"
    file.write_text("time_s,acceleration_g,note\n0,0,start\n0.1,0.3,\n0.5,-0.2,\n")
    found = recorded(file)
    assert (found.times, found.levels) == ((0.0, 0.1, 0.5), (0.0, 0.3, -0.2))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,a\n0,1\n", "columns are ['t', 'a']; allowed: time_s and acceleration_g"),
        ("", "columns are []; allowed: time_s and acceleration_g, once"),
        ("time_s,acceleration_g,time_s\n0,0,0\n", "allowed: time_s and acceleration_g, once"),
        ("\t[" * 3000 + "\n0,0\n", "allowed: time_s and acceleration_g, once"),
        ("time_s,acceleration_g\n0,0\n0.1,fast\n", "line 3 is ['0.1', 'fast']; allowed: 2 cells"),
        ("time_s,acceleration_g\n0,0\n0.1\n", "line 3 is ['0.1']; allowed: 2 cells"),
        ("time_s,acceleration_g\n0,0\n0.1,1,9\n", "line 3 is ['0.1', '1', '9']; allowed: 2 cells"),
        ("time_s,acceleration_g\n0,0\n", "1 times and 1 accelerations; allowed: 2 or more"),
        ("time_s,acceleration_g\n0.1,0\n0.2,1\n", "times of a history do not rise from 0 s"),
        ("time_s,acceleration_g\n0,0\n0,1\n", "times of a history do not rise from 0 s"),
        ("time_s,acceleration_g\n0,0\n-1e999,0\n-1e999,0\n", "do not rise from 0 s"),
        ("time_s,acceleration_g\n0,0\nnan,1\n", "times of a history do not rise from 0 s"),
        ("time_s,acceleration_g\n0,0\n1,nan\n", "an acceleration of nan g; allowed: -20 to 20"),
        ("time_s,acceleration_g\n0,0\n1,99\n", "an acceleration of 99 g; allowed: -20 to 20"),
        ("time_s,acceleration_g\n0,0\n1e9,1\n", "a history of 1e+09 s; allowed: up to 600 s"),
    ],
)
def test_a_file_that_is_no_history_is_refused_by_name_and_line(tmp_path, text, message):
    file = tmp_path / "bad.csv"
    file.write_text(text)
    with pytest.raises(TransportError) as refusal:
        recorded(file)
    assert str(refusal.value).startswith(f"{file}: ")
    assert message in str(refusal.value)
    assert str(refusal.value).isprintable()
    assert len(str(refusal.value)) < 1000


def test_rules_of_the_package_say_what_their_sources_ask():
    assert list(rules()) == ["en12195", "eumos40509", "tilt"]
    road = rules()["en12195"].directions()
    assert road == {0.0: 0.8, 90.0: 0.5, 180.0: 0.5, 270.0: 0.5}
    platform = rules()["eumos40509"]
    assert (platform.rise, platform.hold, set(platform.directions().values())) == (0.05, 0.3, {0.5})
    assert platform.largest_displacement(120.0) == pytest.approx(6.0)
    assert History((0.0, 1.0), (0.0, 0.0)).duration == 1.0


def test_a_rule_of_ones_own_comes_from_a_file(tmp_path):
    file = tmp_path / "ours.toml"
    file.write_text(
        "[ours]\nlevels = { forwards = 0.3 }\nrise = 0.1\nhold = 1\nrest = 0\n"
        "rotation = 5\ndisplacement = 2\n"
    )
    assert rule_named(str(file)).directions() == {0.0: 0.3}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("levels = { up = 0.3 }", r"levels\[up\] is 'up'; allowed: backwards, forwards, sideways"),
        ("levels = { forwards = 0.3 }\nspeed = 3", "unknown key 'speed'"),
        ("levels = { forwards = 0.3 }\ndisplacement_share = 0.1", "just one"),
        (
            "levels = { forwards = 0.3 }\nrise = -1",
            r"rise is -1; allowed: a number, 0 to 1,000 \[s\]",
        ),
        ("levels = { forwards = 0.3 }\nrise = 700", "a history of 701 s; allowed: up to 600"),
        (
            'levels = { forwards = "0.5" }',
            r"levels\[forwards\] is '0.5'; allowed: a number, 0 to 20 \[g\]",
        ),
        (
            "levels = { forwards = nan }",
            r"levels\[forwards\] is nan; allowed: a number, 0 to 20 \[g\]",
        ),
        ('levels = ["forwards"]', r"levels is \['forwards'\]; allowed: one value or more by"),
        (
            "levels = {}",
            "levels is {}; allowed: one value or more by backwards, forwards, sideways",
        ),
        (
            "levels = { forwards = 0.3 }\nrotation = 0",
            r"rotation is 0; allowed: a number, 0.1 to 1,000 \[degrees\]",
        ),
        ("levels = { forwards = 0.3 }\ntitle = 3", "title is 3; allowed: a text"),
        ('levels = { forwards = 0.3 }\n"\\u0007" = 3', r"unknown key '\\x07'"),
        ("levels = { forwards = " + "[" * 5000, "not valid TOML"),
        ("levels = { forwards = 0.3 }\ntilted = 1", "tilted is 1; allowed: true or false"),
    ],
)
def test_a_rule_that_cannot_be_is_refused(tmp_path, change, message):
    file = tmp_path / "ours.toml"
    usual = {"rise": 0, "hold": 1, "rest": 0, "rotation": 5, "displacement": 2}
    rest = "\n".join(
        f"{key} = {value}" for key, value in usual.items() if f"{key} = " not in change
    )
    file.write_text(f"[ours]\n{change}\n{rest}\n")
    with pytest.raises(TransportError, match=message):
        rule_named(str(file))
    with pytest.raises(TransportError, match="en12195, eumos40509, tilt"):
        rule_named("en12196")


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_flat_boxes_hold_what_their_friction_is_in_every_direction(count):
    items = tuple(Item(k, (30.0 * k, 0, 0), (30, 5, 30), 5.0 + 4.0 * k) for k in range(count))
    layout = Layout("row", Pallet(120, 200, 100), items)
    assert all(one.held for one in under_rule(layout, rules()["eumos40509"]))


ONE_BOX = Layout("one", Pallet(120, 200, 100), (Item(0, (40.0, 0, 30), (30, 10, 30), 8.0),))


@pytest.mark.parametrize("engine", ["mujoco", "dart"])
def test_a_minute_of_braking_is_decided_when_the_box_has_slid_too_far(engine):
    (found,) = under_history(ONE_BOX, constant(0.9, 60.0), (0.0,), f"label@{engine}")
    assert (found.held, found.moved_item, found.mode, found.reason) == (False, 0, Mode.SLIDES, "")


def test_a_decided_ride_goes_on_for_seconds_at_most():
    times = []
    with LoadedWorld(ONE_BOX, "mujoco", SimulationParameters(frequency=240)) as world:
        ride = world.ride(
            constant(0.9, 60.0), 0.0, displacement=5.0, rotation=10.0, whole=True,
            watch=lambda look: times.append(look.seconds),
        )  # fmt: skip
    assert ride.seconds < 0.3
    assert times[-1] == pytest.approx(ride.seconds + 5.0, abs=0.02)


@pytest.mark.parametrize("breaks_at", [0.02, 0.6])
def test_an_engine_that_gives_up_changes_no_answer_that_is_known(monkeypatch, breaks_at):
    """In metres: the box has moved too far at 0.05."""
    real, start = LoadedWorld._read, []

    def broken(self):
        poses = real(self)
        start.append(poses.centres)
        if abs(poses.centres - start[0]).max() > breaks_at:
            raise EngineError("the simulation diverged")
        return poses

    monkeypatch.setattr(LoadedWorld, "_read", broken)
    (found,) = under_history(ONE_BOX, constant(0.9, 2.0), (0.0,), "label@mujoco")
    if breaks_at < 0.05:
        assert (found.held, found.reason) == (None, "the simulation diverged")
    else:
        assert (found.held, found.mode, found.reason) == (False, Mode.SLIDES, "")


def test_rules_of_the_package_end_before_a_decided_ride_is_cut():
    for rule in rules().values():
        assert rule.history(0.5).duration + rule.rest < 5.0
