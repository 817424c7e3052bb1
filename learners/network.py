"""The networks that are trained, in torch.

:mod:`steadyload.learners.inference` runs the same ones without it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from steadyload.learners.inference import HEADS
from steadyload.learners.options import NetworkKind


class LstmNetwork(nn.Module):
    """Steps in, a logit a step out: above 0 means more likely unstable than not.

    Args:
        columns: features of a step.
        hidden: size of the states.
        layers: LSTM layers on top of each other.
        dropout: between layers, 0 to 1.
    """

    mean: Tensor
    scale: Tensor

    def __init__(self, columns: int, hidden: int, layers: int, dropout: float = 0.0) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(columns))
        self.register_buffer("scale", torch.ones(columns))
        between = dropout if layers > 1 else 0.0
        self.lstm = nn.LSTM(columns, hidden, layers, batch_first=True, dropout=between)
        self.head = nn.Linear(hidden, 1)

    def normalise_as(self, rows: Any) -> None:
        """Normalise by mean and deviation of features, (N, F)."""
        deviation = np.asarray(rows, dtype=np.float64).std(axis=0)
        deviation[deviation < 1e-6] = 1.0
        self.mean.copy_(torch.from_numpy(np.mean(rows, axis=0, dtype=np.float64)))
        self.scale.copy_(torch.from_numpy(1.0 / deviation))

    def forward(self, rows: Tensor) -> Tensor:
        """Logits (B, T) of features (B, T, F), which are not normalised."""
        normal = (rows - self.mean) * self.scale
        states, _ = self.lstm(normal)
        return self.decide(normal, states).squeeze(-1)

    def decide(self, normal: Tensor, states: Tensor) -> Tensor:
        """Logits (B, T, 1) of normalised features and states (B, T, H)."""
        return self.head(states)


class AttentionNetwork(LstmNetwork):
    """An LSTM whose states look back at earlier items; see :class:`NetworkKind`."""

    def __init__(self, columns: int, hidden: int, layers: int, dropout: float = 0.0) -> None:
        super().__init__(columns, hidden, layers, dropout)
        self.query, self.mixed = nn.Linear(hidden, hidden), nn.Linear(2 * hidden, hidden)
        self.key, self.value = nn.Linear(columns, hidden), nn.Linear(columns, hidden)

    def decide(self, normal: Tensor, states: Tensor) -> Tensor:
        """See :meth:`LstmNetwork.decide`."""
        many, steps, width = states.shape
        query, key, value = (
            part.reshape(many, steps, HEADS, width // HEADS).transpose(1, 2)
            for part in (self.query(states), self.key(normal), self.value(normal))
        )
        scores = query @ key.transpose(2, 3) / math.sqrt(width // HEADS)
        later = torch.ones(steps, steps, dtype=torch.bool, device=scores.device).triu(1)
        weights = scores.masked_fill(later, -math.inf).softmax(-1)
        seen = (weights @ value).transpose(1, 2).reshape(many, steps, width)
        return self.head(torch.relu(self.mixed(torch.cat((states, seen), dim=2))))


NETWORKS: dict[NetworkKind, type[LstmNetwork]] = {
    NetworkKind.LSTM: LstmNetwork,
    NetworkKind.ATTENTION: AttentionNetwork,
}
