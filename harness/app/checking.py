"""Whether planned loads stand while they are loaded: an answer a pallet, for those who load it."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import TYPE_CHECKING

from steadyload.app.answers import Answer as Answer
from steadyload.app.answers import Check as Check
from steadyload.app.answers import Reliability
from steadyload.app.check_defaults import GAPS_CM, default_method, default_methods
from steadyload.app.faults import fault_of
from steadyload.app.recommend.front import Front, FrontError, front_for
from steadyload.app.recommend.kept import load_fronts
from steadyload.app.remedies import prepare_remedies, remedy_of
from steadyload.errors import UserError
from steadyload.layouts.files.record import Refused
from steadyload.layouts.model.footing import gaps, largest
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout, require_layout
from steadyload.layouts.model.naming import box_id, with_ids
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.method import (
    Method,
    Status,
    Stopwatch,
    TimeoutExpiredError,
    Verdict,
    judge,
)
from steadyload.methods.doubt import doubt
from steadyload.methods.envelope import leaves
from steadyload.methods.equilibrium.margin import margin_of
from steadyload.methods.registry import make_method
from steadyload.numbers import number_within, seconds_allowed
from steadyload.plugins import OWN
from steadyload.progress import Progress, silent
from steadyload.runs.able import asked_question, asked_to_stand
from steadyload.runs.methods_here import method_named, use_methods
from steadyload.runs.pool import PartLimit, SinglePart, run_units
from steadyload.statics.bearing.crushed import Crushed
from steadyload.statics.bearing.crushing import first_crushed
from steadyload.transport.rules import Rule, rule_named, rule_of

if TYPE_CHECKING:
    from steadyload.transport.trials import RuleAnswer

_FEW = 100
"""Layouts that compiled rules judge before a process beside this one has started."""

_PATIENCE = 5.0
"""CPU seconds that a process is given beyond twice the time that a layout may take."""


_COMPILATION = logging.getLogger("steadyload.engines.reference.compilation")


class GapLimitError(UserError):
    """A limit on gaps that is none."""


def check(
    layout: Layout,
    method: str | Method | None = None,
    *,
    timeout: float | None = None,
    transport: str | Rule | None = None,
    gaps_cm: float | None = GAPS_CM,
    frame: Frame | None = None,
) -> Check:
    """Whether a load stands while it is loaded, box by box.

    Args:
        layout: the plan, in the order of loading.
        method: that answers; or its spec, which is asked whether the load stands unless it states
            another question; None for the default one for so many boxes
            (:func:`steadyload.app.check_defaults.default_method`).
        timeout: CPU seconds that it and the look for crushed boxes may take, and again as many that
            the margin may.
        transport: a rule of the road that the complete load is asked to hold, such as ``en12195``,
            or a TOML file of one; by the method where it judges accelerations, else by
            :data:`steadyload.transport.limits.EXACT`.
        gaps_cm: how far a box that has nothing under it may drop [cm], 0 or more; a load that
            stands else, and has a larger gap, ``hovers``. None for any gap.
        frame: axes and unit of the sentences: those of the file of the layout.

    Raises:
        LayoutError: it is no layout.
        WrongTypeError: ``frame`` or ``transport`` is of another type.
        NumberError: the timeout is no finite number above 0.
        SpecError, EngineNotInstalledError: there is no such method, or its engine is missing.
        TransportError: there is no such rule.
        GapLimitError: ``gaps_cm`` is not a number of 0 or more.
    """
    found = answer_on(
        layout, method, timeout=timeout, transport=transport, gaps_cm=gaps_cm, frame=frame
    )
    if found.answer in (Answer.STANDS, Answer.HOVERS):
        return with_margin(layout, found, timeout)
    if found.answer is not Answer.FAILS or found.crushed is not None:
        return found
    assert found.verdict is not None, "what fails was judged"
    fault = fault_of(layout, found.verdict, found.method)
    assert fault is not None, "what fails has a step"
    return replace(
        found,
        fault=fault,
        balance_lost_box=None if fault.lost is None else box_id(layout.items, fault.lost.step),
        reason=fault.sentence(layout, found.frame),
        remedy=remedy_of(layout, fault, found.frame),
    )


def with_margin(layout: Layout, found: Check, timeout: float | None = None) -> Check:
    """An answer on a load that does not fail, with its margin, where that is found in time.

    Args:
        layout: that was judged.
        found: the answer.
        timeout: CPU seconds that it may take.
    """
    with suppress(TimeoutExpiredError):
        margin = margin_of(layout, Stopwatch(timeout))
        at = None if margin is None else margin.item
        return replace(found, margin=margin, margin_box=box_id(layout.items, at))
    return found


def answer_on(
    layout: Layout,
    method: str | Method | None = None,
    *,
    timeout: float | None = None,
    transport: str | Rule | None = None,
    gaps_cm: float | None = GAPS_CM,
    frame: Frame | None = None,
) -> Check:
    """The answer of :func:`check` without its reason, remedy and margin, for many changed plans.

    Args:
        layout: see there.
        method: likewise.
        timeout: likewise.
        transport: likewise.
        gaps_cm: likewise.
        frame: likewise.
    """
    require_layout(layout)
    limit, frame = _gap_limit(gaps_cm), Frame.given(frame)
    rule = None if transport is None else rule_of(transport)
    judging = prepared(method, len(layout))
    spec = str(judging.spec)
    watch = Stopwatch(timeout)
    verdict = judge(judging, layout, timeout)
    verdict, crushed = _unless_crushed(layout, verdict, watch)
    found = gaps(layout)
    gap = largest(found)
    note = "" if gap is None else gap.sentence(layout, frame)
    if verdict.status is not Status.DONE:
        answer = Answer.NOT_JUDGED
    elif crushed is not None or not verdict.stable:
        answer = Answer.FAILS
    else:
        hovers = gap is not None and gap.exceeds(limit)
        answer = Answer.HOVERS if hovers else Answer.STANDS
    said, outside = with_ids(verdict.reason, layout.items), leaves(layout, judging, frame=frame)
    if answer is Answer.NOT_JUDGED:
        reason = said or str(verdict.status)
    elif answer is Answer.HOVERS:
        reason = note
    else:
        reason = "" if crushed is None else crushed.sentence(frame)
    return Check(
        layout=layout.name,
        items=len(layout),
        method=spec,
        answer=answer,
        verdict=verdict,
        failing_box=box_id(layout.items, verdict.failing_step),
        moved_box=box_id(layout.items, verdict.moved_item),
        reason=reason,
        method_reason=said,
        gaps=len(found),
        gap=gap,
        gaps_cm=limit,
        gap_note=note,
        gap_box=None if gap is None else box_id(layout.items, gap.item),
        gap_onto_box=None if gap is None else box_id(layout.items, gap.onto),
        frame=frame,
        reliability=None if outside else reliability(judging, len(layout)),
        outside=outside,
        doubt=with_ids(doubt(layout, judging, verdict, frame), layout.items),
        crushed=crushed,
        transport=_on_the_road(layout, rule, judging),
    )


def _on_the_road(layout: Layout, rule: Rule | None, method: Method) -> RuleAnswer | None:
    """The answer of a rule, where there is one: few checks need the solvers of transport."""
    if rule is None:
        return None
    from steadyload.transport.trials import answer_rule

    return answer_rule(layout, rule, method)


def _unless_crushed(
    layout: Layout, verdict: Verdict, watch: Stopwatch
) -> tuple[Verdict, Crushed | None]:
    """The box that is crushed before the step at which a verdict sees something move too far.

    Where the time is up before that is known, a load that stands else has no verdict.

    Args:
        layout: that was judged.
        verdict: on it.
        watch: of the judgement and this look.
    """
    try:
        return verdict, first_crushed(layout, before=verdict.failing_step, check_time=watch.check)
    except TimeoutExpiredError as error:
        if not verdict.stable:
            return verdict, None
        return replace(verdict, status=Status.TIMEOUT, reason=str(error)), None


def _gap_limit(gaps_cm: float | None) -> float:
    """The limit [cm] that a text or a number states.

    Raises:
        GapLimitError: it states none.
    """
    if gaps_cm is None:
        return math.inf
    return number_within(
        "gaps_cm", gaps_cm, 0.0, unit="[cm], or None for any gap", error=GapLimitError
    )


def check_all(
    entries: Sequence[tuple[str, Layout | Refused]],
    method: str | Method | None = None,
    *,
    timeout: float | None = None,
    transport: str | None = None,
    gaps_cm: float | None = GAPS_CM,
    frame: Frame | None = None,
    workers: int = 1,
    progress: Progress = silent,
) -> list[Check]:
    """Check several layouts, in their order; one that is not valid is an answer, too.

    Args:
        entries: as :func:`steadyload.runs.scoring.read_entries` gives them.
        method: see :func:`check`; None: every layout is judged by the default for its size.
        timeout: likewise; a process that does not heed it is ended some seconds later.
        transport: likewise.
        gaps_cm: likewise.
        frame: likewise.
        workers: processes that judge; 0 judges in this one, as rules do few layouts.
        progress: called with the layouts done and those in all.

    Raises:
        as :func:`check`.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    seconds_allowed(timeout)
    named = None if method is None else asked_to_stand(method)
    sizes = [len(entry) for _, entry in entries if isinstance(entry, Layout)]
    judges = [make_method(spec) for spec in default_methods(sizes)] if named is None else [named]
    use_methods(judges)
    rule = None if transport is None else rule_named(transport)
    most = _gap_limit(gaps_cm)
    found: list[Check | None] = [None] * len(entries)
    units = []
    for place, (file, entry) in enumerate(entries):
        spec = str(judges[0].spec)
        if isinstance(entry, Layout):
            if named is None:
                spec = default_method(len(entry))
            units.append(_Entry(place, entry, spec, timeout, rule, gaps_cm, frame))
        else:
            found[place] = Check(
                entry.name, None, spec, Answer.BAD_INPUT, file, reason=str(entry.error),
                gaps_cm=most, frame=frame or Frame(),
            )  # fmt: skip
    processes = 0 if _at_once(judges, units) else min(workers, len(units))
    alone = processes == len(units) == 1
    for judging in () if alone else judges:
        judging.prepare()  # what is wrong is told once, and no two processes compile the same
    work = partial(_check, tells=alone and _COMPILATION.isEnabledFor(logging.INFO))
    done = len(entries) - len(units)
    progress(done, len(entries))
    timed_out = partial(_not_judged, Status.TIMEOUT)
    for unit, [answer] in run_units(
        work, units, workers=processes, crashed=partial(_not_judged, Status.CRASHED),
        limit=None if timeout is None else PartLimit(2.0 * timeout + _PATIENCE, timed_out),
    ):  # fmt: skip
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
    gaps_cm: float | None = GAPS_CM
    frame: Frame | None = None

    def describe(self, part: int) -> str:
        return f"{self.method} on layout {self.layout.name!r}"


