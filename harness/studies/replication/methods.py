"""Methods that the paper compares, the readings of its simulations, and ours: specs by title."""

from __future__ import annotations

from itertools import accumulate
from typing import NamedTuple

MEMORISER, LSTM_1, LSTM_E, SUPPORT = "memoriser", "LSTM_1", "LSTM_e", "support"
"""Names of what is trained on splits; ``support`` is LSTM_1 with our features, by list alone."""


class Extent(NamedTuple):
    """How much is trained.

    Attributes:
        epochs: most epochs of a training.
        seeds: trainings of LSTM_1 a fold.
        ensemble: whether LSTM_e is trained.
        hours: of CPU time of all trainings; all have an equal share.
    """

    epochs: int
    seeds: int
    ensemble: bool
    hours: float = 6.0


FULL, QUICK = Extent(700, 3, ensemble=True), Extent(10, 1, ensemble=False)
"""Extents of the page, and of a page of few files."""

STATIC = {
    "FBS": "fbs", "PBS 0.9": "pbs0.9", "PBS 0.7": "pbs0.7", "PBS 0.5": "pbs0.5", "SME": "sme",
}  # fmt: skip
"""Static rules: they learn nothing, so that a split changes nothing for them."""

READINGS = {
    "PS_3, literal": "ps3-literal@bullet",
    "PS_3, converted": "ps3@bullet",
    "PS_5, literal": "ps5-literal@bullet",
    "PS_5, converted": "ps5@bullet",
}
"""Both readings of the baselines: the authors' numbers as SI, and one centimetre as one metre."""

_ADDED = {
    "PS_opt as printed": "ps_opt-paper@bullet",
    "reseat": ":between_steps=reseat",
    "one look a placement": ",samples=1",
    "friction 0.25": ",friction=0.25",
    "restitution 0.0121": ",restitution=0.0121",
    "10 iterations: their program": ",solver_iterations=10",
}

AS_RUN = dict(zip(_ADDED, accumulate(_ADDED.values()), strict=True))
"""From PS_opt as printed to what the authors' program does."""

PS_OPT = AS_RUN | {
    "all parameters of the label": "label@bullet",
    "MuJoCo instead of Bullet": "label@mujoco",
    "tuned parameters: ps_opt@mujoco": "ps_opt@mujoco",
}
"""From PS_opt as printed to ours: each changes one thing more than the one before."""

OURS = {"our lstm_1": "lstm_1", "our lstm_e": "lstm_e", "cascade@mujoco": "cascade@mujoco"}
"""Methods that come with the package; their networks learnt from other item lists."""

METHODS = STATIC | READINGS | PS_OPT | OURS
"""Every method that is judged."""

PAPER = (
    {title: title for title in STATIC}
    | {title: title.partition(",")[0] for title in READINGS}
    | dict.fromkeys(AS_RUN, "PS_opt")
)
"""The title in the paper of those that it has."""
