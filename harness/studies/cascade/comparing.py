"""Accuracy and cost of a cascade, its stages' decisions, and what its thresholds were fitted on.

Shares are 0 to 1, times in ms a layout.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from steadyload.config import bind
from steadyload.errors import nearest
from steadyload.layouts.benchmark.parts import UNLEARNT, Part, set_named
from steadyload.methods.cascade.cascade import Cascade
from steadyload.methods.cascade.thresholds import Ladder
from steadyload.methods.naming import MethodKey
from steadyload.methods.registry import make_method
from steadyload.reports.columns import (
    column,
    compact,
    factor,
    fixed,
    general,
    milliseconds,
    names,
    percent,
    plain_percent,
    row,
    shown_column,
)  # fmt: skip
from steadyload.runs.comparison import detectable
from steadyload.runs.costs import CostKind, CostSource
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import MethodEvaluation, evaluate
from steadyload.runs.labels import labelled_cases, load_labels
from steadyload.runs.provenance import provenance_lines, source_line
from steadyload.runs.runner import run_study
from steadyload.runs.timing import load_while
from steadyload.statistics.estimate import Estimate
from steadyload.studies.cascade.stages import Stage, decisions_of, stages_of
from steadyload.studies.kit import Lab
from steadyload.tuning import TuningError

BESIDE = (
    "fbs", "sme", "equilibrium", "lstm_1", "lstm_e", "equilibrium:time=0.3", "ps_opt@{engine}",
    "ps3@{engine}",
)  # fmt: skip
"""Methods that a cascade is compared with."""

WITHIN = 0.005
"""Aim: largest difference of accuracy to the most accurate simulation."""

LIMIT = 1.0
"""Aim: largest cost [ms a layout]."""

NEAR = 0.01
"""Largest difference to the best accuracy at which a simulation counts as accurate."""

TENTH = 0.1
"""Aim: largest share of the cost of the cheapest accurate simulation."""

_TURN = 150
"""Cases that a method judges before it is the next one's turn; a switch of methods costs time."""

_three = partial(compact, digits=3)
_hundredths = partial(plain_percent, digits=2)


@row
class Judged:
    """A method, and how the cascade compares with it on the same cases."""

    method: MethodKey
    title: str = column("method")
    n: int = column()
    accuracy: Estimate = column("accuracy %", percent)
    cpu: Estimate = column("CPU ms", milliseconds)
    ahead: Estimate | None = column("cascade ahead", percent, "accuracy of the cascade minus its")
    shown: float | None = shown_column()
    cost_ratio: Estimate | None = column("share of its time", factor, "CPU time of the cascade")
    substeps: float | None = column(
        form=lambda count: fixed(count, 1), about="of the engine, mean a layout; None without one"
    )
    budget: str = column("budget, points", about="of a cascade; empty for other methods")


@row
class Decided:
    """Steps that a stage decided on the fitted cases, those of them wrong, and lost cases."""

    method: str = column("stage")
    steps: int = column()
    wrong: int = column()
    lost: int = column("cases lost")


@row
class Held:
    """A stage that is not trained on labels, evaluated at every step of other cases."""

    method: str = column("stage")
    cases: int = column()
    item_lists: int = column("item lists")
    steps: int = column()
    decided: int = column()
    wrong: int = column()


@row
class LeftOut:
    """Cases of item lists that thresholds were fitted without, by their number of boxes."""

    above: int = column("boxes above", about="and up to the next number")
    lost: int = column()
    cases: int = column()


