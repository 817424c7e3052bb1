"""Sources of the differences between verdicts: engine, parameters, question, and luck of the case.

Every case is judged by one loading algorithm under every combination of some engines, parameter
sets and questions, and the differences are put down to them
(:mod:`steadyload.statistics.variance`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import LISTS, REAL, Part, set_named
from steadyload.layouts.model.question import Question, with_question
from steadyload.methods.registry import make_method
from steadyload.methods.tuned import EQUAL, TUNED, tuned_engines
from steadyload.runs.judged import JudgedCases
from steadyload.runs.labels import Cases
from steadyload.statistics import metrics
from steadyload.statistics.variance import source_shares
from steadyload.studies.kit import Lab


@dataclass(frozen=True)
class Design:
    """Combinations under which the cases of one labelled set are judged.

    Attributes:
        labelled_set: a word of :data:`steadyload.layouts.benchmark.dataset.SETS`.
        parameters: names of parameter sets.
        questions: that are asked; each parameter set answers all of them.
    """

    labelled_set: str
    parameters: tuple[str, ...]
    questions: tuple[Question, ...]

    @property
    def levels(self) -> dict[str, tuple[str, ...]]:
        """The levels of every factor that has two or more."""
        engines, parameters, questions = tuned_engines(), self.parameters, self.questions
        found = {"engine": engines, "parameters": parameters, "question": questions}
        return {factor: own for factor, own in found.items() if len(own) > 1}

    def specs(self) -> list[str]:
        """Methods, in the order of the levels, the last factor's first."""
        return [
            str(make_method(with_question(f"{parameters}@{engine}", question)).spec)
            for engine, parameters, question in product(
                tuned_engines(), self.parameters, self.questions
            )
        ]


DESIGNS = (
    Design(LISTS, ("ps3-literal", "ps_opt-paper", EQUAL, "label"), (Question.WITHIN,)),
    Design(LISTS, (EQUAL, "label"), (Question.WITHIN,)),
    Design(LISTS, (TUNED, "label"), (Question.WITHIN,)),
    Design(LISTS, (TUNED, "label"), (Question.WITHIN, Question.STANDS)),
    Design(REAL, (TUNED,), (Question.WITHIN, Question.STANDS)),
)
"""The first is of all parameter sets, of which two stop at other times and thresholds than the
label; the second of those that follow the label; the third shows how much depends on the searches,
by parameters whose searches differed from engine to engine. On real pallets only the tuned
parameters: others take DART minutes a pallet."""

ANSWERS: Mapping[str, Callable[[NDArray[np.float64]], NDArray[np.float64]]] = {
    "share of items placed": lambda placed: placed,
    "stable or not": lambda placed: (placed == 1.0).astype(float),
}
"""Numbers that a verdict is taken as, from the share of items placed safely, by name; the one that
the page speaks of comes first."""


def sources_of_differences(judged: Mapping[str, JudgedCases]) -> list[dict[str, Any]]:
    """Share out the differences between verdicts, by design and by what a verdict is taken as."""
    return [
        table_of(judged[design.labelled_set], design, answer)
        for design in DESIGNS
        for answer in ANSWERS
    ]


def judged_by_designs(lab: Lab, name: str, limit: int) -> JudgedCases:
    """Judge cases of part test, on which nothing was tuned, by the methods of a set's designs."""
    designs = [design for design in DESIGNS if design.labelled_set == name]
    return lab.judge(
        tuple(dict.fromkeys(spec for design in designs for spec in design.specs())),
        Cases(load_benchmark(set_named(name)), Part.TEST, limit=limit),
        folder=f"sources/{name}",
        name=f"sources of differences, {name}",
        shard_size=20,
    ).judged


def table_of(judged: JudgedCases, design: Design, answer: str) -> dict[str, Any]:
    """Shares of the sources in the differences between some verdicts of a run.

    Returns:
        ``shares``: a row a source: one factor, or several together; ``freedom`` is of a case.
        ``cases``, ``item_lists``: on which all have a verdict; ``left_out``: cases on which one has
        none; ``differing``: share of the cases on which not all verdicts are the same; ``largest``:
        the single factor with the largest share.
    """
    specs = design.specs()
    whole = judged.said[specs].notna().all(axis=1).to_numpy(bool)
    kept = judged.only(whole)
    assert kept.labels is not None, "the run is on a labelled set"
    counts = kept.labels["item_count"]
    numbers = ANSWERS[answer](kept.said[specs].to_numpy(float) / counts.to_numpy(float)[:, None])
    levels = design.levels
    shape = (len(numbers), *map(len, levels.values()))
    found = source_shares(numbers.reshape(shape), tuple(levels), kept.clusters)
    rows = [
        {
            "title": " with ".join(own.factors),
            **{name: getattr(own, name) for name in ("whole", "always", "by_case", "component")},
            "freedom": math.prod(len(levels[factor]) - 1 for factor in own.factors),
        }
        for own in found
    ]
    single = {own.factors[0]: own.whole.value for own in found if len(own.factors) == 1}
    return {
        "design": design, "answer": answer, "cases": len(numbers),
        "item_lists": kept.clusters.nunique(), "left_out": int((~whole).sum()),
        "differing": metrics.share((numbers != numbers[:, :1]).any(axis=1), kept.clusters),
        "largest": max(single, key=single.__getitem__),
        "shares": pd.DataFrame(rows).assign(
            design=f"{design.labelled_set} (n = {len(numbers)}): {', '.join(design.parameters)}; "
            f"{' and '.join(design.questions)}"
        ),
    }  # fmt: skip
