"""Rows of the tables and charts of an evaluation. Shares are 0 to 1, times in ms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

from steadyload.methods.naming import MethodKey
from steadyload.reports.columns import (
    cell,
    column,
    compact,
    factor,
    milliseconds,
    percent,
    plain_percent,
    row,
    significant,
)
from steadyload.runs.comparison import PairTest
from steadyload.runs.evaluation import (
    MethodEvaluation,
)
from steadyload.statistics.estimate import Estimate
from steadyload.studies.evaluation.costing import Cost, Growth

_whole = partial(plain_percent, digits=0)


def _share(found: Estimate | str | None) -> str:
    return factor(found) if isinstance(found, Estimate) else cell(found)


def _alarms(found: Estimate) -> str:
    return f"{percent(found)}, n {found.n}"


@row
class NoVerdict:
    """Cases on which a method ended with one status; ``reason`` of that with most boxes."""

    method: str = column()
    status: str = column()
    cases: int = column()
    boxes: str = column(left=False)
    reason: str = column("reason, with most boxes")


@row
class Failing:
    """Share of cases whose label is a failing step."""

    label: str = column()
    share: Estimate = column("fails %", percent)


@row
class Result:
    """One method on a group of cases; what is by class, size, margin or ratio is of all cases.

    Attributes:
        own: accuracy, errors and cost.
        share: CPU time over that of the yardstick on the same cases; 1 for itself.
        mean_cpu: CPU time by number of boxes; empty where times are of a timing pass.
        cost_at: expected cost of errors, by the cost of an overestimation.
        alarms: false alarms on steps that do not balance, by margin.
        beside: accuracy in the paper and here, by group.
        failing: accuracy on cases whose label is a failing step.
        multiple: CPU time over that of the unit of the timing pass on the same cases.
        body_substeps: engine steps times the boxes that take part, mean over all cases; None of a
            method without them.
        cost, growth: CPU time of judging, in the timing pass or with a time limit, and its growth.
        versus: the test against one method; None where all pairs are tested, and for that method.
    """

    own: MethodEvaluation
    paper: float | None = column("paper %", partial(plain_percent, digits=2))
    letters: str | None = column()
    share: Estimate | str | None = column(form=_share)
    classes: Mapping[str, Estimate] = column("class {}", percent, default_factory=dict)
    sizes: Mapping[str, Estimate] = column("{}", percent, default_factory=dict)
    mean_cpu: Mapping[str, Estimate] = column("{}", milliseconds, default_factory=dict)
    scenarios: Mapping[str, Estimate] = column("{} %", percent, default_factory=dict)
    cpu_by: Mapping[str, float | None] = column("{} CPU ms", significant, default_factory=dict)
    cost_at: Mapping[str, Estimate | None] = column("cost at {}", factor, default_factory=dict)
    alarms: Mapping[str, Estimate] = column("{}", _alarms, default_factory=dict)
    fragile_errors: str | None = column("errors on fragile labels %", default=None)
    multiple: Estimate | None = column("multiple", factor, default=None)
    body_substeps: Estimate | None = column("body-substeps", factor, default=None)
    spread: float | None = column("spread of repeats %", _whole, default=None)
    beside: Mapping[str, str] = column("{} %, paper / ours", default_factory=dict)
    paper_wall: float | None = column("paper, wall ms", compact, default=None)
    paper_share: float | None = column("paper, of its PS_3", compact, default=None)
    versus: PairTest[MethodKey] | None = None
    failing: Estimate | None = column("failing: accuracy %", percent, default=None)
    cost: Cost | None = None
    growth: Growth | None = None

    @property
    def spread_of_cost(self) -> str:
        """Median and 90 % of the cost in words; empty where they are not known."""
        if self.cost is None:
            return ""
        median, ninety = map(significant, (self.cost.median, self.cost.ninety))
        return f"median {median} ms, 90 % within {ninety} ms"

    @property
    def ratio(self) -> str | None:
        """The share without its interval."""
        return compact(self.share.value) if isinstance(self.share, Estimate) else self.share


@row
class Point:
    """A value of a method at a place of a curve."""

    method: MethodKey
    title: str
    x: float | str
    value: Estimate | float | None


@row
class Cell:
    """A share or a difference of shares in a matrix; a pale one is not significant."""

    line: str
    place: str
    value: Estimate
    pale: bool = False


@row
class Against:
    """A method compared with one other; ``scenarios``: difference [points] and corrected p."""

    test: PairTest[MethodKey]
    scenarios: Mapping[str, str] = column("{}")


@row
class Cheapest:
    """The ratios of the costs of errors at which a method is the cheapest one."""

    least: float = column("ratio from", compact)
    most: float = column("to", compact)
    own: MethodEvaluation


@row
class Beside:
    """A method and the paper's of its name, on a group of cases; ``printed``: of the paper."""

    own: MethodEvaluation
    group: str
    printed: Sequence[float]


@row
class Timing:
    """The timing pass besides the times in the rows of the evaluation.

    Attributes:
        yardstick: the method that shares refer to; None where it was not timed.
        unit: the method that multiples refer to; None where it was not timed.
        multiples: by spec, CPU time over that of the unit on the same cases.
        spread: by spec, largest minus smallest mean of a repeat, over the mean.
        untimed: methods without times, with the reason.
        refused: of methods with times, cases that they refuse; no method was timed on those.
        load: sentence on what else the machine did.
        made_with: provenance of the times; empty where it is not known.
    """

    yardstick: MethodKey | None
    shares: Mapping[str, Mapping[str, Estimate]]
    unit: MethodKey | None
    multiples: Mapping[str, Estimate]
    spread: Mapping[str, float]
    layouts: int
    item_lists: int
    repeats: int
    block: int
    untimed: Mapping[str, str]
    refused: Mapping[str, int]
    load: str
    made_with: Mapping[str, str]
