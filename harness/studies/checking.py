"""Whether planned loads stand while they are loaded: an answer a pallet, for those who load it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache
from typing import Any

from steadyload.bearing import Crushed, first_crushed
from steadyload.kernels.constants import FLOOR
from steadyload.layouts.contacts import find_supports
from steadyload.layouts.model import Layout, require_layout
from steadyload.layouts.naming import box_id, with_ids
from steadyload.layouts.question import Question
from steadyload.layouts.record import Refused
from steadyload.methods.envelope import leaves
from steadyload.methods.method import Method, Status, Verdict, judge
from steadyload.methods.registry import make_method
from steadyload.notebook import ShownInNotebook
from steadyload.numbers import time_limit
from steadyload.runs.pool import PartLimit, SinglePart, run_units
from steadyload.statistics.estimate import Estimate
from steadyload.studies.able import asked_question
from steadyload.studies.options import DEFAULT_METHOD
from steadyload.studies.recommend.front import Front, FrontError, front_for
from steadyload.studies.recommend.kept import load_fronts
from steadyload.transport.rules import Rule, rule_named
from steadyload.transport.trials import RuleAnswer, answer_rule

TIPPING = 5.0
"""Angle [degrees] from which on a moved box is said to tip."""

_PATIENCE = 5.0
"""CPU seconds that a process is given beyond twice the time that a layout may take."""

_WAYS = {"left": "left", "right": "right", "front": "forward", "back": "back"}
"""Side of a box -> the way in which it tips over that side."""

Progress = Callable[[int, int], None]


class Answer(StrEnum):
    """Answer to the question whether a load stands.

    ``bad input``: the layout is not valid, and no method was asked.
    """

    STANDS = "stands"
    FAILS = "fails"
    NOT_JUDGED = "not judged"
    BAD_INPUT = "bad input"


@dataclass(frozen=True, slots=True)
class Reliability:
    """The accuracy that the method was measured to have on layouts of about so many boxes.

    Attributes:
        accuracy: share of cases on which it names the failing step of the label, 0 to 1.
        cases: labelled cases behind it.
        part: of which labelled set they are.
    """

    accuracy: Estimate
    cases: int
    part: str


@dataclass(frozen=True, slots=True)
class Check(ShownInNotebook):
    """The answer of a method on one layout.

    Attributes:
        layout: its name.
        file: name of its file; empty for one that is of none.
        items: number of boxes; None where the layout is not valid.
        method: spec of the method.
        answer: see :class:`Answer`.
        verdict: of the method; None where the layout is not valid.
        failing_box, moved_box: ids of the boxes of the failing step and of the one that moves too
            far; None where there is no such box, or it has no id.
        side: of its support beyond which the centre of mass of the moved box lies in the plan, or
            that of the failing step where none is known to move: ``left`` or ``right`` (low or high
            x), ``front`` or ``back`` (low or high z); None where it lies above its support.
        unsupported: whether that box stands on nothing in the plan.
        reason: of the method, or what is wrong with the layout; empty for a load that stands.
        reliability: None where the method was not measured on layouts of such a size, or on none
            beyond what its engine was measured to hold.
        outside: a sentence for every way in which the layout lies beyond that.
        crushed: the box that first bears more than it may; the load fails then, at that step,
            unless something moves too far before. None where none does, or none has a limit.
        transport: whether the complete load holds a rule of the road; None where none was asked.
    """

    layout: str
    items: int | None
    method: str
    answer: Answer
    file: str = ""
    verdict: Verdict | None = None
    failing_box: str | None = None
    moved_box: str | None = None
    side: str | None = None
    unsupported: bool = False
    reason: str = ""
    reliability: Reliability | None = None
    outside: tuple[str, ...] = ()
    crushed: Crushed | None = None
    transport: RuleAnswer | None = None

    @property
    def stands(self) -> bool:
        """Whether the load stands, box by box."""
        return self.answer is Answer.STANDS

    @property
    def sentence(self) -> str:
        """The answer in a few words: "fails at step 5: SKU-2002 tips forward, 13.1 cm"."""
        if self.answer is Answer.STANDS:
            return "stands"
        if self.answer is Answer.BAD_INPUT:
            return str(self.answer)
        if self.answer is Answer.NOT_JUDGED:
            return f"{self.answer}: {self.reason}"
        if self.crushed is not None:
            return str(self.crushed)
        assert self.verdict is not None
        said = self.verdict
        box = self.moved_box if said.moved_item is not None else self.failing_box
        motion = f"{box or f'item {said.item_at_fault}'}{self._motion}"
        return f"fails at step {said.failing_step}: {motion}"

    @property
    def _motion(self) -> str:
        """Motion of the box, as far as verdict and plan tell it, to follow its name."""
        said, way = self.verdict, f" {_WAYS[self.side]}" if self.side else ""
        if said is None or said.displacement is None:  # a method that measures no movement
            if self.unsupported:
                return " stands on nothing"
            return f" leans{way}" if way else ""
        how = "moves" if said.rotation is None or said.rotation < TIPPING else f"tips{way}"
        return f" {how}, {said.displacement:.1f} cm"

    def __str__(self) -> str:
        boxes = "" if self.items is None else f" ({self.items} boxes)"
        sure = ""
        if self.reliability is not None:
            found = self.reliability
            sure = (
                f", right on {100 * found.accuracy.value:.1f} % of {found.cases} labelled cases "
                "of about this size"
            )
        road = "" if self.transport is None else f"; {self.transport}"
        return f"{self.layout}{boxes}: {self.sentence}{road} [{self.method}{sure}]"

    def to_dict(self) -> dict[str, Any]:
        """The answer as values that JSON can hold, with units in the names."""
        sure = self.reliability
        of_verdict = (self.verdict.to_dict() if self.verdict is not None else {}).get
        return {
            "layout": self.layout,
            "file": self.file,
            "items": self.items,
            "method": self.method,
            "answer": str(self.answer),
            "score": of_verdict("score"),
            "failing_step": of_verdict("failing_step"),
            "failing_box": self.failing_box,
            "moved_step": of_verdict("moved_step"),
            "moved_box": self.moved_box,
            "displacement_cm": of_verdict("displacement_cm"),
            "rotation_deg": of_verdict("rotation_deg"),
            "side": self.side,
            "unsupported": self.unsupported,
            "reason": self.reason,
            "outside": list(self.outside),
            "reliability": None if sure is None else sure.accuracy.value,
            "reliability_low": None if sure is None else sure.accuracy.low,
            "reliability_high": None if sure is None else sure.accuracy.high,
            "reliability_cases": None if sure is None else sure.cases,
            "cpu_seconds": of_verdict("cpu_seconds"),
            "crushed_step": None if self.crushed is None else self.crushed.step,
            "crushed_item": None if self.crushed is None else self.crushed.item,
            "bears_kg": None if self.crushed is None else self.crushed.bears_kg,
            "allowed_kg": None if self.crushed is None else self.crushed.allowed_kg,
            **_transport_fields(self.transport),
        }


def _transport_fields(answer: RuleAnswer | None) -> dict[str, Any]:
    worst = None if answer is None else answer.worst
    return {
        "transport_rule": None if answer is None else answer.rule,
        "transport_method": None if answer is None else answer.method,
        "transport_held": None if answer is None else answer.held,
        "transport_direction_deg": None if worst is None else worst.direction_deg,
        "transport_moved_step": None if worst is None else worst.moved_item,
        "transport_mode": None if worst is None or worst.mode is None else str(worst.mode),
        "transport_reason": "" if worst is None else worst.reason,
    }


def check(
    layout: Layout,
    method: str = DEFAULT_METHOD,
    *,
    timeout: float | None = None,
    transport: str | Rule | None = None,
) -> Check:
    """Whether a load stands while it is loaded, box by box.

    Args:
        layout: the plan, in the order of loading.
        method: spec of the method that answers.
        timeout: CPU seconds that it may take.
        transport: a rule of the road that the complete load is asked to hold, such as ``en12195``,
            or a TOML file of one; by the method where it knows accelerations, else by
            :data:`steadyload.transport.limits.EXACT`.

    Raises:
        LayoutError: it is no layout.
        NumberError: the timeout is no finite number above 0.
        SpecError, EngineNotInstalledError: there is no such method, or its engine is missing.
        TransportError: there is no such rule.
    """
    require_layout(layout)
    rule = rule_named(transport) if isinstance(transport, str) else transport
    judging = _default() if method == DEFAULT_METHOD else make_method(method)
    judging.prepare(len(layout))
    spec = str(judging.spec)
    verdict = judge(judging, layout, timeout)
    if verdict.status is not Status.DONE:
        answer = Answer.NOT_JUDGED
    else:
        answer = Answer.STANDS if verdict.stable else Answer.FAILS
    crushed = first_crushed(layout)
    if crushed is not None:
        if answer is Answer.FAILS and (verdict.failing_step or 0) <= crushed.step:
            crushed = None
        elif answer is not Answer.NOT_JUDGED:
            answer = Answer.FAILS
    reason, outside = with_ids(verdict.reason, layout.items), leaves(layout, judging)
    at_fault = verdict.item_at_fault
    return Check(
        layout=layout.name,
        items=len(layout),
        method=spec,
        answer=answer,
        verdict=verdict,
        failing_box=box_id(layout.items, verdict.failing_step),
        moved_box=box_id(layout.items, verdict.moved_item),
        side=None if at_fault is None else leaning(layout, at_fault),
        unsupported=at_fault is not None and stands_on_nothing(layout, at_fault),
        reason=reason or (str(verdict.status) if answer is Answer.NOT_JUDGED else ""),
        reliability=None if outside else reliability(spec, len(layout)),
        outside=outside,
        crushed=crushed,
        transport=None if rule is None else answer_rule(layout, rule, judging),
    )


def check_all(
    entries: Sequence[tuple[str, Layout | Refused]],
    method: str = DEFAULT_METHOD,
    *,
    timeout: float | None = None,
    transport: str | None = None,
    workers: int = 1,
    progress: Progress = lambda done, total: None,
) -> list[Check]:
    """Check several layouts, in their order; one that is not valid is an answer, too.

    Args:
        entries: as :func:`steadyload.runs.scoring.read_entries` gives them.
        method: see :func:`check`.
        timeout: likewise; a process that does not heed it is ended some seconds later.
        transport: likewise.
        workers: processes that judge; 0 judges in this one.
        progress: called with the layouts done and those in all.

    Raises:
        as :func:`check`.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    time_limit(timeout)
    judging = make_method(method)
    judging.prepare()  # what is wrong with the method is told at once, and once
    rule = None if transport is None else rule_named(transport)
    spec = str(judging.spec)
    found: list[Check | None] = [None] * len(entries)
    units = []
    for place, (file, entry) in enumerate(entries):
        if isinstance(entry, Layout):
            units.append(_Entry(place, entry, spec, timeout, rule))
        else:
            found[place] = Check(
                entry.name, None, spec, Answer.BAD_INPUT, file, reason=str(entry.error)
            )
    done = len(entries) - len(units)
    progress(done, len(entries))
    limit = None if timeout is None else PartLimit(2.0 * timeout + _PATIENCE, _timed_out)
    for unit, [answer] in run_units(
        _check, units, workers=min(workers, len(units)), crashed=_crashed, limit=limit
    ):
        found[unit.place] = replace(answer, file=entries[unit.place][0])
        done += 1
        progress(done, len(entries))
    return [answer for answer in found if answer is not None]


