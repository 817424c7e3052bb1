"""Methods that the paper compares, the readings of its simulations, and ours."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Line:
    """A method of the page.

    Attributes:
        spec: of the method.
        title: as the page names it.
        paper: title of the paper's own figures; empty where it has none.
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
"""Static rules: they learn nothing, and a split is nothing to them."""

LITERAL, CONVERTED = "literal", "converted"

READINGS = (
    Line("ps3-literal@bullet", "PS_3, literal", "PS_3"),
    Line("ps3@bullet", "PS_3, converted", "PS_3"),
    Line("ps5-literal@bullet", "PS_5, literal", "PS_5"),
    Line("ps5@bullet", "PS_5, converted", "PS_5"),
)
"""Both readings of the baselines: the authors' numbers as SI, and one centimetre as one metre."""

PRINTED = "ps_opt-paper@bullet"

PS_OPT = (
    Line(PRINTED, "PS_opt as printed", "PS_opt"),
    Line(f"{PRINTED}:between_steps=reseat", "reseat", "PS_opt"),
    Line(f"{PRINTED}:between_steps=reseat,samples=1", "one look a placement", "PS_opt"),
    Line(f"{PRINTED}:between_steps=reseat,samples=1,friction=0.25", "friction 0.25", "PS_opt"),
    Line(
        f"{PRINTED}:between_steps=reseat,samples=1,friction=0.25,restitution=0.0121",
        "restitution 0.0121",
        "PS_opt",
    ),
    Line(
        f"{PRINTED}:between_steps=reseat,samples=1,friction=0.25,restitution=0.0121,"
        "solver_iterations=10",
        "10 iterations: their program",
        "PS_opt",
    ),
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
