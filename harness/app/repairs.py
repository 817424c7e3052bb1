"""Repair: from a plan that fails to the nearest one that stands."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace

from steadyload.app.check_defaults import GAPS_CM
from steadyload.app.checking import Answer, Check, prepared, with_margin
from steadyload.app.repair_options import ALLOWED, MARGIN_CM, SECONDS, SHIFT_CM
from steadyload.app.repair_options import RepairOptions as RepairOptions
from steadyload.app.repair_results import Outcome as Outcome
from steadyload.app.repair_results import Repair as Repair
from steadyload.layouts.files.record import Refused
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout, LayoutError, require_layout
from steadyload.layouts.model.naming import label_in
from steadyload.layouts.model.snapping import snap
from steadyload.methods.contract.method import Method
from steadyload.methods.registry import make_method
from steadyload.methods.uncertainty import Uncertainty
from steadyload.progress import Progress, silent
from steadyload.repairing.changes import changes_between
from steadyload.repairing.confirmed import (
    Confirmation,
    ConfirmedSearch,
    Found,
    Stopped,
    changed_plan,
)
from steadyload.repairing.plan import Boxes, Kind
from steadyload.runs.able import asked_to_stand
from steadyload.runs.methods_here import method_named, use_methods
from steadyload.runs.pool import PartLimit, SinglePart, run_units
from steadyload.runs.verdict_reliability import Sampling, verdict_reliability
from steadyload.time_limit import TimeLimit, cpu_clock

OFF = Uncertainty(com=0.5)
"""By how much centres of mass are off, as far as anybody knows."""

_LOOKS = Sampling(half_width=0.001, most=256)
"""As many samples for every plan."""

_NO_MORE = 1e-9
"""CPU seconds of a search that ends with the first plan that is confirmed."""

_PATIENCE = 5.0
"""CPU seconds that a process is given beyond three times that limit."""


def repair(
    layout: Layout,
    allow: Collection[Kind | str] = ALLOWED,
    *,
    method: str | Method | None = None,
    shift_cm: float = SHIFT_CM,
    margin_cm: float = MARGIN_CM,
    seconds: float = SECONDS,
    seed: int = 0,
    gaps_cm: float | None = GAPS_CM,
    frame: Frame | None = None,
) -> Repair:
    """The nearest plan that stands: fewest boxes left out, then fewest moved, then least far.

    Another order of loading is tried first. Boxes stay inside the contour, overlap nothing, keep
    their upper side up, bear no more than they may, and are let down from above. The search asks
    for balance with a margin; whether the result stands is for ``method`` to say. How likely it is
    to stand with boxes that are not exactly as planned is said beside.

    Args:
        layout: the plan, in the order of loading.
        allow: see :class:`RepairOptions`, as all that follow.
        method: likewise.
        shift_cm: likewise.
        margin_cm: likewise.
        seconds: likewise.
        seed: likewise.
        gaps_cm: likewise.
        frame: likewise.

    Raises:
        as :class:`RepairOptions` and :func:`steadyload.check`.
    """
    options = RepairOptions(
        allow=allow, method=None if method is None else asked_to_stand(method),
        shift_cm=shift_cm, margin_cm=margin_cm, seconds=seconds, seed=seed, gaps_cm=gaps_cm,
        frame=Frame.given(frame),
    )  # fmt: skip
    require_layout(layout)
    clock = cpu_clock()
    begun = clock()
    found = _repaired(layout, options)
    return replace(found, seconds=clock() - begun)


def _repaired(layout: Layout, options: RepairOptions) -> Repair:
    """See :func:`repair`."""
    before, allowed = options.judge(layout), options.kinds
    same = Repair(
        layout.name, Outcome.UNCHANGED, layout, tuple(range(len(layout))),
        judged_by=before.method, before=before, after=before, frame=options.frame,
    )  # fmt: skip
    if before.stands:
        return same
    if before.answer is Answer.NOT_JUDGED:
        reason = f"not judged: {before.reason}"
        return replace(same, outcome=Outcome.NOT_REPAIRED, reason=reason)
    gaps_cm = options.gaps_cm if Kind.DROP in allowed else None
    closed = layout if gaps_cm is None else snap(layout, gaps_cm)
    boxes = Boxes(closed)
    found = _searched(boxes, options)
    if found.attempt is None:
        reason = _why_not(layout, found, allowed, options.seconds)
        return replace(same, outcome=Outcome.NOT_REPAIRED, reason=reason, stopped=found.stopped)
    assert found.confirmation is not None, "its plan was confirmed"
    origins, after = found.attempt.order, found.confirmation.answer
    changed = changed_plan(boxes, found.attempt)
    after = with_margin(changed, after)
    chance = chance_to_stand(changed)
    raised = None if closed is layout else _raised(layout, closed, changed, origins)
    if raised is not None and (again := with_margin(raised, options.judge(raised))).stands:
        changed, after = raised, again
    return replace(
        same,
        outcome=Outcome.REPAIRED,
        layout=changed,
        origins=origins,
        changes=changes_between(layout, changed, origins),
        left_out=tuple(item for step, item in enumerate(layout.items) if step not in origins),
        after=after,
        chance=chance,
        stopped=found.stopped,
    )


def _searched(boxes: Boxes, options: RepairOptions) -> Found[_Confirmation]:
    """The nearest plan with the largest margin of those looked for at which there is one.

    A plan without a margin is looked for first, of which the first one will do. What time it leaves
    goes to plans with a margin: each of these searches ends after half of the time that is left
    where it has confirmed no plan by then.
    """
    limit = TimeLimit(options.seconds, "repair")

    def search(margin: float, seconds: float, without: float) -> Found[_Confirmation]:
        return ConfirmedSearch(
            boxes, options.kinds, options.shift_cm, options.seed,
            lambda plan: _Confirmation.of(options.judge(plan)), seconds, margin, without,
        ).run()  # fmt: skip

    if not options.margin_cm:
        return search(0.0, options.seconds, options.seconds)
    found = search(0.0, _NO_MORE, options.seconds)
    for margin in options.margins_cm:
        left = limit.left()
        if found.attempt is None or found.stopped is Stopped.INTERRUPTED or left <= 0.0:
            break
        try:
            nearer = search(margin, left, left / 2.0 if margin else left)
        except KeyboardInterrupt:
            return replace(found, stopped=Stopped.INTERRUPTED)
        if nearer.attempt is not None:
            return nearer
    return found


def chance_to_stand(layout: Layout) -> float:
    """The probability that a plan balances where every centre of mass is off by 5 mm (s.d.).

    By exact equilibrium, on the same deviations for every plan.

    Args:
        layout: a plan that balances.
    """
    found = verdict_reliability(make_method("equilibrium"), layout, OFF, _LOOKS)
    return sum(safe == len(layout) for safe in found.said) / len(found.said)


@dataclass(frozen=True)
class _Confirmation(Confirmation):
    """A judge's answer on a changed plan, for the search; ``answer``: that in full."""

    answer: Check = field(kw_only=True)

    @classmethod
    def of(cls, answer: Check) -> _Confirmation:
        """From the answer of a check."""
        said, crushed = answer.verdict, answer.crushed
        steps: list[int | None] = []
        if crushed is not None:
            steps += [crushed.step, crushed.item]
        elif said is not None and said.failing_step is not None:
            steps += [said.failing_step, said.item_at_fault]
        elif answer.hovering and answer.gap is not None:
            steps.append(answer.gap.item)
        at_fault = tuple(sorted({step for step in steps if step is not None}))
        return cls(answer.stands, at_fault, answer=answer)


