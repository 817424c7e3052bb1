"""Cost of a judgement by engine, number of items and phase, beside the engine's own stepping.

Everything here is measured in one process, alternatives in turn, in CPU time; compare ratios.
"""

from __future__ import annotations

import math
import multiprocessing
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial

import numpy as np

from steadyload.engines.registry import capabilities, engines_here, open_world
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.layouts.packing.packing import random_boxes, random_layouts
from steadyload.methods.contract.method import Seconds, Status
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.scene import boxes
from steadyload.methods.simulation.simulation_parameters import SimulationParameters
from steadyload.reports.columns import column, fixed, row, significant
from steadyload.runs.able import spatial_engines
from steadyload.runs.provenance import made_on
from steadyload.runs.worker import worker_environment
from steadyload.statistics.growth import slope
from steadyload.studies.kit import Asked, Lab

ITEM_COUNTS = (5, 10, 20, 50, 100, 200)
TUNING = "t_max=0.3,frequency=90,between_steps=reseat,samples=1"
"""Parameters of a placement of 27 substeps with one sample at its end."""

_LARGEST_SPATIAL_WALL = 20
"""Largest wall for 3-D engines, whose solvers it is the worst case of: DART needs 40 s for 50."""

_PATIENCE = 60.0
"""Time limit of a judgement [s]; a curve ends with one that exceeds it or has no verdict."""

_REPEATS = 5
_ENOUGH_SECONDS = 2.0
"""Time above which a case is not repeated [s]."""


@row
class SpeedPoint:
    """Cost of one layout [CPU ms, medians over ``repeats``].

    ``floor`` is the engine's own stepping, ``create`` the adding of boxes; None where they were not
    measured.
    """

    item_count: int = column("J")
    total: float = column("CPU ms", significant)
    build: float = column("build ms", significant)
    step: float = column("step ms", significant)
    read: float = column("read ms", significant)
    floor: float | None = column("floor ms", significant)
    create: float | None = column("create ms", significant)
    repeats: int

    @property
    def own(self) -> float | None:
        """All that is neither stepping nor adding [CPU us a placement]; None where not known."""
        if self.floor is None or self.create is None:
            return None
        return 1e3 * (self.total - self.floor - self.create) / self.item_count


@row
class SpeedCurve:
    """Cost against the number of items: one engine, one scene, one scope."""

    engine: str = column()
    scene: str = column()
    scope: str = column()
    points: tuple[SpeedPoint, ...]
    exponent: float | None = column("exponent", partial(fixed, digits=2))

    @property
    def panel(self) -> str:
        """Title of its panel."""
        return f"{self.scene}, scope {self.scope}"


@row
class Cost:
    """A point of a curve; the share of steps [%], and all else [CPU us a placement]."""

    curve: SpeedCurve
    point: SpeedPoint
    share: float = column("step %", fixed)
    own: float | None = column("own us a placement", fixed)


@row
class Throughput:
    """Layouts a second [1/s, wall time] over one process and over two."""

    engine: str = column()
    layouts: int = column("n")
    one: float = column("layouts/s, 1 process", significant)
    two: float = column("layouts/s, 2 processes", significant)


@row
class Gain:
    """A throughput, and that over two processes by that over one."""

    throughput: Throughput
    gain: float = column(form="{:.2f}".format)


@cache
def random_pile(count: int) -> Layout:
    """The first ``count`` boxes of one pile packed from the bottom up.

    Nine tenths of every base are supported: the pile stands, so that every item is placed.
    """
    pallet = Pallet(140.0, 400.0, 100.0)
    return random_boxes(f"pile-{count}", count, pallet, "bottom-back-left", seed=3, support=0.9)


def brick_wall(count: int) -> Layout:
    """Bricks of 20 x 15 cm and full depth in courses of six, shifted by 5 cm in turn: planar."""
    items = []
    for index in range(count):
        course, place = divmod(index, 6)
        x = 20.0 * place + (5.0 if course % 2 else 0.0)
        items.append(Item(index, (x, 15.0 * course, 0.0), (20.0, 15.0, 40.0), 3.0))
    return Layout(f"wall-{count}", Pallet(130.0, 600.0, 40.0), tuple(items))


class SpeedUnit(Asked[SpeedCurve], what="cost by number of items"):
    """A curve to be measured."""

    engine: str
    scene: str
    scope: str
    counts: tuple[int, ...]
    made_by: Mapping[str, str]

    def describe(self, part: int) -> str:
        """Description of the curve for messages."""
        return f"{self.engine}, {self.scene}, {self.scope}"

    def measure(self) -> SpeedCurve:
        """Measure points, up to the first that the engine has no verdict for in time."""
        points = []
        for count in self.counts:
            layout = brick_wall(count) if self.scene == "wall" else random_pile(count)
            point = _measure(self.engine, layout, self.scope)
            if point is None:
                break
            points.append(point)
        # The growth of the total from 10 items on, by least squares in log-log; none of one point.
        large = [p for p in points if p.item_count >= 10]
        found = slope([p.item_count for p in large], [p.total for p in large])
        exponent = found if math.isfinite(found) else None
        return SpeedCurve(self.engine, self.scene, self.scope, tuple(points), exponent)


