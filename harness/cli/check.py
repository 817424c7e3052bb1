"""``steadyload check``: do planned pallets stand while they are loaded?"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from steadyload.app.check_defaults import default_help
from steadyload.cli.fail_on import ANY, WORDS, FailOn, fail_on
from steadyload.cli.flags import UsageError
from steadyload.cli.reading import Files
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
from steadyload.config import option, positive_number
from steadyload.escaping import printable

if TYPE_CHECKING:
    from steadyload.app.checking import Check as Checked
    from steadyload.app.repair_results import Repair as Repaired
    from steadyload.layouts.files.record import Refused
    from steadyload.layouts.model.frame import Frame
    from steadyload.layouts.model.layout import Layout

STANDS, FAILS, BAD_INPUT, NOT_JUDGED = 0, 1, 2, 3
"""Exit statuses; of several the worse one: bad input, then a load that fails."""

_RULE = 10
"""Characters of the column of a rule, escapes included."""

_ACCURACY = (
    "Accuracy: of the method on labelled cases of about so many boxes, the same for all such "
    "pallets."
)


@dataclass(frozen=True, kw_only=True)
class Check(Files):
    """Files, and the method that answers."""

    method: str | None = option(None, default_help(), names=("--method", "-m"), metavar="SPEC")
    limit: int | None = option(None, "only the first N layouts", least=1)
    timeout: float | None = option(
        None, "CPU seconds a pallet may take", metavar="S", read=positive_number
    )
    fail_on: FailOn = option(
        ANY, "end with status 1 or 3 for: any pallet that does not stand or was not judged; one "
        "that fails; a box that has nothing under it and drops by more than CM (2 unless gaps= "
        "says otherwise); with margin=CM, one that stands by less than CM, which any leaves out; "
        f"allowed: {WORDS} (default: any)",
        metavar="WORDS", read=fail_on,
    )  # fmt: skip
    transport: str | None = option(
        None, "does the complete load hold this rule of the road, too? en12195, eumos40509, tilt, "
        "or a TOML file; by the method if it judges accelerations, else by equilibrium",
        metavar="RULE",
    )  # fmt: skip
    repair: bool = option(
        False, "also find the nearest plan that stands of each load that fails or hovers; "
        "steadyload repair writes them, and has options",
    )  # fmt: skip
    json: bool = option(False, "print one JSON array of records, units in the names")
    csv: bool = option(False, "print the same records as CSV")
    html: Path | None = option(
        None, "also write a page of all pallets, DIR/index.html, each with its player",
        metavar="DIR",
    )  # fmt: skip
    workers: int | None = option(
        None, "processes that judge (default: one a core)", names=("--workers", "-j"), least=1
    )

    def __post_init__(self) -> None:
        if self.json and self.csv:
            raise UsageError("--json: not allowed with --csv")
        if self.html is not None and self.html.exists() and not self.html.is_dir():
            raise UsageError(f"--html: {str(self.html)!r} is no folder; allowed: a folder")

    def run(self) -> int:
        """Judge all pallets and print a row each; the exit status tells the worst answer."""
        from steadyload.app.checking import Answer, check_all
        from steadyload.errors import FailedError
        from steadyload.layouts.model.frame import Frame
        from steadyload.runs.envelope_use import score_warnings
        from steadyload.runs.pool import all_cores
        from steadyload.runs.scoring import read_entries
        from steadyload.transport.rules import rule_named

        reading = self.reading()
        if self.transport is not None:
            rule_named(self.transport)
        entries = read_entries(self.files, limit=self.limit, **reading)
        try:
            with progress_bar("judging") as advance:
                found = check_all(
                    entries, self.method, timeout=self.timeout, transport=self.transport,
                    gaps_cm=self.fail_on.gaps_cm, frame=Frame.of(reading["dialect"]),
                    workers=self.workers or all_cores(), progress=advance,
                )  # fmt: skip
        except FailedError as error:
            say(f"steadyload: {error}")
            return NOT_JUDGED
        for one in found:
            if one.answer is Answer.BAD_INPUT:
                say(f"steadyload: {one.reason}")
        for warning in score_warnings(one.to_dict() for one in found):
            say(warning)
        repairs, ended = self._repairs(entries, found, Frame.of(reading["dialect"]))
        with kept_status():
            self._print(found, repairs)
        if isinstance(ended, FailedError):
            say(f"steadyload: {ended}")
        elif ended is not None:
            raise ended
        if self.html is not None:
            from steadyload.app.checked_page import write_checked

            with progress_bar("drawing") as advance:
                page = write_checked(
                    entries, found, self.html, repairs=repairs,
                    workers=self.workers or all_cores(), progress=advance,
                )  # fmt: skip
            say(f"page: {page}")
        return self._status(found)

    def _repairs(
        self, entries: Sequence[tuple[str, Layout | Refused]], found: Sequence[Checked],
        frame: Frame,
    ) -> tuple[dict[int, Repaired], BaseException | None]:  # fmt: skip
        """The repairs of loads that fail or hover, by place, and what ended the work early."""
        if not self.repair:
            return {}, None
        from steadyload.app.answers import Answer
        from steadyload.app.repairs import RepairOptions
        from steadyload.cli.repair import repaired

        places = [k for k, one in enumerate(found) if one.answer in (Answer.FAILS, Answer.HOVERS)]
        options = RepairOptions(method=self.method, gaps_cm=self.fail_on.gaps_cm, frame=frame)
        done, ended = repaired([entries[place] for place in places], options, self.workers)
        return dict(zip(places, done, strict=True)), ended

    def _records(
        self, found: Sequence[Checked], repairs: Mapping[int, Repaired]
    ) -> list[dict[str, Any]]:
        records = [one.to_dict() for one in found]
        if self.repair:
            from steadyload.app.repair_results import repair_fields

            for place, record in enumerate(records):
                record |= repair_fields(repairs.get(place))
        return records

    def _print(self, found: Sequence[Checked], repairs: Mapping[int, Repaired]) -> None:
        from steadyload.app.answers import Answer, close_to, on_the_road, too_far

        if self.json:
            print(json.dumps(self._records(found, repairs), indent=1))
        elif self.csv:
            print(csv_text(self._records(found, repairs)), end="")
        else:
            asked = self.transport is not None
            name, sentence = _widths(found, asked)
            rows = [_row(one, asked, name, sentence) for one in found]
            files = [one.file for one in found]
            print_table(_header(found, asked), rows, files)
            places = [f"{name}: " for name in file_names(files)] or [""] * len(found)
            for number, (place, one) in enumerate(zip(places, found, strict=True)):
                cut = len(printable(one.sentence)) > sentence
                notes = (one.sentence,) * cut + one.notes * (not one.stands)
                for note in (*notes, *_repair_notes(repairs.get(number))):
                    print(f"{place}{printable(one.layout)}: {printable(note)}")
            if any(one.reliability is not None for one in found):
                print(_ACCURACY)
            upright = (Answer.STANDS, Answer.HOVERS)
            if any(one.gap is not None and one.answer in upright for one in found):
                print(too_far(found[0].frame, found[0].gaps_cm))
            if any(one.stands for one in found):
                print(close_to(found[0].frame))
            print(_counts(found))
            if self.repair:
                print(_repair_counts(repairs))
            for rule in dict.fromkeys(one.transport.rule for one in found if one.transport):
                print(printable(on_the_road(rule)))
            if asked:
                print("On the road: rigid boxes, without wrap, straps or anti-slip mats.")

    def _stands_by_little(self, one: Checked) -> bool:
        """Whether a load stands by less than the least margin, or by no known one."""
        least = self.fail_on.margin_cm
        known = one.margin is not None and least is not None and one.margin.cm >= least
        return one.stands and not known

    def _status(self, found: Sequence[Checked]) -> int:
        from steadyload.app.checking import Answer

        answers = {one.answer for one in found}
        held = {one.transport.held for one in found if one.transport is not None}
        if Answer.BAD_INPUT in answers:
            return BAD_INPUT
        fails = Answer.FAILS in answers or False in held
        high = any(one.hovering and one.answer is not Answer.NOT_JUDGED for one in found)
        if (fails and self.fail_on.fails) or (high and self.fail_on.hovers):
            return FAILS
        if self.fail_on.margin_cm is not None and any(map(self._stands_by_little, found)):
            return FAILS
        lost = Answer.NOT_JUDGED in answers or None in held
        return NOT_JUDGED if lost and self.fail_on.not_judged else STANDS


def _repair_notes(repair: Repaired | None) -> list[str]:
    """The repair of a load in sentences; none where there is none."""
    told = () if repair is None else (repair.sentence, *repair.sentences)
    return [f"repair: {note}" for note in told]


def _repair_counts(repairs: Mapping[int, Repaired]) -> str:
    from steadyload.app.repair_results import Outcome

    done = sum(one.outcome is Outcome.REPAIRED for one in repairs.values())
    return f"repair: {done} of {len(repairs)} that fail or hover stand when they are changed"


def _header(found: Sequence[Checked], transport: bool) -> tuple[str, ...]:
    rule = next((one.transport.rule for one in found if one.transport is not None), "on the road")
    return ("pallet", "boxes", "accuracy", *([printable(rule, _RULE)] * transport), "answer")


def _widths(found: Sequence[Checked], transport: bool) -> tuple[int, int]:
    """Of names and of sentences: all that a row has, if they need it."""
    files = max((len(name) + 2 for name in file_names([one.file for one in found])), default=0)
    left = ROW - len("  boxes  accuracy  ") - (_RULE + 2) * transport - files
    longest = max((len(printable(one.layout)) for one in found), default=0)
    sentences = max((len(printable(one.sentence)) for one in found), default=0)
    name = min(longest, max(NAME, left - sentences))
    return name, left - max(name, len("pallet"))


def _row(one: Checked, transport: bool, name: int, sentence: int) -> tuple[str, ...]:
    right = one.reliability
    return (
        printable(printable(one.layout), name),
        "-" if one.items is None else str(one.items),
        "-" if right is None else f"{100 * right.accuracy.value:.0f} %",
        *([_on_the_road(one)] * transport),
        printable(printable(one.sentence), sentence),
    )


def _on_the_road(one: Checked) -> str:
    """``holds``, or how the first box leaves its place."""
    if one.transport is None or one.transport.held is None:
        return "-"
    worst = one.transport.worst
    return "holds" if worst is None else str(worst.mode)


def _counts(found: Sequence[Checked]) -> str:
    """The last line: how many stand, fail and have no answer, and by which methods."""
    from steadyload.app.answers import Answer, counted
    from steadyload.runs.able import spec_with_question

    standing, *others = counted(one.answer for one in found)
    airy = sum(one.stands and one.gaps > 0 for one in found)
    close = sum(one.close_call for one in found)
    more = [f"{close} close call{'s' * (close != 1)}"] * bool(close)
    more += [f"{airy} with gaps"] * bool(airy)
    told = [standing + f" ({', '.join(more)})" * bool(more), *others]
    judged = [one for one in found if one.answer is not Answer.BAD_INPUT] or found
    methods = ", ".join(map(spec_with_question, dict.fromkeys(one.method for one in judged)))
    method = f" ({methods})" if found else ""
    pallets = "1 pallet" if len(found) == 1 else f"{len(found)} pallets"
    roads = [one.transport for one in found if one.transport is not None]
    road = ""
    if roads:
        holding = sum(one.held is True for one in roads)
        road = f"; {holding} hold {printable(roads[0].rule, NAME)} ({roads[0].method})"
    return f"{pallets}: {', '.join(told)}{method}{road}"
