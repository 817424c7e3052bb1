"""A cascade compared with its stages and simulations, on cases on which nothing was fitted."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, PublishedPage, Study, methods_option, option, set_option
from steadyload.tuning.cascade.defaults import ENGINE

if TYPE_CHECKING:
    from steadyload.studies.cascade.comparing import Found


class Cascade(Study["Found"]):
    """Which cascade is compared with which methods, on which cases."""

    question = "What does a cascade save, and what accuracy does it cost?"
    about = "compare a cascade with its stages and with simulations on test, and write its page"
    workers = None
    pages = (PublishedPage("cascade", "--directory lists"),)

    engine: str = option(ENGINE, f"default: {ENGINE}", metavar="NAME")
    methods: tuple[str, ...] = methods_option("a further method on the page; may be repeated")
    thresholds: Path | None = option(
        None, "file of thresholds (default: the one of the package)", metavar="FILE"
    )
    directory: str = set_option()
    judge_on: str = option(
        "test", "part of the labelled set, such as validation (default: test)", metavar="PART"
    )
    limit: int = option(300, "cases a scenario (default: 300)", least=2)

    def run(self, lab: Lab) -> Found:
        """Verdicts, judged in one process, because times are shown."""
        from steadyload.studies.cascade.comparing import compare

        return compare(
            lab, self.engine, methods=self.methods, directory=self.directory, part=self.judge_on,
            limit=self.limit, thresholds=self.thresholds,
        )  # fmt: skip
