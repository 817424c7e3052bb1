"""The timing pass, as a page tells of it."""

from __future__ import annotations

import numpy as np
import pandas as pd

from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.runs.costs import load_explained
from steadyload.runs.evaluation import Evaluation
from steadyload.runs.timing import BLOCK
from steadyload.studies.evaluation.judged_set import YARDSTICK
from steadyload.studies.evaluation.judging import Options, Timed
from steadyload.studies.evaluation.rows import Timing

UNIT = "sme"
"""The method whose time on the same processor is a unit that other machines have, too."""


def timing_of(asked: Options, timed: Timed, evaluation: Evaluation) -> Timing:
    """The timing pass besides the times that rows of the evaluation have.

    Args:
        asked: the options.
        timed: the times.
        evaluation: with these for costs.
    """
    cpu = timed.times.cpu
    yardstick = evaluation.judged.keys.get(YARDSTICK) if YARDSTICK in cpu else None
    others = [spec for spec in cpu if yardstick is not None and spec != YARDSTICK]
    unit = evaluation.judged.keys.get(UNIT) if UNIT in cpu else None
    by_repeat = {spec: own.mean(axis=1) for spec, own in cpu.items()}
    cases = pd.MultiIndex.from_tuples(timed.cases, names=KEYS)
    return Timing(
        yardstick=yardstick,
        shares={
            group: {spec: evaluation.cost_ratio(spec, YARDSTICK, group) for spec in others}
            for group in evaluation.groups
        },
        unit=unit,
        multiples={} if unit is None else {spec: evaluation.cost_ratio(spec, UNIT) for spec in cpu},
        spread={spec: float(np.ptp(means) / means.mean()) for spec, means in by_repeat.items()},
        layouts=len(timed.cases),
        item_lists=evaluation.judged.clusters.loc[cases].nunique(),
        repeats=asked.repeats,
        block=BLOCK,
        untimed=timed.untimed,
        refused=timed.refused,
        load=load_explained(evaluation.cost_source.load),
        made_with=timed.times.made_with,
    )
