"""Methods that the paper compares, the readings of its simulations, and ours."""

from __future__ import annotations

from itertools import accumulate
from typing import NamedTuple

MEMORISER, LSTM_1, LSTM_E, SUPPORT = "memoriser", "LSTM_1", "LSTM_e", "support"
"""Names of what is trained on splits; ``support`` is LSTM_1 with our features, by list alone."""


class Line(NamedTuple):
    """A method of the page: its spec, its title there, and the title of the paper's own figures;
    that is empty where the paper has none.
    """

    spec: str
    title: str
    paper: str = ""


STATIC = (
    Line("fbs", "FBS", "FBS"),
    Line("pbs0.9", "PBS 0.9", "PBS 0.9"),
    Line("pbs0.7", "PBS 0.7", "PBS 0.7"),
    Line("pbs0.5", "PBS 0.5", "PBS 0.5"),
    Line("sme", "SME", "SME"),
)
"""Static rules: they learn nothing, so that a split changes nothing for them."""

READINGS = (
    Line("ps3-literal@bullet", "PS_3, literal", "PS_3"),
    Line("ps3@bullet", "PS_3, converted", "PS_3"),
    Line("ps5-literal@bullet", "PS_5, literal", "PS_5"),
    Line("ps5@bullet", "PS_5, converted", "PS_5"),
)
"""Both readings of the baselines: the authors' numbers as SI, and one centimetre as one metre."""

PRINTED = "ps_opt-paper@bullet"

_CHANGES = {
    "reseat": f"{PRINTED}:between_steps=reseat",
    "one look a placement": ",samples=1",
    "friction 0.25": ",friction=0.25",
    "restitution 0.0121": ",restitution=0.0121",
    "10 iterations: their program": ",solver_iterations=10",
}
"""What a line changes besides what the lines before it do."""

AS_RUN = (
    Line(PRINTED, "PS_opt as printed", "PS_opt"),
    *(
        Line(spec, title, "PS_opt")
        for title, spec in zip(_CHANGES, accumulate(_CHANGES.values()), strict=True)
    ),
)
"""From PS_opt as printed to what the authors' program does."""

PS_OPT = (
    *AS_RUN,
    Line("label@bullet", "all parameters of the label"),
    Line("label@mujoco", "MuJoCo instead of Bullet"),
    Line("ps_opt@mujoco", "tuned parameters: ps_opt@mujoco"),
)
"""From PS_opt as printed to ours: a line changes one thing more than the one before."""

OURS = (
    Line("lstm_1", "our lstm_1"),
    Line("lstm_e", "our lstm_e"),
    Line("cascade@mujoco", "cascade@mujoco"),
)
"""Methods that come with the package; their networks learnt from other item lists."""

ALL_LINES = (*STATIC, *READINGS, *PS_OPT, *OURS)
"""Every method that is judged, once."""
