"""Parts of a study: a class that is its own configuration, and what it judges and measures.

A study is ``study.py`` with one class below :class:`Study`, and ``page.md.j2`` beside it. Its rows
are classes of :mod:`steadyload.reports.columns`, in modules that are imported when it is run. This
module imports neither what judges nor what draws, so that help on a command is quick.
"""

from __future__ import annotations

import dataclasses
import inspect
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import (
    TYPE_CHECKING,
    Any,
    ClassVar,
    Generic,
    NamedTuple,
    Protocol,
    Self,
    TypeVar,
    dataclass_transform,
)

from steadyload.config import bind, methods_option, operand, option, set_option
from steadyload.studies.study import Progress, PublishedPage, silent

if TYPE_CHECKING:
    from steadyload.layouts.model.question import Question
    from steadyload.reports.page import Page
    from steadyload.runs.costs import CostKind
    from steadyload.runs.evaluation import Evaluation
    from steadyload.runs.labels import Cases

__all__ = [
    "Asked", "Found", "Lab", "Measured", "PublishedPage", "Study", "asked", "methods_option",
    "operand", "option", "set_option",
]  # fmt: skip

R = TypeVar("R")

_WORD = "word of the key"
_MADE_WITH = "made_with"


def asked(word: str) -> Any:
    """A field of an :class:`Asked` with a word of its own in the key.

    Args:
        word: in the place of the field's name, as rows that were kept earlier have it.
    """
    return field(metadata={_WORD: word})


@dataclass_transform(frozen_default=True, field_specifiers=(asked,))
class Asked(ABC, Generic[R]):
    """Base of what is measured once and kept. All fields are the key, and what the class states:
    ``class Size(Asked[Point], question="scale", methods=METHODS)``.
    """

    stated: ClassVar[Mapping[str, Any]]

    def __init_subclass__(cls, *, question: str, **constants: Any) -> None:
        dataclass(frozen=True)(cls)
        cls.stated = {"question": question, **constants}

    @property
    def key(self) -> str:
        """The key of its row."""
        from steadyload.runs.provenance import key_of

        fields = dataclasses.fields(self)  # type: ignore[arg-type]
        own = {one.metadata.get(_WORD, one.name): getattr(self, one.name) for one in fields}
        return key_of({**self.stated, **{word: _plain(value) for word, value in own.items()}})

    def describe(self, part: int) -> str:
        """Description for messages."""
        return ", ".join(f"{name} {value}" for name, value in vars(self).items())

    @abstractmethod
    def measure(self) -> R:
        """The row that is found; its fields are kept."""

    def __len__(self) -> int:
        return 1

    def without(self, done: int) -> Self:
        """See :meth:`steadyload.runs.pool.WorkUnit.without`."""
        return self


def _plain(value: Any) -> Any:
    """A value as JSON can hold it; of a layout the hash of its content."""
    if hasattr(value, "content_hash"):
        return value.content_hash()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {one.name: _plain(getattr(value, one.name)) for one in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in value]
    return str(value) if isinstance(value, Path) else value


class Measured(NamedTuple, Generic[R]):
    """Rows in the order in which they were asked for, and the provenance of the last one."""

    rows: list[R]
    made_with: Mapping[str, str]


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
    progress: Progress = silent

    def measure(
        self,
        units: Sequence[Asked[R]],
        row: type[R],
        *,
        folder: str = "measured",
        parallel: bool = False,
    ) -> Measured[R]:
        """Measure what is not kept yet, and read the rest, however fast the code has become.

        Args:
            units: one or more.
            row: class of the rows. Fields of a row that are named as fields of what is asked are
                not stored twice.
            folder: of the kept rows, in the work folder.
            parallel: measure in as many processes as :attr:`workers`; times that compete for a
                processor are no times, so that by default one after the other is measured here.

        Raises:
            ResultsError: see :func:`steadyload.runs.store.kept_records`.
        """
        from steadyload.runs.pool import IN_THIS_PROCESS
        from steadyload.runs.store import kept_records

        found = kept_records(
            self.work / folder,
            units,
            _kept,
            workers=self.workers if parallel else IN_THIS_PROCESS,
            progress=lambda *done: self.progress("measuring", *done),
        )
        names = [one.name for one in dataclasses.fields(row)]  # type: ignore[arg-type]
        rows = []
        for unit, stored in zip(units, found, strict=True):
            known = vars(unit) | stored
            own = {name: known[name] for name in names if name in known}
            rows.append(bind(row, own, f"kept row {unit.key}"))
        return Measured(rows, found[-1].get(_MADE_WITH, {}))

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
            folder: of the run, in the work folder.
            name: of the run, whose folder no other one may use; empty for that of the folder.
            shard_size: cases a unit of work. It is part of the keys of kept rows.
            costs: source of times, see :class:`steadyload.runs.costs.CostSource`; None says no more
                than that they are of judging.

        Raises:
            ResultsError: the folder holds another run or something else.
            BenchmarkError: there is no such case.
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
            progress=lambda *done: self.progress(f"judging {folder}", *done),
        )
        judged = load_judged(self.work / folder)
        return evaluate(
            judged if question is None else judged.asked(question),
            source=None if costs is None else CostSource(costs),
        )


def _kept(unit: Asked[Any]) -> Iterator[dict[str, Any]]:
    from steadyload.runs.provenance import provenance_lines

    made_with = provenance_lines()  # of the code that measures
    found, known = dataclasses.asdict(unit.measure()), vars(unit)
    own = {k: v for k, v in found.items() if k not in known or known[k] != v}
    yield {**own, _MADE_WITH: made_with}


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
    """A question; its fields are the options of its command, and ``page.md.j2`` is its page.

    Attributes:
        question: the sentence that its page answers.
        about: summary of the command for the list of commands.
        name: the name under which it is registered; by default that of its package.
        command_words: the command that runs it, without flags; by default its name.
        resumable: whether it keeps finished results in its work folder and continues from there.
        workers: default number of processes that judge; 0 for one a core, None where a study works
            in this process alone.
        work: default work folder; by default that of its name below ``runs``.
        pages: its published pages; by default one of its name, made by the command without flags.
    """

    question: ClassVar[str]
    about: ClassVar[str]
    name: ClassVar[str] = ""
    command_words: ClassVar[str] = ""
    resumable: ClassVar[bool] = True
    workers: ClassVar[int | None] = 1
    work: ClassVar[Path] = Path()
    pages: ClassVar[tuple[PublishedPage, ...]] = ()

    def __init_subclass__(cls) -> None:
        dataclass(frozen=True, kw_only=True)(cls)
        cls.name = cls.name or cls.__module__.removesuffix(".study").rpartition(".")[2]
        words = cls.name.replace("_", "-")
        cls.command_words = cls.command_words or words
        cls.work = cls.work if cls.work.name else Path("runs") / words
        cls.pages = cls.pages or (PublishedPage(cls.name),)

    @abstractmethod
    def run(self, lab: Lab) -> F:
        """The results; an interrupted run goes on in the lab's folder."""

    def page(self, found: F) -> Page:
        """The page of results, made of the template beside its module.

        The template reads ``found``, and ``study`` for its options.
        """
        from steadyload.reports.composing import composed

        template = Path(inspect.getfile(type(self))).with_name("page.md.j2")
        return composed(template, {"study": self, "found": found}, found.made_with)
