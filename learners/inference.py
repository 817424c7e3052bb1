"""Inference of trained networks by NumPy and the C library alone: judging needs no torch.

One layout at a time takes tenths of a millisecond in C, in one thread; many at once are matrix
products. Both give what torch gives, to rounding.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from steadyload.core import learned
from steadyload.learners.features import Array32

VERSION = 1
"""Of how networks are asked: raised when the same weights say something else."""

HEADS = 4
"""Of the attention, where there is one."""


@dataclass(frozen=True)
class _Attention:
    """Weights of the attention over earlier items; every one transposed, with its bias."""

    query: tuple[Array32, Array32]
    mixed: tuple[Array32, Array32]
    key: tuple[Array32, Array32]
    value: tuple[Array32, Array32]


class Memory(NamedTuple):
    """State that a network carries from step to step.

    ``seen``: so many steps. ``state``: of every layer, its outputs and its cells, (L, 2, H).
    """

    seen: int
    state: Array32


class Network:
    """A trained network that judges; made from the arrays that :mod:`steadyload.learners.network`
    trains.

    Args:
        arrays: weights by the names that they have there.
    """

    def __init__(self, arrays: Mapping[str, Array32]) -> None:
        mean, scale = arrays["mean"].astype(float), arrays["scale"].astype(float)
        layers: list[learned.Layer] = []
        while f"lstm.weight_ih_l{len(layers)}" in arrays:
            number = len(layers)
            bias = arrays[f"lstm.bias_ih_l{number}"].astype(float)
            bias = bias + arrays[f"lstm.bias_hh_l{number}"]
            inward = arrays[f"lstm.weight_ih_l{number}"].astype(float)
            if not number:
                inward, bias = _normalised(inward, bias, mean, scale)
            recurrent = arrays[f"lstm.weight_hh_l{number}"]
            layers.append(learned.Layer(_gates(inward), _gates(recurrent), _gates(bias)))
        head = _flat(arrays["head.weight"][0])
        self._lstm = learned.Lstm(layers, head, float(arrays["head.bias"][0]))
        self._attention = None
        if "query.weight" in arrays:
            self._attention = _Attention(
                *(_linear(arrays, name) for name in ("query", "mixed")),
                *(_linear(arrays, name, mean, scale) for name in ("key", "value")),
            )

    def probabilities(self, rows: Array32) -> Array32:
        """That a step is unstable, for every step of one layout.

        Args:
            rows: features, not normalised, (J, F).
        """
        return self.go_on(rows, self.start())[0]

    def start(self) -> Memory:
        """The state of a network before the first step."""
        return Memory(0, self._lstm.start())

    def go_on(self, rows: Array32, memory: Memory) -> tuple[Array32, Memory]:
        """Probabilities that a step is unstable, for steps after those in the memory.

        Args:
            rows: features of all steps, not normalised, (J, F).
            memory: of the steps seen; it stays as it is.

        Returns:
            Shape (J - seen,), and the memory of all steps.
        """
        states, state = self._lstm.run(rows[memory.seen :], memory.state)
        after = Memory(len(rows), state)
        if self._attention is None:
            return self._lstm.decide(states), after
        return self._sigmoid(self._attended(rows[None], states[None]))[0], after

    def probabilities_of_many(self, rows: Array32) -> Array32:
        """That a step is unstable, for every step of many layouts.

        Args:
            rows: features, not normalised, padded with anything after a layout's end, (B, T, F).

        Returns:
            Shape (B, T); what stands after a layout's end means nothing.
        """
        # Time comes first: every step is then one piece of memory.
        below = np.ascontiguousarray(rows.transpose(1, 0, 2))
        for layer in self._lstm.layers:
            below = _run_many(below, layer)
        states = below.transpose(1, 0, 2)
        if self._attention is None:
            return self._sigmoid(self._logits(states))
        return self._sigmoid(self._attended(rows, states))

    @staticmethod
    def _sigmoid(logits: Array32) -> Array32:
        return 0.5 * np.tanh(0.5 * logits) + 0.5

    def _attended(self, rows: Array32, states: Array32) -> Array32:
        """Logits of states, those of the last steps or of all, that look back at all before."""
        assert self._attention is not None
        weights = self._attention
        many, steps, width = states.shape
        query, key, value = (
            (of @ matrix + bias).reshape(many, -1, HEADS, width // HEADS).transpose(0, 2, 1, 3)
            for of, (matrix, bias) in (
                (states, weights.query),
                (rows, weights.key),
                (rows, weights.value),
            )
        )
        scores = query @ key.transpose(0, 1, 3, 2) / np.float32(math.sqrt(width // HEADS))
        seen = rows.shape[1] - steps
        scores[..., np.triu(np.ones(scores.shape[2:], dtype=bool), k=1 + seen)] = -np.inf
        scores = np.exp(scores - scores.max(axis=-1, keepdims=True))
        scores /= scores.sum(axis=-1, keepdims=True)
        back = (scores @ value).transpose(0, 2, 1, 3).reshape(many, steps, width)
        matrix, bias = weights.mixed
        mixed = np.maximum(np.concatenate((states, back), axis=2) @ matrix + bias, 0.0)
        return self._logits(mixed)

    def _logits(self, states: Array32) -> Array32:
        logits: Array32 = states @ self._lstm.head + np.float32(self._lstm.last)
        return logits


def _normalised(weight: Any, bias: Any, mean: Any, scale: Any) -> tuple[Any, Any]:
    """A linear layer that takes features as they are, for one that takes normalised ones."""
    return weight * scale, bias - weight @ (mean * scale)


def _linear(
    arrays: Mapping[str, Array32], name: str, mean: Any = 0.0, scale: Any = 1.0
) -> tuple[Array32, Array32]:
    """Weight, transposed, and bias of a linear layer."""
    weight, bias = arrays[f"{name}.weight"].astype(float), arrays[f"{name}.bias"].astype(float)
    if np.ndim(mean):
        weight, bias = _normalised(weight, bias, mean, scale)
    return _flat(weight.T), _flat(bias)


def _flat(array: Any) -> Array32:
    with np.errstate(over="ignore"):
        # What is infinite then is no verdict; see the methods.
        return np.require(array, np.float32, ["C", "ALIGNED"])


def _gates(array: Any) -> Array32:
    """Rows i, f, g, o of torch as columns i, f, o, g: what takes a sigmoid stands together."""
    i, f, g, o = np.split(array, 4)
    return _flat(np.concatenate((i, f, o, g)).T)


def _run_many(rows: Array32, layer: learned.Layer) -> Array32:
    """One layer over many layouts: states (T, B, H) of inputs (T, B, F)."""
    steps, many, _ = rows.shape
    width = len(layer.recurrent)
    inward = (rows.reshape(steps * many, -1) @ layer.inward + layer.bias).reshape(steps, many, -1)
    out = np.empty((steps, many, width), dtype=np.float32)
    cell = np.zeros((many, width), dtype=np.float32)
    for step in range(steps):
        gates = inward[step]
        if step:
            gates += out[step - 1] @ layer.recurrent
        # sigmoid(x) = (1 + tanh(x / 2)) / 2: one tanh for all gates.
        gates[:, : 3 * width] *= 0.5
        np.tanh(gates, out=gates)
        gates[:, : 3 * width] *= 0.5
        gates[:, : 3 * width] += 0.5
        i, f, o, g = (gates[:, k * width : (k + 1) * width] for k in range(4))
        cell *= f
        cell += i * g
        np.multiply(o, np.tanh(cell), out=out[step])
    return out
