"""The reference simulator's parts, each against something that does not share its code."""

import math

import numpy as np
import pytest

from steadyload.engines.reference.blocks import elimination_order, factorise, solve
from steadyload.engines.reference.compilation import compiled
from steadyload.engines.reference.contact import BODY, FLOOR, make_scratch
from steadyload.engines.reference.islands import candidate_pairs, islands
from steadyload.engines.reference.law import Law, friction_ratio, normal_force
from steadyload.engines.reference.motion import (
    Field,
    accelerations,
    linearise,
    make_linearisation,
    turn_by,
)
from steadyload.engines.reference.options import ReferenceOptions
from steadyload.engines.reference.polygon import EDGES, separation
from steadyload.engines.reference.rodas import FINISHED, Control, integrate
from steadyload.engines.reference.world import ReferenceWorld
from steadyload.engines.world import (
    GRAVITY,
    Box,
    EngineError,
    Velocities,
    WorldSettings,
)

SOFT = Law(1e6, 1.2, 1e3, 1e-5, 0.5, 0.4, 1e-3, 1e-2, 1e9)
REBOUNDING = SOFT._replace(exponent=1.0, damping=0.0, damping_ratio=2.0)
FIELD = Field(np.array([0.3, 0.2, -GRAVITY]), 0.0, 0.1, 0.2)


def make_bodies(sizes, masses, offsets, fixed=()):
    bodies = np.rec.array(np.zeros(len(sizes), BODY))
    for k, body in enumerate(bodies):
        box = Box(tuple(sizes[k]), masses[k], (0.0, 0.0, 0.0), tuple(offsets[k]))
        body.half, body.offset = 0.5 * np.array(box.size), box.mass_offset
        body.mass, body.inertia = box.mass, box.inertia
        body.extent, body.fixed = math.hypot(*(body.half + np.abs(body.offset))), k in fixed
    return bodies


def turned(vectors):
    out = np.zeros((len(vectors), 3, 3))
    turn_by(np.ascontiguousarray(vectors), np.tile(np.eye(3), (len(vectors), 1, 1)), out)
    return out


class Pile:
    """A box on a box, and one beside the lower, all turned and shifted a little, or a lot."""

    def __init__(self, seed, tilt, speed, fixed=()):
        random = np.random.default_rng(seed)
        sizes = random.uniform(0.1, 0.3, (3, 3))
        offsets = random.uniform(-0.02, 0.02, (3, 3))
        self.bodies = make_bodies(sizes, (1.0, 2.0, 3.0), offsets, fixed)
        centres = np.zeros((3, 3))
        centres[0, 2] = sizes[0, 2] / 2
        centres[1] = (*random.uniform(-0.05, 0.05, 2), sizes[0, 2] + sizes[1, 2] / 2)
        centres[2] = (
            (sizes[0, 0] + sizes[2, 0]) / 2 - 1e-6, random.uniform(-0.05, 0.05), sizes[2, 2] / 2
        )  # fmt: skip
        self.turn = turned(tilt * random.normal(size=(3, 3)))
        self.p = centres + np.einsum("nij,nj->ni", self.turn, offsets)
        self.p += 0.02 * tilt * random.normal(size=(3, 3)) - [0.0, 0.0, 2e-6]
        self.v, self.w = speed * random.normal(size=(3, 3)), 10 * speed * random.normal(size=(3, 3))
        self.pairs = np.array([(0, FLOOR), (1, FLOOR), (2, FLOOR), (0, 1), (0, 2), (1, 2)])
        self.scratch = make_scratch()

    def accelerations(self, pose=None, velocity=None, law=SOFT):
        pose = np.zeros((3, 6)) if pose is None else pose
        velocity = np.zeros((3, 6)) if velocity is None else velocity
        turn, out = np.zeros((3, 3, 3)), np.zeros((3, 6))
        turn_by(np.ascontiguousarray(pose[:, 3:]), self.turn, turn)
        accelerations(
            law, FIELD, self.bodies, self.pairs, self.p + pose[:, :3], turn,
            self.v + velocity[:, :3], self.w + velocity[:, 3:], out, self.scratch,
        )  # fmt: skip
        return out

    def linearise(self, law=SOFT):
        """Derivatives of the mass-weighted accelerations by poses and velocities, (18, 18) each."""
        lin, out = make_linearisation(3, len(self.pairs)), np.zeros((3, 6))
        touching = linearise(
            law, FIELD, self.bodies, self.pairs, self.p, self.turn, self.v, self.w, out, lin,
            self.scratch,
        )  # fmt: skip
        by_pose, by_velocity, mass = np.zeros((3, 3, 6, 3, 6))
        for b in range(3):
            by_pose[b, :, b], by_velocity[b, :, b] = lin.own_pose[b], lin.own_velocity[b]
            mass[b, :, b] = lin.mass[b]
        for k in range(touching):
            for x, i in enumerate(lin.ends[k]):
                for y, j in enumerate(lin.ends[k]):
                    if FLOOR not in (i, j):
                        part = np.s_[6 * x : 6 * x + 6, 6 * y : 6 * y + 6]
                        by_pose[i, :, j] += lin.by_pose[k][part]
                        by_velocity[i, :, j] += lin.by_velocity[k][part]
        return [m.reshape(18, 18) for m in (by_pose, by_velocity, mass)], touching


