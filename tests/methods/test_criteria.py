"""The criteria against their definitions, written out with rotation matrices."""

import math

import numpy as np
import pytest

from steadyload.engines.world import Box, Poses
from steadyload.methods.simulation.criteria import Criterion, Examiner

# World (x, y, z) = layout (z, x, y).
TO_LAYOUT = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], dtype=float)


def matrix(quaternion):
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def unstable(boxes, poses, criterion, eps_t, eps_r):
    """Eq. 6 and 7, or the authors' evaluation, item by item."""
    for box, centre, quaternion in zip(boxes, poses.centres, poses.quaternions, strict=True):
        turn = matrix(quaternion)
        in_layout = TO_LAYOUT @ turn @ TO_LAYOUT.T
        angles = (
            math.atan2(in_layout[2, 1], in_layout[2, 2]),
            -math.asin(max(-1.0, min(1.0, in_layout[2, 0]))),
            math.atan2(in_layout[1, 0], in_layout[0, 0]),
        )
        shift = centre - box.centre
        if criterion is Criterion.PAPER:
            moved = math.sqrt(float(shift @ shift))
        else:
            corner = -0.5 * np.array(box.size)
            moved = float(np.abs(shift + turn @ corner - corner).max())
        if 100.0 * moved > eps_t or math.degrees(max(map(abs, angles))) > eps_r:
            return True
    return False


@pytest.mark.parametrize("criterion", list(Criterion))
def test_verdicts_are_those_of_the_definition(criterion):
    random = np.random.default_rng(4)
    seen = {True: 0, False: 0}
    for _ in range(4000):
        eps_t, eps_r = random.choice([1.0, 3.0, 10.0, 22.0]), random.choice([5, 7, 10, 100, 180])
        count = int(random.integers(1, 4))
        boxes = [
            Box(tuple(random.uniform(0.01, 0.6, 3)), 1.0, tuple(random.uniform(0, 1, 3)))
            for _ in range(count)
        ]
        axes = random.normal(size=(count, 3))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        # Angles and displacements on the order of the thresholds, so that both sides are met.
        angles = np.radians(eps_r) * random.uniform(0, 1.6, count) * random.choice([0.02, 0.6, 1.0])
        quaternions = np.concatenate(
            (np.cos(angles / 2)[:, None], np.sin(angles / 2)[:, None] * axes), axis=1
        ) * random.choice([-1.0, 1.0], (count, 1))
        shifts = random.normal(size=(count, 3)) * 0.01 * eps_t * random.choice([0.1, 0.6])
        poses = Poses(np.array([b.centre for b in boxes]) + shifts, quaternions)
        examiner = Examiner(boxes, criterion, eps_t, eps_r)
        found = examiner.examine(0, poses, np.arange(count)) is not None
        assert found is unstable(boxes, poses, criterion, eps_t, eps_r)
        seen[found] += 1
    assert min(seen.values()) > 400


def test_excess_scales_the_thresholds():
    box = Box((0.1, 0.1, 0.1), 1.0, (0.0, 0.0, 0.05))
    examiner = Examiner([box], Criterion.PAPER, 10.0, 10.0)
    upright = np.array([[1.0, 0.0, 0.0, 0.0]])
    poses = Poses(np.array([[0.15, 0.0, 0.05]]), upright)
    assert examiner.examine(0, poses, np.arange(1)).displacement == pytest.approx(15.0)
    assert examiner.examine(0, poses, np.arange(1), excess=2.0) is None
    assert examiner.examine(0, poses, np.arange(1), excess=1.4) is not None


def test_items_keep_their_numbers_in_any_order():
    boxes = [Box((0.1, 0.1, 0.1), 1.0, (0.2 * k, 0.0, 0.05)) for k in range(4)]
    examiner = Examiner(boxes, Criterion.PAPER, 10.0, 10.0)
    order = np.array([2, 0])
    planned = np.array([boxes[k].centre for k in order])
    centres = np.add(planned, [(0.0, 0.0, 0.0), (0.3, 0.0, 0.0)])
    finding = examiner.examine(3, Poses(centres, np.tile([1.0, 0, 0, 0], (2, 1))), order)
    assert (finding.failing_step, finding.moved_item) == (3, 0)


def test_a_turn_from_one_side_to_the_other_is_a_movement():
    """By 6 degrees about the corner that is looked at, from -3 to +3 degrees."""
    box = Box((1.0, 2.0, 0.5), 1.0, (0.0, 0.0, 0.25))
    examiner = Examiner([box], Criterion.ADAMS, 10.0, 10.0)
    corner = np.array(box.centre) - 0.5 * np.array(box.size)

    def turned(degrees):
        half = 0.5 * math.radians(degrees)
        quaternion = np.array([math.cos(half), 0.0, math.sin(half), 0.0])
        centre = corner + matrix(quaternion) @ (0.5 * np.array(box.size))
        return Poses(centre[None], quaternion[None])

    found = examiner.between(turned(-3.0), turned(3.0), np.array([0]))
    assert found == pytest.approx([0.6])
    assert examiner.between(turned(3.0), turned(3.0), np.array([0])) == pytest.approx(
        [0.0], abs=1e-6
    )