@row
class Fitted:
    """Thresholds as they were fitted, for one budget; fields as in the file of thresholds."""

    budget: str = column("budget, points")
    stages: str = column("stages before the last")
    losses: tuple[int, int] = column(
        "lost (allowed)", "{0[0]} ({0[1]})".format, "cases where the last method alone is right"
    )
    gained: int = column(about="the other way round")
    bound: float = column("bound %", _hundredths, "of the share of lost cases, as configured")
    sure_bound: float = column("95 % bound %", _hundredths)
    left_out: Mapping[str, int] = column(
        "left out lost",
        "{0[lost]} of {0[cases]}".format,
        "where an item list is judged by thresholds that were fitted without it",
    )
    accuracy: float = column("accuracy %", plain_percent)
    alone: float = column("last alone %", plain_percent)
    milliseconds: float = column("CPU ms", _three, "from the times of single steps")
    milliseconds_alone: float = column("last alone", _three)
    last: str
    cases: int
    item_lists: int
    independent: float
    decided: tuple[Decided, ...]
    elsewhere: tuple[Held, ...]
    left_out_by_size: tuple[LeftOut, ...] = ()


class Aim(NamedTuple):
    """An aim, the measured value, and whether it is reached: yes, no or open."""

    aim: str
    measured: str
    reached: str


@row
class Found:
    """A cascade on a part of a labelled set, beside other methods.

    ``part``: after the name of the set unless it is the package's large one. ``fitted_there``: it
    is of a set that thresholds were fitted on, and no test part. ``swept``: the cascade at all
    budgets, by rising budget. ``best``: the most accurate simulation. ``confidence``: of bounds.
    """

    part: str
    fitted_there: bool
    cases: int
    item_lists: int
    cascade: Judged
    swept: Sequence[Judged]
    others: Sequence[Judged]
    best: Judged
    aims: Sequence[Aim]
    stages: Sequence[Stage]
    steps_a_layout: float
    ladders: Sequence[Fitted]
    confidence: float
    cost_source: CostSource
    made_with: Mapping[str, str]


def compare(
    lab: Lab,
    engine: str,
    *,
    methods: Sequence[str] = (),
    directory: str = "",
    part: str = Part.TEST,
    limit: int | None = None,
    thresholds: Path | None = None,
    beside: Sequence[str] = BESIDE,
) -> Found:
    """Judge a part of the labelled set, methods in turns.

    An interrupted study is resumed; methods that were judged keep their times.

    Args:
        lab: where it runs; with 0 or 1 workers times are taken in one process.
        engine: of the cascade.
        methods: specs of further methods.
        directory: of the labelled set, see :func:`steadyload.layouts.benchmark.dataset.set_named`.
        part: of the labelled set, one that no stage has learnt from.
        limit: largest number of cases a scenario; None for all.
        thresholds: file of thresholds; None for those that come with the package.
        beside: specs of the methods that the cascade is compared with, ``{engine}`` for the engine.

    Raises:
        TuningError: the part is one on which methods are trained or tuned.
        ThresholdsError: no thresholds for the engine, or ones fitted with other methods.
        as :func:`steadyload.runs.runner.run_study`.
    """
    if part not in UNLEARNT:
        raise TuningError(f"part is {part!r}; {nearest(part, UNLEARNT)}")
    cascade = _cascade(engine, thresholds)
    made_by, ladders = cascade.thresholds.made_by, cascade.thresholds.ladders
    own, default = str(cascade.spec), cascade.thresholds.default
    swept = [budget for budget in ladders if budget != default]
    budgets = {own: default} | {str(_cascade(engine, thresholds, b).spec): b for b in swept}
    named = [spec.replace("{engine}", engine) for spec in beside]
    definition = StudyDefinition(
        name="cascade",
        methods=tuple(dict.fromkeys([*budgets, *named, *methods])),
        benchmark=part,
        benchmark_directory=set_named(directory),
        limit=limit,
        shard_size=_TURN,
    )
    run = lab.work / "run"
    load = load_while(
        lambda: run_study(
            definition, run, workers=lab.workers, progress=lambda *of: lab.progress("judging", *of)
        ),
        lab.work / "load.json",
    )
    source = CostSource(CostKind.IN_TURNS, load=load)
    evaluation = evaluate(run, source=source, by_scenario=False)
    labels = load_labels(run)
    item_lists = labels["instance"].nunique()
    rows = [
        _row(evaluation.row(spec, against=own), budgets.get(spec), item_lists)
        for spec in definition.methods
    ]
    others = [method for method in rows if not method.budget]
    simulations = [method for method in others if method.method.engine]
    steps, layouts = decisions_of(cascade, labelled_cases(definition), labels)
    fitted_on = [made_by.get("directory") or "", *made_by["data"]]  # sets; empty: the large one
    return Found(
        part=f"{directory} {part}".strip(),
        fitted_there=part != Part.TEST and directory in fitted_on,
        cases=len(labels),
        item_lists=item_lists,
        cascade=rows[0],
        swept=sorted((m for m in rows if m.budget), key=lambda method: float(method.budget)),
        others=others,
        best=max(simulations, key=lambda method: method.accuracy.value),
        aims=aims(rows[0], simulations),
        stages=list(stages_of(cascade, steps, layouts)),
        steps_a_layout=len(steps) / len(layouts),
        ladders=[_fitted(budget, ladder) for budget, ladder in ladders.items()],
        confidence=float(made_by["confidence"]),
        cost_source=evaluation.cost_source,
        made_with={
            **provenance_lines(evaluation.judged.manifest),
            "thresholds fitted by": source_line(made_by),
            "thresholds fitted on": f"{', '.join(name or 'the large set' for name in fitted_on)}; "
            f"cases {made_by['cases']}",
        },
    )


