"""Numbers to draw deviations from: scrambled Sobol points, the same for every method and layout.

Sobol points fill a cube more evenly than random ones, so a probability read off them is nearer to
the truth. Scrambled at random they stay as even, every point is uniformly distributed, and several
scramblings apart from one another show by how much their answers differ.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.model.layout import FloatArray

_BITS = 32
_MOST_DIMENSIONS = 21_201
"""Those of scipy, whose import takes half a second and is left until points are asked for."""


def sobol(first: int, last: int, dimensions: int, *, seed: int, replicate: int) -> FloatArray:
    """Points of a scrambled Sobol sequence, strictly inside the unit cube.

    Scrambled by a random lower triangular matrix and a digital shift (Matousek 1998), as by scipy;
    but a coordinate depends on seed, replicate and its own number alone, not on how many others
    there are. Beyond those that Sobol points are known for, coordinates are plain random numbers.

    Args:
        first: the first point, counted from 0.
        last: the one after the last; points are most even where both are multiples of the same
            power of two.
        dimensions: coordinates of a point, 1 or more.
        seed: 0 or more.
        replicate: which scrambling; those of different numbers are independent of one another.

    Returns:
        Shape (last - first, dimensions); read-only.
    """
    even = min(dimensions, _MOST_DIMENSIONS)
    # In blocks, so that layouts of about one length find them made already.
    block = min(1 << (even - 1).bit_length(), _MOST_DIMENSIONS)
    points = _scrambled(first, last, block, seed, replicate)[:, :even]
    if dimensions == even:
        return points
    keys = [[seed, replicate, 1, point] for point in range(first, last)]
    rest = [np.random.default_rng(key).random(dimensions - even) for key in keys]
    return np.concatenate((points, rest), axis=1)


@lru_cache(maxsize=256)
def _scrambled(first: int, last: int, dimensions: int, seed: int, replicate: int) -> FloatArray:
    random = np.random.default_rng([seed, replicate])
    rows = random.integers(0, 1 << _BITS, (dimensions, _BITS + 1), dtype=np.uint32)
    plain = _plain(first, last, dimensions)
    found = np.broadcast_to(rows[:, _BITS], plain.shape).copy()
    for bit in range(_BITS):
        # Bit 0 is the highest: a matrix row is what is drawn above the diagonal bit, and that bit.
        diagonal = 1 << (_BITS - 1 - bit)
        row = (rows[:, bit] & np.uint32((1 << _BITS) - 2 * diagonal)) | np.uint32(diagonal)
        odd = np.bitwise_count(row & plain) & np.uint8(1)
        found ^= odd.astype(np.uint32) << np.uint32(_BITS - 1 - bit)
    points = (found.astype(np.float64) + 0.5) / 2.0**_BITS
    points.setflags(write=False)
    return points


@lru_cache(maxsize=16)
def _plain(first: int, last: int, dimensions: int) -> NDArray[np.uint32]:
    """Sobol points before scrambling, as whole numbers of 32 bits."""
    from scipy.stats import qmc

    sequence = qmc.Sobol(dimensions, scramble=False, bits=_BITS)
    if first:
        sequence.fast_forward(first)
    return np.asarray(sequence.random(last - first) * 2.0**_BITS, dtype=np.uint32)
