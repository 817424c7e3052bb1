"""Inference of trained networks by numpy and compiled loops alone: judging needs no torch.

One layout at a time is a matter of tenths of a millisecond in a loop that stays in one thread; many
at once are matrix products. Both give what torch gives, to rounding.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from steadyload.learners.compiled import compiled
from steadyload.learners.features import Array32

VERSION = 1
"""Of how networks are asked: raised when the same weights say something else."""

HEADS = 4
"""Of the attention, where there is one."""


@dataclass(frozen=True)
class _Layer:
    """Weights of one LSTM layer, transposed and in the order i, f, o, g, ready for products."""

    inward: Array32
    recurrent: Array32
    bias: Array32


@dataclass(frozen=True)
class _Attention:
    """Weights of the attention over earlier items; every one transposed, with its bias."""

    query: tuple[Array32, Array32]
    mixed: tuple[Array32, Array32]
    key: tuple[Array32, Array32]
    value: tuple[Array32, Array32]


class Memory(NamedTuple):
    """State that a network carries from step to step.

    ``seen``: so many steps. ``states``: of every layer, its output and its cell, (2, H).
    """

    seen: int
    states: tuple[Array32, ...]


class Network:
    """A trained network that judges; made from the arrays that :mod:`steadyload.learners.network`
    trains.

    Args:
        arrays: weights by the names that they have there.
    """

    def __init__(self, arrays: Mapping[str, Array32]) -> None:
        mean, scale = arrays["mean"].astype(float), arrays["scale"].astype(float)
        self._layers: list[_Layer] = []
        while f"lstm.weight_ih_l{len(self._layers)}" in arrays:
            number = len(self._layers)
            bias = arrays[f"lstm.bias_ih_l{number}"].astype(float)
            bias = bias + arrays[f"lstm.bias_hh_l{number}"]
            inward = arrays[f"lstm.weight_ih_l{number}"].astype(float)
            if not number:
                inward, bias = _normalised(inward, bias, mean, scale)
            recurrent = arrays[f"lstm.weight_hh_l{number}"]
            self._layers.append(_Layer(_gates(inward), _gates(recurrent), _gates(bias)))
        self._head, self._last = _flat(arrays["head.weight"][0]), float(arrays["head.bias"][0])
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
        widths = [len(layer.recurrent) for layer in self._layers]
        return Memory(0, tuple(np.zeros((2, width), dtype=np.float32) for width in widths))

    def go_on(self, rows: Array32, memory: Memory) -> tuple[Array32, Memory]:
        """Probabilities that a step is unstable, for steps after those in the memory.

        Args:
            rows: features of all steps, not normalised, (J, F).
            memory: of the steps seen; it stays as it is.

        Returns:
            Shape (J - seen,), and the memory of all steps.
        """
        below, states = rows[memory.seen :], tuple(state.copy() for state in memory.states)
        for layer, state in zip(self._layers, states, strict=True):
            below = _run(below, layer.inward, layer.recurrent, layer.bias, state)
        after = Memory(len(rows), states)
        if self._attention is None:
            return _decide(below, self._head, self._last), after
        return self._sigmoid(self._attended(rows[None], below[None]))[0], after

    def probabilities_of_many(self, rows: Array32) -> Array32:
        """That a step is unstable, for every step of many layouts.

        Args:
            rows: features, not normalised, padded with anything after a layout's end, (B, T, F).

        Returns:
            Shape (B, T); what stands after a layout's end means nothing.
        """
        # Time comes first: every step is then one piece of memory.
        below = np.ascontiguousarray(rows.transpose(1, 0, 2))
        for layer in self._layers:
            below = _run_many(below, layer)
        states = below.transpose(1, 0, 2)
        if self._attention is None:
            return self._sigmoid(states @ self._head + np.float32(self._last))
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
        return mixed @ self._head + np.float32(self._last)


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
        return np.ascontiguousarray(array, dtype=np.float32)


def _gates(array: Any) -> Array32:
    """Rows i, f, g, o of torch as columns i, f, o, g: what takes a sigmoid stands together."""
    i, f, g, o = np.split(array, 4)
    return _flat(np.concatenate((i, f, o, g)).T)


def _run_many(rows: Array32, layer: _Layer) -> Array32:
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


@compiled
def _run(
    rows: Array32, inward: Array32, recurrent: Array32, bias: Array32, state: Array32
) -> Array32:
    """One layer over one layout: outputs (J, H) of inputs (J, F).

    Args:
        rows: the inputs.
        inward: weights of the inputs.
        recurrent: weights of the output before.
        bias: of the gates.
        state: output and cell before the first step, (2, H); then those after the last.
    """
    steps, width = len(rows), len(recurrent)
    out = np.empty((steps, width), dtype=np.float32)
    gates = np.empty(4 * width, dtype=np.float32)
    last, cell = state[0], state[1]
    for step in range(steps):
        gates[:] = bias
        _add_product(rows[step], inward, gates)
        _add_product(last, recurrent, gates)
        for m in range(3 * width):
            gates[m] = np.float32(1.0) / (np.float32(1.0) + math.exp(-gates[m]))
        for m in range(width):
            cell[m] = gates[width + m] * cell[m] + gates[m] * math.tanh(gates[3 * width + m])
            last[m] = gates[2 * width + m] * math.tanh(cell[m])
        out[step] = last
    return out


@compiled
def _add_product(vector: Array32, matrix: Array32, out: Array32) -> None:
    """Add vector @ matrix to ``out``, four rows of the matrix at a time."""
    count = len(vector)
    whole = count - count % 4
    for k in range(0, whole, 4):
        a, b, c, d = vector[k], vector[k + 1], vector[k + 2], vector[k + 3]
        one, two, three, four = matrix[k], matrix[k + 1], matrix[k + 2], matrix[k + 3]
        for m in range(len(out)):
            out[m] += a * one[m] + b * two[m] + c * three[m] + d * four[m]
    for k in range(whole, count):
        a, one = vector[k], matrix[k]
        for m in range(len(out)):
            out[m] += a * one[m]


@compiled
def _decide(states: Array32, head: Array32, last: float) -> Array32:
    """Probabilities from states."""
    out = np.empty(len(states), dtype=np.float32)
    for step in range(len(states)):
        logit = last
        for m in range(len(head)):
            logit += states[step, m] * head[m]
        out[step] = 1.0 / (1.0 + math.exp(-logit))
    return out