@pytest.mark.parametrize("tilt", [1e-4, 1e-2, 0.5])
@pytest.mark.parametrize("law", [SOFT, REBOUNDING], ids=["damped", "rebounding"])
@pytest.mark.parametrize("seed", range(8))
def test_derivatives_are_those_of_finite_differences(seed, law, tilt):
    pile = Pile(seed, tilt, 1e-3)
    (by_pose, by_velocity, mass), touching = pile.linearise(law)
    assert touching >= 3
    for analytic, which, step in ((by_pose, 0, 1e-9), (by_velocity, 1, 1e-7)):
        found = np.zeros((18, 18))
        for k in range(18):
            change = np.zeros(18)
            change[k] = step
            sides = []
            for sign in (1.0, -1.0):
                arguments = [None, None]
                arguments[which] = (sign * change).reshape(3, 6)
                sides.append(pile.accelerations(*arguments, law).ravel())
            found[:, k] = mass @ (sides[0] - sides[1]) / (2.0 * step)
        # Corners that appear within a step, and rounding, are what is left.
        assert np.abs(analytic - found).max() < 1e-5 * np.abs(found).max()


@pytest.mark.parametrize("law", [SOFT, REBOUNDING], ids=["damped", "rebounding"])
def test_derivatives_of_crossing_edges_are_exact(law):
    # One box stands on its edge across another that stands on its edge.
    pile = Pile(3, 0.0, 1e-3)
    pile.turn = turned(np.array([[math.pi / 4, 0.02, 0.03], [0.01, math.pi / 4, 0.02], [0, 0, 0]]))
    half = np.array([b.half for b in pile.bodies])
    pile.p[0] = (0.0, 0.0, 1.0)
    reach = math.hypot(*half[0, 1:]) * 0.9 + math.hypot(*half[1, [0, 2]]) * 0.9
    for shift in np.linspace(0.0, 0.2, 4000):
        pile.p[1] = (0.0, 0.0, 1.0 + reach + 0.05 - shift)
        spun = pile.turn[0].T @ pile.turn[1]
        offset = [b.offset for b in pile.bodies]
        apart = offset[0] + pile.turn[0].T @ (pile.p[1] - pile.p[0]) - spun @ offset[1]
        kind, _, _ = separation(half[0], half[1], spun, np.ascontiguousarray(apart))
        if kind == EDGES:
            break
    assert kind == EDGES
    pile.pairs = np.array([(0, 1)])
    (by_pose, _, mass), touching = pile.linearise(law)
    assert touching == 1
    found = np.zeros((18, 18))
    for k in range(18):
        change = np.zeros(18)
        change[k] = 1e-8
        both = [pile.accelerations((s * change).reshape(3, 6), law=law) for s in (1.0, -1.0)]
        found[:, k] = mass @ (both[0] - both[1]).ravel() / 2e-8
    assert np.abs(by_pose - found).max() < 1e-5 * np.abs(found).max()


