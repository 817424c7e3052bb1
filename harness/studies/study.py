"""The shape of a study: a question, a configuration, a run, and the page of what it found."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Generic, Protocol, TypeVar

C = TypeVar("C")
R = TypeVar("R")


class Progress(Protocol):
    """Is told what is worked on and, where that is known, how much of it is done."""

    def __call__(self, what: str, done: int = 0, total: int = 0, /) -> None:
        """Take note."""


def silent(what: str, done: int = 0, total: int = 0, /) -> None:
    """Progress that nobody sees."""


@dataclass(frozen=True, slots=True)
class PublishedPage:
    """A page below ``reports/published``, and what remakes it.

    Attributes:
        folder: of the page.
        flags: what follows the command of the study; file patterns are filled in.
        before: command lines that make what the page is made of.
        question: the one that it answers, where that is not the whole question of the study.
    """

    folder: str
    flags: str = ""
    before: tuple[str, ...] = ()
    question: str = ""


class Study(ABC, Generic[C, R]):
    """A study; the command line, the index of pages and what remakes them know it by this alone.

    Attributes:
        name: the one under which it is registered.
        question: the sentence that its page answers.
        about: what the command does, in a list of commands.
        command: words of the command that runs it; empty for its name.
        folder: below ``runs``, where it works unless another folder is named; empty for its name.
        Config: a frozen dataclass of :func:`steadyload.engines.quantities.quantity` fields, or of
            :func:`steadyload.studies.options.option`; keys, flags and their help come from it.
        resumable: it keeps what is finished in its work folder and goes on from there.
        workers: processes that judge unless others are asked for; 0 for one a core, None where a
            study works in this process alone.
        published: the pages that are kept; empty for one page of the study's name, as the command
            makes it unasked.
    """

    name: ClassVar[str]
    question: ClassVar[str]
    about: ClassVar[str]
    command: ClassVar[str] = ""
    folder: ClassVar[str] = ""
    Config: type[C]
    resumable: ClassVar[bool] = True
    workers: ClassVar[int | None] = 1
    published: ClassVar[tuple[PublishedPage, ...]] = ()

    @abstractmethod
    def run(self, config: C, work: Path, *, workers: int = 1, progress: Progress = silent) -> R:
        """Result of the study; judged in ``work``, where an interrupted run is resumed."""

    @abstractmethod
    def page(self, result: R) -> Any:
        """The :class:`steadyload.reports.page.Page` that shows it; computes nothing."""

    @property
    def command_words(self) -> str:
        """The command that runs it, without its flags."""
        return self.command or self.name.replace("_", "-")

    @property
    def work(self) -> Path:
        """The folder in which it works unless another is named."""
        return Path("runs") / (self.folder or self.name.replace("_", "-"))

    @property
    def pages(self) -> tuple[PublishedPage, ...]:
        """:attr:`published`, with what it means where it is empty."""
        return self.published or (PublishedPage(self.name),)
