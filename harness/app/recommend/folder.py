"""Measurements in the folder of a study on labelled sets."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from steadyload.app.recommend.front import Front, FrontError
from steadyload.app.recommend.kept import NAME, REAL, SMALL, SPATIAL, load_fronts
from steadyload.app.recommend.measured import front_of
from steadyload.layouts.model.question import Question
from steadyload.layouts.sizes import FINE_SIZES
from steadyload.runs import frames as v
from steadyload.runs.costs import CPU, limited_costs
from steadyload.runs.judged import load_judged, manifest_lines
from steadyload.statistics.metrics import median


def measured_in(run: str | Path) -> tuple[Front, ...]:
    """Measurements of a folder, from its :data:`NAME` where it has one.

    Args:
        run: work folder of an evaluation, or the run folder of a study on a labelled set.

    Raises:
        ResultsError: not such a folder, or no case in it has been judged by all methods yet.
        FrontError: its layouts have no labels, its :data:`NAME` is damaged, or it is an
            evaluation that is not complete yet.
    """
    run = Path(run)
    if (kept := run / NAME).exists():
        return load_fronts(kept)
    if (run / SPATIAL).exists():
        raise FrontError(
            f"{run}: the evaluation is not complete there; go on with steadyload study evaluation "
            f"--work {run}"
        )
    if (run / REAL).exists():
        folders = [folder for name in (SMALL, REAL) if (folder := run / name).exists()]
        return tuple(front for folder in folders for front in _fronts(folder, medians=True))
    return tuple(_fronts(run, medians=False))


def _fronts(folder: Path, *, medians: bool) -> Iterator[Front]:
    """A front a bin of the number of boxes and question.

    CPU times are means over its cases, as on the page of a comparison; or medians over all cases
    of the bin, as where judgements have a time limit.
    """
    judged = load_judged(folder)
    if judged.labels is None:
        raise FrontError(f"{folder}: its layouts have no labels, so that no accuracy is known")
    place = np.searchsorted(FINE_SIZES, judged.labels["item_count"].to_numpy(int))
    for number in np.unique(place):
        of_size = judged.only(place == number)
        for question in Question:
            asked = of_size.asked(question)
            if asked.said.empty:
                continue
            frame, times = v.costed(asked), "mean of judging"
            rows = v.by_method(frame, ("right", "over", "under_or_none"))
            rows["cpu"] = v.mean(frame, "cpu", ["method"])
            if medians:
                limit = float(judged.manifest["study"]["timeout"])
                taken = limited_costs(of_size.results, limit).milliseconds
                cpu = {spec: median(own[CPU]) for spec, own in taken.items()}
                rows["cpu"] = pd.Series(cpu, dtype=object)
                times = f"median of judging, given up after {limit:g} s"
            yield front_of(asked, question, rows, times, manifest_lines(judged))