@pytest.mark.parametrize("seed", range(12))
def test_the_contact_force_is_continuous_under_small_motions(seed):
    """Along a random path on which corners split and merge, no step's change is out of proportion.

    The path is walked twice, the second time in steps a tenth as long: a jump would not shrink.
    """
    random = np.random.default_rng(seed)
    pile = Pile(seed, 1e-5, 0.0)
    pile.pairs = np.array([(0, FLOOR), (2, FLOOR), (0, 1), (0, 2)])
    law = Law(1e6, 1.0, 0.0, 1e-7, 0.0, 0.0, 1e-4, 1e-2, 1e9)
    # In the plane by a centimetre, so that corners pass edges; up, down and about by far less.
    scale = np.array([1e-2, 1e-2, 1e-6, 1e-5, 1e-5, 1e-2])
    ends = random.uniform(-1.0, 1.0, (2, 3, 6)) * scale
    # The two beside each other stay so: which of two faces carries a contact changes with a jump of
    # the force's direction by the angle between them.
    ends[:, [0, 2], :2] *= 1e-4
    ends[:, [0, 2], 5] *= 1e-3
    jumps = []
    for count in (200, 2000):
        forces = [
            pile.accelerations(pose=ends[0] + s * (ends[1] - ends[0]), law=law)
            for s in np.linspace(0.0, 1.0, count)
        ]
        jumps.append(np.abs(np.diff(forces, axis=0)).max())
    assert jumps[0] > 0.0
    assert jumps[1] < 0.2 * jumps[0]


def test_normal_and_friction_forces_have_the_derivatives_they_say():
    for depth in (1e-7, 5e-6, 2e-5):
        for rate in (-1e-3, 0.0, 2e-3):
            force, by_depth, by_rate = normal_force(SOFT, SOFT.damping, depth, rate)
            if force > 0.0:
                step = 1e-5 * depth
                up, down = (
                    normal_force(SOFT, SOFT.damping, depth + s, rate)[0] for s in (step, -step)
                )
                assert by_depth == pytest.approx((up - down) / (2.0 * step), rel=1e-6)
                up, down = (
                    normal_force(SOFT, SOFT.damping, depth, rate + s)[0] for s in (1e-8, -1e-8)
                )
                assert by_rate == pytest.approx((up - down) / 2e-8, rel=1e-6, abs=1e-6)
    for speed in (3e-4, 9.9e-4, 2e-3, 8e-3, 2e-2):
        _, slope = friction_ratio(SOFT, speed)
        up, down = (friction_ratio(SOFT, speed * s)[0] for s in (1 + 1e-6, 1 - 1e-6))
        assert slope * speed == pytest.approx((up - down) / (2e-6 * speed), rel=1e-5)
    coefficient = [speed * friction_ratio(SOFT, speed)[0] for speed in (1e-3, 1e-2, 1.0)]
    assert coefficient == pytest.approx([0.5, 0.4, 0.4])
    assert normal_force(SOFT, SOFT.damping, 1e-6, -10.0) == (0.0, 0.0, 0.0)  # a contact never pulls


@pytest.mark.parametrize("count", [1, 2, 7, 40])
def test_blocks_are_solved_like_a_dense_matrix(count):
    random = np.random.default_rng(count)
    filled = random.random((count, count)) < 3.0 / count
    filled |= filled.T | np.eye(count, dtype=bool)
    matrix = random.normal(size=(count, count, 6, 6)) * filled[:, :, None, None]
    matrix[range(count), range(count)] += 20.0 * np.eye(6)
    vector = random.normal(size=(count, 6))
    dense = matrix.transpose(0, 2, 1, 3).reshape(6 * count, 6 * count)
    expected = np.linalg.solve(dense, vector.ravel())
    order = elimination_order(filled)
    assert sorted(order) == list(range(count))
    assert factorise(matrix, filled, order)
    solve(matrix, filled, order, vector)
    np.testing.assert_allclose(vector.ravel(), expected, rtol=1e-10, atol=1e-13)


def test_elimination_of_a_chain_fills_nothing_in():
    filled = np.abs(np.subtract.outer(range(50), range(50))) <= 1
    before = filled.copy()
    elimination_order(filled)
    assert (filled == before).all()


