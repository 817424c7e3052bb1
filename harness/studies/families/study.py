"""Methods on families of layouts outside the distribution of the labelled sets."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, methods_option, option

if TYPE_CHECKING:
    from steadyload.studies.families.comparing import Found


class Families(Study["Found"]):
    """Layouts of every family, and the methods that judge them."""

    answers = "How accurate are methods on layouts unlike those they were fitted on?"
    about = "judge families of generated layouts outside the distribution of the labelled sets"
    verdicts = True

    limit: int | None = option(None, "layouts of every family (default: 120)", least=1)
    methods: tuple[str, ...] = methods_option(
        "may be repeated (default: rules, networks, cascades and tuned simulations)"
    )

    def run(self, lab: Lab) -> Found:
        """Verdicts on layouts of all families, compared with those of the reference."""
        from steadyload.studies.families.comparing import compare
        from steadyload.studies.families.judging import judge_families

        return compare(judge_families(lab, **vars(self)))
