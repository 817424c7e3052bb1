"""Which stage of a cascade decided how many steps and layouts, and how often it was right.

Shares are 0 to 1.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pandas as pd

from steadyload.layouts.model.layout import Layout
from steadyload.methods.cascade.cascade import Cascade, Decision
from steadyload.methods.cascade.thresholds import Ladder, Larger
from steadyload.methods.cascade.thresholds import Stage as LadderStage
from steadyload.methods.naming import method_key
from steadyload.methods.registry import make_method
from steadyload.statistics.metrics import share
from steadyload.statistics.placed import items_placed_by_case


def decisions_of(
    cascade: Cascade, cases: Iterable[tuple[str, Layout]], labels: pd.DataFrame
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Steps by the pair of thresholds that decided them, and layouts by the last one they needed:
    numbers as of :func:`_thresholds`.
    """
    listed = list(cases)
    cascade.prepare(max(len(layout) for _, layout in listed))
    known = _thresholds(cascade.ladder)
    of = {stage.method: stage for stage in reversed(_with_last(cascade.ladder))}
    placed = items_placed_by_case(labels["failing_step"], labels["item_count"])
    steps, layouts = [], []
    for scenario, layout in listed:
        label = labels.loc[(layout.name, scenario)]
        safe = int(placed[layout.name, scenario])
        decisions = cascade.decisions(layout)
        numbers = [known.index((own.stage, of[own.stage].at(own.step))) for own in decisions]
        steps += [
            (number, label["instance"], decision.step <= safe, _right(decision, safe))
            for number, decision in zip(numbers, decisions, strict=True)
        ]
        end = decisions[-1].step if decisions[-1].unstable else len(layout)
        layouts.append((max(numbers), label["instance"], end == safe))
    return (
        pd.DataFrame(steps, columns=["stage", "list", "labelled", "right"]),
        pd.DataFrame(layouts, columns=["stage", "list", "right"]),
    )


def _right(decision: Decision, safe: int) -> bool:
    return decision.unstable == (decision.step == safe)


def _with_last(ladder: Ladder) -> tuple[LadderStage, ...]:
    return (*ladder.stages, LadderStage(ladder.last, None, None))


def _thresholds(ladder: Ladder) -> list[tuple[str, Larger]]:
    """Every pair of thresholds, with its method: of each stage by size, and none of the last."""
    return [(stage.method, each) for stage in _with_last(ladder) for each in stage.ranges]


def stages_of(cascade: Cascade, steps: pd.DataFrame, layouts: pd.DataFrame) -> pd.DataFrame:
    """Stages and their pairs of thresholds, of the tables of :func:`decisions_of`.

    Returns:
        ``stage``; ``low``, ``high``: a step of a lower score is stable, of a higher one unstable;
        missing where it never accepts or rejects, both of the last one, for what is left;
        ``stage_steps``: share of all steps that it decided; ``steps_right``: of these, up to the
        label's failing step; ``stage_layouts``: share of layouts that needed it and no later one;
        ``layouts_right``: of these.
    """
    known, found = _thresholds(cascade.ladder), []
    for number, (method, each) in enumerate(known):
        if (each.low, each.high) == (None, None) and number + 1 < len(known):
            continue
        own = steps[(steps["stage"] == number) & steps["labelled"]]
        needed = layouts[layouts["stage"] == number]
        title = method_key(make_method(method)).title
        found.append(
            {
                "stage": f"{title} above {each.above} items" if each.above else title,
                "low": each.low,
                "high": each.high,
                "stage_steps": share(np.asarray(steps["stage"] == number), steps["list"]),
                "steps_right": share(own["right"], own["list"]),
                "stage_layouts": share(np.asarray(layouts["stage"] == number), layouts["list"]),
                "layouts_right": share(needed["right"], needed["list"]),
            }
        )
    return pd.DataFrame(found)