def _raised(
    layout: Layout, closed: Layout, changed: Layout, origins: Sequence[int]
) -> Layout | None:
    """The changed plan with boxes that nothing else was done to at their old heights again.

    Args:
        layout: the plan that was given.
        closed: the same with small gaps closed.
        changed: what the search made of that.
        origins: of the items of ``changed`` the steps in the others.

    Returns:
        None where that is no valid plan.
    """
    items = [
        replace(item, position=layout.items[step].position)
        if (item.position, item.size) == (closed.items[step].position, closed.items[step].size)
        else item
        for item, step in zip(changed.items, origins, strict=True)
    ]
    try:
        return Layout(layout.name, layout.pallet, tuple(items))
    except LayoutError:
        return None


def _why_not(
    layout: Layout, found: Found[_Confirmation], allowed: Collection[Kind], seconds: float
) -> str:
    """Why no plan was found, in a sentence."""
    words = ", ".join(kind for kind in Kind if kind in allowed)
    if found.nearest is None:
        return f"no plan was found within {seconds:g} s of CPU time"
    left = found.nearest.left_out
    if not left:
        return f"of {found.judged} changed plans none was confirmed (allowed changes: {words})"
    box = label_in(layout.items, left[0])
    others = {1: "", 2: ", nor has 1 other"}.get(len(left), f", nor have {len(left) - 1} others")
    free = "place where it stands" if set(allowed) - {Kind.ORDER} else "turn at which it stands"
    others_stand = "; with leave the others may stand without them"
    end = "" if len(left) == len(layout) else others_stand
    return f"{box} has no free {free}{others} (allowed changes: {words}){end}"


