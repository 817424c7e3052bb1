"""Limits of loads that stand, by every method; judged where they are missing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import pandas as pd

from steadyload.app.recommend.front import best, front_for
from steadyload.app.recommend.kept import load_fronts
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import LISTS, REAL, Part
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.question import Question
from steadyload.layouts.sizes import MOST_SMALL
from steadyload.methods.contract.spec import parse_spec
from steadyload.methods.registry import make_method
from steadyload.methods.tuned import TUNED
from steadyload.runs.able import fixed_step_engines
from steadyload.runs.asked import measured
from steadyload.runs.pool import PartLimit
from steadyload.runs.provenance import made_by
from steadyload.runs.store import JSON, Store, locked
from steadyload.studies.kit import Asked, Lab, asked
from steadyload.transport.limits import EXACT, VERSION, Limit, around, limits
from steadyload.transport.whole_load import whole_load_limit

REFERENCE = "label@reference"
RUBBING = "equilibrium:sides=friction"
WHOLE = "whole load"
"""Stands for the rule of thumb, which is no method: it judges no loading."""

FRICTIONS = (0.2, 0.3, 0.4, 0.5, 0.6)
RISES = (0.0, 0.05, 0.2, 0.5)
"""Times in which an acceleration rises [s]."""

RISING = "label@mujoco"
"""The method that is asked with every rise."""

FRICTION = 0.5
"""Coefficient of every contact where none is stated."""

LOADS, SMALL = 200, 60
"""Loads of real size, and of the set of many lists."""

REFERENCED = 100
"""Loads of real size, those of fewest boxes, that the reference judges, too."""

DIRECTIONS = 8
"""Directions around a load."""

_SECONDS = 1200.0
"""CPU time that all directions of a load may take."""


@dataclass(frozen=True)
class Load:
    """A load that stands by its label, of one of the labelled sets.

    Attributes:
        of: the set.
        name: of the layout, with its scenario.
        layout: with its centres of mass.
        item_list: that it was packed from.
    """

    of: str
    name: str
    layout: Layout
    item_list: str

    def content_hash(self) -> str:
        """All of it that limits depend on, see :meth:`Layout.content_hash`."""
        return self.layout.content_hash()


class LimitUnit(Asked[list[dict[str, Any]]], what="limits of acceleration", version=VERSION):
    """The limits of a load, in all directions."""

    load: Load
    method: str
    directions: tuple[float, ...]
    rise: float
    made_by: Mapping[str, str] = asked("made by")

    def describe(self, part: int) -> str:
        """Description of the load for messages."""
        return f"{self.method} on load {self.load.name!r}"

    def measure(self) -> list[dict[str, Any]]:
        """Find them."""
        found = limits(self.load.layout, self.method, directions=self.directions, rise=self.rise)
        return list(map(asdict, found))


def _without(unit: LimitUnit, _part: int, reason: str) -> list[dict[str, Any]]:
    return [asdict(Limit(direction, None, reason=reason)) for direction in unit.directions]


@dataclass(frozen=True)
class LoadLimits:
    """Limits of some loads.

    Attributes:
        loads: by set.
        rows: a row a load, method and direction: ``of``, ``load`` (its place among those of its
            set), ``item_list``, ``method``, ``rise`` and the fields of
            :class:`steadyload.transport.limits.Limit`.
    """

    loads: Mapping[str, Sequence[Load]]
    rows: pd.DataFrame


def exact_at(friction: float) -> str:
    """The method that finds the exact limit at a coefficient of friction."""
    return EXACT if friction == FRICTION else f"{EXACT},friction={friction:g}"


def standing_loads(of: str, count: int, most_boxes: int | None = None) -> list[Load]:
    """Loads of a set that stand by their label: layouts that are all different first."""
    benchmark = load_benchmark(of)
    part = Part.TEST if of == LISTS else Part.ALL
    cases = benchmark.select(part, question=Question.STANDS)
    cases = cases[cases["failing_step"].isna()]
    if most_boxes is not None:
        cases = cases[cases["item_count"] <= most_boxes]
    again = cases.duplicated("layout")
    chosen = pd.concat([cases[~again], cases[again]]).head(count)
    names = chosen[["layout", "scenario", "instance"]].itertuples(index=False)
    return [
        Load(of, f"{name} {scenario}", benchmark.layout(name, scenario), item_list)
        for name, scenario, item_list in names
    ]


def engines_on_the_front(boxes: int) -> tuple[str, ...]:
    """Engines whose tuned simulation no cheaper one beats on loads of so many boxes.

    Of those that are installed, by rising CPU time, where a load has to stand; as `steadyload
    recommend` knows them.

    Args:
        boxes: of a load; the largest loads that were measured stand for larger ones.
    """
    fronts = [front for front in load_fronts() if front.question == Question.STANDS]
    own = front_for(fronts, Question.STANDS, min(boxes, max(front.most for front in fronts)))
    simulations = [m for m in own.here().measured if parse_spec(m.method).name == TUNED]
    return tuple(one.engine for one in best(simulations) if one.engine)


def limits_of_loads(lab: Lab, limit: int | None = None) -> LoadLimits:
    """Find the missing limits of loads, and return all; with ``limit`` of so many loads of each
    set, of real size those of fewest boxes.
    """
    here = {
        LISTS: fixed_step_engines(),
        REAL: fixed_step_engines(engines_on_the_front(MOST_SMALL)),
    }
    real = standing_loads(REAL, LOADS, MOST_SMALL)
    fewest = sorted(real, key=lambda load: len(load.layout))[: min(REFERENCED, limit or REFERENCED)]
    found = {
        LISTS: standing_loads(LISTS, min(SMALL, limit or SMALL)),
        REAL: real if limit is None else fewest,
    }
    statics = list(dict.fromkeys([EXACT, RUBBING, *map(exact_at, FRICTIONS)]))
    asked_of = [
        (load, method, 0.0)
        for of, own in found.items()
        for method in (*statics, *(f"label@{name}" for name in here[of]))
        for load in own
    ]
    asked_of += [(load, REFERENCE, 0.0) for load in (*found[LISTS], *fewest)]
    asked_of += [(load, RISING, rise) for rise in RISES if rise for load in found[LISTS]]
    made = {method: made_by(make_method(method)) for _, method, _ in asked_of}
    ways = around(DIRECTIONS)
    units = [LimitUnit(load, method, ways, rise, made[method]) for load, method, rise in asked_of]
    with locked(lab.work):
        store: Store[Any, Any] = Store(lab.work / "limits", JSON)
        store.complete(
            units,
            measured,
            crashed=_without,
            limit=PartLimit(_SECONDS, _without),
            workers=lab.workers,
            progress=lambda *of: lab.progress("limits", *of),
        )
    places = {id(load): place for own in found.values() for place, load in enumerate(own)}

    def row(load: Load, method: str, rise: float, limit: Mapping[str, Any]) -> dict[str, Any]:
        about = {"of": load.of, "load": places[id(load)], "item_list": load.item_list}
        return {**about, "method": method, "rise": rise, **limit}

    rows = [
        row(unit.load, unit.method, unit.rise, limit)
        for unit in units
        for limit in store.read(unit.key)[0]
    ]
    rows += [
        row(load, WHOLE, 0.0, asdict(Limit(way, whole_load_limit(load.layout, FRICTION, way))))
        for own in found.values()
        for load in own
        for way in ways
    ]
    return LoadLimits(found, pd.DataFrame(rows))
