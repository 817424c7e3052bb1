"""Checks and digests of the numbers and names of a layout."""

from __future__ import annotations

import hashlib

import numpy as np
from numpy.typing import NDArray

from steadyload.escaping import shown

FloatArray = NDArray[np.float64]

SHOWN = 200
"""Characters of a name in a message."""

_MOST_BITS = 1023
"""Of a whole number that a float can hold."""


def digest_of(*arrays: FloatArray) -> str:
    """SHA-256 of arrays of numbers, as hex digits."""
    digest = hashlib.sha256()
    for array in arrays:
        digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    return digest.hexdigest()


def is_number(value: object) -> bool:
    """True for a number that a float can hold, finite or not."""
    if isinstance(value, int):
        return not isinstance(value, bool) and value.bit_length() <= _MOST_BITS
    return isinstance(value, float | np.floating | np.integer)


def is_vector(values: object) -> bool:
    """True for three numbers."""
    return isinstance(values, tuple | list) and len(values) == 3 and all(map(is_number, values))


def unprintable(name: object) -> str:
    """Sentence that refuses a name."""
    told = ascii(name[:SHOWN]) if isinstance(name, str) else shown(name)
    return f"name is {told}; allowed: one or more printable characters"
