"""Published verdicts and labels, judged again on the machine at hand."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, methods_option, option

if TYPE_CHECKING:
    from steadyload.studies.determinism.comparing import Found


class Determinism(Study["Found"]):
    """Verdicts and labels that differ when another machine judges the same cases."""

    question = "Which published verdicts and labels differ on another processor?"
    about = "published verdicts and labels of a random sample, judged again on this machine"

    rows: str = option(
        "",
        "run folder on a labelled set whose verdicts are judged again (default: the kept rows of "
        "the page evaluation)",
        metavar="DIR",
    )
    cases: int = option(300, "drawn at random, judged by every method (default: 300)", least=1)
    labels: int = option(60, "of them whose labels are made again (default: 60)", least=0)
    seed: int = option(0, "of the draw (default: 0)", least=0)
    methods: tuple[str, ...] = methods_option(
        "judge again only this method of the rows; may be repeated (default: those of the "
        "published page)"
    )

    def run(self, lab: Lab) -> Found:
        """The same cases, judged here and compared with the rows."""
        from steadyload.studies.determinism.comparing import judge_again

        return judge_again(lab, **vars(self))

    def remarks(self, found: Found) -> Iterable[str]:
        """Methods that were left out, and why."""
        return [f"{spec} is left out: {why}" for spec, why in found.left_out.items()]