def _check(unit: _Entry, tells: bool = False) -> Iterator[Check]:
    """Prepares first: the limit on the time of a part is not meant for compilation, which this
    process prints where it ``tells``.
    """
    if tells:
        _tell_compilation()
    method = method_named(unit.method)
    method.prepare(len(unit.layout))
    if unit.timeout is not None:
        prepare_remedies()
    return _checked(unit, method)


@cache
def _tell_compilation() -> None:
    """Print in this process what it compiles, as a command does."""
    logging.basicConfig(format="steadyload: %(message)s")
    _COMPILATION.setLevel(logging.INFO)


def _checked(unit: _Entry, method: Method) -> Iterator[Check]:
    yield check(
        unit.layout,
        method,
        timeout=unit.timeout,
        transport=unit.rule,
        gaps_cm=unit.gaps_cm,
        frame=unit.frame,
    )


def _at_once(methods: Sequence[Method], units: Sequence[_Entry]) -> bool:
    """Whether all is judged before a process beside this one has started: a few layouts, by
    compiled rules of ours, which heed the limit on their time and end no process.
    """
    own = all(m.batched and type(m).__module__.startswith(OWN) for m in methods)
    return own and len(units) <= _FEW and not any(unit.rule for unit in units)


def _not_judged(status: Status, unit: _Entry, _: int, reason: str) -> Check:
    items = len(unit.layout)
    verdict = Verdict(items, status, reason=reason)
    return Check(
        unit.layout.name, items, unit.method, Answer.NOT_JUDGED, verdict=verdict, reason=reason,
        gaps_cm=_gap_limit(unit.gaps_cm), frame=unit.frame or Frame(),
    )  # fmt: skip


