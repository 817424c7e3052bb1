"""Direct solution of linear systems of 6 x 6 blocks, one row of blocks a body.

Bodies that do not touch share no block. Elimination in order of least degree keeps most blocks of
a pile empty, so the work grows with the contacts and not with the cube of the number of bodies.
"""

from __future__ import annotations

import numpy as np

from steadyload.engines.reference.compilation import compiled

SIZE = 6


@compiled
def elimination_order(filled):
    """Order by least degree; ``filled`` (n, n) of bool is completed by the blocks that fill in."""
    n = len(filled)
    order = np.empty(n, np.int64)
    degree = np.zeros(n, np.int64)
    done = np.zeros(n, np.bool_)
    for i in range(n):
        for j in range(n):
            if i != j and filled[i, j]:
                degree[i] += 1
    around = np.empty(n, np.int64)
    for step in range(n):
        best = -1
        for i in range(n):
            if not done[i] and (best < 0 or degree[i] < degree[best]):
                best = i
        order[step], done[best] = best, True
        count = 0
        for i in range(n):
            if not done[i] and filled[best, i]:
                around[count] = i
                count += 1
                degree[i] -= 1
        for x in range(count):
            for y in range(x):
                i, j = around[x], around[y]
                if not filled[i, j]:
                    filled[i, j] = filled[j, i] = True
                    degree[i] += 1
                    degree[j] += 1
    return order


@compiled
def _invert(block):
    """Invert a 6 x 6 block in place (Gauss and Jordan, partial pivoting); False if singular."""
    swaps = np.empty(SIZE, np.int64)
    for k in range(SIZE):
        pivot = k
        for i in range(k + 1, SIZE):
            if abs(block[i, k]) > abs(block[pivot, k]):
                pivot = i
        if not abs(block[pivot, k]) > 0.0:
            return False
        swaps[k] = pivot
        if pivot != k:
            for j in range(SIZE):
                block[k, j], block[pivot, j] = block[pivot, j], block[k, j]
        inverse = 1.0 / block[k, k]
        block[k, k] = 1.0
        for j in range(SIZE):
            block[k, j] *= inverse
        for i in range(SIZE):
            if i != k:
                factor = block[i, k]
                block[i, k] = 0.0
                for j in range(SIZE):
                    block[i, j] -= factor * block[k, j]
    for k in range(SIZE - 1, -1, -1):
        pivot = swaps[k]
        if pivot != k:
            for i in range(SIZE):
                block[i, k], block[i, pivot] = block[i, pivot], block[i, k]
    return True


@compiled
def factorise(matrix, filled, order):
    """Factorise in place: inverses on the diagonal, multipliers below, the rest above it.

    Args:
        matrix: shape (n, n, 6, 6); blocks that are not ``filled`` are not read.
        filled: which blocks there are, as :func:`elimination_order` leaves it.
        order: as that returns it.

    Returns:
        Whether no diagonal block was singular.
    """
    n = len(order)
    product = np.empty((SIZE, SIZE))
    for step in range(n):
        k = order[step]
        if not _invert(matrix[k, k]):
            return False
        for x in range(step + 1, n):
            i = order[x]
            if not filled[i, k]:
                continue
            left, inverse = matrix[i, k], matrix[k, k]
            for r in range(SIZE):
                for c in range(SIZE):
                    total = 0.0
                    for m in range(SIZE):
                        total += left[r, m] * inverse[m, c]
                    product[r, c] = total
            left[:, :] = product
            for y in range(step + 1, n):
                j = order[y]
                if not filled[k, j]:
                    continue
                right, target = matrix[k, j], matrix[i, j]
                for r in range(SIZE):
                    for m in range(SIZE):
                        factor = left[r, m]
                        for c in range(SIZE):
                            target[r, c] -= factor * right[m, c]
    return True


@compiled
def solve(matrix, filled, order, vector):
    """Solve for ``vector`` (n, 6) in place, with the factors of :func:`factorise`."""
    n = len(order)
    total = np.empty(SIZE)
    for step in range(n):
        k = order[step]
        for x in range(step + 1, n):
            i = order[x]
            if filled[i, k]:
                for r in range(SIZE):
                    for c in range(SIZE):
                        vector[i, r] -= matrix[i, k, r, c] * vector[k, c]
    for step in range(n - 1, -1, -1):
        k = order[step]
        total[:] = vector[k]
        for x in range(step + 1, n):
            j = order[x]
            if filled[k, j]:
                for r in range(SIZE):
                    for c in range(SIZE):
                        total[r] -= matrix[k, j, r, c] * vector[j, c]
        for r in range(SIZE):
            vector[k, r] = 0.0
            for c in range(SIZE):
                vector[k, r] += matrix[k, k, r, c] * total[c]
