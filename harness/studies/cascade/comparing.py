"""Accuracy and cost of a cascade, its stages' decisions, and what its thresholds were fitted on.

Shares are 0 to 1, times in ms a layout.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import pandas as pd

from steadyload.layouts.benchmark.parts import Part, set_named
from steadyload.methods.cascade.cascade import Cascade
from steadyload.methods.cascade.thresholds import Ladder
from steadyload.methods.contract.spec import parse_spec
from steadyload.methods.registry import make_method
from steadyload.reports.columns import factor, general, milliseconds, names, percent
from steadyload.runs import frames as v
from steadyload.runs.costs import CostKind, CostSource
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.judged import load_judged
from steadyload.runs.labels import labelled_cases, load_labels
from steadyload.runs.provenance import provenance_lines, source_line
from steadyload.runs.runner import run_study
from steadyload.runs.timing import load_while
from steadyload.statistics.paired import detectable
from steadyload.studies.cascade.stages import decisions_of, stages_of
from steadyload.studies.kit import Lab

CASCADE = "cascade@mujoco"

BESIDE = (
    "fbs", "sme", "equilibrium", "lstm_1", "lstm_e", "equilibrium:time=0.3", "ps_opt@mujoco",
    "ps3@mujoco",
)  # fmt: skip
"""Methods that the cascade is compared with."""

DIRECTORY, PART = "lists", Part.TEST
"""Of the labelled set; no stage has learnt from it."""

LIMIT = 300
"""Cases a scenario."""

WITHIN = 0.005
"""Aim: largest difference of accuracy to the most accurate simulation."""

MOST = 1.0
"""Aim: largest cost [ms a layout]."""

NEAR = 0.01
"""Largest difference to the best accuracy at which a simulation counts as accurate."""

TENTH = 0.1
"""Aim: largest share of the cost of the cheapest accurate simulation."""

_TURN = 150
"""Cases that a method judges before it is the next one's turn; a switch of methods costs time."""


class Found(SimpleNamespace):
    """All that the page shows."""

    made_with: Mapping[str, str]


def compare(lab: Lab, limit: int | None) -> Found:
    """Judge a part of the labelled set, methods in turns.

    An interrupted study is resumed; methods that were judged keep their times.
    """
    cascade = _cascade()
    made_by, ladders = cascade.thresholds.made_by, cascade.thresholds.ladders
    own, default = str(cascade.spec), cascade.thresholds.default
    budgets = {own: default} | {str(_cascade(b).spec): b for b in ladders if b != default}
    definition = StudyDefinition(
        name="cascade",
        methods=(*budgets, *BESIDE),
        benchmark=PART,
        benchmark_directory=set_named(DIRECTORY),
        limit=limit or LIMIT,
        shard_size=_TURN,
    )
    run = lab.work / "run"
    load = load_while(
        lambda: run_study(
            definition, run, workers=lab.workers, progress=lambda *of: lab.progress("judging", *of)
        ),
        lab.work / "load.json",
    )
    judged, labels = load_judged(run), load_labels(run)
    item_lists = labels["instance"].nunique()
    rows = _by_method(v.costed(judged), own, item_lists)
    swept = sorted(budgets, key=budgets.__getitem__)
    others = rows.drop(index=swept)
    simulations = others[others["key"].map(lambda key: key.engine is not None)]
    steps, layouts = decisions_of(cascade, labelled_cases(definition), labels)
    fitted_on = [made_by.get("directory") or "", *made_by["data"]]  # sets; empty: the large one
    budget, first = next(iter(ladders.items()))
    return Found(
        part=f"{DIRECTORY} {PART}".strip(),
        cases=len(labels),
        item_lists=item_lists,
        cascade=rows.loc[own],
        swept=rows.loc[swept].assign(budget=[general(budgets[spec]) for spec in swept]),
        others=others,
        beside=rows.loc[[own, *others.index]],
        best=simulations.loc[v.best(simulations["right"])],
        aims=aims(rows.loc[own], simulations),
        stages=stages_of(cascade, steps, layouts),
        steps_a_layout=len(steps) / len(layouts),
        ladders=pd.DataFrame([_fitted(own, ladder) for own, ladder in ladders.items()]),
        first={**first.found, "last": first.last, "budget": general(budget)},
        **{
            name: pd.DataFrame(first.found.get(name, ())).rename(columns=_OF_FITTED)
            for name in ("decided", "elsewhere", "left_out_by_size")
        },
        confidence=float(made_by["confidence"]),
        costs=CostSource(CostKind.IN_TURNS, load=load).explained(),
        made_with={
            **provenance_lines(judged.manifest),
            "thresholds fitted by": source_line(made_by),
            "thresholds fitted on": f"{', '.join(name or 'the large set' for name in fitted_on)}; "
            f"cases {made_by['cases']}",
        },
    )