def spin_error(step):
    """Error of the attitude after 0.5 s of free spin at fixed steps."""
    options = ReferenceOptions(tolerance=1e-4, most_time=step)
    finer = ReferenceOptions(tolerance=1e-12, most_time=1e-3)
    found = []
    for chosen in (options, finer):
        settings = WorldSettings(gravity=(0.0, 0.0, 0.0), options=chosen)
        with ReferenceWorld(settings) as world:
            world.add_box(Box((0.1, 0.2, 0.3), 1.0, (0.0, 0.0, 1.0)))
            world.set_velocities(Velocities(np.zeros((1, 3)), np.array([[0.5, 3.0, 0.7]])))
            world.stepSimulation(0.5, 1, 0.5)
            found.append(world.poses().quaternions[0])
    return 2.0 * np.linalg.norm(found[0] - found[1])


def test_the_order_of_convergence_is_four_on_a_smooth_problem():
    errors = [spin_error(step) for step in (1.0, 0.01, 0.005)][1:]
    assert 1e-12 < errors[1] < errors[0]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.4)


def energy(world):
    """Kinetic and potential energy [J]; what springs hold is missing, and never negative."""
    poses, velocities = world.poses(), world.velocities()
    total = 0.0
    for k, box in enumerate(world.boxes):
        w, x, y, z = poses.quaternions[k]
        turn = np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        mass_centre = poses.centres[k] + turn @ box.mass_offset
        spin = turn.T @ velocities.angular[k]
        total += box.mass * (GRAVITY * mass_centre[2] + 0.5 * (velocities.linear[k] ** 2).sum())
        total += 0.5 * (np.array(box.inertia) * spin * spin).sum()
    return total


@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize("seed", range(4))
def test_energy_is_never_created(seed, friction):
    random = np.random.default_rng(seed)
    boxes = []
    for k in range(4):
        size = tuple(random.uniform(0.05, 0.2, 3))
        centre = (*random.uniform(-0.05, 0.05, 2), 0.2 + 0.22 * k)
        offset = tuple(random.uniform(-0.1, 0.1, 3) * size)
        boxes.append(Box(size, float(random.uniform(0.5, 5.0)), centre, offset))
    with ReferenceWorld(WorldSettings(friction=friction)) as world:
        for box in boxes:
            world.add_box(box)
        start = now = energy(world)
        for _ in range(60):
            world.stepSimulation(0.01, 1, 0.01)
            now = energy(world)
            assert now <= start + 1e-5
    assert now < 0.8 * start  # they fell, and lost it


def test_momentum_and_angular_momentum_survive_a_collision_in_flight():
    boxes = [
        Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 10.0), (0.01, 0.0, 0.02)),
        Box((0.2, 0.1, 0.1), 3.0, (0.2, 0.03, 10.04), (-0.02, 0.01, 0.0)),
    ]
    settings = WorldSettings(gravity=(0.0, 0.0, 0.0), friction=0.7)
    with ReferenceWorld(settings) as world:
        for box in boxes:
            world.add_box(box)
        start = Velocities(np.array([[1.0, 0.0, 0.1], [-1.0, 0, 0]]), np.array([[0, 2.0, 1.0]] * 2))
        world.set_velocities(start)

        def momenta():
            masses = np.array([b.mass for b in boxes])
            places, spins = world._mass_centres, world._axes
            v, w = world.velocities()
            inertia = [r @ np.diag(b.inertia) @ r.T for r, b in zip(spins, boxes, strict=True)]
            angular = sum(
                m * np.cross(x, u) + i @ s
                for m, x, u, i, s in zip(masses, places, v, inertia, w, strict=True)
            )
            return masses @ v, angular

        linear, angular = momenta()
        world.stepSimulation(0.2, 1, 0.2)
        after = momenta()
        assert np.abs(world.velocities().linear - start.linear).max() > 0.1, "they should collide"
    np.testing.assert_allclose(after[0], linear, atol=1e-9)
    np.testing.assert_allclose(after[1], angular, atol=1e-6)


