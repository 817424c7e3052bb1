"""Base class of studies: a question, a configuration, a run, and the page of its results."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Generic, TypeVar

from steadyload.progress import NamedProgress, silent

C = TypeVar("C")
R = TypeVar("R")


def command_words(name: str) -> str:
    """The command of the study with a name."""
    return f"study {name.replace('_', '-')}"


@dataclass(frozen=True, slots=True)
class PublishedPage:
    """A page below ``reports/published``, with the commands that remake it.

    Attributes:
        folder: of the page.
        flags: flags after the command of the study; file patterns are expanded.
        before: command lines that make the input of the page.
        question: the question of the page, where that is not the whole question of the study.
    """

    folder: str
    flags: str = ""
    before: tuple[str, ...] = ()
    question: str = ""


class Study(ABC, Generic[C, R]):
    """A study, as the command line, the index of pages and the remaking of pages use it.

    Attributes:
        name: the name under which it is registered.
        question: the sentence that its page answers.
        about: summary of the command for the list of commands.
        Config: a frozen dataclass of :func:`steadyload.engines.quantities.quantity` fields, or of
            :func:`steadyload.config.option`; keys, flags and their help come from it.
        resumable: whether it keeps finished results in its work folder and continues from there.
        workers: default number of processes that judge; 0 for one a core, None where a study works
            in this process alone.
        published: its published pages; empty for one page of the study's name, made by the command
            without flags.
    """

    name: ClassVar[str]
    question: ClassVar[str]
    about: ClassVar[str]
    Config: type[C]
    resumable: ClassVar[bool] = True
    workers: ClassVar[int | None] = 1
    published: ClassVar[tuple[PublishedPage, ...]] = ()

    @abstractmethod
    def run(
        self, config: C, work: Path, *, workers: int = 1, progress: NamedProgress = silent
    ) -> R:
        """Result of the study; judged in ``work``, where an interrupted run is resumed."""

    @abstractmethod
    def page(self, result: R) -> Any:
        """The :class:`steadyload.reports.pages.page.Page` of a result; computes nothing."""

    @property
    def command_words(self) -> str:
        """The command that runs it, without its flags."""
        return command_words(self.name)

    @property
    def work(self) -> Path:
        """The default work folder."""
        return Path("runs") / self.name

    @property
    def pages(self) -> tuple[PublishedPage, ...]:
        """:attr:`published`, or the default page where it is empty."""
        return self.published or (PublishedPage(self.name),)
