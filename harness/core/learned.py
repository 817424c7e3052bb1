"""Features, ranges and networks of learned methods in C, one layout at a time: see learned.h.

Arrays that are filled are C-contiguous and of type float64, where nothing else is said.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from steadyload.core.constants import PLAIN, QUANTITIES, SUPPORT
from steadyload.core.library import LIBRARY, array, count_of, ended_well, work
from steadyload.core.whole import Given


def plain_features(given: Given, pallet: Any) -> Any:
    """Plain features of every step, of type float32, (J, PLAIN): ``sl_plain_features``.

    Args:
        given: the layout; its floor is not looked at.
        pallet: width, height and depth [cm], above 0, (3,).
    """
    found, at = np.empty((len(given), PLAIN), np.float32), array("pallet", pallet, 3)
    LIBRARY.sl_plain_features(*given.addresses[:-1], at, found.ctypes.data)
    return found


def support(given: Given) -> tuple[Any, Any]:
    """Support of every step, (J, SUPPORT), and the same as networks take it, of type float32:
    ``sl_support``.
    """
    shape = len(given), SUPPORT
    table, features = np.empty(shape), np.empty(shape, np.float32)
    ended = LIBRARY.sl_support(work(), *given.addresses, table.ctypes.data, features.ctypes.data)
    ended_well(ended, "the support of a layout")
    return table, features


def quantities(given: Given) -> Any:
    """Quantities of every box that training has ranges of, (J, QUANTITIES): ``sl_quantities``."""
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


class Layer(NamedTuple):
    """An LSTM layer of H cells that takes F inputs: arrays of type float32.

    Attributes:
        inward: weights of the inputs, (F, 4 H); gates in the order input, forget, output, cell.
        recurrent: weights of the outputs of the step before, (H, 4 H).
        bias: of the gates, (4 H,).
    """

    inward: Any
    recurrent: Any
    bias: Any


class Lstm:
    """L layers of H cells each, one upon the other, and the decision on a step.

    The arrays are kept, and must not change.

    Args:
        layers: the first takes the features of a step, each other one the outputs of that before.
        head: weights of the logit, of type float32, (H,).
        last: its bias.
    """

    def __init__(self, layers: Sequence[Layer], head: Any, last: float) -> None:
        self.layers, self.head, self.last = tuple(layers), head, last
        self.width = count_of("head", head)
        self._columns = count_of("inward", layers[0].inward)
        self._head_at = array("head", head, self.width, kind=np.float32)
        columns = (self._columns, *(self.width for _ in layers[1:]))
        self._at = [
            (count, *self._addresses(layer, count))
            for layer, count in zip(layers, columns, strict=True)
        ]

    def __reduce__(self) -> tuple[Any, ...]:
        """A copy has arrays, and so addresses, of its own."""
        return type(self), (self.layers, self.head, self.last)

    def _addresses(self, layer: Layer, columns: int) -> tuple[int, int, int]:
        gates = 4 * self.width
        return (
            array("inward", layer.inward, columns, gates, kind=np.float32),
            array("recurrent", layer.recurrent, self.width, gates, kind=np.float32),
            array("bias", layer.bias, gates, kind=np.float32),
        )

    def start(self) -> Any:
        """The state before the first step: outputs and cells of every layer, (L, 2, H)."""
        return np.zeros((len(self.layers), 2, self.width), np.float32)

    def run(self, rows: Any, state: Any) -> tuple[Any, Any]:
        """Outputs of the last layer, (J, H), and the state after the last step: ``sl_run_layer``.

        Args:
            rows: features of J steps, of type float32, (J, F).
            state: before the first of them; it stays as it is.
        """
        steps, count, mine = count_of("rows", rows), len(self.layers), work()
        given = array("rows", rows, steps, self._columns, kind=np.float32)
        array("state", state, count, 2, self.width, kind=np.float32)
        after, outputs = state.copy(), np.empty((count, steps, self.width), np.float32)
        state_at, found = after.ctypes.data, outputs.ctypes.data
        for columns, *weights in self._at:
            ended = LIBRARY.sl_run_layer(
                mine, steps, columns, self.width, given, *weights, state_at, found
            )
            ended_well(ended, "a layer of a network")
            given, found = found, found + outputs.strides[0]
            state_at += after.strides[0]
        return outputs[-1], after

    def decide(self, outputs: Any) -> Any:
        """The probability that a step is unstable, 0 to 1, of J steps, (J,): ``sl_decide``.

        Args:
            outputs: of the last layer, (J, H).
        """
        steps = count_of("outputs", outputs)
        given = array("outputs", outputs, steps, self.width, kind=np.float32)
        chances = np.empty(steps, np.float32)
        LIBRARY.sl_decide(steps, self.width, given, self._head_at, self.last, chances.ctypes.data)
        return chances
