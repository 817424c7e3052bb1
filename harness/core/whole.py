"""Whole layouts in C, one or many: see steadyload.h and, of margins, searching.h."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.core.library import (
    FINDING,
    LIBRARY,
    Finding,
    RefusedError,
    array,
    count_of,
    ended_well,
    work,
)

SUPPORTED, CARRIED, BALANCED = range(3)
"""Rules: ``sl_rule`` of steadyload.h."""


def judge(
    rule: int, alpha: float, lower: Any, upper: Any, weights: Any, offsets: Any, floor: Any
) -> Finding:
    """The first failure of a layout: ``sl_judge``."""
    boxes, found = _boxes(lower, upper, weights, offsets), np.empty(1, FINDING)
    at = array("floor", floor, 5)
    ended = LIBRARY.sl_judge(work(), rule, alpha, *boxes, at, found.ctypes.data)
    ended_well(ended, "a layout")
    return _finding(found)


def judge_many(
    rule: int, alpha: float, starts: Any, lower: Any, upper: Any, weights: Any, offsets: Any,
    floors: Any,
) -> Any:  # fmt: skip
    """Findings of many layouts, of type :data:`FINDING`, (L,): ``sl_judge_many``.

    Args:
        rule: see the header.
        alpha: likewise.
        starts: of type int32, (L + 1,); they do not descend, nor go beyond the boxes.
        lower: see the header, as all that follow.
        upper: likewise.
        weights: likewise.
        offsets: likewise.
        floors: likewise.
    """
    (count, *boxes), layouts = _boxes(lower, upper, weights, offsets), count_of("starts", starts) - 1
    first = array("starts", starts, layouts + 1, kind=np.int32)
    of_floors = array("floors", floors, layouts, 5)
    if layouts < 0 or starts[0] < 0 or starts[-1] > count or (np.diff(starts) < 0).any():
        raise RefusedError("starts of layouts descend, or go beyond the boxes")
    found = np.empty(layouts, FINDING)
    ended = LIBRARY.sl_judge_many(
        work(), rule, alpha, layouts, first, *boxes, of_floors, found.ctypes.data
    )
    ended_well(ended, "a batch of layouts")
    return found


def check(lower: Any, upper: Any, weights: Any, offsets: Any, contour: Any) -> int:
    """0 for a layout that has a meaning, else 1 + the first box that is wrong: ``sl_check``."""
    boxes = _boxes(lower, upper, weights, offsets)
    return int(LIBRARY.sl_check(*boxes, array("contour", contour, 6)))


def margin(most: float, lower: Any, upper: Any, weights: Any, offsets: Any, floor: Any) -> Finding:
    """The margin of balance of a layout, as ``number``: ``sl_margin``."""
    boxes, found = _boxes(lower, upper, weights, offsets), np.empty(1, FINDING)
    at = array("floor", floor, 5)
    ended_well(LIBRARY.sl_margin(work(), most, *boxes, at, found.ctypes.data), "a margin")
    return _finding(found)


def _boxes(lower: Any, upper: Any, weights: Any, offsets: Any) -> tuple[int, int, int, int, int]:
    """How many boxes there are, and the addresses of their arrays."""
    count = count_of("lower", lower)
    return (
        count, array("lower", lower, count, 3), array("upper", upper, count, 3),
        array("weights", weights, count), array("offsets", offsets, count, 3),
    )  # fmt: skip


def _finding(found: Any) -> Finding:
    ended, step, item, _, number = found[0].item()
    return Finding(ended, step, item, number)