def repair_all(
    entries: Sequence[tuple[str, Layout | Refused]],
    options: RepairOptions,
    *,
    workers: int = 1,
    progress: Progress = silent,
) -> list[Repair]:
    """Repair several plans, in their order; takes and raises as :func:`repair_each`."""
    found = dict(repair_each(entries, options, workers=workers, progress=progress))
    return [found[place] for place in range(len(entries))]


def repair_each(
    entries: Sequence[tuple[str, Layout | Refused]],
    options: RepairOptions,
    *,
    workers: int = 1,
    progress: Progress = silent,
) -> Iterator[tuple[int, Repair]]:
    """Repair several plans, each handed out with its place as soon as it is known.

    A plan that is not valid is an outcome, too. An interrupt comes as an error after what is known
    was handed out: who keeps that loses nothing.

    Args:
        entries: as :func:`steadyload.runs.scoring.read_entries` gives them.
        options: of all repairs.
        workers: processes; 0 repairs in this one, where an interrupt ends a search with the best
            plan that it has.
        progress: called with the plans done and those in all.

    Raises:
        as :func:`repair`.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    if options.method is not None:
        named = asked_to_stand(options.method)
        use_methods([named])
        named.prepare()
        options = replace(options, method=str(named.spec))
    units = []
    for place, (file, entry) in enumerate(entries):
        if isinstance(entry, Layout):
            units.append(_Unit(place, entry, options))
        else:
            yield place, _refused(file, entry, options)
    done = len(entries) - len(units)
    progress(done, len(entries))
    for unit, [one] in run_units(
        _repair, units, workers=min(workers, len(units)), crashed=_lost,
        limit=PartLimit(3.0 * options.seconds + _PATIENCE, _lost),
    ):  # fmt: skip
        done += 1
        progress(done, len(entries))
        yield unit.place, replace(one, file=entries[unit.place][0])
        if one.stopped is Stopped.INTERRUPTED:
            raise KeyboardInterrupt


def as_planned(
    file: str,
    entry: Layout | Refused,
    options: RepairOptions,
    reason: str,
    stopped: Stopped = Stopped.DONE,
) -> Repair:
    """The outcome of a plan that was not worked on to the end; of one that is not valid as ever.

    Args:
        file: that it was read from.
        entry: the plan.
        options: of the repair.
        reason: why there is no other outcome.
        stopped: what ended the work.
    """
    if isinstance(entry, Refused):
        return _refused(file, entry, options)
    return Repair(
        entry.name, Outcome.NOT_REPAIRED, entry, tuple(range(len(entry))), reason=reason,
        stopped=stopped, file=file, frame=options.frame,
    )  # fmt: skip


def _refused(file: str, entry: Refused, options: RepairOptions) -> Repair:
    return Repair(
        entry.name, Outcome.BAD_INPUT, None, reason=str(entry.error), file=file,
        frame=options.frame,
    )  # fmt: skip


@dataclass(frozen=True)
class _Unit(SinglePart):
    """A unit of work: one plan. ``place``: in the list of all."""

    place: int
    layout: Layout
    options: RepairOptions

    def describe(self, part: int) -> str:
        return f"the repair of {self.layout.name!r}"


def _repair(unit: _Unit) -> Iterator[Repair]:
    """Prepares first: the limit on the time of a part is not meant for compilation."""
    options = unit.options
    if isinstance(options.method, str):
        options = replace(options, method=method_named(options.method))
    prepared(options.method, len(unit.layout))
    return _repairs(unit.layout, options)


def _repairs(layout: Layout, options: RepairOptions) -> Iterator[Repair]:
    clock = cpu_clock()
    begun = clock()
    yield replace(_repaired(layout, options), seconds=clock() - begun)


def _lost(unit: _Unit, _: int, reason: str) -> Repair:
    return as_planned("", unit.layout, unit.options, reason)
