"""The flag ``--fail-on``: answers that end a check with a status other than 0."""

from __future__ import annotations

from dataclasses import dataclass

from steadyload.app.check_defaults import GAPS_CM
from steadyload.config import number_from_zero


@dataclass(frozen=True, slots=True)
class FailOn:
    """Answers that count; bad input always does.

    Attributes:
        fails: a load that fails, is crushed, or does not hold the rule of the road.
        hovers: a gap above the limit.
        not_judged: no verdict.
        gaps_cm: the limit on gaps [cm].
        margin_cm: the least margin of a load that stands [cm]; None for any.
    """

    fails: bool = False
    hovers: bool = False
    not_judged: bool = False
    gaps_cm: float = GAPS_CM
    margin_cm: float | None = None


ANY = FailOn(fails=True, hovers=True, not_judged=True)

WORDS = "any, fails, gaps=CM, margin=CM, several of them with commas, or nothing alone"


_LIMITS = {"gaps": "gaps_cm", "margin": "margin_cm"}
"""Words that may state a limit [cm]."""


def fail_on(text: str) -> FailOn:
    """The answers that a text names, such as ``any``, ``fails,gaps=0.5`` or ``nothing``.

    Raises:
        ValueError: a word that there is not, or that does not go with the others.
    """
    words = [word.strip().partition("=") for word in text.split(",")]
    names = [name for name, _, _ in words]
    for name, equals, _ in words:
        known = name in ("any", "fails", "gaps", "nothing") or (name == "margin" and equals)
        if not known or (equals and name not in _LIMITS):
            raise ValueError(f"{text!r}; allowed: {WORDS}")
        if names.count(name) > 1:
            raise ValueError(f"{text!r} has {name} twice; allowed: each word once")
    if "nothing" in names:
        if len(names) > 1:
            raise ValueError(f"{text!r} has nothing beside other words; allowed: nothing alone")
        return FailOn()
    limits: dict[str, float] = {}
    for name, equals, value in words:
        if equals:
            try:
                limits[_LIMITS[name]] = number_from_zero(value)
            except ValueError:
                raise ValueError(
                    f"{text!r}: {name} is {value!r}; allowed: centimetres, 0 or more"
                ) from None
    everything = "any" in names
    return FailOn(
        "fails" in names or everything, "gaps" in names or everything, everything, **limits
    )
