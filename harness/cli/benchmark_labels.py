"""``steadyload benchmark label``, ``judge``, ``screen``: labels of a set and further verdicts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from steadyload.cli.benchmark import IN_SPLIT, print_first
from steadyload.cli.flags import UsageError
from steadyload.cli.studies import workers_option
from steadyload.cli.terminal import progress_bar, resumable, study_progress
from steadyload.config import REQUIRED, operand, option, stated


@dataclass(frozen=True)
class Label:
    """Which set, the sizes of the splits, and the further methods."""

    directory: Path = operand(
        Path("runs/benchmark"), "folder of the new set (default: runs/benchmark)", metavar="DIR"
    )
    test: int | None = option(None, IN_SPLIT.format("test", "as built or labelled last"), least=2)
    validation: int | None = option(
        None, IN_SPLIT.format("validation", "as built or labelled last"), least=2
    )
    judges: str | None = option(
        None, "further judges of validation and test; `robust` says less with few (default: all)",
        choices=("all", "few", "none"),
    )  # fmt: skip
    question: str = option(
        "within", "stands: whether a load stands once everything rests; of a set that has its "
        "labels and splits (default: within)", choices="steadyload.layouts.model.question:Question",
    )  # fmt: skip
    train: int | None = option(
        None, "with --question stands: this many training cases, too (default: 5000)", least=0
    )
    workers: int = workers_option(0)

    def __post_init__(self) -> None:
        of_within = {"--test": self.test, "--validation": self.validation, "--judges": self.judges}
        of_other = {"--train": self.train} if self.question == "within" else of_within
        for flag, value in of_other.items():
            if value is not None:
                raise UsageError(f"{flag}: not allowed with --question {self.question}")

    def run(self) -> None:
        """Label the missing cases."""
        from steadyload.layouts.model.question import Question

        if self.question == Question.STANDS:
            self._stands()
        else:
            self._within()

    def _stands(self) -> None:
        from steadyload.labelling.label_stands import TRAINING_CASES, label_stands

        with resumable(self.directory), study_progress() as progress:
            count = label_stands(
                self.directory,
                training_cases=TRAINING_CASES if self.train is None else self.train,
                workers=self.workers,
                progress=progress,
            )
        print(f"{count} labels of the question stands -> {self.directory / 'labels.parquet'}")

    def _within(self) -> None:
        from steadyload.labelling.labelling import PANELS, label_set, split_sizes
        from steadyload.layouts.benchmark.tables import read_tables

        built = split_sizes(read_tables(self.directory)[3])
        sizes = replace(built, **stated(test=self.test, validation=self.validation))
        with resumable(self.directory), study_progress() as progress:
            label_set(
                self.directory, sizes=sizes, judges=PANELS[self.judges or "all"],
                workers=self.workers, progress=progress,
            )  # fmt: skip
        print(f"labels and opinions -> {self.directory}")


@dataclass(frozen=True)
class Further:
    """Which cases of which set, and the further methods."""

    directory: Path = operand(REQUIRED, "folder of a labelled set", metavar="DIR")
    part: str = option(
        "test-300", "default: test-300", choices="steadyload.layouts.benchmark.parts:Part"
    )
    limit: int | None = option(None, "only the first N of every scenario", least=1)
    question: str = option(
        "within", "whose labels are judged again (default: within)",
        choices="steadyload.layouts.model.question:Question",
    )  # fmt: skip
    judges: str = option("all", "few: three quick ones (default: all)", choices=("all", "few"))
    close_steps: int | None = option(
        None, "of large layouts: two changes of contacts alone, of both questions, at the steps "
        "that are close, of all cases that fail and N that stand", metavar="N", least=0,
    )  # fmt: skip
    workers: int = workers_option(0)

    def __post_init__(self) -> None:
        if self.close_steps is not None and self.limit is not None:
            raise UsageError("--close-steps: not allowed with --limit")

    def run(self) -> None:
        """Judge the cases that have not been judged by all of the methods."""
        if self.close_steps is not None:
            self._close_steps(self.close_steps)
            return
        from steadyload.labelling.further_verdicts import add_further_verdicts
        from steadyload.labelling.labelling import PANELS
        from steadyload.layouts.model.question import Question

        with resumable(self.directory), progress_bar("judging") as advance:
            count = add_further_verdicts(
                self.directory, part=self.part, limit=self.limit, question=Question(self.question),
                judges=PANELS[self.judges], workers=self.workers, progress=advance,
            )  # fmt: skip
        print(f"{count} cases judged by further methods -> {self.directory}")

    def _close_steps(self, standing: int) -> None:
        from steadyload.labelling.close_steps import judge_close_steps

        with resumable(self.directory), progress_bar("judging") as advance:
            count = judge_close_steps(
                self.directory, part=self.part, standing=standing, workers=self.workers,
                progress=advance,
            )  # fmt: skip
        print(f"{count} cases judged at their close steps -> {self.directory}")


@dataclass(frozen=True)
class Screen:
    """Which set, and how large its layouts may be."""

    directory: Path = operand(REQUIRED, "folder of the set", metavar="DIR")
    most_items: int | None = option(None, "only layouts of at most so many items", least=1)
    again: int | None = option(
        None, "label N cases once more, drawn at random, and compare; the set stays as it is",
        metavar="N", least=1,
    )  # fmt: skip
    least_items: int | None = option(None, "with --again: only of at least so many items", least=1)
    keep_in: Path | None = option(
        None, "label nothing; keep the rows made so far in tables of the set SET, from which this "
        "command goes on in a copy of SET", metavar="SET",
    )  # fmt: skip
    workers: int = workers_option(0)

    def __post_init__(self) -> None:
        if self.keep_in is not None and (self.again or self.most_items) is not None:
            raise UsageError("--keep-in: not allowed with --again or --most-items")
        if self.again is not None and self.most_items is not None:
            raise UsageError("--most-items: not allowed with --again; allowed: --least-items")
        if self.again is None and self.least_items is not None:
            raise UsageError("--least-items: not allowed without --again")

    def run(self) -> None:
        """Label the missing cases for both questions: validation, then test, then training."""
        from steadyload.labelling.screening import keep_again, keep_begun, label_screened

        if self.keep_in is not None:
            print(f"unlabelled cases with rows: {keep_begun(self.directory, self.keep_in)}")
            print(f"labels that were made again: {keep_again(self.directory, self.keep_in)}")
        elif self.again is not None:
            self._again(self.again)
        else:
            with resumable(self.directory), progress_bar("labelling") as advance:
                count = label_screened(
                    self.directory, most_items=self.most_items, workers=self.workers,
                    progress=advance,
                )  # fmt: skip
            print(f"{count} cases have labels of both questions -> {self.directory}")

    def _again(self, count: int) -> None:
        from steadyload.labelling.screening import label_again

        with resumable(self.directory), progress_bar("labelling again") as advance:
            found = label_again(
                self.directory, count, least_items=self.least_items or 1, workers=self.workers,
                progress=advance,
            )  # fmt: skip
        equal = len(found.cases) - len(found.differ)
        print(f"{equal} of {len(found.cases)} cases, labelled again, are equal -> {self.directory}")
        print_first("differs", [f"{layout} {scenario}" for layout, scenario in found.differ])
