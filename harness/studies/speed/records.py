"""Records of a run of the benchmark: costs, growth, and what they were measured with."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any, TypeVar

from steadyload.statistics.estimate import Estimate

R = TypeVar("R")


class Kind(StrEnum):
    """Kind of work whose cost is measured.

    ``loop``: a Python loop over the layouts. ``empty``: a verdict with its times, of a method that
    does nothing. ``judge``: layouts one by one. ``batch``: all layouts at once. ``place``:
    placements in a session. ``feasible``: positions of an item in a session, judged at once.
    """

    LOOP = "loop"
    EMPTY = "empty"
    JUDGE = "judge"
    BATCH = "batch"
    PLACE = "place"
    FEASIBLE = "feasible"


@dataclass(frozen=True, slots=True)
class CaseSet:
    """A set of layouts that is judged: its name, number of layouts and mean number of items."""

    name: str
    layouts: int
    mean_items: float


@dataclass(frozen=True, slots=True)
class Cost:
    """CPU time of one judgement, placement or position.

    Attributes:
        cases: name of the set of layouts.
        kind: of work.
        method: spec; empty for what no method does.
        count: judgements, placements or positions of a repeat.
        missing: layouts left out because they had no verdict in time.
        microseconds: of one: the median of the repeats.
    """

    cases: str
    kind: Kind
    method: str
    count: int
    missing: int
    microseconds: Estimate


@dataclass(frozen=True, slots=True)
class StepShares:
    """Shares of the steps of a set of layouts.

    Attributes:
        cases: name of the set of layouts.
        method: spec.
        steps: that were judged.
        kept: for which forces found before were kept.
        asked: for which the model of motion was asked.
    """

    cases: str
    method: str
    steps: int
    kept: Estimate
    asked: Estimate


@dataclass(frozen=True, slots=True)
class GrowthPoint:
    """CPU time of a judgement at a number of items: the median of layouts that are stable.

    Attributes:
        items: of every layout.
        joined: how many of the layouts are made of several, side by side.
        microseconds: of a judgement by itself.
        batch: of one in a batch, without a verdict of its own; of nothing where a method has none.
    """

    items: int
    joined: int
    microseconds: Estimate
    batch: Estimate


@dataclass(frozen=True, slots=True)
class GrowthCurve:
    """Cost by number of items: one method, one scene.

    Attributes:
        scene: its name.
        method: spec.
        points: by rising number of items.
        exponent: the cost grows as this power of the number of items.
        late: likewise, from 50 items on.
        batch: likewise, in a batch; of nothing where a method has no batches.
    """

    scene: str
    method: str
    points: tuple[GrowthPoint, ...]
    exponent: Estimate
    late: Estimate
    batch: Estimate


@dataclass(frozen=True, slots=True)
class SpeedRun:
    """A run of the benchmark.

    Attributes:
        date: on which it was made.
        source: revision of the code.
        machine: kind of processor; times on other kinds are not compared.
        compiled: whether methods ran compiled.
        quick: whether it is a short run on fewer layouts.
        load: most processes that wanted to run, one of them ours; None where it is not known.
        patience: seconds after which a judgement is given up.
        cases: that were judged.
        costs, steps, growth: what was measured.
        made_with: provenance of the code that measured, as a page shows it.
    """

    date: str
    source: str
    machine: str
    compiled: bool
    quick: bool
    load: float | None
    patience: float
    cases: tuple[CaseSet, ...]
    costs: tuple[Cost, ...]
    steps: tuple[StepShares, ...]
    growth: tuple[GrowthCurve, ...]
    made_with: Mapping[str, str]

    @classmethod
    def from_json(cls, entry: Mapping[str, Any]) -> SpeedRun:
        """The run of an stored run.

        Raises:
            LookupError, TypeError, ValueError: it is no stored run.
        """
        growth = [
            {**curve, "points": tuple(_read(GrowthPoint, point) for point in curve["points"])}
            for curve in entry["growth"]
        ]
        return cls(
            **{
                **entry,
                "cases": tuple(_read(CaseSet, each) for each in entry["cases"]),
                "costs": tuple(
                    _read(Cost, {**each, "kind": Kind(each["kind"])}) for each in entry["costs"]
                ),
                "steps": tuple(_read(StepShares, each) for each in entry["steps"]),
                "growth": tuple(_read(GrowthCurve, curve) for curve in growth),
            }
        )

    def cost(self, cases: str, kind: Kind, method: str = "") -> Cost | None:
        """The cost of a kind of work; None where it was not measured."""
        wanted = (cases, kind, method)
        return next((c for c in self.costs if (c.cases, c.kind, c.method) == wanted), None)

    def to_json(self) -> dict[str, Any]:
        """The run as an stored run."""
        plain = _plain(asdict(self))
        assert isinstance(plain, dict)
        return plain


def _read(record: type[R], entry: Mapping[str, Any]) -> R:
    """A record of its entry; a mapping is an estimate."""
    return record(**{k: _estimate(v) if isinstance(v, Mapping) else v for k, v in entry.items()})


def _estimate(entry: Mapping[str, Any]) -> Estimate:
    """An estimate of its entry, in which numbers that are none are null."""
    low, value, high = (
        math.nan if entry[name] is None else float(entry[name]) for name in ("low", "value", "high")
    )
    return Estimate(value, low, high, int(entry["n"]))


def _plain(value: Any) -> Any:
    """A value as JSON holds it: numbers that are none become null."""
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
