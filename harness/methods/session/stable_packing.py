"""Packing heuristics that reject unstable placements, by a loading session for each bin."""

from __future__ import annotations

import time
from contextlib import ExitStack
from dataclasses import dataclass

from steadyload.layouts.model.layout import Item, Layout
from steadyload.layouts.packing.heuristics import Heuristic, pack_bins
from steadyload.layouts.packing.packing import Instance, WeightRule, packed_item, source_name
from steadyload.layouts.packing.spaces import Space
from steadyload.methods.contract.method import Method
from steadyload.methods.registry import method_of
from steadyload.methods.session.session import LoadingSession


@dataclass(frozen=True, slots=True)
class StablePacking:
    """Result of packing one instance.

    Attributes:
        layouts: one for each bin, with all its items, unlike those of the labelled set.
        left_out: items that were not accepted at any place, not even in an empty bin.
        placements: number of judged placements.
        rejected: number of these that were rejected.
        seconds: CPU time in all.
        judging: CPU time of the judgements alone.
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
    """Pack an instance into as many bins as needed, and reject placements that are not stable.

    After a rejection the heuristic takes its next choice: the next orientation of the item, the
    next space, the next bin.

    Args:
        instance: the items.
        heuristic: the rules.
        method: judges placements; None rejects nothing.
        weights: the rule for the weights of items.

    Raises:
        SpecError: there is no such method.
    """
    judge = None if method is None else method_of(method)
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
        """Place a box in a bin if the method accepts that; returns whether it was placed."""
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
