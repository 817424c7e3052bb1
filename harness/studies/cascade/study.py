"""A cascade compared with its stages and simulations, on cases on which nothing was fitted."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, option

if TYPE_CHECKING:
    from steadyload.studies.cascade.comparing import Found


class Cascade(Study["Found"]):
    """A cascade, its stages and simulations."""

    answers = "What does a cascade save, and what accuracy does it cost?"
    about = "compare a cascade with its stages and with simulations on test, and write its page"
    workers = None
    verdicts = True

    limit: int | None = option(None, "only the first N cases a scenario (default: 300)", least=2)

    def run(self, lab: Lab) -> Found:
        """Verdicts, judged in one process, because times are shown."""
        from steadyload.studies.cascade.comparing import compare

        return compare(lab, self.limit)
