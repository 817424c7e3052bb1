"""Siconos's process under the system's Python, and what contacts without compliance owe."""

import math

import numpy as np
import pytest

from steadyload.engines import registry, system_python
from steadyload.engines.attitudes import degrees_apart
from steadyload.engines.checks.scenes import turned_about
from steadyload.engines.registry import engine_names, engines, installed_versions, world_class
from steadyload.engines.world import GRAVITY, Box, EngineNotInstalledError, WorldSettings
from steadyload.methods import make_method

NEEDS_SICONOS = pytest.mark.deep("needs the package python3-siconos")
SIDE = 0.1
CUBE = (SIDE, SIDE, SIDE)
H = 1.0 / 480.0


@pytest.fixture
def siconos():
    try:
        return world_class("siconos")
    except EngineNotInstalledError as error:
        pytest.skip(str(error))


def test_where_it_is_missing_one_sentence_says_what_brings_it(monkeypatch, tmp_path):
    monkeypatch.setattr(system_python, "PACKAGES", str(tmp_path))
    with pytest.raises(EngineNotInstalledError, match="apt-get install python3-siconos"):
        make_method("label@siconos").prepare()
    assert registry.missing_packages("siconos") == ("siconos",)
    assert "siconos" not in installed_versions("siconos")
    assert registry.capabilities("siconos").dimensions == 3


def test_a_package_of_the_system_has_the_version_that_lies_there(monkeypatch, tmp_path):
    about = tmp_path / "siconos-9.8.egg-info"
    about.mkdir()
    (about / "PKG-INFO").write_text("Metadata-Version: 1.1\nName: siconos\nVersion: 9.8\n")
    monkeypatch.setattr(system_python, "PACKAGES", str(tmp_path))
    assert registry.missing_packages("siconos") == ()
    assert installed_versions("siconos")["siconos"] == "9.8"
    assert "siconos" not in installed_versions("drake")


def test_it_is_known_and_compared_only_where_it_is_named():
    assert "siconos" in engines()
    assert "siconos" not in engine_names()
    assert "siconos" not in registry.engines_here()


@NEEDS_SICONOS
def test_verdicts(siconos, stack):
    method = make_method("simulation@siconos:between_steps=reseat")
    assert method.judge(stack(0.0, 4.0, 0.0)).stable
    assert method.judge(stack(0.0, 6.0)).failing_step == 1


@NEEDS_SICONOS
def test_a_death_is_an_error_and_the_next_layout_has_its_verdict(siconos, stack, monkeypatch):
    method = make_method("simulation@siconos")
    advance = siconos._advance

    def killed_first(world, substeps, length):
        world._prepare()
        world._holder._process.kill()
        advance(world, substeps, length)

    with monkeypatch.context() as patched:
        patched.setattr(siconos, "_advance", killed_first)
        verdict = method.judge(stack(0.0))
    assert verdict.status == "error"
    assert "Siconos's process ended (-9)" in verdict.reason
    assert method.judge(stack(0.0)).stable


@NEEDS_SICONOS
@pytest.mark.parametrize("heading", [0.0, 25.0, 70.0])
@pytest.mark.parametrize("slope", [0.55, 0.9])
def test_friction_is_that_of_the_contact_on_any_slope(siconos, heading, slope):
    """A plate on a fixed ramp that is turned about two axes; frames of contacts are oblique."""
    friction, seconds = 0.5, 0.2
    tilt = math.degrees(math.atan(slope))
    lean, turn = turned_about((0.0, 1.0, 0.0), tilt), turned_about((0.0, 0.0, 1.0), heading)
    attitude = product(turn, lean)
    angle = math.radians(heading)
    ahead = np.array([math.cos(angle), math.sin(angle), 0.0])
    normal = slope * ahead + (0.0, 0.0, 1.0)
    down = ahead - (0.0, 0.0, slope)
    normal, down = normal / np.linalg.norm(normal), down / np.linalg.norm(down)
    start = np.array((0.0, 0.0, 3.0)) + 0.125 * normal - 0.3 * down
    with siconos(WorldSettings(friction=friction)) as world:
        world.add_box(Box((2.0, 1.0, 0.2), 1.0, (0.0, 0.0, 3.0), fixed=True, attitude=attitude))
        world.add_box(Box((0.2, 0.3, 0.05), 2.0, tuple(start.tolist()), attitude=attitude))
        world.stepSimulation(seconds, 1000, H)
        poses = world.poses()
    cosine = 1.0 / math.hypot(1.0, slope)
    way = 0.5 * GRAVITY * cosine * (slope - friction) * seconds**2
    assert (poses.centres[1] - start) @ down == pytest.approx(way, rel=0.01)
    assert (poses.centres[1] - start) @ normal == pytest.approx(0.0, abs=1e-5)
    assert degrees_apart(poses.quaternions[1], attitude) < 0.01


