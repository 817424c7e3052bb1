"""Movements of items in the authors' reference simulations, read off their raw observations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from steadyload.escaping import shown
from steadyload.layouts.benchmark.tables import BenchmarkError
from steadyload.layouts.model.layout import FloatArray

LABEL_T = 10.0
"""The authors call a step unstable once a corner moved by more along one axis [cm]."""

LABEL_R = 10.0
"""The authors call a step unstable once an item turned by more about one axis [degrees]."""

_FULL_TURN = 360.0


class RotationUnit(StrEnum):
    """Unit of the angles of raw observations."""

    DEGREES = "degrees"
    RADIANS = "radians"


@dataclass(frozen=True, slots=True)
class Movements:
    """Movements, a value a step; the largest over all items placed by then.

    Attributes:
        corner_last, corner_most: how far a corner marker moved along any one axis [cm], at the
            last sample and at any, shape (steps,).
        angle_last, angle_most: how far an item turned about any one axis [degrees], likewise.
        moved: the item that is furthest beyond the label's thresholds at the last sample.
        largest_value: the largest angle as the file states it, whatever its unit.
    """

    corner_last: FloatArray
    corner_most: FloatArray
    angle_last: FloatArray
    angle_most: FloatArray
    moved: list[int]
    largest_value: float

    @property
    def failing_step(self) -> int | None:
        """The first step that the label's rule calls unstable; None for a stable layout."""
        failed = np.flatnonzero((self.corner_last > LABEL_T) | (self.angle_last > LABEL_R))
        return int(failed[0]) if len(failed) else None


def read_movements(
    content: Any, item_count: int, unit: RotationUnit = RotationUnit.DEGREES
) -> Movements:
    """Movements from raw observations, all relative to the first sample of their step.

    Args:
        content: a list of steps, each ``{"sequence": k, "itemDeltas": {"i": {"observations":
            [{"translation": {x, y, z}, "rotation": {x, y, z}}, ...]}}}``; translations [cm] are
            those of an item's corner marker, samples in order of time.
        item_count: of the layout; there must be a step an item.
        unit: of the rotations. Angles that differ by a full turn are equal.

    Raises:
        BenchmarkError: not of this form, or a step is missing.
    """
    steps = _steps(content, item_count)
    rows, moved, largest = [], [], 0.0
    for step in range(item_count):
        deltas = steps[step]
        if not isinstance(deltas, Mapping) or not deltas:
            raise BenchmarkError(f"step {step}: itemDeltas holds no items; allowed: one or more")
        items, found = [], []
        for key, delta in deltas.items():
            items.append(_item(key, step))
            samples = _samples(delta, f"step {step}, item {key}")
            largest = max(largest, float(np.abs(samples[:, 3:]).max()))
            found.append(_shifts(samples, unit))
        last = np.array([(corner[-1], angle[-1]) for corner, angle in found])
        most = [max(values.max() for values in column) for column in zip(*found, strict=True)]
        rows.append([*last.max(axis=0), *most])
        beyond = np.maximum(last[:, 0] / LABEL_T, last[:, 1] / LABEL_R)
        moved.append(items[int(beyond.argmax())])
    corner_last, angle_last, corner_most, angle_most = np.array(rows).T
    return Movements(corner_last, corner_most, angle_last, angle_most, moved, largest)


def _steps(content: Any, item_count: int) -> dict[int, Any]:
    steps: dict[int, Any] = {}
    for entry in content if isinstance(content, list) else [content]:
        step = entry.get("sequence") if isinstance(entry, Mapping) else None
        if type(step) is not int or "itemDeltas" not in entry:
            raise BenchmarkError("is no list of steps, each with 'sequence' and 'itemDeltas'")
        if step in steps:
            raise BenchmarkError(f"step {step} stands there twice; allowed: each once")
        steps[step] = entry["itemDeltas"]
    if sorted(steps) != list(range(item_count)):
        raise BenchmarkError(
            f"holds {len(steps)} steps; allowed: 0 to {item_count - 1}, one an item"
        )
    return steps


def _item(key: str, step: int) -> int:
    if not (key.isascii() and key.isdigit() and int(key) <= step):
        raise BenchmarkError(
            f"step {step}: item is {shown(key)}; allowed: 0 to {step}, placed by then"
        )
    return int(key)


def _samples(delta: Any, where: str) -> FloatArray:
    """Translations [cm] and rotations as stated, shape (samples, 6)."""
    try:
        values = np.array(
            [
                [sample[what][axis] for what in ("translation", "rotation") for axis in "xyz"]
                for sample in delta["observations"]
            ],
            dtype=float,
        )
    except (KeyError, TypeError, ValueError, OverflowError):
        values = np.empty(0)
    if not values.size or not np.isfinite(values).all():
        raise BenchmarkError(
            f"{where}: observations are no samples; allowed: one or more, each with finite x, y "
            "and z of 'translation' and 'rotation'"
        )
    return values


def _shifts(samples: FloatArray, unit: RotationUnit) -> tuple[FloatArray, FloatArray]:
    """Largest shift along an axis [cm] and turn about an axis [degrees], shape (samples,) each."""
    change = np.abs(samples - samples[0])
    turned = np.degrees(change[:, 3:]) if unit is RotationUnit.RADIANS else change[:, 3:]
    turned = turned % _FULL_TURN
    turned = np.minimum(turned, _FULL_TURN - turned)
    return change[:, :3].max(axis=1), turned.max(axis=1)
