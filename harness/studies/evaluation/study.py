"""All methods on the labelled test split: accuracy, cost, and where they err."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from steadyload.config import ConfigError, positive_number
from steadyload.studies.kit import Lab, PublishedPage, Study, methods_option, option, set_option

if TYPE_CHECKING:
    from steadyload.studies.evaluation.comparing import Found

_PUBLISHED = "--directory lists --limit 300"
"""300 cases a scenario, as many as the paper has, of many item lists; a third of them are timed."""


class Evaluation(Study["Found"]):
    """Which methods, and on which cases."""

    answers = "How accurate is every method on every engine, and what does it cost?"
    about = "all methods on a labelled test split, as Table 5 of the paper, every engine"
    workers = 0
    verdicts = True
    pages = (
        PublishedPage("evaluation", _PUBLISHED),
        PublishedPage(
            "evaluation_stands", f"{_PUBLISHED} --question stands",
            answers="How accurate is every method where a load has to stand until it rests?",
        ),
        PublishedPage(
            "evaluation_real",
            "--directory real --question both --timeout 20 --workers 1 --work runs/evaluation_real",
            answers="Which method judges a pallet of real size, how right is it, and at what "
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
    limit: int | None = option(None, "only the first N cases a scenario (default: all)", least=2)
    timeout: float | None = option(
        None, "CPU seconds a judgement may take, as for large layouts; then times are of judging, "
        "and there is no timing pass (default: no limit)", metavar="S", read=positive_number,
    )  # fmt: skip

    published: bool = option(
        False, "the methods of -m beside those of the published page of the question, whose kept "
        "verdicts and times are read; its cases and time limit count",
    )  # fmt: skip

    def __post_init__(self) -> None:
        if self.published and not self.methods:
            raise ConfigError("--published shows methods beside the published ones; name them: -m")
        if self.published and (self.directory or self.timeout is not None):
            raise ConfigError(
                "--published takes the cases and the time limit of the published page; leave "
                "--directory and --timeout out"
            )

    def run(self, lab: Lab) -> Found:
        """Judged over processes, timed in one; also writes the front that ``recommend`` reads."""
        from steadyload.layouts.model.question import Question
        from steadyload.studies.evaluation.comparing import compare
        from steadyload.studies.evaluation.judging import Options, beside_published

        questions = tuple(q for q in Question if self.asked in (q, "both"))
        asked = Options(self.methods, self.directory, questions, self.limit, self.timeout)
        return compare(lab, beside_published(lab, asked) if self.published else asked)

    def remarks(self, found: Found) -> Iterable[str]:
        """Methods that were left out, and why; where kept times stand beside those of here."""
        if self.published:
            yield "verdicts and times of published methods are kept ones, times of other machines"
        yield from (f"{spec} is left out: {why}" for spec, why in found.left_out.items())
