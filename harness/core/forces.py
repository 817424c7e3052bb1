"""Forces in C by those who have the equations: see forces.h."""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.core.constants import STANDS
from steadyload.core.library import (
    HELD,
    LIBRARY,
    Kept,
    RefusedError,
    array,
    count_of,
    ended_well,
    work,
)


def least_squares(columns: Any, target: Any) -> tuple[Any, Any, bool]:
    """The x >= 0 with the least sum of squares of target - (sum of x times columns):
    ``sl_nonnegative_least_squares``.

    Args:
        columns: (n, m).
        target: (m,).

    Returns:
        x, (n,), the residual, (m,), and whether the search ended.
    """
    count, rows = count_of("columns", columns), count_of("target", target)
    x, residual = np.empty(count), np.empty(rows)
    ended = LIBRARY.sl_nonnegative_least_squares(
        work(), count, rows, array("columns", columns, count, rows), array("target", target, rows),
        x.ctypes.data, residual.ctypes.data,
    )  # fmt: skip
    return x, residual, ended_well(ended, "least squares") == STANDS


class Energy:
    """Forces of least energy of a load that grows: ``sl_energy_new``. All arrays are copied.

    Args:
        starts: of the columns of L, of type int32, (m + 1,).
        rows: of its entries, likewise, (e,).
        diagonal: D, (m,).
        column_starts: of effects of unit forces at corners, of type int32, (n + 1,).
        column_rows: likewise, (f,).
        column_values: (f,).
        right: (m,).
        presses: which corners probably press, of type bool, (n,).
    """

    def __init__(
        self, starts: Any, rows: Any, diagonal: Any, column_starts: Any, column_rows: Any,
        column_values: Any, right: Any, presses: Any,
    ) -> None:  # fmt: skip
        equations, corners = count_of("right", right), count_of("presses", presses)
        entries, effects = count_of("rows", rows), count_of("column_rows", column_rows)
        whole = array("starts", starts, equations + 1, kind=np.int32)
        own = array("column_starts", column_starts, corners + 1, kind=np.int32)
        if starts[-1] != entries or column_starts[-1] != effects:
            raise RefusedError("columns do not end where their entries do")
        made = HELD.sl_energy_new(
            equations, whole, array("rows", rows, entries, kind=np.int32),
            array("diagonal", diagonal, equations), corners, own,
            array("column_rows", column_rows, effects, kind=np.int32),
            array("column_values", column_values, effects), array("right", right, equations),
            array("presses", presses, corners, kind=bool),
        )  # fmt: skip
        if not made:
            raise RefusedError("these numbers make no equations, or there is no memory for them")
        self._kept = Kept(made, HELD.sl_energy_free)

    def pulls(self, corners: Any, equations: Any) -> Any:
        """Forces at corners, times the roots of how far they yield, (k,); None where there are
        none, and nothing can be asked any more: ``sl_energy_solve``.

        Args:
            corners: of type int32, (k,).
            equations: likewise, (q,).
        """
        count, some = count_of("corners", corners), count_of("equations", equations)
        found = np.empty(count)
        ended = HELD.sl_energy_solve(
            self._kept.address, count, array("corners", corners, count, kind=np.int32), some,
            array("equations", equations, some, kind=np.int32), found.ctypes.data,
        )  # fmt: skip
        return found if ended_well(ended, "corners and equations") == STANDS else None