def aims(own: Judged, simulations: Sequence[Judged]) -> list[Aim]:
    """Aims of a cascade; decided by the ends of intervals, because a point proves nothing."""
    best = max(simulations, key=lambda method: method.accuracy.value)
    least = best.accuracy.value - NEAR
    accurate = [method for method in simulations if method.accuracy.value >= least]
    cheapest = min(accurate, key=lambda method: method.cpu.value)
    assert best.ahead is not None
    assert cheapest.cost_ratio is not None
    return [
        Aim(
            f"no more than {100 * WITHIN:g} points behind the most accurate simulation, "
            f"{best.title}",
            f"{percent(best.ahead)} points",
            _reached(-best.ahead.high, -best.ahead.low, WITHIN),
        ),
        Aim(
            f"no more than {LIMIT:g} ms a layout",
            f"{milliseconds(own.cpu)} ms",
            _reached(own.cpu.low, own.cpu.high, LIMIT),
        ),
        Aim(
            f"no more than {TENTH:g} of the CPU time of the cheapest simulation within "
            f"{100 * NEAR:g} point of the best, {cheapest.title}",
            factor(cheapest.cost_ratio),
            _reached(cheapest.cost_ratio.low, cheapest.cost_ratio.high, TENTH),
        ),
    ]


def _reached(low: float, high: float, most: float) -> str:
    """Whether what should be small is at most a value, by the ends of its interval."""
    if high <= most:
        return "yes"
    return "no" if low > most else "open"


def _cascade(engine: str, thresholds: Path | None, budget: float | None = None) -> Cascade:
    values = [f"thresholds={thresholds}"] if thresholds else []
    values += [] if budget is None else [f"budget={budget:g}"]
    made = make_method(f"cascade@{engine}{':' if values else ''}{','.join(values)}")
    assert isinstance(made, Cascade)
    return made


def _row(found: MethodEvaluation, budget: float | None, item_lists: int) -> Judged:
    """A method as it is shown; ``budget`` of a cascade [points]."""
    same = ("method", "accuracy", "cpu", "ahead", "cost_ratio")
    return Judged(
        **{name: getattr(found, name) for name in same},
        title=found.method.title,
        n=found.accuracy.n,
        shown=None if found.ahead is None else detectable(found.ahead, item_lists),
        substeps=found.substeps or None,
        budget="" if budget is None else general(budget),
    )


def _fitted(budget: float, ladder: Ladder) -> Fitted:
    """Thresholds for a budget [points], as their file describes them."""
    known = dict(ladder.found)
    values = {
        "losses": (known.pop("lost"), known.pop("allowed")),
        "budget": general(budget),
        "stages": names(map(str, ladder.stages)),
        "last": ladder.last,
    }
    return bind(Fitted, known | values, f"thresholds for {budget:g} points")
