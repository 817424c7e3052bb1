"""Packing heuristics that put nothing where the loading would fail: by a session a bin."""

from __future__ import annotations

import time
from contextlib import ExitStack
from dataclasses import dataclass

from steadyload.layouts.heuristics import Heuristic, pack_bins
from steadyload.layouts.model import Item, Layout
from steadyload.layouts.packing import Instance, WeightRule, packed_item, source_name
from steadyload.layouts.spaces import Space
from steadyload.methods.method import Method
from steadyload.methods.registry import make_method
from steadyload.methods.session import LoadingSession


@dataclass(frozen=True, slots=True)
class StablePacking:
    """What came of packing one instance.

    Attributes:
        layouts: a bin each, whole: not cut as those of the labelled set are.
        left_out: items that were accepted nowhere, not even in an empty bin.
        placements: that were judged.
        rejected: of these.
        seconds: CPU time of it all.
        judging: CPU time of the placements alone.
    """

    layouts: tuple[Layout, ...]
    left_out: int
    placements: int
    rejected: int
    seconds: float
    judging: float


def pack_stably(
    instance: Instance,
    heuristic: Heuristic,
    method: str | Method | None,
    *,
    weights: WeightRule = WeightRule.PAPER,
) -> StablePacking:
    """Pack an instance into as many bins as it takes, and reject placements that are not stable.

    Where a placement is rejected, the heuristic goes on to the next place that it would take: the
    next way to turn the item, the next space, the next bin.

    Args:
        instance: what is packed.
        heuristic: the rules.
        method: judges placements; None rejects nothing.
        weights: how heavy items are.

    Raises:
        SpecError: there is no such method.
    """
    judge = make_method(method) if isinstance(method, str) else method
    run = _Run(instance, judge, weights)
    start = time.process_time()
    with run.open:
        pack_bins(
            instance.pallet.size, instance.sizes, heuristic, planar=instance.planar,
            accept=run.accept,
        )  # fmt: skip
    seconds = time.process_time() - start
    layouts = tuple(
        Layout(source_name(heuristic, instance, which), instance.pallet, tuple(items))
        for which, items in enumerate(run.bins)
        if items
    )
    left_out = len(instance.sizes) - sum(map(len, layouts))
    return StablePacking(layouts, left_out, run.placements, run.rejected, seconds, run.judging)


class _Run:
    def __init__(self, instance: Instance, method: Method | None, weights: WeightRule) -> None:
        self.instance, self.method, self.weights = instance, method, weights
        self.bins: list[list[Item]] = []
        self.sessions: list[LoadingSession] = []
        self.open = ExitStack()
        self.placements = self.rejected = 0
        self.judging = 0.0

    def accept(self, which: int, box: Space) -> bool:
        """Whether a box may stand in a bin; then it stands there."""
        if which == len(self.bins):
            self.bins.append([])
            if self.method is not None:
                session = LoadingSession(self.instance.pallet, self.method)
                self.sessions.append(self.open.enter_context(session))
        item = packed_item(len(self.bins[which]), box, self.weights)
        if self.method is not None:
            verdict = self.sessions[which].try_place(item)
            self.placements += 1
            self.judging += verdict.cpu.total
            if not verdict.stable:
                self.rejected += 1
                return False
        self.bins[which].append(item)
        return True