_OF_FITTED = {
    "method": "stage", "lost": "lost_cases", "item_lists": "lists", "steps": "counted_steps",
}  # fmt: skip
"""Columns of an evaluation of thresholds -> those of pages."""


def _cascade(budget: float | None = None) -> Cascade:
    spec = parse_spec(CASCADE)
    made = make_method(spec if budget is None else spec.stating("budget", f"{budget:g}"))
    assert isinstance(made, Cascade)
    return made


def _by_method(frame: pd.DataFrame, cascade: str, item_lists: int) -> pd.DataFrame:
    """A row a method, and how the cascade compares with it on the same cases.

    Returns:
        ``ahead``: accuracy of the cascade minus its; ``shown``: the least difference that the cases
        show; ``cost_ratio``: CPU time of the cascade over its; missing of the cascade itself.
        ``substeps``: of the engine, mean a layout.
    """
    by = ["method"]
    theirs = v.beside(frame, "right", cascade).astype(float)
    other = frame.assign(
        ahead=theirs - frame["right"].astype(float), of_cascade=v.beside(frame, "cpu", cascade)
    )
    other = other[other["method"] != cascade]
    found = v.by_method(frame, ["right"]).assign(
        cpu=v.mean(frame, "cpu", by),
        ahead=v.mean(other, "ahead", by),
        cost_ratio=v.ratio(other, "of_cascade", "cpu", by),
        substeps=frame.groupby("method")["substeps"].mean().replace(0.0, math.nan),
    )
    shown = found["ahead"].map(lambda one: detectable(one, item_lists), na_action="ignore")
    return found.assign(shown=shown)


def aims(own: pd.Series, simulations: pd.DataFrame) -> pd.DataFrame:
    """Aims of a cascade; decided by the ends of intervals, because a point proves nothing."""
    right = v.values(simulations["right"])
    best = simulations.loc[right.idxmax()]
    accurate = simulations[right >= right.max() - NEAR]
    cheapest = accurate.loc[v.values(accurate["cpu"]).idxmin()]
    ahead, cpu, cost = best["ahead"], own["cpu"], cheapest["cost_ratio"]
    found = [
        (
            f"no more than {100 * WITHIN:g} points behind the most accurate simulation, "
            f"{best['title']}",
            f"{percent(ahead)} points",
            _reached(-ahead.high, -ahead.low, WITHIN),
        ),
        (
            f"no more than {MOST:g} ms a layout",
            f"{milliseconds(cpu)} ms",
            _reached(cpu.low, cpu.high, MOST),
        ),
        (
            f"no more than {TENTH:g} of the CPU time of the cheapest simulation within "
            f"{100 * NEAR:g} point of the best, {cheapest['title']}",
            factor(cost),
            _reached(cost.low, cost.high, TENTH),
        ),
    ]
    return pd.DataFrame(found, columns=["aim", "measured", "reached"])


def _reached(low: float, high: float, most: float) -> str:
    """Whether what should be small is at most a value, by the ends of its interval."""
    if high <= most:
        return "yes"
    return "no" if low > most else "open"


def _fitted(budget: float, ladder: Ladder) -> dict[str, Any]:
    """Thresholds for a budget [points], as their file describes them."""
    known = ladder.found
    return {
        **{name: known[name] for name in ("gained", "bound", "sure_bound", "alone")},
        "budget": general(budget),
        "before_last": names(map(str, ladder.stages)),
        "losses": f"{known['lost']} ({known['allowed']})",
        "left_out": "{lost} of {cases}".format(**known["left_out"]),
        "together": known["accuracy"],
        "step_times": known["milliseconds"],
        "step_times_alone": known["milliseconds_alone"],
    }
