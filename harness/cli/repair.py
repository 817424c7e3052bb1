"""``steadyload repair``: from plans that fail to the nearest ones that stand."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any

from steadyload.app.check_defaults import default_help
from steadyload.cli.convert import WRITABLE
from steadyload.cli.flags import UsageError
from steadyload.cli.interrupts import is_behind
from steadyload.cli.reading import Files, check_output
from steadyload.cli.terminal import (
    NAME,
    ROW,
    csv_text,
    file_names,
    kept_status,
    print_table,
    progress_bar,
    say,
)
from steadyload.config import REQUIRED, number_from_zero, option, output_option, positive_number
from steadyload.errors import FailedError
from steadyload.escaping import printable

if TYPE_CHECKING:
    from steadyload.app.repair_results import Repair as Repaired
    from steadyload.app.repairs import RepairOptions
    from steadyload.layouts.files.record import Refused
    from steadyload.layouts.files.sources import Content
    from steadyload.layouts.model.layout import Layout

STAND, SOME_FAIL, BAD_INPUT, NOT_JUDGED = 0, 1, 2, 3
"""Exit statuses; of several the worse one: bad input, then a plan that does not stand."""

_ENDINGS = {"native": ".json", "csv": ".csv", "job": ".json", "parquet": ".parquet"}
"""Format that is written -> the ending of a file in a folder."""


def _native(target: Path) -> Path:
    """The file for plans that the form of their own cannot state."""
    return target.with_name(f"{target.name}.native.json")


def _words(text: str) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(","))


@dataclass(frozen=True, kw_only=True)
class Repair(Files):
    """Files, what may change of their plans, and where the result goes."""

    output: Path = output_option(
        REQUIRED, "the file that is written, in the form of the one that is read; a folder for "
        "several", metavar="OUT",
    )  # fmt: skip
    allow: Sequence[str] | None = option(
        None, "what may change: order, drop, shift, turn, move, leave, several with commas "
        "(default: all but leave)", metavar="WORDS", read=_words,
    )  # fmt: skip
    method: str | None = option(
        None, f"that confirms what stands; {default_help()}", names=("--method", "-m"),
        metavar="SPEC",
    )  # fmt: skip
    shift_cm: float | None = option(
        None, "how far shift may move a box sideways (default: 30)", metavar="CM",
        read=number_from_zero,
    )  # fmt: skip
    margin: float | None = option(
        None, "by how much all contacts may be smaller with the plan still in balance; half of it, "
        "and so on, where no plan has it (default: 2)", metavar="CM", read=number_from_zero,
    )  # fmt: skip
    seconds: float | None = option(
        None, "CPU seconds a plan may take (default: 10)", metavar="S", read=positive_number
    )
    seed: int = option(0, "of random choices; the same one finds the same plans", least=0)
    to: str | None = option(
        None, "another format than that of the file that is read", choices=WRITABLE
    )
    json: bool = option(False, "print one JSON array of records, units in the names")
    csv: bool = option(False, "print the same records as CSV")
    workers: int | None = option(
        None, "processes that search (default: one a core)", names=("--workers", "-j"), least=1
    )

    def __post_init__(self) -> None:
        if self.json and self.csv:
            raise UsageError("--json: not allowed with --csv")

    def run(self) -> int:
        """Repair all plans, write them, and print what came of each."""
        from steadyload.app.repair_results import Outcome
        from steadyload.layouts.model.frame import Frame
        from steadyload.runs.envelope_use import score_warnings
        from steadyload.runs.scoring import read_entries

        targets, reading = self._targets(), self.reading()
        options = self._options(Frame.of(reading["dialect"]))
        sources = self._sources()
        entries = read_entries(sources, **reading)
        found, ended = repaired(entries, options, self.workers)
        for one in found:
            if one.outcome is Outcome.BAD_INPUT:
                say(f"steadyload: {one.reason}")
        for warning in score_warnings(one.after.to_dict() for one in found if one.after):
            say(warning)
        try:
            written = self._write(sources, targets, found, reading)
        except OSError:
            self._print(found, options)  # what was found is told, also where it cannot be written
            raise
        with kept_status():
            self._print(found, options)
        for target in targets if written else ():
            say(f"plans: {target}")
        if isinstance(ended, FailedError):
            say(f"steadyload: {ended}")
        elif ended is not None:
            done = sum(bool(one.judged_by) for one in found)
            ended.add_note(
                f"{done} of {len(found)} plans were done; the others are written as they were"
            )
            raise ended
        return _status(found) if written else BAD_INPUT

    def _options(self, frame: Any) -> RepairOptions:
        """The options that the flags state.

        Raises:
            RepairError: there is no such change.
            SpecError: there is no such method.
        """
        from steadyload.app.repairs import RepairOptions
        from steadyload.config import stated

        given = stated(
            allow=self.allow, shift_cm=self.shift_cm, margin_cm=self.margin, seconds=self.seconds
        )
        return RepairOptions(method=self.method, seed=self.seed, frame=frame, **given)

    def _targets(self) -> list[Path]:
        """For each file that is read the one that is written.

        Raises:
            UsageError: one of them is read, too, or cannot be written, or two are the same.
        """
        out = self.output
        several = len(self.files) > 1 or out.is_dir()
        if several and out.exists() and not out.is_dir():
            raise UsageError(f"--output: {str(out)!r} is no folder; allowed for several files: one")
        found = [out / self._name(file) if several else out for file in self.files]
        for (file, target), (other, same) in combinations(zip(self.files, found, strict=True), 2):
            if target == same:
                raise UsageError(
                    f"--output: {str(file)!r} and {str(other)!r} would both be written to "
                    f"{str(target)!r}; allowed: one at a time"
                )
        for target in found:
            self._check(target)
        if not several and not out.absolute().parent.is_dir():
            raise UsageError(f"--output: {str(out.parent)!r} is no folder; allowed: one that is")
        return found

    def _check(self, target: Path) -> None:
        """Refuse to write over what is read, and where nothing can be written.

        Raises:
            UsageError: the target is such a file.
        """
        read = [*self.files, *filter(None, [self.profile])]
        check_output(target, read)
        if target.is_dir():
            raise UsageError(f"--output: {str(target)!r} is a folder; allowed: a file")
        if self.to != "native":
            check_output(_native(target), read)

    def _name(self, file: Path) -> str:
        own = Path("standard-input") if file == Path("-") else file
        return own.name if self.to is None else own.stem + _ENDINGS[self.to]

    def _sources(self) -> Sequence[Path | Content]:
        """The files that plans are read from; where their form is kept, the bytes of them.

        Raises:
            UsageError: the form of a file cannot be written.
            LayoutError: a file has too many bytes.
            OSError: a file cannot be read.
        """
        from steadyload.layouts.files.parquet_footer import is_parquet
        from steadyload.layouts.files.sources import Content

        if self.to is not None:
            return self.files
        contents = [Content.of(file) for file in self.files]
        for content in contents:
            if is_parquet(content.data):
                raise UsageError(
                    f"--output: {str(content)!r} is a Parquet file, which has no text to change; "
                    f"allowed: --to with one of {', '.join(WRITABLE)}"
                )
        return contents

    def _write(
        self,
        sources: Sequence[Path | Content],
        targets: Sequence[Path],
        found: Sequence[Repaired],
        reading: Mapping[str, Any],
    ) -> bool:
        """Write all files; False: some plan cannot be stated in the form of its file.

        All plans of such a file are written in the native format then, beside where it would be.
        """
        from steadyload.app.repaired_files import write_repaired
        from steadyload.layouts.files.sources import Content, source_name
        from steadyload.layouts.formats import Format, write_layouts
        from steadyload.layouts.model.layout import LayoutError

        whole = True
        for source, target in zip(sources, targets, strict=True):
            own = [one for one in found if one.file == source_name(source)]
            plans = [one.layout for one in own if one.layout is not None]
            if len(targets) > 1:
                target.parent.mkdir(parents=True, exist_ok=True)
            try:
                if isinstance(source, Content):
                    write_repaired(source, target, own, **reading)
                else:
                    write_layouts(target, plans, Format(str(self.to)))
            except LayoutError as error:
                whole = False
                say(f"steadyload: {error}")
                if self.to != Format.NATIVE:
                    native = _native(target)
                    write_layouts(native, plans, Format.NATIVE)
                    say(f"steadyload: nothing is written to {target}; its plans are in {native}")
        return whole

    def _print(self, found: Sequence[Repaired], options: RepairOptions) -> None:
        from steadyload.app.repair_results import Outcome

        if self.json:
            print(json.dumps([one.to_dict() for one in found], indent=1))
            return
        if self.csv:
            print(csv_text([_flat(one) for one in found]), end="")
            return
        files = [one.file for one in found]
        name, outcome = _widths(found, files)
        rows = [
            (
                printable(printable(one.name), name),
                "-" if one.layout is None else str(len(one.layout) + len(one.left_out)),
                printable(_in_brief(one), outcome),
            )
            for one in found
        ]
        print_table(("pallet", "boxes", "repair"), rows, files)
        places = [f"{name}: " for name in file_names(files)] or [""] * len(found)
        for place, one in zip(places, found, strict=True):
            notes = [one.sentence] if len(printable(_in_brief(one))) > outcome else []
            if one.outcome is Outcome.NOT_REPAIRED:
                notes = [one.sentence]
            for note in (*notes, *one.sentences):
                print(f"{place}{printable(one.name)}: {printable(note)}")
        print(summary(found, options))


def repaired(
    entries: Sequence[tuple[str, Layout | Refused]],
    options: RepairOptions,
    workers: int | None,
) -> tuple[list[Repaired], BaseException | None]:
    """The outcomes for all plans, and what ended the work before its end; None for nothing.

    A plan whose turn did not come then is as it was.

    Args:
        entries: the plans.
        options: of all repairs.
        workers: processes; None for one a core, and for a single plan this one, in which an
            interrupt ends the search with the best plan so far.
    """
    from steadyload.app.repairs import as_planned, repair_each
    from steadyload.layouts.model.layout import Layout
    from steadyload.repairing.confirmed import Stopped
    from steadyload.runs.pool import IN_THIS_PROCESS, all_cores

    valid = sum(isinstance(entry, Layout) for _, entry in entries)
    if workers is None:
        workers = all_cores() if valid > 1 else IN_THIS_PROCESS
    found: dict[int, Repaired] = {}
    ended: BaseException | None = None
    stopped, reason = Stopped.DONE, ""
    try:
        with progress_bar("repairing") as advance:
            for place, one in repair_each(entries, options, workers=workers, progress=advance):
                found |= {place: one}
    except FailedError as error:
        ended, reason = error, str(error)
    except (KeyboardInterrupt, Exception) as error:
        if not is_behind(error):
            raise
        ended, stopped, reason = error, Stopped.INTERRUPTED, "interrupted before its end"
    for place, (file, entry) in enumerate(entries):
        if place not in found:
            found[place] = as_planned(file, entry, options, reason, stopped)
    return [found[place] for place in range(len(entries))], ended


def summary(found: Sequence[Repaired], options: RepairOptions) -> str:
    """How many plans stand, were repaired and were not, by which methods, and what ended early."""
    from steadyload.app.repair_results import counted_repairs
    from steadyload.repairing.confirmed import Stopped
    from steadyload.runs.able import spec_with_question

    plans = "1 plan" if len(found) == 1 else f"{len(found)} plans"
    judged_by = dict.fromkeys(one.judged_by for one in found if one.judged_by)
    methods = ", ".join(map(spec_with_question, judged_by))
    late = sum(one.stopped is Stopped.TIME for one in found)
    ended = f"; {late} ended after {options.seconds:g} s, more may find better" if late else ""
    return f"{plans}: {counted_repairs(found)}{f' ({methods})' if methods else ''}{ended}"


def _in_brief(one: Repaired) -> str:
    """The outcome of a row; a reason stands below the table."""
    from steadyload.app.repair_results import Outcome

    return str(one.outcome) if one.outcome in (Outcome.NOT_REPAIRED, Outcome.BAD_INPUT) else (
        one.sentence
    )  # fmt: skip


def _widths(found: Sequence[Repaired], files: Sequence[str]) -> tuple[int, int]:
    """Of names and of outcomes: all that a row has, if they need it."""
    left = ROW - len("  boxes  ") - max((len(name) + 2 for name in file_names(files)), default=0)
    longest = max((len(printable(one.name)) for one in found), default=0)
    outcomes = max((len(printable(_in_brief(one))) for one in found), default=0)
    name = min(longest, max(NAME, left - outcomes))
    return name, left - max(name, len("pallet"))


def _flat(one: Repaired) -> dict[str, Any]:
    """The record of a repair with its changes in words."""
    return one.to_dict() | {"changes": one.sentences}


def _status(found: Sequence[Repaired]) -> int:
    from steadyload.app.answers import Answer
    from steadyload.app.repair_results import Outcome

    if any(one.outcome is Outcome.BAD_INPUT for one in found):
        return BAD_INPUT
    open_ = [one.before for one in found if one.outcome is Outcome.NOT_REPAIRED]
    if any(said is not None and said.answer is not Answer.NOT_JUDGED for said in open_):
        return SOME_FAIL
    return NOT_JUDGED if open_ else STAND
