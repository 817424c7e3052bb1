"""Algorithm 1 of the paper: the one loading loop, over any engine."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from engines.registry import open_world, world_class
from engines.world import (
    SETTINGS,
    Box,
    BroadPhase,
    EngineError,
    FloatArray,
    Poses,
    World,
    WorldSettings,
    rotate,
)
from harness.layouts.model import Layout
from harness.methods.method import STABLE, Finding, Method, Phase, Status, Stopwatch
from harness.methods.spec import quantity

_CM = 0.01
_WORLD_AXES = [2, 0, 1]
"""World (x, y, z) = layout (z, x, y): z up instead of y up, by a rotation, not a mirror."""


class BetweenSteps(StrEnum):
    """What happens between two placements.

    ``carry``: the state goes on (Algorithm 1 as printed). ``reseat``: every item goes back to its
    planned pose, at rest (the authors' code, and the way their labels were made).
    """

    CARRY = "carry"
    RESEAT = "reseat"


class Criterion(StrEnum):
    """When an item counts as moved.

    ``paper``: Eq. 6 and 7, at any sample: the geometric centre moved by more than ``eps_t``
    (Euclidean), or an angle about an axis exceeds ``eps_r``. ``adams``: the authors' evaluation of
    the reference simulation, at the last sample: the left-bottom-back corner moved by more than
    ``eps_t`` along one axis, or an angle exceeds ``eps_r``.
    """

    PAPER = "paper"
    ADAMS = "adams"


@dataclass(frozen=True)
class SimulationParameters:
    """Table 3 of the paper and what it leaves open, in its units.

    Raises:
        ValueError: ``t_max`` is shorter than one substep.
    """

    t_max: float = quantity(0.3, "simulated time a placement", unit="s", least=1e-6, most=1000)
    frequency: float = quantity(240, "substeps a second", unit="Hz", least=1, most=1e6)
    eps_t: float = quantity(10, "displacement that counts as unstable", unit="cm", least=0)
    eps_r: float = quantity(10, "angle that counts as unstable", unit="deg", least=0)
    friction: float = quantity(0.5, "Coulomb friction of a contact", least=0, most=10)
    restitution: float = quantity(0, "restitution of a contact", least=0, most=1)
    linear_damping: float = quantity(
        0, "share of linear velocity lost a second", least=0, most=0.999999
    )
    angular_damping: float = quantity(
        0, "share of angular velocity lost a second", least=0, most=0.999999
    )
    margin: float = quantity(0, "collision margin", unit="m", least=0, most=1)
    broad_phase: BroadPhase | None = quantity(None, "broad-phase collision detection")
    solver_iterations: int | None = quantity(
        None, "iterations of the contact solver", least=1, most=100_000
    )
    gravity: float = quantity(9.8, "gravitational acceleration", unit="m/s2", least=0, most=1000)
    between_steps: BetweenSteps = quantity(BetweenSteps.CARRY, "state between two placements")
    criterion: Criterion = quantity(Criterion.PAPER, "when an item counts as moved")
    samples: int = quantity(
        10, "looks at the items a placement, the last at its end", least=1, most=100_000
    )
    emulate: frozenset[str] = quantity(
        frozenset(),
        "settings to imitate where an engine can do so only at a price",
        choices=SETTINGS,
    )

    def __post_init__(self) -> None:
        if self.t_max * self.frequency < 1.0 - 1e-9:
            raise ValueError(
                f"t_max times frequency is {self.t_max * self.frequency:g} substeps a placement; "
                "allowed: 1 or more"
            )

    def world_settings(self) -> WorldSettings:
        """The part of the parameters that a world is made with."""
        return WorldSettings(
            friction=self.friction,
            restitution=self.restitution,
            linear_damping=self.linear_damping,
            angular_damping=self.angular_damping,
            margin=self.margin,
            broad_phase=self.broad_phase,
            solver_iterations=self.solver_iterations,
            gravity=(0.0, 0.0, -self.gravity),
            emulate=self.emulate,
        )


class Simulation(Method):
    """Loading stability by rigid-body simulation (Algorithm 1, Eq. 6 and 7).

    Items are added one after the other. After each, the world is stepped for ``t_max`` seconds and
    looked at ``samples`` times; the first sample at which an item violates the criterion ends the
    loading. The printed algorithm looks before it steps and never after the last item: a slip, not
    a rule, and not followed here.
    """

    Parameters = SimulationParameters
    needs_engine = True

    @property
    def _engine(self) -> str:
        assert self.spec.engine is not None, "make_method asks for an engine"
        return self.spec.engine

    def prepare(self, item_count: int = 0) -> None:
        """Import the engine and warm it up.

        Raises:
            EngineNotInstalledError: its library is missing.
        """
        world_class(self._engine).warm_up(item_count)

    def _judge(self, layout: Layout, watch: Stopwatch) -> Finding:
        parameters: SimulationParameters = self.parameters
        settings = parameters.world_settings()
        watch.enter(Phase.BUILD)
        world = open_world(self._engine, settings)
        run = _Loading(world, boxes(layout), parameters, watch)
        try:
            finding = run.load()
        except EngineError as error:
            finding = Finding(status=Status.ERROR, reason=str(error))
        finally:
            watch.enter(Phase.BUILD)
            world.close()
        return Finding(
            failing_step=finding.failing_step,
            moved_item=finding.moved_item,
            displacement=finding.displacement,
            rotation=finding.rotation,
            reason=finding.reason,
            status=finding.status,
            ignored=world.capabilities.ignored(settings),
            emulated=world.capabilities.emulated(settings),
            substeps=run.substeps,
        )


def boxes(layout: Layout) -> list[Box]:
    """A layout's items as boxes of a world: metres, z up. The one place where axes change."""
    sizes = (layout.upper - layout.lower)[:, _WORLD_AXES] * _CM
    centres = (0.5 * (layout.lower + layout.upper))[:, _WORLD_AXES] * _CM
    offsets = layout.mass_offsets[:, _WORLD_AXES] * _CM
    return [
        Box(tuple(size), weight, tuple(centre), tuple(offset))
        for size, weight, centre, offset in zip(
            sizes.tolist(), layout.weights.tolist(), centres.tolist(), offsets.tolist(), strict=True
        )
    ]


class _Loading:
    """One run of Algorithm 1."""

    def __init__(
        self, world: World, items: list[Box], parameters: SimulationParameters, watch: Stopwatch
    ) -> None:
        self.world, self.items, self.parameters, self.watch = world, items, parameters, watch
        self.substeps = 0
        self.planned = np.array([b.centre for b in items])
        self.corners = -0.5 * np.array([b.size for b in items])

    def load(self) -> Finding:
        """Place item after item until one moves or all stand."""
        for step, item in enumerate(self.items):
            self.watch.enter(Phase.BUILD)
            self.world.add_box(item)
            self.world.prepare()
            finding = self._settle(step)
            if finding is not None:
                return finding
            if self.parameters.between_steps is BetweenSteps.RESEAT:
                self.watch.enter(Phase.BUILD)
                self.world.reset_poses()
        return STABLE

    def _settle(self, step: int) -> Finding | None:
        p = self.parameters
        length = 1.0 / p.frequency
        limit = math.ceil(p.t_max * p.frequency) + 1
        for sample in range(1, p.samples + 1):
            last = sample == p.samples
            self.watch.enter(Phase.STEP)
            count = self.world.stepSimulation(p.t_max / p.samples, limit, length)
            self.substeps += count.executed
            if (p.criterion is Criterion.ADAMS or not count.executed) and not last:
                continue
            self.watch.enter(Phase.READ)
            finding = self._examine(step, self.world.poses())
            if finding is not None:
                return finding
        return None

    def _examine(self, step: int, poses: Poses) -> Finding | None:
        if not (np.isfinite(poses.centres).all() and np.isfinite(poses.quaternions).all()):
            return Finding(
                status=Status.DIVERGED,
                reason=f"the engine's state became non-finite when item {step} was placed",
            )
        moved = self._displacements(poses) / _CM
        turned = np.degrees(euler_angles(poses.quaternions)).max(axis=1)
        unstable = (moved > self.parameters.eps_t) | (turned > self.parameters.eps_r)
        if not unstable.any():
            return None
        # Name the item that is furthest beyond its threshold, in units of the thresholds.
        excess = np.maximum(
            moved / max(self.parameters.eps_t, 1e-12), turned / max(self.parameters.eps_r, 1e-12)
        )
        item = int(excess.argmax())
        return Finding(
            failing_step=step,
            moved_item=item,
            displacement=float(moved[item]),
            rotation=float(turned[item]),
            reason=f"item {item} moved {moved[item]:.1f} cm and turned {turned[item]:.1f} degrees",
        )

    def _displacements(self, poses: Poses) -> FloatArray:
        """How far each item moved [m], shape (n,), as the criterion measures it."""
        count = len(poses.centres)
        shift = poses.centres - self.planned[:count]
        if self.parameters.criterion is Criterion.PAPER:
            return np.sqrt((shift * shift).sum(axis=1))
        corners = self.corners[:count]
        shift += rotate(poses.quaternions, corners) - corners
        return np.abs(shift).max(axis=1)


def euler_angles(quaternions: FloatArray) -> FloatArray:
    """Absolute roll, pitch and yaw [rad], shape (n, 3): turns about the layout's x, y and z axes.

    Args:
        quaternions: w, x, y, z in *world* axes, shape (n, 4), unit length.

    The decomposition is R = Rz Ry Rx in layout axes; below some 20 degrees the order hardly
    matters.
    """
    w, z, x, y = quaternions.T
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return np.abs(np.stack((roll, pitch, yaw), axis=1))
