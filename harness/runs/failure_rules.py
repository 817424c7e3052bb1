"""Rules by which a loading fails, and how a method is told one."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from steadyload.layouts.model.question import Question
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.criteria import Criterion

REFERENCE = "label@reference"
"""The preset that makes labels; every rule is a change of its parameters."""


@dataclass(frozen=True, slots=True)
class Rule:
    """When an item has moved too far, after how long.

    Attributes:
        name: what differs from the usual rule; of the usual rule what it is.
        seconds: simulated time a placement [s]; None: until all rests, the question ``stands``.
        eps_t: displacement that counts as unstable [cm].
        eps_r: angle that counts as unstable [degrees].
        criterion: what is measured, and at which of the samples.
    """

    name: str
    seconds: float | None = 0.3
    eps_t: float = 10.0
    eps_r: float = 10.0
    criterion: Criterion = Criterion.ADAMS

    def given_to(self, spec: str) -> str:
        """A method as it is when it is told this rule: with its time, thresholds and criterion.

        Only parameters that the method has are stated, so that one without any stays as it is. A
        method of which the question is all that can be told, such as a learner, hears of
        ``stands`` alone.

        Args:
            spec: of the method.

        Returns:
            The canonical spec.

        Raises:
            SpecError: see :func:`steadyload.methods.registry.make_method`.
        """
        method = make_method(spec)
        parameters = getattr(method, "parameters", None)
        known = {field.name for field in dataclasses.fields(parameters)} if parameters else set()
        values = {key: value for key, value in self._parameters.items() if key in known}
        if not values:
            return str(method.spec)
        together = {**dict(method.spec.values), **values}
        if self.seconds is None:
            for key in ("t_max", "time", "early_exit"):
                together.pop(key, None)
        stated = dataclasses.replace(method.spec, values=tuple(together.items()))
        return str(make_method(str(stated)).spec)

    @property
    def short(self) -> str:
        """Its name where there is little room."""
        return "label" if self == USUAL else self.name

    @property
    def label(self) -> str:
        """Spec of the reference under this rule."""
        return self.given_to(REFERENCE)

    @property
    def _parameters(self) -> Mapping[str, Any]:
        """The rule as parameters of any method, by every name that these have."""
        found: dict[str, Any] = {
            "eps_t": f"{self.eps_t:g}",
            "eps_r": f"{self.eps_r:g}",
            "criterion": str(self.criterion),
        }
        if self.seconds is None:
            return {**found, "question": str(Question.STANDS)}
        found |= {"t_max": f"{self.seconds:g}", "time": f"{self.seconds:g}"}
        # A sample beyond a threshold ends a placement by itself where every sample counts.
        return {**found, "early_exit": "0"} if self.criterion is Criterion.PAPER else found


USUAL = Rule("label: 0.3 s, 10 cm, 10 degrees, corner")
RULES = (
    Rule("0.15 s", seconds=0.15),
    USUAL,
    Rule("0.6 s", seconds=0.6),
    Rule("1 s", seconds=1.0),
    Rule("3 s", seconds=3.0),
    Rule("stands", seconds=None),
    Rule("5 cm", eps_t=5.0),
    Rule("22 cm", eps_t=22.0),
    Rule("5 degrees", eps_r=5.0),
    Rule("15 degrees", eps_r=15.0),
    Rule("centre, any time", criterion=Criterion.PAPER),
)
"""The usual rule and changes of one part of it at a time; times first, in their order."""

TIMES = tuple(rule for rule in RULES if rule is USUAL or rule.seconds != USUAL.seconds)
LIMITS = tuple(rule for rule in RULES if rule is USUAL or rule not in TIMES)
"""Rules that differ in time, and those that differ in thresholds or in what is measured."""
