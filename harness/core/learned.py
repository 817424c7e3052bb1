"""What learned methods judge by, in C, one layout at a time: see learned.h.

What is filled is C-contiguous and of type float64, where nothing else is said.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from steadyload.core.library import LIBRARY, array, count_of, ended_well, work
from steadyload.core.whole import Given

PLAIN, SUPPORT, QUANTITIES = 14, 43, 6
"""Columns of plain features, of support and of quantities: as the header numbers them."""


def plain_features(given: Given, pallet: Any) -> Any:
    """Plain features of every step, of type float32, (J, PLAIN): ``sl_plain_features``.

    Args:
        given: the layout; its floor is not looked at.
        pallet: width, height and depth [cm], above 0, (3,).
    """
    found, at = np.empty((len(given), PLAIN), np.float32), array("pallet", pallet, 3)
    LIBRARY.sl_plain_features(*given.addresses[:-1], at, found.ctypes.data)
    return found


def support_table(given: Given) -> Any:
    """Support of every step, (J, SUPPORT): ``sl_support_table``."""
    found = np.empty((len(given), SUPPORT))
    ended = LIBRARY.sl_support_table(work(), *given.addresses, found.ctypes.data)
    ended_well(ended, "the support of a layout")
    return found


def support_features(given: Given) -> Any:
    """Support of every step as networks take it, of type float32, (J, SUPPORT):
    ``sl_support_features``.
    """
    found = np.empty((len(given), SUPPORT), np.float32)
    ended = LIBRARY.sl_support_features(work(), *given.addresses, found.ctypes.data)
    ended_well(ended, "the support of a layout")
    return found


def quantities(given: Given) -> Any:
    """What training has ranges of, of every box, (J, QUANTITIES): ``sl_quantities``."""
    found = np.empty((len(given), QUANTITIES))
    LIBRARY.sl_quantities(*given.addresses, found.ctypes.data)
    return found


def count_inside(found: Any, least: Any, most: Any) -> int:
    """The number of first boxes whose quantities all lie in a range: ``sl_inside``.

    Args:
        found: quantities, (J, QUANTITIES).
        least: of each, (QUANTITIES,).
        most: likewise.
    """
    count = count_of("found", found)
    ends = array("least", least, QUANTITIES), array("most", most, QUANTITIES)
    return int(LIBRARY.sl_inside(count, array("found", found, count, QUANTITIES), *ends))


class Layer:
    """One LSTM layer of H cells that takes F inputs: ``sl_run_layer``.

    All arrays are of type float32; these are kept, and must not change.

    Args:
        inward: weights of the inputs, (F, 4 H); gates in the order input, forget, output, cell.
        recurrent: weights of the outputs of the step before, (H, 4 H).
        bias: of the gates, (4 H,).
    """

    def __init__(self, inward: Any, recurrent: Any, bias: Any) -> None:
        self.inward, self.recurrent, self.bias = inward, recurrent, bias
        self._columns, self.width = count_of("inward", inward), count_of("recurrent", recurrent)
        gates = 4 * self.width
        self._addresses = (
            array("inward", inward, self._columns, gates, kind=np.float32),
            array("recurrent", recurrent, self.width, gates, kind=np.float32),
            array("bias", bias, gates, kind=np.float32),
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy has arrays, and so addresses, of its own."""
        return type(self), (self.inward, self.recurrent, self.bias)

    def run(self, rows: Any, state: Any) -> tuple[Any, Any]:
        """Outputs of some steps, (J, H), and the state after the last one.

        Args:
            rows: inputs, (J, F).
            state: outputs and cells before the first step, (2, H); it stays as it is.
        """
        steps = count_of("rows", rows)
        at = array("rows", rows, steps, self._columns, kind=np.float32)
        array("state", state, 2, self.width, kind=np.float32)
        outputs, after = np.empty((steps, self.width), np.float32), state.copy()
        ended = LIBRARY.sl_run_layer(
            work(), steps, self._columns, self.width, at, *self._addresses,
            after.ctypes.data, outputs.ctypes.data,
        )  # fmt: skip
        ended_well(ended, "a layer of a network")
        return outputs, after


def decide(outputs: Any, head: Any, last: float) -> Any:
    """The probability that a step is unstable, 0 to 1, of some steps, (J,): ``sl_decide``.

    Args:
        outputs: of the last layer, of type float32, (J, H).
        head: weights of the logit, of type float32, (H,).
        last: its bias.
    """
    steps, width = count_of("outputs", outputs), count_of("head", head)
    chances = np.empty(steps, np.float32)
    LIBRARY.sl_decide(
        steps, width, array("outputs", outputs, steps, width, kind=np.float32),
        array("head", head, width, kind=np.float32), last, chances.ctypes.data,
    )  # fmt: skip
    return chances
