"""Answers of a check: one a pallet, as sentences and as records."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from steadyload.layouts.model.footing import Footing, Gap, Side
from steadyload.layouts.model.frame import Frame
from steadyload.methods.contract.verdict import Verdict, record_of
from steadyload.notebook import ShownInNotebook
from steadyload.runs.able import asked_question, spec_with_question
from steadyload.statics.bearing.crushed import Crushed
from steadyload.statics.load_margin import CLOSE_CALL, LoadMargin, MarginKind
from steadyload.statistics.estimate import Estimate

if TYPE_CHECKING:
    from steadyload.app.faults import Fault
    from steadyload.transport.trials import RuleAnswer

TIPPING = 5.0
"""Angle [degrees] from which on a moved box is said to tip."""


TOO_FAR = 10.0
"""A movement [cm] beyond which a box moves too far; also a turn [degrees]."""


class Answer(StrEnum):
    """Answer to the question whether a load stands.

    ``hovers``: the method says that it stands, but a box has nothing under it and drops farther
    than is allowed. ``bad input``: the layout is not valid, and no method judged it.
    """

    STANDS = "stands"
    FAILS = "fails"
    HOVERS = "hovers"
    NOT_JUDGED = "not judged"
    BAD_INPUT = "bad input"


def close_to(frame: Frame) -> str:
    """A sentence on margins, and on loads that are close calls."""
    return (
        "By: how much smaller all contacts may be on every side with the load still standing, at "
        "rest where boxes have gaps below them; a load is a close call below "
        f"{frame.stated(CLOSE_CALL)} {frame.unit}."
    )


def counted(answers: Iterable[str]) -> list[str]:
    """How many stand, and fail, in words, and how many have each other answer that there is."""
    numbers, usual = Counter(answers), (Answer.STANDS, Answer.FAILS)
    verbs = {Answer.STANDS: "stand", Answer.FAILS: "fail", Answer.HOVERS: "hover"}
    return [f"{numbers[a]} {verbs.get(a, a)}" for a in Answer if numbers[a] or a in usual]


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

    def __str__(self) -> str:
        share = f"{100.0 * self.accuracy.value:.1f} % of {self.cases}"
        return f"{share} labelled cases of about this size"


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
        fault: the facts behind a load that fails; None for one that does not, and for one that is
            crushed.
        balance_lost_box: id of the box after which contact forces do not balance a plan that fails;
            None where there is no such box, or it has no id.
        reason: the fault in a sentence; the gap of a load that hovers; what is wrong with a layout
            that is not valid, and why there is no verdict; else empty.
        method_reason: what the method itself says; empty for a load that stands.
        gaps: number of boxes that have nothing under them when they are loaded.
        gap: the largest below them; None where there is none.
        gaps_cm: how large it may be [cm].
        gap_note: a sentence on it; empty where there is none.
        gap_box, gap_onto_box: ids of that box and of the one that it drops onto; None where there
            is no such box, or it has no id.
        frame: axes and unit of all sentences.
        reliability: None where the method was not measured on layouts of such a size, or on none
            beyond what its engine was measured to hold.
        outside: a sentence for every way in which the layout lies beyond that.
        doubt: a sentence on a load that a simulation sees fall although contact forces balance it;
            else empty.
        remedy: the smallest change by which the failing step would stand, in a sentence; empty for
            a load that does not fail, or whose failing step is balanced.
        crushed: the box that first bears more than it may; the load fails then, at that step,
            unless something moves too far before. None where none does, or none has a limit.
        transport: whether the complete load holds a rule of the road; None where none was asked.
        margin: by how much a load that stands, or hovers, does so; None where closed forms do not
            find that it stands, and for other answers.
        margin_box: id of the box that is the first to lose its balance; None where there is no such
            box, or it has no id.
    """

    layout: str
    items: int | None
    method: str
    answer: Answer
    file: str = ""
    verdict: Verdict | None = None
    failing_box: str | None = None
    moved_box: str | None = None
    fault: Fault | None = None
    balance_lost_box: str | None = None
    reason: str = ""
    method_reason: str = ""
    gaps: int = 0
    gap: Gap | None = None
    gaps_cm: float = math.inf
    gap_note: str = ""
    gap_box: str | None = None
    gap_onto_box: str | None = None
    frame: Frame = Frame()
    reliability: Reliability | None = None
    outside: tuple[str, ...] = ()
    doubt: str = ""
    remedy: str = ""
    crushed: Crushed | None = None
    transport: RuleAnswer | None = None
    margin: LoadMargin | None = None
    margin_box: str | None = None

    @property
    def stands(self) -> bool:
        """Whether the load stands, box by box."""
        return self.answer is Answer.STANDS

    @property
    def close_call(self) -> bool:
        """Whether a load stands by less than :data:`CLOSE_CALL`, or by no known margin."""
        return self.stands and (self.margin is None or self.margin.is_close_call)

    @property
    def hovering(self) -> bool:
        """Whether a gap is larger than is allowed, whatever the method says of the load."""
        return self.gap is not None and self.gap.exceeds(self.gaps_cm)

    @property
    def footing(self) -> Footing | None:
        """How the box at fault stands in the plan; None where there is no fault."""
        return None if self.fault is None else self.fault.footing

    @property
    def side(self) -> Side | None:
        """Side of its support beyond which the centre of mass of the box at fault lies."""
        edge = None if self.footing is None else self.footing.edge
        return None if edge is None else edge.side

    @property
    def unsupported(self) -> bool:
        """Whether the box at fault, or that of the largest gap of a load that hovers, has nothing
        under it in the plan.
        """
        at_fault = self.footing is not None and self.footing.gap is not None
        return at_fault or self.answer is Answer.HOVERS

    @property
    def sentence(self) -> str:
        """The answer in a few words: "fails at box 6 of 9: SKU-2002 tips to +z, 13.1 cm"."""
        if self.answer is Answer.STANDS:
            return f"{'close call' if self.close_call else 'stands'}{self._by}{self._gap_in_brief}"
        if self.answer is Answer.BAD_INPUT:
            return str(self.answer)
        if self.answer is Answer.NOT_JUDGED:
            return f"{self.answer}: {self.reason}"
        if self.answer is Answer.HOVERS:
            return self._hovering
        if self.crushed is not None:
            return self.crushed.sentence(self.frame)
        assert self.verdict is not None
        said = self.verdict
        assert said.failing_step is not None, "what fails, fails at a step"
        at_fault = said.failing_step if said.moved_item is None else said.moved_item
        box = self.failing_box if said.moved_item is None else self.moved_box
        placed = f"box {said.failing_step + 1} of {self.items}"
        return f"fails at {placed}: {box or f'box {at_fault + 1}'}{self._motion}"

    @property
    def _by(self) -> str:
        """The margin of a load that stands, to follow that."""
        margin = self.margin
        if margin is None:
            return ", margin not known"
        at_rest = " at rest" if margin.kind is MarginKind.AT_REST else ""
        said = f", by {margin.words(self.frame)}{at_rest}"
        if margin.item is None:
            return said
        return f"{said} at {self.margin_box or f'box {margin.item + 1}'}"

    @property
    def _hovering(self) -> str:
        gap = self.gap
        assert gap is not None, "a load hovers for a gap"
        above = "" if gap.onto is None else f" above {self.gap_onto_box or f'box {gap.onto + 1}'}"
        high = f"{self.frame.length(gap.height, finely=True)}{above or ' up'}"
        box = self.gap_box or f"box {gap.item + 1}"
        return f"hovers at box {gap.item + 1} of {self.items}: {box}, {high}"

    @property
    def _gap_in_brief(self) -> str:
        """The largest gap of a load that stands, to follow that; empty where there is none."""
        if self.gap is None:
            return ""
        box = self.gap_box or f"box {self.gap.item + 1}"
        more = f" and {self.gaps - 1} more" if self.gaps > 1 else ""
        return f"; {self.frame.length(self.gap.height, finely=True)} of air under {box}{more}"

    @property
    def _motion(self) -> str:
        """Motion of the box, as far as verdict and plan tell it, to follow its name."""
        said, way = self.verdict, f" to {self.side.way(self.frame)}" if self.side else ""
        seen = self.fault is not None and self.fault.simulation
        if self.unsupported:
            return " has nothing under it"
        if said is None or said.displacement is None or not seen:
            lost = None if self.fault is None else self.fault.lost
            gives_way = lost is not None and said is not None and lost.item == said.item_at_fault
            return f" leans{way}" if way else " gives way" if gives_way else ""
        how = "moves" if said.rotation is None or said.rotation < TIPPING else f"tips{way}"
        return f" {how}, {self.frame.length(said.displacement)}"

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences that say more than the answer in a few words."""
        failing = self.answer is Answer.FAILS
        found = [self.reason] if failing and self.crushed is None else []
        said = any(self.gap_note in note for note in found)
        if self.gap_note and (self.hovering or not failing) and not said:
            found.append(self.gap_note)
        found += [note for note in (self.remedy, self.doubt) if note]
        return tuple(found)

    def __str__(self) -> str:
        boxes = "" if self.items is None else f" ({self.items} boxes)"
        right = "" if self.reliability is None else f", right on {self.reliability}"
        road = "" if self.transport is None else f"; {self.transport}"
        said = "; ".join((self.sentence, *self.notes))
        method = spec_with_question(self.method)
        return f"{self.layout}{boxes}: {said}{road} [{method}{right}]"

    def to_dict(self) -> dict[str, Any]:
        """The answer as values that JSON can hold, with units in the names."""
        sure = self.reliability
        of_verdict = (record_of(self.verdict) if self.verdict is not None else {}).get
        known, widest = self.items is not None, 0.0 if self.gap is None else self.gap.height
        seen = self.fault is not None and self.fault.simulation
        lost = None if self.fault is None else self.fault.lost
        return {
            "layout": self.layout,
            "file": self.file,
            "items": self.items,
            "method": self.method,
            "question": asked_question(self.method),
            "answer": str(self.answer),
            "score": of_verdict("score"),
            "failing_step": of_verdict("failing_step"),
            "failing_box": self.failing_box,
            "moved_item": of_verdict("moved_item"),
            "moved_box": self.moved_box,
            "displacement_cm": of_verdict("displacement_cm") if seen else None,
            "rotation_deg": of_verdict("rotation_deg") if seen else None,
            **_footing_fields(self.footing, self.frame),
            "unsupported": self.unsupported if known else None,
            "hovering": self.hovering if known else None,
            "gaps": self.gaps if known else None,
            "gap_cm": round(widest, 6) if known else None,
            "gap_step": None if self.gap is None else self.gap.item,
            "gap_box": self.gap_box,
            "gap_onto_step": None if self.gap is None else self.gap.onto,
            "gap_onto_box": self.gap_onto_box,
            "gap_note": self.gap_note,
            "close_call": self.close_call if known else None,
            "margin_cm": None if self.margin is None else round(self.margin.cm, 3),
            "margin_kind": None if self.margin is None else str(self.margin.kind),
            "margin_item": None if self.margin is None else self.margin.item,
            "margin_box": self.margin_box,
            "balance_lost_step": None if lost is None else lost.step,
            "balance_lost_box": self.balance_lost_box,
            "balance_lost_item": None if lost is None else lost.item,
            "reason": self.reason,
            "method_reason": self.method_reason,
            "outside": list(self.outside),
            "doubt": self.doubt,
            "remedy": self.remedy,
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


def too_far(frame: Frame, gaps_cm: float) -> str:
    """How far a box may move, and from which gap on a load hovers.

    Args:
        frame: unit of lengths.
        gaps_cm: the largest gap that is allowed [cm]; infinite for any.
    """
    said = (
        f"Too far: a corner by {frame.stated(TOO_FAR)} {frame.unit} along an axis, or a turn by "
        f"{TOO_FAR:g} degrees, unless the method says otherwise; a box that drops by less counts "
        "as placed."
    )
    if math.isinf(gaps_cm):
        return said
    return (
        f"{said} A load that stands by that rule hovers where a box has nothing under it and drops "
        f"farther than {frame.stated(gaps_cm)} {frame.unit}."
    )


def on_the_road(rule: str) -> str:
    """A sentence that tells the answer and a rule of the road apart."""
    return (
        f"The answer judges the loading, box by box; {rule} judges the ride of the complete load, "
        "where a box with any gap below it has no support unless a simulation answers."
    )


def _footing_fields(found: Footing | None, frame: Frame) -> dict[str, Any]:
    edge = None if found is None else found.edge
    return {
        "side": None if edge is None else str(edge.side),
        "direction": None if edge is None else edge.side.way(frame),
        "beyond_edge_cm": None if found is None else 0.0 if edge is None else edge.beyond,
        "edge_of_step": None if edge is None else edge.box,
        "base_supported": None if found is None else found.support,
    }


def _transport_fields(answer: RuleAnswer | None) -> dict[str, Any]:
    worst = None if answer is None else answer.worst
    return {
        "transport_rule": None if answer is None else answer.rule,
        "transport_method": None if answer is None else answer.method,
        "transport_held": None if answer is None else answer.held,
        "transport_direction_deg": None if worst is None else worst.direction_deg,
        "transport_moved_item": None if worst is None else worst.moved_item,
        "transport_mode": None if worst is None or worst.mode is None else str(worst.mode),
        "transport_reason": "" if worst is None else worst.reason,
    }
