"""How sure verdicts are on loads that deviate from their plans."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from steadyload.studies.kit import Lab, Study, methods_option, option

if TYPE_CHECKING:
    from steadyload.studies.uncertain.comparing import Found


class Uncertain(Study["Found"]):
    """Deviations, methods and numbers of cases; None for the defaults."""

    question = "How reliable is a verdict when a load deviates from its plan?"
    about = "reliability of verdicts on labelled cases: accuracy, probability, cost"

    uncertain: str | None = option(
        None, "what deviates (default: com=5mm,position=3mm)", metavar="WHAT"
    )
    methods: tuple[str, ...] = methods_option(
        "may be repeated (default: a rule, the equilibrium with time, a network, an engine)"
    )
    cases: int | None = option(
        None, "a scenario, for methods without an engine (default: 100)", least=1
    )
    engine_cases: int | None = option(
        None, "a scenario, for methods with one (default: 20)", least=1
    )
    checked: int | None = option(
        None, "layouts that are compared with many random samples (default: 50)", least=0
    )

    def run(self, lab: Lab) -> Found:
        """Reliability of verdicts on sampled cases, compared with the labels."""
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.uncertain.comparing import summarise
        from steadyload.studies.uncertain.sampling import UncertainOptions, run_uncertain

        made_with = provenance_lines()  # of the code at the time of sampling
        given: dict[str, Any] = {
            "uncertainty": self.uncertain,
            "methods": tuple(dict.fromkeys(self.methods)) or None,
            "cases": self.cases,
            "engine_cases": self.engine_cases,
            "checked": self.checked,
        }
        asked = UncertainOptions(**{k: value for k, value in given.items() if value is not None})
        sampled = run_uncertain(
            asked, lab.work, workers=lab.workers,
            progress=lambda *of: lab.progress("sampling", *of),
        )  # fmt: skip
        return summarise(asked, sampled, made_with)
