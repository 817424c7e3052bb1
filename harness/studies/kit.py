"""Parts of a study: a class that is its own configuration, and what it judges and measures.

A study is ``study.py`` with one class below :class:`Study`, and ``page.md.j2`` beside it. Its rows
are classes of :mod:`steadyload.reports.columns`, in modules that are imported when it is run. This
module imports neither what judges nor what draws, so that help on a command is quick.
"""

from __future__ import annotations

import inspect
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Generic, Protocol, TypeVar, dataclass_transform

from steadyload.config import methods_option, operand, option, set_option
from steadyload.progress import NamedProgress, silent
from steadyload.runs.asked import Asked, Measured, asked, kept_rows, rows_so_far

if TYPE_CHECKING:
    from steadyload.layouts.model.question import Question
    from steadyload.reports.pages.page import Page
    from steadyload.runs.costs import CostKind
    from steadyload.runs.evaluation import Evaluation
    from steadyload.runs.labels import Cases

__all__ = [
    "Asked", "Found", "Lab", "Measured", "PublishedPage", "Study", "asked", "methods_option",
    "operand", "option", "set_option",
]  # fmt: skip

R = TypeVar("R")


@dataclass(frozen=True, slots=True)
class PublishedPage:
    """A page below ``reports/published``, with the command that remakes it.

    Attributes:
        folder: of the page.
        flags: flags after the command of the study; file patterns are expanded.
        answers: the sentence that the page answers, where that is not the one of the study.
    """

    folder: str
    flags: str = ""
    answers: str = ""


@dataclass(frozen=True)
class Lab:
    """Where a study runs.

    Attributes:
        work: folder of what is judged and measured; an interrupted run goes on there.
        workers: processes that judge.
        progress: called with the current work, the amount that is done, and that of all.
    """

    work: Path
    workers: int = 1
    progress: NamedProgress = silent

    def measure(
        self,
        units: Sequence[Asked[R]],
        row: type[R],
        *,
        folder: str = "measured",
        parallel: bool = False,
    ) -> Measured[R]:
        """Measure what is not kept yet, and read the rest: see :func:`kept_rows`.

        Args:
            units: one or more.
            row: class of the rows.
            folder: of the kept rows, in the work folder.
            parallel: measure in as many processes as :attr:`workers`; times that compete for a
                processor are no times, so that by default one after the other is measured here.
        """
        return kept_rows(
            self.work / folder,
            units,
            row,
            workers=self.workers if parallel else 0,
            progress=lambda *done: self.progress("measuring", *done),
        )

    def so_far(self, units: Sequence[Asked[R]], row: type[R], *, folder: str) -> list[R | None]:
        """The rows that :meth:`measure` has kept in a folder, None for each that is missing."""
        return rows_so_far(self.work / folder, units, row)

    def judge(
        self,
        methods: Sequence[str],
        cases: Cases,
        *,
        question: Question | None = None,
        timeout: float | None = None,
        folder: str = "judged",
        name: str = "",
        shard_size: int = 12,
        costs: CostKind | None = None,
    ) -> Evaluation:
        """Judge labelled cases by methods, as far as that is missing, and evaluate the verdicts.

        Args:
            methods: specs.
            cases: to judge; all methods judge the same ones.
            question: whose labels are compared with verdicts, on the cases that have one; None
                for ``within``.
            timeout: CPU seconds that a judgement may take; None for no limit.
            folder: of the run, in the work folder; empty for that itself.
            name: of the run, whose folder no other one may use; empty for that of the folder.
            shard_size: cases a unit of work. It is part of the keys of kept rows.
            costs: source of times, see :class:`steadyload.runs.costs.CostSource`; None says no more
                than that they are of judging.
        """
        from steadyload.runs.costs import CostSource
        from steadyload.runs.definition import StudyDefinition
        from steadyload.runs.evaluation import evaluate
        from steadyload.runs.judged import load_judged
        from steadyload.runs.runner import run_study

        definition = StudyDefinition(
            name or folder,
            tuple(methods),
            scenarios=cases.scenarios,
            limit=cases.limit,
            shard_size=shard_size,
            timeout=timeout,
            benchmark=cases.part,
        )
        run_study(
            definition,
            self.work / folder,
            benchmark=cases.benchmark,
            workers=self.workers,
            progress=lambda *done: self.progress(f"judging {folder}".rstrip(), *done),
        )
        judged = load_judged(self.work / folder)
        return evaluate(
            judged if question is None else judged.asked(question),
            source=None if costs is None else CostSource(costs),
        )


class Found(Protocol):
    """The results of a study: a record that the template of its page reads."""

    @property
    def made_with(self) -> Mapping[str, str]:
        """Provenance, at the foot of the page."""
        ...


F = TypeVar("F", bound=Found)


@dataclass_transform(
    frozen_default=True,
    kw_only_default=True,
    field_specifiers=(option, operand, methods_option, set_option),
)
class Study(ABC, Generic[F]):
    """Its fields are the options of its command, and ``page.md.j2`` is its page.

    Attributes:
        answers: the sentence, a question mark at its end, that its page answers.
        about: summary of the command for the list of commands.
        name: the name under which it is registered; by default that of its package.
        resumable: whether it keeps finished results in its work folder and continues from there.
        workers: default number of processes that judge; 0 for one a core, None where a study works
            in this process alone.
        command_words: the command that runs it, without flags, made of its name.
        work: default work folder, of its name below ``runs``.
        verdicts: whether the rows behind its pages are verdicts, which are kept as one table, see
            :mod:`steadyload.runs.tidy`.
        pages: its published pages; unless stated one of its name, made by the command without
            flags.
    """

    answers: ClassVar[str]
    about: ClassVar[str]
    name: ClassVar[str] = ""
    command_words: ClassVar[str]
    resumable: ClassVar[bool] = True
    workers: ClassVar[int | None] = 1
    work: ClassVar[Path]
    verdicts: ClassVar[bool] = False
    pages: ClassVar[tuple[PublishedPage, ...]]

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True, kw_only=True)(cls)
        cls.name = cls.name or cls.__module__.removesuffix(".study").rpartition(".")[2]
        cls.command_words = f"study {cls.name.replace('_', '-')}"
        cls.work = Path("runs") / cls.name
        cls.pages = cls.pages if "pages" in vars(cls) else (PublishedPage(cls.name),)

    @abstractmethod
    def run(self, lab: Lab) -> F:
        """The results; an interrupted run goes on in the lab's folder."""

    def beside(self, found: F, folder: Path) -> None:
        """Write files into the folder of the page, to which it links; by default none."""

    def printed(self, found: F, page: Path) -> str:
        """The text that the command prints; by default the path of its page."""
        return str(page)

    def remarks(self, found: F) -> Iterable[str]:
        """Sentences that the command says after that; by default none."""
        return ()

    def status(self, found: F) -> int:
        """Exit status of the command."""
        return 0

    def page(self, found: F) -> Page:
        """The page of results, made of the template beside its module.

        The template reads ``found``, and ``study`` for its options.
        """
        from steadyload.reports.pages.composing import composed

        template = Path(inspect.getfile(type(self))).with_name("page.md.j2")
        return composed(template, {"study": self, "found": found}, found.made_with)
