"""Layouts for test vectors, drawn at random and taken from the labelled sets that are shipped.

A layout is ``lower`` and ``upper`` (J, 3), ``weights`` (J,), ``offsets`` (J, 3) and ``floor`` (5,),
as ``harness/core/steadyload.h`` has them.
"""

from __future__ import annotations

import numpy as np

from steadyload.layouts.benchmark.dataset import SETS, load_benchmark

PLANE = (-np.inf, -np.inf, np.inf, np.inf, 0.0)
SIDES = (10.0, 18.0, 20.0, 22.0, 25.0, 40.0)
APART = (0.0, 0.0, 1e-9, 0.005, 0.00999, 0.0101, 0.02, 0.5, 2.0)
"""How far boxes miss the tops below them, or each other at their sides [cm]: nothing, rounding, the
tolerance, what closes when boxes move, more.
"""


def drawn(draw, most):
    """A random layout of 2 to ``most`` boxes, or one of plates joined by a bridge."""
    return bridged(draw) if draw.random() < 0.05 else dropped(draw, most)


def dropped(draw, most):
    """Boxes let down at random places on grids of few lengths: edges, tops and centres tie; some
    stand out over the edge of the deck, miss the tops below, are slivers, or are pushed below.
    """
    wide, deep = draw.choice([60.0, 80.0, 120.0]), draw.choice([50.0, 60.0, 80.0])
    grid, over = draw.choice([1.0, 5.0, 0.1]), draw.choice([0.0, 0.0, 8.0])
    jitter, count = draw.choice(APART), int(draw.integers(2, most + 1))
    lower, upper, found = np.empty((count, 3)), np.empty((count, 3)), 0
    sizes = draw.choice(SIDES, (count, 3))
    if draw.random() < 0.3:
        sizes = np.maximum(np.round(draw.uniform(4.0, 45.0, (count, 3)) / grid), 1.0) * grid
    if draw.random() < 0.2 and count > 4:  # all that follows stands on one plate: one group
        lower[:2], upper[0], upper[1] = 0.0, (wide, 20.0, deep), (wide, 25.0, deep)
        lower[1, 1], found = 20.0, 2
        sizes = sizes[2:]
    for size in sizes:
        if draw.random() < 0.1:
            size[draw.integers(3)] = draw.choice([0.02, 0.5, 2.0, 3.0])
        end = [wide + over - size[0], 1.0, deep + over - size[2]]
        place = np.round(draw.uniform([-over, 0.0, -over], end) / grid) * grid
        low, high = lower[:found], upper[:found]
        if found and draw.random() < 0.4:
            other, axis = int(draw.integers(found)), int(draw.choice([0, 2]))
            flush = high[other, axis], low[other, axis] - size[axis], low[other, axis]
            place[axis] = draw.choice(flush) + draw.choice([0.0, 0.0, 0.01, 0.3])
        shared = np.minimum(high[:, ::2], (place + size)[::2]) - np.maximum(low[:, ::2], place[::2])
        under = high[shared.min(axis=1) > 0.0100001, 1] if found else np.empty(0)
        place[1] = under.max() if len(under) else 0.0
        if draw.random() < 0.25:
            place[1] = max(place[1] + draw.choice([-1.0, 1.0, 1.0]) * jitter, 0.0)
        lower[found], upper[found] = place, place + size
        found += 1
    weights = np.round(draw.uniform(1.0, 20.0, count))
    if draw.random() < 0.3:
        weights = draw.choice([0.01, 0.1, 1.0, 3.0, 100.0, 1000.0], count)
    elif draw.random() < 0.05:  # rounding hides what balances
        weights = draw.choice([1e-9, 1.0, 1e6], count)
    offsets = np.zeros((count, 3))
    if draw.random() < 0.4:
        offsets = np.round(draw.uniform(-0.3, 0.3, (count, 3)) * (upper - lower), 1)
    if draw.random() < 0.1:
        order = draw.permutation(count)
        lower, upper = lower[order], upper[order]
    floor = PLANE if draw.random() < 0.4 else (0.0, 0.0, wide, deep, 14.4)
    return lower, upper, weights, offsets, np.array(floor)


def bridged(draw):
    """Two plates joined by a bridge; a bar on one of them comes down onto a prop; then more boxes,
    of which many neither load nor meet what moves.
    """
    rows = [
        (0, 0, 0, 40, 20, 40), (100, 0, 0, 40, 20, 40), (0, 20, 0, 40, 10, 40),
        (100, 20, 0, 40, 10, 40), (30, 30, 0, 80, 5, 10),
        (0, 0, 90, 10, 30 - draw.choice([0.5, 1.0, 3.0]), 10), (0, 30, 20, 10, 5, 80),
    ]  # fmt: skip
    for _ in range(int(draw.integers(1, 5))):
        x = draw.choice([0.0, 10.0, 20.0, 30.0, 100.0, 110.0, 120.0, 130.0, 137.0])
        taken = [k for k, row in enumerate(rows[7:]) if row[0] == x]
        rows.append((x, 30 + 5 * len(taken), 20 if x else 90 - 20 * len(taken), 10, 5, 10))
    table, count = np.array(rows, dtype=float), len(rows)
    weights = np.round(draw.uniform(1.0, 9.0, count), 1)
    lower, upper = table[:, :3].copy(), table[:, :3] + table[:, 3:]
    return lower, upper, weights, np.zeros((count, 3)), np.array(PLANE)


def shipped(count, most):
    """About so many layouts of at most ``most`` boxes of every set, with their names."""
    for word in ("", *SETS):
        bench = load_benchmark(word or None)
        batch = bench.batch(bench.cases.iloc[:: max(len(bench.cases) // count, 1)])
        for k in range(len(batch.starts) - 1):
            part = slice(batch.starts[k], batch.starts[k + 1])
            arrays = batch.lower, batch.upper, batch.weights, batch.mass_offsets
            if part.stop - part.start <= most:
                own = (np.ascontiguousarray(each[part]) for each in arrays)
                yield f"{word or 'large'} {k}", (*own, np.array(batch.floors[k]))
