"""Choice of a method: accuracy against CPU time, as measured on cases of one question and size."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from steadyload.engines.registry import engines, engines_here
from steadyload.errors import UserError, nearest
from steadyload.layouts.model.question import Question, question_named
from steadyload.statistics.error_costs import ErrorShares
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.front import undominated

_HOW_TO_MEASURE = (
    "To measure: steadyload study evaluation --directory real --question both --timeout 20 "
    "--work RUN (layouts of real size), or a study on a labelled set of your own; then "
    "steadyload recommend --from RUN"
)
"""End of a sentence on what was not measured."""


class FrontError(UserError):
    """No measured method meets the requirements, or nothing was measured."""


@dataclass(frozen=True, slots=True)
class Measured:
    """Measured accuracy and cost of a method.

    Attributes:
        method: its spec.
        title: shown in tables.
        engine: the engine that it runs on; None for one without.
        accuracy: share of cases with the label's failing step; a case without a verdict counts as
            wrong, whatever the reason.
        cpu: CPU time a layout [ms].
        without_verdict: number of cases without a verdict.
        errors: by direction; None where the measurement did not keep them.
    """

    method: str
    title: str
    engine: str | None
    accuracy: Estimate
    cpu: Estimate
    without_verdict: int = 0
    errors: ErrorShares | None = None


@dataclass(frozen=True)
class Front:
    """Methods that were measured on the same cases.

    Attributes:
        measured: those that can answer the question, in the order of the run.
        question: of the labels that they are compared with.
        fewest, most: boxes of a layout.
        part: of the labelled set, after the name of the set unless it is the package's large one.
        cases, item_lists: how many there are.
        study: the name of the study that measured.
        times: the kind of CPU times, in words.
        about: provenance, with the ``machine`` of the measurement.
        left_out: by spec, the reason why a method of the run is not among them; those made for
            another question are in neither.
    """

    measured: tuple[Measured, ...]
    question: Question
    fewest: int
    most: int
    part: str
    cases: int
    item_lists: int
    study: str
    times: str
    about: Mapping[str, str]
    left_out: Mapping[str, str] = field(default_factory=dict)

    @property
    def sizes(self) -> str:
        """The numbers of boxes."""
        return f"{self.fewest} to {self.most}" if self.most > self.fewest else f"{self.most}"

    def beyond(self, boxes: int) -> int:
        """Distance of a number of boxes from those that were measured; 0 if it is among them."""
        return max(self.fewest - boxes, boxes - self.most, 0)

    def here(self) -> Front:
        """The methods whose engines are installed; the others are in ``left_out``."""
        installed = (None, *engines_here())
        lost = {
            m.method: f"engine {m.engine!r} is not installed here"
            for m in self.measured
            if m.engine not in installed
        }
        measured = tuple(m for m in self.measured if m.method not in lost)
        return replace(self, measured=measured, left_out={**self.left_out, **lost})

    def measured_on(self) -> str:
        """Sentence on the cases, the times and the machine."""
        return (
            f"Question {self.question}, measured on {self.cases} cases of {self.sizes} boxes: "
            f"part {self.part}, {self.item_lists} item lists; CPU time: {self.times}; "
            f"{self.about['machine']}"
        )


def front_for(fronts: Iterable[Front], question: Question, boxes: int | None = None) -> Front:
    """The front for a question and a size.

    A size between those that were measured gets the nearest of these. Of several fronts the one of
    the most cases is taken.

    Args:
        fronts: the measurements.
        question: that a method is to answer.
        boxes: of a layout; None for the smallest layouts that were measured.

    Raises:
        FrontError: nothing was measured for the question, or only smaller or larger layouts.
        QuestionError: no such question.
    """
    question = question_named(question)
    asked = [front for front in fronts if front.question == question]
    if not asked:
        raise FrontError(f"no method was measured for the question {question}. {_HOW_TO_MEASURE}")
    if boxes is None:
        return min(asked, key=lambda front: (front.most, -front.cases))
    ends = min(f.fewest for f in asked), max(f.most for f in asked)
    if not ends[0] <= boxes <= ends[1]:
        nearest_size = ends[0] if boxes < ends[0] else ends[1]
        raise FrontError(
            f"no method was measured on layouts of {boxes} boxes for the question {question}; "
            f"measured: {sizes_of(asked)} boxes, of which {nearest_size} are nearest: --boxes "
            f"{nearest_size}. {_HOW_TO_MEASURE}"
        )
    return min(asked, key=lambda front: (front.beyond(boxes), -front.cases))


def sizes_of(fronts: Iterable[Front]) -> str:
    """The numbers of boxes of several fronts."""
    ordered = sorted(fronts, key=lambda front: (front.fewest, front.most))
    return ", ".join(dict.fromkeys(front.sizes for front in ordered))


def best(
    measured: Iterable[Measured],
    engine: str | None = None,
    overestimation_costs: float | None = None,
) -> list[Measured]:
    """Methods than which no cheaper one is as good, by rising CPU time.

    Args:
        measured: the methods.
        engine: only methods on this engine, and those that need none; None for all.
        overestimation_costs: the cost of an overestimation over that of an underestimation: good is
            whose errors cost little. None: good is who is right often.

    Raises:
        FrontError: no such engine, or no such method was measured; or the directions of errors are
            asked for and were not kept.
    """
    if engine is not None and engine not in engines():
        raise FrontError(f"unknown engine {engine!r}; {nearest(engine, engines())}")
    asked = [m for m in measured if engine is None or m.engine in (None, engine)]
    losses = {id(m): _loss(m, overestimation_costs) for m in asked}
    found = undominated(asked, lambda m: m.cpu.value, lambda m: losses[id(m)])
    if not found:
        raise FrontError("no such method was measured")
    return found


def on_front(measured: Iterable[Measured]) -> tuple[str, ...]:
    """Specs of the methods than which no cheaper one is as accurate, by rising CPU time.

    Args:
        measured: the methods; those that were not timed do not count.
    """
    timed = [entry for entry in measured if entry.cpu.n]
    return tuple(entry.method for entry in best(timed)) if timed else ()


def _loss(entry: Measured, overestimation_costs: float | None) -> float:
    """Number that is lower for better methods."""
    if overestimation_costs is None:
        return -entry.accuracy.value
    return error_cost(entry, overestimation_costs).value


def error_cost(entry: Measured, overestimation_costs: float) -> Estimate:
    """Expected cost of a method's errors a layout, where an underestimation costs 1.

    Raises:
        FrontError: the directions of its errors were not kept.
    """
    if entry.errors is None:
        raise FrontError(
            f"the measurement of {entry.method} on these layouts does not tell over- from "
            "underestimations, so that --overestimation-costs has nothing to go by; leave it out, "
            f"or measure anew. {_HOW_TO_MEASURE}"
        )
    return entry.errors.cost(overestimation_costs)


def recommend(
    front: Front,
    *,
    budget: float | None = None,
    accuracy: float | None = None,
    engine: str | None = None,
    overestimation_costs: float | None = None,
) -> Measured:
    """The method to use: the best one within a budget, or the cheapest that is accurate enough.

    The best one is the most accurate, or the one whose errors cost least.

    Args:
        front: the measurements.
        budget: CPU time that a layout may take [ms]; None for any.
        accuracy: share of cases that must be right; None for any. With a budget or a cost of
            errors, the result is the best method that meets all.
        engine: see :func:`best`.
        overestimation_costs: see :func:`best`.

    Raises:
        FrontError: no method meets the requirements; the message names the closest one. Or as
            :func:`best`.
    """
    best(front.measured, engine, overestimation_costs)  # all can be compared
    asked = best(front.measured, engine)
    if budget is not None and not any(m.cpu.value <= budget for m in asked):
        raise FrontError(
            f"budget is {budget:g} ms a layout; the cheapest measured: {described(asked[0])}. "
            f"{front.measured_on()}"
        )

    def is_cheap(m: Measured) -> bool:
        return budget is None or m.cpu.value <= budget

    def is_right(m: Measured) -> bool:
        return accuracy is None or m.accuracy.value >= accuracy

    cheap = [*filter(is_cheap, asked)]
    fit = [*filter(is_right, cheap)]
    if not fit:
        within = "" if budget is None else f" within {budget:g} ms"
        raise FrontError(
            f"accuracy is {100 * (accuracy or 0.0):g} %; the most accurate measured{within}: "
            f"{described(cheap[-1])}. {front.measured_on()}"
        )
    if overestimation_costs is not None:
        allowed = [m for m in front.measured if is_cheap(m) and is_right(m)]
        return best(allowed, engine, overestimation_costs)[-1]
    return fit[-1] if budget is not None or accuracy is None else fit[0]


def described(entry: Measured, overestimation_costs: float | None = None) -> str:
    """Sentence on the accuracy and cost of a method, and on what its errors cost."""
    share = entry.accuracy
    told = (
        f"{entry.method} is right in {100 * share.value:.1f} % of cases "
        f"[{100 * share.low:.1f}, {100 * share.high:.1f}] and takes {entry.cpu.value:.3g} ms"
    )
    if overestimation_costs is None:
        return told
    cost = error_cost(entry, overestimation_costs)
    return (
        f"{told}; its errors cost {cost.value:.3g} [{cost.low:.3g}, {cost.high:.3g}] a layout, "
        f"where an overestimation costs {overestimation_costs:g} and an underestimation 1"
    )