@dataclass(frozen=True)
class _Entry(SinglePart):
    """A unit of work: one layout. ``place``: in the list of all."""

    place: int
    layout: Layout
    method: str
    timeout: float | None
    rule: Rule | None = None

    def describe(self, part: int) -> str:
        return f"{self.method} on layout {self.layout.name!r}"


def _check(unit: _Entry) -> Iterator[Check]:
    yield check(unit.layout, unit.method, timeout=unit.timeout, transport=unit.rule)


def _crashed(unit: _Entry, _: int, reason: str) -> Check:
    return _not_judged(unit, Status.CRASHED, reason)


def _timed_out(unit: _Entry, _: int, reason: str) -> Check:
    return _not_judged(unit, Status.TIMEOUT, reason)


def _not_judged(unit: _Entry, status: Status, reason: str) -> Check:
    items = len(unit.layout)
    verdict = Verdict(items, status, reason=reason)
    return Check(
        unit.layout.name, items, unit.method, Answer.NOT_JUDGED, verdict=verdict, reason=reason
    )


def reliability(method: str, boxes: int) -> Reliability | None:
    """How often a method was right on labelled cases of about so many boxes; None: not measured.

    Args:
        method: canonical spec; it is held against the labels of the question that it is asked, and
            of ``stands`` where it knows no questions.
        boxes: of a layout.
    """
    question = asked_question(method) or Question.STANDS
    try:
        front = front_for(_measured(), question, boxes)
    except FrontError:
        return None
    entry = next((m for m in front.measured if m.method == method), None)
    return None if entry is None else Reliability(entry.accuracy, front.cases, front.part)


