"""Published verdicts and labels, judged again on the machine at hand."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, option

if TYPE_CHECKING:
    from steadyload.studies.determinism.comparing import Found


class Determinism(Study["Found"]):
    """Verdicts and labels that differ when another machine judges the same cases."""

    answers = "Which published verdicts and labels differ on another processor?"
    about = "published verdicts and labels of a random sample, judged again on this machine"
    verdicts = True

    limit: int | None = option(
        None, "only N cases, and labels of no more than these (default: 300, and 60 labels)",
        least=1, metavar="N",
    )  # fmt: skip

    def run(self, lab: Lab) -> Found:
        """The same cases, judged here and compared with the rows."""
        from steadyload.studies.determinism.comparing import judge_again

        return judge_again(lab, self.limit)

    def remarks(self, found: Found) -> Iterable[str]:
        """Methods that were left out, and why."""
        return [f"{spec} is left out: {why}" for spec, why in found.left_out.items()]
