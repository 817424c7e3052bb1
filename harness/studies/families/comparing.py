"""Verdicts on families of layouts compared with those of the reference, by family and together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import attrgetter

import numpy as np

from steadyload.layouts.packing.families import FAMILIES
from steadyload.methods.contract.method import Status
from steadyload.methods.naming import MethodKey
from steadyload.methods.registry import make_method
from steadyload.reports.columns import (
    column,
    compact,
    counts,
    milliseconds,
    percent,
    row,
    significant,
)
from steadyload.runs.comparison import PairTest
from steadyload.runs.costs import CPU, CostKind, CostSource
from steadyload.runs.evaluation import Evaluation, MethodEvaluation, evaluate
from steadyload.runs.judged import JudgedCases, manifest_lines
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import mean, share
from steadyload.statistics.paired import LEVEL
from steadyload.studies.families.judging import AGAINST, LABEL, FamilyCases, families_of

ALL = "all families"


@row
class FamilyRow:
    """A family, or all together; ``unlabelled`` layouts are those on which the label's simulation
    gave no verdict, by status, and are in nothing else.
    """

    family: str = column()
    about: str = column("boxes")
    n: int = column(about="labelled layouts")
    stands: Estimate = column("stand %", percent, "of these")
    label_cpu: Estimate = column("CPU ms a label", milliseconds)
    label_cpu_most: float = column("slowest label, ms", significant)
    unlabelled: Mapping[str, int] = column("without label", counts, notable=True)


@row
class Judged:
    """A method on a family, or on all together. A case without a verdict is wrong."""

    family: str = column()
    method: MethodKey = column(form=attrgetter("title"), left=True)
    n: int = column()
    right: Estimate = column("right %", percent)
    over: Estimate = column("over %", percent, "fails later than by the label, or stands wrongly")
    under: Estimate = column("under %", percent, "fails earlier than by the label")
    refused: Estimate = column("refused %", percent)
    lost: Mapping[str, int] = column("no verdict otherwise", counts, notable=True)
    cpu: Estimate = column("CPU ms", milliseconds)


@row
class ByFamily:
    """Share of cases on which a method is right, by family."""

    method: MethodKey = column(form=attrgetter("title"), left=True)
    right: Mapping[str, Estimate] = column("{} %", percent)


@row
class Gain:
    """A method compared with the one that all are compared with, on the same cases."""

    method: MethodKey = column(form=attrgetter("title"), left=True)
    difference: Estimate = column("difference", percent, "of the shares that are right, in points")
    only_it: Estimate = column("only it is right %", percent)
    only_other: Estimate = column("only the other is right %", percent)
    p: float = column(form=compact, about="corrected for all tests of the table")
    simulates: bool
    by_family: Mapping[str, Estimate] = column("{}", percent)

    @property
    def significant(self) -> int:
        """1 where it is significantly more accurate, -1 where it is less, else 0."""
        return int(np.sign(self.difference.value)) if self.p < LEVEL else 0


@row
class Found:
    """Everything that the page shows.

    ``families``: with all together last. ``together``: methods on all families, the one with
    most right first. ``each``: on each family. ``against``: the method of ``gains``.
    ``label_seconds``: CPU time of all labels.
    """

    families: Sequence[FamilyRow]
    together: Sequence[Judged]
    each: Mapping[str, Sequence[Judged]]
    by_family: Sequence[ByFamily]
    gains: Sequence[Gain]
    against: MethodKey
    boxes: tuple[int, int]
    label: str
    label_seconds: float
    left_out: Mapping[str, str]
    costs: str
    made_with: Mapping[str, str]

    @property
    def whole(self) -> FamilyRow:
        """All families together."""
        return self.families[-1]

    @property
    def simulations(self) -> Sequence[Gain]:
        """Gains of methods that simulate."""
        return [own for own in self.gains if own.simulates]

    @property
    def refusing(self) -> Sequence[Judged]:
        """Methods that refuse some cases, the one that refuses most first."""
        some = [own for own in self.together if own.refused.value > 0.0]
        return sorted(some, key=lambda own: -own.refused.value)


def compare(found: FamilyCases) -> Found:
    """The comparison of what was judged; families in the order of their registry.

    Raises:
        ResultsError: there is no label of any case.
    """
    judged = found.judged
    label, against = (str(make_method(spec).spec) for spec in (LABEL, AGAINST))
    compared = [spec for spec in judged.keys if spec != label]
    labelled = judged.labelled_by(label, found.families)
    methods = labelled.of(compared)
    source = CostSource(CostKind.JUDGING)
    families = families_of(methods.said, found.families)
    names = [name for name in FAMILIES if (families == name).any()]
    whole = evaluate(methods, source=source)
    parts = {
        name: evaluate(methods.only((families == name).to_numpy()), source=source) for name in names
    }
    each = {name: _rows(name, part) for name, part in parts.items()}
    together = sorted(_rows(ALL, whole), key=lambda own: -own.right.value)
    assert labelled.labels is not None
    counts_of_boxes = labelled.labels["item_count"]
    return Found(
        families=[_family(name, judged, labelled, found.families) for name in (*names, ALL)],
        together=together,
        each=each,
        by_family=[
            ByFamily(own.method, {name: _of(each[name], own.method).right for name in names})
            for own in together
        ],
        gains=_gains(whole, parts, against),
        against=methods.keys[against],
        boxes=(int(counts_of_boxes.min()), int(counts_of_boxes.max())),
        label=label,
        label_seconds=float(_cpu(judged, label).sum()) / 1e3,
        left_out=found.left_out,
        costs=source.explained(),
        made_with=manifest_lines(judged) | {"seed": str(found.seed)},
    )


def _of(rows: Sequence[Judged], method: MethodKey) -> Judged:
    return next(own for own in rows if own.method == method)


def _rows(family: str, part: Evaluation) -> list[Judged]:
    return [_judged(family, part.judged, own) for own in part.methods]


def _judged(family: str, judged: JudgedCases, own: MethodEvaluation) -> Judged:
    statuses = judged.results[judged.results["method"] == own.method.spec]["status"]
    refused = str(Status.REFUSED)
    return Judged(
        family=family,
        method=own.method,
        n=own.accuracy.n,
        right=own.accuracy,
        over=own.over,
        under=own.under,
        refused=share(statuses == refused),
        lost={status: n for status, n in own.without_verdict.items() if status != refused},
        cpu=own.cpu,
    )


def _family(
    name: str, judged: JudgedCases, labelled: JudgedCases, families: Mapping[str, str]
) -> FamilyRow:
    every, known = (families_of(own.said, families) for own in (judged, labelled))
    here = np.ones(len(known), bool) if name == ALL else (known == name).to_numpy()
    asked = np.ones(len(every), bool) if name == ALL else (every == name).to_numpy()
    label = str(make_method(LABEL).spec)
    own = judged.only(asked).results
    statuses = own[own["method"] == label]["status"].value_counts()
    assert labelled.labels is not None
    cpu = _cpu(judged.only(asked), label)
    return FamilyRow(
        family=name,
        about="" if name == ALL else FAMILIES[name].about,
        n=int(here.sum()),
        stands=share(labelled.labels["failing_step"].isna()[here], labelled.clusters[here]),
        label_cpu=mean(cpu),
        label_cpu_most=float(cpu.max()),
        unlabelled={
            str(status): int(n) for status, n in statuses.items() if status != str(Status.DONE)
        },
    )


def _cpu(judged: JudgedCases, spec: str) -> np.ndarray:
    """CPU times of a method [ms], a case each."""
    own = judged.results[judged.results["method"] == spec]
    return 1e3 * own[CPU].to_numpy(float)


def _gains(whole: Evaluation, parts: Mapping[str, Evaluation], against: str) -> list[Gain]:
    tests: Sequence[PairTest[MethodKey]] = whole.versus(against).tests
    return [
        Gain(
            method=test.first,
            difference=test.difference,
            only_it=test.only_first,
            only_other=test.only_second,
            p=test.corrected,
            simulates=test.first.engine is not None,
            by_family={
                name: part.difference(test.first.spec, against) for name, part in parts.items()
            },
        )
        for test in tests
    ]
