"""The labelled cases that genotypes are judged on, in the order in which they are judged."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any

import pandas as pd

from steadyload.layouts.benchmark import Part, load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.model import Layout
from steadyload.layouts.question import Question


@dataclass(frozen=True, slots=True)
class Case:
    """A layout with its label.

    Attributes:
        layout: with its centres of mass.
        safe: items placed safely, all of them for a stable layout.
        scenario: where its centres of mass are from.
        instance: the item list that it was packed from.
        robust: whether all further methods agree with the label; None where none judged it.
    """

    layout: Layout
    safe: int
    scenario: str
    instance: str
    robust: bool | None


@dataclass(frozen=True, slots=True)
class CaseSource:
    """Source of cases: a part of a labelled set, and the set's folder, None for the shipped one.

    ``limit``: only so many a scenario, those of the first ranks. ``question``: whose labels count.
    """

    part: str = str(Part.VALIDATION)
    directory: str | None = None
    limit: int | None = None
    question: str = str(Question.WITHIN)

    def stored(self) -> dict[str, Any]:
        """The fields as they are stored; the question only where it is not the usual one."""
        found = asdict(self)
        if found["question"] == Question.WITHIN:
            del found["question"]
        return found


@cache
def load_cases(source: CaseSource) -> tuple[Case, ...]:
    """The cases with fragile labels first: on these parameter sets differ most, and soonest.

    Among the fragile and among the others scenarios take turns, so that a search that is
    interrupted, or a genotype that is given up, has seen all of them.

    Raises:
        BenchmarkError: not a labelled set, or it holds no such case.
    """
    benchmark = load_benchmark(source.directory)
    question = Question(source.question)
    chosen = benchmark.select(source.part, limit=source.limit, question=question)
    chosen = chosen.join(benchmark.confidence["robust"], on=KEYS)
    fragile = ~chosen["robust"].astype("boolean").fillna(True)
    turn = chosen.groupby(["scenario", fragile]).cumcount()
    chosen = chosen.assign(turn=turn, sure=~fragile).sort_values(["sure", "turn"], kind="stable")
    safe = chosen["failing_step"].fillna(chosen["item_count"]).astype(int)
    robust = [None if pd.isna(value) else bool(value) for value in chosen["robust"]]
    return tuple(
        Case(benchmark.layout(name, scenario), *rest)
        for name, scenario, *rest in zip(
            chosen["layout"], chosen["scenario"], safe, chosen["scenario"], chosen["instance"],
            robust, strict=True,
        )
    )  # fmt: skip


def fingerprint(cases: Iterable[Case]) -> str:
    """Hash of layouts and labels, in the order of the cases."""
    lines = "\n".join(f"{case.layout.content_hash()} {case.safe}" for case in cases)
    return hashlib.sha256(lines.encode()).hexdigest()[:16]
