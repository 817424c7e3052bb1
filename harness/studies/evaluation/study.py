"""All methods on the labelled test split: accuracy, cost, and where they err."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.config import positive_number
from steadyload.studies.kit import Lab, PublishedPage, Study, methods_option, option, set_option

if TYPE_CHECKING:
    from steadyload.studies.evaluation.comparing import Found

_PUBLISHED = "--directory lists --limit 300 --timed 100 --repeats 1"
"""300 cases a scenario, as many as the paper has, of many item lists; a third of them are timed."""


class Evaluation(Study["Found"]):
    """Which methods, on which cases, and how their cost is measured."""

    question = "How accurate is every method on every engine, and what does it cost?"
    about = "all methods on a labelled test split, as Table 5 of the paper, every engine"
    workers = 0
    pages = (
        PublishedPage("evaluation", _PUBLISHED),
        PublishedPage(
            "evaluation_stands", f"{_PUBLISHED} --question stands",
            question="How accurate is every method where a load has to stand until it rests?",
        ),
        PublishedPage(
            "evaluation_real",
            "--directory real --question both --timeout 20 --small 60 --pallets 60 --workers 1 "
            "--work runs/evaluation_real",
            question="Which method judges a pallet of real size, how right is it, and at what "
            "cost?",
        ),
    )  # fmt: skip

    methods: tuple[str, ...] = methods_option(
        "may be repeated (default: the paper's methods on every engine, and our own; with "
        "--timeout fewer)"
    )
    directory: str = set_option()
    asked: str = option(
        "within",
        "whose labels and methods the page shows: within, stands or both (default: within); "
        "methods of both are judged",
        metavar="QUESTION", names=("--question",), choices=("within", "stands", "both"),
    )  # fmt: skip
    limit: int | None = option(None, "only the first N cases a scenario", least=2)
    timed: int = option(
        100,
        "cases a scenario that are timed, in one process, at most 20 of the planar set "
        "(default: 100)",
        least=1,
    )
    repeats: int = option(3, "how often they are timed (default: 3)", least=1)
    views: int = option(
        0,
        "write pages that play N of the cases that divide the methods, and link them (default: 0)",
        least=0,
    )
    timeout: float | None = option(
        None, "CPU seconds a judgement may take, as for large layouts; then times are of judging, "
        "and there is no timing pass (default: no limit)", metavar="S", read=positive_number,
    )  # fmt: skip
    small: int = option(
        0, "with --timeout, cases a scenario of the small layouts of the package, too (default: 0)",
        least=0,
    )  # fmt: skip
    sizes: tuple[int, ...] = option(
        (), "largest numbers of boxes of bins (default: 3 to 20; with --timeout 20 to 150)",
        fewest=1, least=1,
    )  # fmt: skip
    pallets: int = option(
        0, "with --timeout, customers' pallets judged on several floors, too (default: 0)", least=0
    )

    def run(self, lab: Lab) -> Found:
        """Judged over processes, timed in one; also writes the front that ``recommend`` reads."""
        from steadyload.app.viewing import require_library
        from steadyload.layouts.model.question import Question
        from steadyload.studies.evaluation.comparing import compare
        from steadyload.studies.evaluation.judging import Options

        if self.views:
            require_library()  # before hours of work
        options = Options(
            self.methods, self.directory,
            tuple(q for q in Question if self.asked in (q, "both")), self.limit, self.timed,
            self.repeats, self.timeout, self.small, self.pallets,
        )  # fmt: skip
        return compare(lab, options, sizes=self.sizes, views=self.views)

    def beside(self, found: Found, folder: Path) -> None:
        """Pages that play cases."""
        from steadyload.studies.evaluation.watched import write_views

        write_views(found.own.watched, folder)

    def remarks(self, found: Found) -> Iterable[str]:
        """Methods that were left out, and why."""
        return [f"{spec} is left out: {why}" for spec, why in found.left_out.items()]