@cache
def _default() -> Method:
    """The default method, which reads nothing but files of the package: it is made once.

    Another one is made for every check, since its spec may name files that change.
    """
    return make_method(DEFAULT_METHOD)


@cache
def _measured() -> tuple[Front, ...]:
    """The measurements of the package; reading them takes as long as judging a pallet."""
    return load_fronts()


def leaning(layout: Layout, item: int) -> str | None:
    """The side over which a box's centre of mass lies beyond everything that it stands on.

    Args:
        layout: the plan.
        item: number of the box; those that are loaded after it do not matter.

    Returns:
        ``left``, ``right`` (low, high x), ``front`` or ``back`` (low, high z), the side on which it
        lies farther out; None where it lies within the rectangle about its support, or nothing
        supports it.
    """
    box = layout.items[item]
    patches = [p for p in find_supports(layout).below[item] if p.below == FLOOR or p.below < item]
    if not patches:
        return None
    x, _, z = (
        low + 0.5 * side + offset
        for low, side, offset in zip(box.position, box.size, box.mass_offset, strict=True)
    )
    out = {
        "left": min(p.x0 for p in patches) - x,
        "right": x - max(p.x1 for p in patches),
        "front": min(p.z0 for p in patches) - z,
        "back": z - max(p.z1 for p in patches),
    }
    side, farthest = max(out.items(), key=lambda entry: entry[1])
    return side if farthest > 0.0 else None


def stands_on_nothing(layout: Layout, item: int) -> bool:
    """Whether neither the floor nor a box loaded before carries a box."""
    supports = find_supports(layout)
    below = (p.below for p in supports.below[item])
    return not supports.on_floor[item] and all(box != FLOOR and box > item for box in below)