def reliability(method: str | Method, boxes: int) -> Reliability | None:
    """How often a method was right on labelled cases of about so many boxes; None: not measured.

    Args:
        method: itself, or its canonical spec; it is held against the labels of the question that it
            is asked, and of ``stands`` where it knows no questions.
        boxes: of a layout.
    """
    question = asked_question(method) or Question.STANDS
    try:
        front = front_for(_measured(), question, boxes)
    except FrontError:
        return None
    entry = next((m for m in front.measured if m.method == str(method)), None)
    return None if entry is None else Reliability(entry.accuracy, front.cases, front.part)


def prepared(method: str | Method | None, boxes: int) -> Method:
    """The method that answers on layouts of so many boxes, ready to judge them.

    Args:
        method: itself, or its spec; None for the default one.
        boxes: of a layout.

    Raises:
        SpecError, EngineNotInstalledError: there is no such method, or its engine is missing.
    """
    judging = _default(default_method(boxes)) if method is None else asked_to_stand(method)
    judging.prepare(boxes)
    return judging


@cache
def _default(spec: str) -> Method:
    """A default method, which reads nothing but files of the package: it is made once."""
    return make_method(spec)


@cache
def _measured() -> tuple[Front, ...]:
    """The measurements of the package; reading them takes as long as judging a pallet."""
    return load_fronts()
