"""Non-negative least squares for contact forces, in C.

SciPy's ``nnls`` (1.17.1) returns solutions that are none where columns repeat each other, as those
of contact points do: of 20,000 groups that lost their balance, some dozen. The residue that it
states is then not that of its solution.
"""

from __future__ import annotations

import numpy as np

from steadyload.core.forces import least_squares
from steadyload.layouts.model.layout import FloatArray


def nonnegative_least_squares(
    matrix: FloatArray, target: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The x >= 0 with the least norm of matrix x - target, and the residue target - matrix x.

    Args:
        matrix: shape (m, n), in units in which its columns and the target are near 1.
        target: shape (m,).

    Raises:
        RuntimeError: the search did not end.
    """
    found, residue, ended = least_squares(np.ascontiguousarray(matrix.T), target)
    if not ended:
        raise RuntimeError("the search for contact forces did not end")
    return found, residue
