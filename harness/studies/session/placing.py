"""Cost of a placement in a loading session by the number of items loaded."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.layouts.packing.packing import random_boxes
from steadyload.methods.contract.method import Method
from steadyload.methods.registry import make_method
from steadyload.methods.session.session import LoadingSession
from steadyload.progress import NamedProgress, silent
from steadyload.runs.asked import Asked, kept_rows
from steadyload.runs.provenance import made_by
from steadyload.studies.kit import Lab

COSTED = (
    "pbs0.7",
    "sme",
    "equilibrium",
    "equilibrium:time=0.3",
    "lstm_1:outside=accept",
    "ps_opt@mujoco",
    "label@mujoco:scope=local",
    "label@mujoco",
)
"""Methods that are measured."""

ITEMS = 200
"""Number of items that are loaded."""

_DRAWS = 3
_SUPPORT = 0.8
_STACK = 20
"""Number of boxes in a stack."""

_APART = 3.0
"""Distance between the centres of stacks, in sides of a box."""

_SPARE = 1.2
"""Number of items offered over the number to be loaded: some are rejected."""

_WINDOW = 20
_REPEATS = 9
_ENOUGH = 10.0
"""Time after which a session ends [s]."""

_ENOUGH_TO_REPEAT = 0.5
"""Total time up to which sessions of one method and draw are repeated [s]."""

_ENOUGH_FOR_A_WHOLE = 1.5
"""Time of one size after which no larger whole layouts are judged [s]."""


class PlacementCost(NamedTuple):
    """Cost of a placement at a number of loaded items.

    Attributes:
        items: last of the consecutive items whose median is taken.
        placement: CPU time of a placement in a session [ms], a median.
        whole: CPU time of judging the whole layout instead [ms]; None where not measured.
    """

    items: int
    placement: float
    whole: float | None


SHOWN = (40, 100, 200)
"""Numbers of loaded items for which the table shows the cost."""


@dataclass(frozen=True, slots=True)
class Scene:
    """Stable boxes: ``about`` describes their arrangement; ``make`` takes a number and a seed."""

    name: str
    about: str
    make: Callable[[int, int], Layout]


def _row(count: int, seed: int) -> Layout:
    pallet = Pallet(100.0, 100.0, 2000.0)
    return random_boxes("row", count, pallet, "back-bottom-left", seed=seed, support=_SUPPORT)


def _pile(count: int, seed: int) -> Layout:
    pallet = Pallet(140.0, 400.0, 100.0)
    return random_boxes("pile", count, pallet, "bottom-back-left", seed=seed, support=_SUPPORT)


def _stacks(count: int, seed: int) -> Layout:
    items: list[Item] = []
    number, side = math.ceil(count / _STACK), 60.0
    for k in range(number):
        stack = random_boxes(
            "stack", _STACK, Pallet(side, 400.0, side), "bottom-back-left",
            seed=seed * number + k, support=_SUPPORT,
        )  # fmt: skip
        for item in stack.items:
            x, y, z = item.position
            items.append(replace(item, sequence=len(items), position=(x, y, z + _APART * side * k)))
    pallet = Pallet(side, 400.0, _APART * side * number)
    return Layout("stacks", pallet, tuple(items[:count]))


SCENES = (
    Scene("stacks", f"floors of 60 x 60 cm apart from each other, {_STACK} boxes on each", _stacks),
    Scene("row", "a long floor, 1 m wide and up to 1 m high, from the back to the front", _row),
    Scene("pile", "a floor of 140 x 100 cm from the bottom up; some 60 boxes cover it", _pile),
)


@dataclass(frozen=True, slots=True)
class MeasuredCurve:
    """The spec of a method, and fields of :class:`PlacementCost`."""

    method: str
    scene: str
    points: Sequence[tuple[int, float, float | None]]


@dataclass(frozen=True, slots=True)
class MeasuredCurves:
    """Curves of all methods in all scenes."""

    curves: Sequence[MeasuredCurve]


class CurvesUnit(Asked[MeasuredCurves], what="cost of a placement"):
    """Curves of methods in turns."""

    methods: tuple[str, ...]
    count: int
    made_by: Mapping[str, Mapping[str, str]]

    def describe(self, part: int) -> str:
        """Description of the curves for messages."""
        return f"placements of {len(self.methods)} methods, up to {self.count} items"

    def measure(self, progress: NamedProgress = silent) -> MeasuredCurves:
        """Measure them; ``progress`` is called with a description of the current measurement."""
        methods = [make_method(spec) for spec in self.methods]
        cells = []
        for scene in SCENES:
            draws = [scene.make(round(_SPARE * self.count), seed) for seed in range(_DRAWS)]
            cells += [_Cell(scene, method, draws) for method in methods]
        for method in methods:
            method.prepare(self.count)
        for turn in range(_REPEATS):
            for cell in cells:
                progress(f"{cell.scene.name}, {cell.method.spec}, turn {turn + 1}")
                cell.run(self.count)
        curves = []
        for cell in cells:
            progress(f"{cell.scene.name}, {cell.method.spec}, whole layouts")
            curves.append(MeasuredCurve(str(cell.method.spec), cell.scene.name, cell.points()))
        return MeasuredCurves(curves)


def session_curves(
    lab: Lab, specs: Sequence[str] = COSTED, *, count: int = ITEMS
) -> tuple[Sequence[MeasuredCurve], Mapping[str, str]]:
    """Cost of a placement against the number of items loaded, by scene and method.

    Sessions are repeated in turns, so that a disturbance of the machine affects all of them, and
    the smallest time of each placement counts.

    Returns:
        The curves, and the provenance of the measurement.
    """
    unit = CurvesUnit(tuple(specs), count, {spec: made_by(make_method(spec)) for spec in specs})
    (found,), made_with = kept_rows(
        lab.work / "measured",
        [unit],
        MeasuredCurves,
        measure=partial(CurvesUnit.measure, progress=lab.progress),
    )
    return found.curves, made_with


@dataclass(slots=True)
class _Cell:
    """One method in one scene: loaded items and smallest times of placements [s], by draw."""

    scene: Scene
    method: Method
    draws: Sequence[Layout]
    loaded: list[Layout] = field(default_factory=list)
    least: list[np.ndarray] = field(default_factory=list)
    spent: float = 0.0

    def run(self, count: int) -> None:
        """Load every draw once more, unless it took too long before."""
        if self.spent > _ENOUGH_TO_REPEAT * len(self.draws):
            return
        for place, draw in enumerate(self.draws):
            loaded, times = _load(self.method, draw, count)
            self.spent += float(times.sum())
            if len(self.least) == place:
                self.loaded.append(loaded)
                self.least.append(times)
            else:
                self.least[place] = np.minimum(self.least[place], times)

    def points(self) -> list[PlacementCost]:
        """The points of the measured curve, with the cost of judging whole layouts."""
        whole = _whole_costs(self.method, self.loaded[0])
        points = []
        for last in range(_WINDOW, min(map(len, self.least)) + 1, _WINDOW):
            times = np.concatenate([times[last - _WINDOW : last] for times in self.least])
            points.append(PlacementCost(last, 1e3 * float(np.median(times)), whole.get(last)))
        return points


def _load(method: Method, layout: Layout, count: int) -> tuple[Layout, np.ndarray]:
    """Place items up to a number accepted or a time limit; CPU seconds of the accepted ones."""
    times: list[float] = []
    spent = 0.0
    with LoadingSession(layout.pallet, method) as session:
        for item in layout.items:
            start = time.process_time()
            stable = session.try_place(item).stable
            taken = time.process_time() - start
            spent += taken
            if stable:
                times.append(taken)
            if len(session) == count or spent > _ENOUGH:
                break
        return session.layout(), np.array(times)


def _whole_costs(method: Method, layout: Layout) -> dict[int, float]:
    """CPU milliseconds of judging the whole layout by number of items, up to a time limit."""
    costs: dict[int, float] = {}
    for items in range(_WINDOW, len(layout) + 1, _WINDOW):
        part, taken = layout.first(items), [method.judge(layout.first(items)).cpu.total]
        while len(taken) < _REPEATS and sum(taken) < 0.1 * _ENOUGH_FOR_A_WHOLE:
            taken.append(method.judge(part).cpu.total)
        costs[items] = 1e3 * min(taken)
        if sum(taken) >= _ENOUGH_FOR_A_WHOLE:
            break
    return costs