def product(one, other):
    """Of two quaternions."""
    (w, *x), (v, *y) = one, other
    x, y = np.array(x), np.array(y)
    return (w * v - x @ y, *(w * y + v * x + np.cross(x, y)).tolist())


@NEEDS_SICONOS
@pytest.mark.parametrize("speed", [0.3, 3.0])
@pytest.mark.parametrize("frequency", [240.0, 960.0])
def test_a_fall_ends_on_the_floor_and_not_in_it(siconos, speed, frequency):
    box = Box(CUBE, 1.0, (0.0, 0.0, 0.5 * SIDE + 0.05), velocity=(0.0, 0.0, -speed))
    with siconos(WorldSettings()) as world:
        world.add_box(box)
        lowest = math.inf
        for _ in range(round(0.3 * frequency)):
            world.stepSimulation(1.0 / frequency, 1, 1.0 / frequency)
            lowest = min(lowest, float(world.poses().centres[0, 2]))
        ended = world.poses().centres[0, 2]
    assert lowest > 0.5 * SIDE - 2e-4
    assert ended == pytest.approx(0.5 * SIDE, abs=2e-4)


@NEEDS_SICONOS
@pytest.mark.parametrize("far", [30.0, 1000.0])
def test_a_toss_far_from_the_middle_of_the_floor_ends_as_one_there(siconos, far):
    """Contacts in single precision are the less exact the farther a floor reaches."""

    def tossed(x, y):
        with siconos(WorldSettings(friction=0.18)) as world:
            world.add_box(
                Box(
                    CUBE,
                    0.4,
                    (x, y, 0.15),
                    attitude=turned_about((1.0, 0.4, -0.3), 50.0),
                    velocity=(-0.8, 0.6, -0.2),
                    angular_velocity=(-3.0, 5.0, 2.0),
                )
            )
            world.stepSimulation(1.0, 1000, H)
            return world.poses()

    here, there = tossed(0.0, 0.0), tossed(far, -far)
    moved = there.centres - (far, -far, 0.0)
    assert np.abs(here.centres[0, :2]).max() > 0.1
    assert moved == pytest.approx(here.centres, abs=1e-5)
    assert degrees_apart(there.quaternions[0], here.quaternions[0]) < 0.01


@NEEDS_SICONOS
def test_boxes_that_overlap_are_held_and_keep_their_momentum(siconos):
    """As the failed check of momentum says, which asks for a push."""
    pair = [Box(CUBE, 1.0, (0.0, 0.0, 50.0)), Box(CUBE, 3.0, (0.06, 0.0, 50.0 + SIDE - 1e-3))]
    with siconos(WorldSettings()) as world:
        for box in pair:
            world.add_box(box)
        world.stepSimulation(0.1, 1000, H)
        linear = world.velocities().linear
        apart = np.diff(world.poses().centres[:, 2])
    assert np.array([1.0, 3.0]) @ linear == pytest.approx([0.0, 0.0, -0.4 * GRAVITY], abs=1e-9)
    assert apart == pytest.approx(SIDE - 1e-3, abs=1e-6)