def test_groups_that_cannot_meet_are_integrated_apart():
    near = [Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.05)), Box((0.1,) * 3, 1.0, (0.06, 0.0, 0.15))]
    far = [Box((0.1, 0.1, 0.1), 2.0, (5.0, 0.0, 0.05)), Box((0.1,) * 3, 0.3, (5.02, 0.0, 0.3))]

    def run(boxes):
        with ReferenceWorld(WorldSettings()) as world:
            for box in boxes:
                world.add_box(box)
            world.stepSimulation(0.3, 1, 0.3)
            return world.poses()

    alone, together = run(near), run([*near, *far])
    assert (alone.centres == together.centres[:2]).all()
    assert (alone.quaternions == together.quaternions[:2]).all()


def test_islands_are_joined_by_free_bodies_only():
    bodies = make_bodies(np.full((4, 3), 0.1), [1.0] * 4, np.zeros((4, 3)), fixed=(1,))
    p = np.array([[0.0, 0, 0.05], [0.1, 0, 0.05], [0.2, 0, 0.05], [0.3, 0, 0.05]])
    pairs = candidate_pairs(0.0, bodies, p, turned(np.zeros((4, 3))), np.full(4, 1e-3))
    # The first stands against the fixed one, which the third does not join it by.
    assert islands(bodies, pairs).tolist() == [0, -1, 2, 2]
    assert [0, FLOOR] in pairs.tolist()
    assert [1, FLOOR] not in pairs.tolist()


def test_a_body_that_is_hit_hard_meets_what_it_reaches():
    """A heavy box that falls fast on a seesaw throws a light one against a third, 0.4 m off."""
    boxes = [
        Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.05)),
        Box((0.1, 0.1, 0.1), 1.0, (0.5, 0.0, 0.05)),
    ]
    with ReferenceWorld(WorldSettings(friction=0.0)) as world:
        for box in boxes:
            world.add_box(box)
        world.set_velocities(Velocities(np.array([[30.0, 0, 0], [0, 0, 0]]), np.zeros((2, 3))))
        world.stepSimulation(0.03, 1, 0.03)
        assert world.velocities().linear[1, 0] > 10.0


def test_radau_follows_the_same_equations_to_the_same_end():
    boxes = [
        Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.05)),
        Box((0.2, 0.12, 0.1), 2.0, (0.055, 0.02, 0.15), (0.01, 0.0, 0.0)),
        Box((0.1, 0.1, 0.05), 0.5, (0.03, 0.0, 0.225)),
    ]
    found = []
    for options in (ReferenceOptions(), ReferenceOptions(integrator="radau")):
        with ReferenceWorld(WorldSettings(options=options)) as world:
            for box in boxes:
                world.add_box(box)
            world.stepSimulation(0.15, 1, 0.15)
            found.append(world.poses())
    assert np.abs(found[0].centres - [b.centre for b in boxes]).max() > 0.01, "it should tip"
    np.testing.assert_allclose(found[0].centres, found[1].centres, atol=2e-5)


def test_the_integrator_says_when_it_gives_up(monkeypatch):
    monkeypatch.setattr("steadyload.engines.reference.world._MOST_WORK", 5)
    with ReferenceWorld(WorldSettings()) as world:
        world.add_box(Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.05)))
        with pytest.raises(EngineError, match="the integrator gave up: it needs too many steps"):
            world.stepSimulation(0.3, 1, 0.3)


def test_a_step_too_long_is_refused_and_shortened():
    """The error estimate is the true one: a first step of 10 ms onto a stiff floor is cut down."""
    bodies = make_bodies([(0.1, 0.1, 0.1)], [1.0], [(0.0, 0.0, 0.0)])
    p, turn = np.array([[0.0, 0.0, 0.0505]]), np.eye(3)[None].copy()
    v, w = np.array([[0.0, 0.0, -1.0]]), np.zeros((1, 3))
    law = ReferenceOptions().law(0.5)
    field = Field(np.array([0.0, 0.0, -GRAVITY]), 0.0, 0.0, 0.0)
    count = integrate(
        law, field, bodies, np.array([(0, FLOOR)]), p, turn, v, w, 0.02, 0.01,
        Control(1e-7, 0.01, 10**6), make_scratch(),
    )  # fmt: skip
    assert count.outcome == FINISHED
    assert count.rejected >= 3
    assert p[0, 2] == pytest.approx(0.05, abs=1e-5)


