"""Loads that boxes bear while a load is built up: each time found from those before."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, eye_array
from scipy.sparse.linalg import splu

from steadyload.core.forces import Energy
from steadyload.layouts.model.contacts import FLOOR
from steadyload.layouts.model.layout import Arrangement, FloatArray
from steadyload.statics.bearing.forces import Rectangles, Statics
from steadyload.statics.bearing.pressing import FIRM


class GrowingStatics:
    """The contact forces of least energy of a load that is built up, box by box.

    They are those of :meth:`Statics.least_energy` of the boxes so far, but for rounding. The
    factors of the equations of the complete load are laid out once; a box that is placed changes
    few of them.

    Args:
        layout: the complete load, J boxes.
        contacts: of the layout, k of them.
        presses: which corners probably press, shape (k, 4).
    """

    def __init__(
        self, layout: Arrangement, contacts: Rectangles, presses: NDArray[np.bool_]
    ) -> None:
        statics, count = Statics(layout, contacts=contacts), len(layout)
        self._pairs = statics.pairs
        self._place = _elimination_order(self._pairs, count)
        self._root = np.sqrt(statics.soft())
        matrix = statics.matrix
        box, of_box = np.divmod(matrix.indices.astype(np.int64), 3)
        values = matrix.data / np.repeat(self._root, np.diff(matrix.indptr))
        rows = 3 * self._place[box] + of_box
        firm = FIRM * (1.0 + np.bincount(rows, values**2, 3 * count))
        right = np.zeros(3 * count)
        right[3 * self._place] = statics.weights
        starts, lines = _layout_of_factors(self._pairs, self._place)
        self._energy = Energy(
            _as_int32(starts), _as_int32(lines), firm, _as_int32(matrix.indptr), _as_int32(rows),
            values, right, presses.ravel(),
        )  # fmt: skip

    def borne(self, group: NDArray[np.int64]) -> FloatArray | None:
        """The loads on the tops of all boxes by the forces in a group [kg], (J,).

        Args:
            group: boxes that are joined by standing on each other, in order; the next one that is
                asked for has nothing to do with it or holds all of it.

        Returns:
            None where none are found, as where none balance; nothing can be asked any more.
        """
        is_there = np.zeros(len(self._place) + 1, dtype=np.bool_)  # the last for the floor
        is_there[group] = is_there[FLOOR] = True
        below, above = self._pairs.T
        contacts = np.flatnonzero(is_there[below] & is_there[above])
        corners = (4 * contacts[:, None] + np.arange(4)).ravel()
        equations = (3 * np.sort(self._place[group])[:, None] + np.arange(3)).ravel()
        pulls = self._energy.pulls(_as_int32(corners), _as_int32(equations))
        if pulls is None:
            return None
        forces = np.maximum(pulls, 0.0) / self._root[corners]
        under = np.repeat(below[contacts], 4)
        tops = np.bincount(under[under != FLOOR], forces[under != FLOOR], len(self._place))
        return np.asarray(tops, dtype=np.float64)


def _as_int32(values: NDArray[np.integer]) -> NDArray[np.int32]:
    return np.ascontiguousarray(values, dtype=np.int32)


def _elimination_order(pairs: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """The place of every box in an order in which few entries of the factors are not zero, (J,)."""
    on_boxes = pairs[pairs[:, 0] != FLOOR]
    half = csc_array(coo_array((np.ones(len(on_boxes)), tuple(on_boxes.T)), shape=(count, count)))
    joined = csc_array(half + half.T + count * eye_array(count))
    factors = splu(
        joined, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )
    return np.asarray(factors.perm_c, dtype=np.int64)


def _layout_of_factors(
    pairs: NDArray[np.int64], place: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Where the factor L of the equations, three a box, may not be zero below its diagonal.

    Args:
        pairs: the lower and the upper box of every contact, (k, 2).
        place: of the boxes in the order of elimination, (J,).

    Returns:
        Where its columns start, (3 J + 1,), and the rows of its entries.
    """
    later: list[set[int]] = [set() for _ in place]
    for one, other in place[pairs[pairs[:, 0] != FLOOR]].tolist():
        later[min(one, other)].add(max(one, other))
    rows = []
    for box, found in enumerate(later):
        behind = sorted(found)
        if behind:
            later[behind[0]].update(behind[1:])
        others = (3 * np.array(behind, dtype=np.int64)[:, None] + np.arange(3)).ravel()
        for of_box in range(3):
            own = np.arange(3 * box + of_box + 1, 3 * box + 3)
            rows.append(np.concatenate((own, others)))
    starts = np.concatenate(([0], np.cumsum([len(found) for found in rows])))
    return starts, np.concatenate(rows)