def speed_curves(lab: Lab, counts: Sequence[int] = ITEM_COUNTS) -> list[SpeedCurve]:
    """Cost against the number of items, per engine: the whole pile, local scope, and the wall."""
    every, few = tuple(counts), tuple(n for n in counts if n <= _LARGEST_SPATIAL_WALL)
    spatial = [("wall", "all", few), ("pile", "all", every), ("pile", "local", every)]
    units = [
        SpeedUnit(engine, scene, scope, numbers, made_on(engine))
        for engine in engines_here()
        for scene, scope, numbers in (
            [("wall", "all", every)] if capabilities(engine).dimensions == 2 else spatial
        )
    ]
    return lab.measure(units, SpeedCurve, folder="speed/measured").rows


class ThroughputUnit(Asked[Throughput], what="throughput"):
    """A throughput to be measured."""

    engine: str
    layouts: int
    made_by: Mapping[str, str]

    def describe(self, part: int) -> str:
        """Description of the throughput for messages."""
        return f"{self.engine}, throughput"

    def measure(self) -> Throughput:
        """Judge the layouts by one worker and by two, which are warm."""
        cases = random_layouts(self.layouts, seed=11)
        spec, rates = f"simulation@{self.engine}:{TUNING}", []
        context = multiprocessing.get_context("spawn")
        for workers in (1, 2):
            parts = [cases[i::10] for i in range(10)]
            with worker_environment(), ProcessPoolExecutor(workers, mp_context=context) as pool:
                list(pool.map(_judge_part, [spec] * 4 * workers, [cases[:6]] * 4 * workers))
                start = time.perf_counter()
                done = sum(pool.map(_judge_part, [spec] * len(parts), parts))
                rates.append(done / (time.perf_counter() - start))
        return Throughput(self.engine, self.layouts, *rates)


def throughput(lab: Lab, layouts: int = 60) -> list[Gain]:
    """Layouts a second over one process and over two, wall time, start-up excluded."""
    units = [ThroughputUnit(engine, layouts, made_on(engine)) for engine in spatial_engines()]
    rates = lab.measure(units, Throughput, folder="throughput/measured").rows
    return [Gain(rate, rate.two / rate.one) for rate in rates]


def _judge_part(spec: str, layouts: list[Layout]) -> int:
    method = make_method(spec)
    method.prepare(20)
    return sum(v.status is Status.DONE for v in method.judge_many(layouts))


def _measure(engine: str, layout: Layout, scope: str) -> SpeedPoint | None:
    """One point, or None where the engine has no verdict within a minute."""
    method = make_method(f"simulation@{engine}:{TUNING},scope={scope}")
    method.prepare(len(layout))
    method.judge(layout if len(layout) <= 20 else layout.first(20))
    runs: list[Seconds] = []
    floors: list[tuple[float, float]] = []
    while len(runs) < _REPEATS and sum(run.total for run in runs) < _ENOUGH_SECONDS:
        verdict = method.judge(layout, timeout=_PATIENCE)
        if not verdict.stable:
            return None
        runs.append(verdict.cpu)
        if scope == "all":
            floors.append(_floor(engine, layout))
    spent = [(run.total, run.build, run.step, run.read) for run in runs]
    total, build, step, read = (1e3 * np.median(spent, axis=0)).tolist()
    floor, create = (1e3 * np.median(floors, axis=0)).tolist() if floors else (None, None)
    return SpeedPoint(len(layout), total, build, step, read, floor, create, len(runs))


def _floor(engine: str, layout: Layout) -> tuple[float, float]:
    """CPU seconds of the engine's own stepping, with no Python of ours between the calls, and of
    adding the boxes, which creates native bodies where the engine has them.
    """
    parameters: SimulationParameters = make_method(f"simulation@{engine}:{TUNING}").parameters
    substeps = round(parameters.t_max * parameters.frequency)
    length, stepping, adding = 1.0 / parameters.frequency, 0.0, 0.0
    planar = capabilities(engine).dimensions == 2
    with open_world(engine, parameters.world_settings()) as world:
        for box in boxes(layout, across="depth" if planar else "width"):
            start = time.process_time()
            world.add_box(box)
            adding += time.process_time() - start
            world.prepare()
            start = time.process_time()
            world._advance(substeps, length)
            stepping += time.process_time() - start
            world.reset_poses()
    return stepping, adding
