"""Resolution of a balance: can what is left over of the weights be told from rounding?

The forces that come closest to balance leave every item with an acceleration. It is compared with
what presses on that item itself, not with the weight of the whole group: under forces of a tonne
rounding may well move a gram, and beside them it may not.
"""

from __future__ import annotations

import numpy as np

from steadyload.core.constants import NOISE, TIE
from steadyload.layouts.model.layout import FloatArray


class UnresolvedError(RuntimeError):
    """The weights of a group lie too far apart to tell balance from rounding."""


def is_balanced(
    motion: FloatArray, loads: FloatArray, masses: FloatArray, residue: float
) -> bool | None:
    """Whether a group of items is balanced; None where rounding hides it.

    A motion within rounding of the item's own loads proves balance: the forces are at hand. One
    above that and above the error of the solution proves that there is none.

    Args:
        motion: acceleration of every item under the forces found [g], shape (n,).
        loads: the same measure of all forces on it, its weight included, without their signs.
        masses: in any unit, shape (n,).
        residue: share of the loads that counts as rounding.
    """
    beyond = motion > residue * loads
    if not beyond.any():
        return True
    error = NOISE * np.sqrt(masses.max() / masses)
    return False if (motion > error)[beyond].any() else None


def fastest(motion: FloatArray) -> int:
    """The place of the item that starts fastest, the first of those that rounding alone ranks.

    Args:
        motion: acceleration of every item [g], shape (n,).
    """
    return int(np.argmax(motion >= (1.0 - TIE) * motion.max()))


def unresolved(weights: FloatArray) -> UnresolvedError:
    """The error that says so of a group with these weights [kg]."""
    ratio = float(weights.max() / weights.min())
    return UnresolvedError(
        "forces cannot be told from rounding: the weights of items that touch each other differ by "
        f"a factor of {ratio:.0e}"
    )