@pytest.mark.parametrize("start", [-0.5, -0.23, -0.1])
def test_a_turning_rod_does_not_jump_through_a_thin_post(start):
    """The tip moves 3 m/s towards a post of 1 mm; its centre of mass does not move at all."""
    settings = WorldSettings(gravity=(0.0, 0.0, 0.0))
    with ReferenceWorld(settings) as world:
        world.add_box(Box((0.02, 0.001, 0.1), 1.0, (0.3, 0.0, 5.0), fixed=True))
        world.add_box(Box((0.65, 0.005, 0.005), 1.0, (0.0, 0.0, 5.0)))
        world.prepare()
        world._axes[1] = turned(np.array([[0.0, 0.0, start]]))[0]
        world.set_velocities(Velocities(np.zeros((2, 3)), np.array([[0, 0, 0], [0, 0, 10.0]])))
        world.stepSimulation(0.1, 1, 0.1)
        # A free rod of inertia I that is stopped at a distance r keeps I / (I + m r^2) of its spin.
        inertia = world.boxes[1].inertia[2]
        kept = inertia / (inertia + 0.3**2)
        assert world.velocities().angular[1, 2] == pytest.approx(10.0 * kept, rel=0.06)


def test_radau_follows_a_fast_fall_and_a_fast_spin():
    spun = []
    for integrator in ("rodas", "radau"):
        options = ReferenceOptions(integrator=integrator)
        with ReferenceWorld(WorldSettings(gravity=(0, 0, 0.0), options=options)) as world:
            world.add_box(Box((0.1, 0.2, 0.3), 3.0, (0.0, 0.0, 5.0)))
            world.set_velocities(Velocities(np.zeros((1, 3)), np.array([[1.0, 100.0, 1.0]])))
            world.stepSimulation(0.05, 1, 0.05)
            spun.append(world.poses().quaternions[0])
    assert 2.0 * np.linalg.norm(spun[0] - spun[1]) < 1e-4
    with ReferenceWorld(WorldSettings(options=options)) as world:
        world.add_box(Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.35)))
        world.set_velocities(Velocities(np.array([[0.0, 0.0, -20.0]]), np.zeros((1, 3))))
        world.stepSimulation(0.04, 1, 0.04)
        assert world.poses().centres[0, 2] == pytest.approx(0.05, abs=2e-3)


def test_a_heavy_box_does_not_bounce_and_an_overlap_is_not_shot_out():
    with ReferenceWorld(WorldSettings()) as world:
        world.add_box(Box((1.0, 1.0, 1.0), 1000.0, (0.0, 0.0, 0.6)))
        fastest = 0.0
        for _ in range(100):
            world.stepSimulation(0.003, 1, 0.003)
            fastest = max(fastest, world.velocities().linear[0, 2])
    assert fastest < 0.15 * math.sqrt(2.0 * GRAVITY * 0.1)
    with ReferenceWorld(WorldSettings()) as world:
        world.add_box(Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.05 - 1e-4)))
        highest = 0.0
        for _ in range(100):
            world.stepSimulation(0.003, 1, 0.003)
            highest = max(highest, world.poses().centres[0, 2] - 0.05)
    assert highest < 2e-4


def test_the_mass_of_a_fixed_box_plays_no_part():
    with ReferenceWorld(WorldSettings()) as world:
        world.add_box(Box((0.1, 0.1, 0.1), 1e-12, (0.0, 0.0, 0.05), fixed=True))
        world.add_box(Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.15)))
        world.stepSimulation(0.1, 1, 0.1)
        assert world.poses().centres[1, 2] == pytest.approx(0.15, abs=1e-6)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"tolerance": -1.0}, "tolerance is -1.0; allowed: 1e-12 to 0.0001"),
        ({"stiction_speed": 1e-9}, "stiction_speed is 1e-09; allowed"),
        ({"contact": "foo"}, "foo"),
        ({"integrator": "x"}, "x"),
    ],
)
def test_options_are_checked_wherever_they_come_from(options, message):
    with pytest.raises(ValueError, match=message):
        ReferenceOptions(**options)


def test_compiled_code_is_known_by_all_sources_of_its_package():
    def function(x):
        return x + 1

    name = function.__qualname__
    assert compiled(function)(1) == 2
    assert function.__qualname__ != name
