"""The paper's experiment: files, labels, splits, and every method on the same test files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.labelling.paper_labels import Labels
from steadyload.layouts.benchmark import Benchmark, Part
from steadyload.layouts.benchmark.dataset import row_of, stored_offsets
from steadyload.layouts.benchmark.paper_files import PaperFiles
from steadyload.layouts.benchmark.tables import CASES, OPINIONS
from steadyload.layouts.model.layout import Layout
from steadyload.learners.features import FeatureKind
from steadyload.learners.options import TrainingOptions
from steadyload.runs.able import able_methods
from steadyload.runs.accuracy import verdicts_against_labels
from steadyload.runs.evaluation import Evaluation
from steadyload.runs.labels import Cases
from steadyload.studies.kit import Lab
from steadyload.studies.replication.memoriser import Memoriser
from steadyload.studies.replication.methods import ALL_LINES, LSTM_1, LSTM_E, MEMORISER, SUPPORT
from steadyload.studies.replication.networks import (
    NETWORKS,
    Effort,
    Material,
    items_safe_by,
    networks_on_folds,
    paper_options,
)
from steadyload.studies.replication.splits import (
    TABLE_2,
    TEST,
    Fold,
    PartSizes,
    SplitKind,
    draw_parts,
    folds,
    labelled_cases,
    share_with_twin,
    steps_safe,
)

Rights = NDArray[np.bool_]
"""Mask of the test files on which a seed of a method is right, (seeds, files)."""

_SHARD = 50


@dataclass(frozen=True)
class SplitResult:
    """Trainings on a split, and how they did on the test files.

    Attributes:
        folds: of the split.
        rights: by name of what was trained, on the test files.
        efforts: of the trainings, by name.
        twins: mask of the test files with a twin in the training of the same scenario.
    """

    folds: tuple[Fold, ...]
    rights: Mapping[str, Rights]
    efforts: Mapping[str, Sequence[Effort]]
    twins: NDArray[np.bool_]


@dataclass(frozen=True)
class Replicated:
    """Everything that was judged.

    Attributes:
        files: all files that took part.
        cases: labelled files by scenario, see
            :func:`steadyload.studies.replication.splits.labelled_cases`.
        part: of every case.
        judged: verdicts of the methods on the distinct cases of the test.
        rights: by spec, on the test files.
        splits: what was trained, by split.
        left_out: by spec, the reason why a method cannot judge.
    """

    files: PaperFiles
    cases: pd.DataFrame
    part: pd.Series
    judged: Evaluation
    rights: Mapping[str, Rights]
    splits: Mapping[SplitKind, SplitResult]
    left_out: Mapping[str, str]

    @property
    def tests(self) -> pd.DataFrame:
        """The test files, a row a file and scenario, in the order of all masks."""
        return self.cases[(self.part == TEST).to_numpy(bool)]


def replicate(
    lab: Lab,
    files: PaperFiles,
    labels: Labels,
    *,
    seed: int,
    epochs: int,
    budget: float,
    seeds: int,
    ensemble: bool,
    methods: tuple[str, ...] = (),
    sizes: Mapping[str, PartSizes] = TABLE_2,
) -> Replicated:
    """Judge and train what is missing; an interrupted run is resumed.

    Args:
        lab: where it is judged and trained.
        files: the data set.
        labels: of its cases.
        seed: of the splits.
        epochs: most epochs of a training.
        budget: seconds of CPU time of all trainings; all have an equal share.
        seeds: trainings of LSTM_1 a fold.
        ensemble: whether LSTM_e is trained.
        methods: specs that are judged; empty for those of the page.
        sizes: of the held-out parts, by scenario.

    Raises:
        SplitError: too few files are labelled.
        SpecError, EngineNotInstalledError: a named method cannot judge.
        LearnerError: a folder holds another training.
        ResultsError, WorkerDiedError: see :func:`steadyload.runs.runner.run_study`.
    """
    cases = labelled_cases(files, labels)
    part = draw_parts(cases, seed=seed, sizes=sizes)
    tests = cases[(part == TEST).to_numpy(bool)]
    named, left_out = able_methods(methods, lambda: dict.fromkeys(line.spec for line in ALL_LINES))
    judged = lab.judge(
        named, Cases(test_set(files, tests), Part.TEST), folder="judged", name="replication",
        shard_size=_SHARD,
    )  # fmt: skip
    return Replicated(
        files=files,
        cases=cases,
        part=part,
        judged=judged,
        rights={spec: rights_of(judged, spec, tests)[None] for spec in named},
        splits=_trained(lab, files, cases, part, epochs, budget, seeds, ensemble),
        left_out=left_out,
    )


def case_layouts(files: PaperFiles, cases: pd.DataFrame) -> list[Layout]:
    """The layouts of some cases, in their order; twins of S1 share one."""
    made: dict[tuple[str, str], Layout] = {}
    found = []
    for row, scenario, name in zip(cases["row"], cases["scenario"], cases["name"], strict=True):
        key = (scenario, name)
        if key not in made:
            made[key] = files.case(row, scenario)
        found.append(made[key])
    return found


def test_set(files: PaperFiles, tests: pd.DataFrame) -> Benchmark:
    """The distinct cases of the test as a labelled set."""
    cases = tests.drop_duplicates(["name", "scenario"])
    layouts = case_layouts(files, cases)
    about = zip(layouts, cases["instance"], cases["item_class"], strict=True)
    rows = {
        layout.name: row_of(layout, instance, int(number), (layout.name,))
        for layout, instance, number in about
    }
    table = pd.DataFrame(
        {
            "layout": cases["name"].to_numpy(),
            "scenario": cases["scenario"].to_numpy(),
            "instance": cases["instance"].to_numpy(),
            "item_count": cases["item_count"].to_numpy(),
            "offsets": list(map(stored_offsets, layouts)),
            "split": str(Part.TEST),
            "rank": cases.groupby("scenario").cumcount().to_numpy(),
            "status": "done",
            "failing_step": cases["failing_step"].array,
        }
    )
    return Benchmark(
        pd.DataFrame(rows.values()).set_index("layout"),
        table.reindex(columns=[*CASES.names, "instance"]),
        pd.DataFrame(columns=OPINIONS.names),
        {"origin": "files"},
    )


def rights_of(judged: Evaluation, spec: str, tests: pd.DataFrame) -> NDArray[np.bool_]:
    """Mask of the test files on which a method is right; twins share a verdict in S1."""
    said = judged.judged.said[spec].reindex(pd.MultiIndex.from_frame(tests[["name", "scenario"]]))
    found: NDArray[np.bool_] = verdicts_against_labels(said, tests)["right"].to_numpy(bool)
    return found


def ensembles_of(
    kind: SplitKind, epochs: int, seeds: int, ensemble: bool
) -> dict[str, list[list[TrainingOptions]]]:
    """By name the ensembles that are trained on every fold of a split, each with its networks.

    Args:
        kind: of the split.
        epochs: most epochs of a training.
        seeds: trainings of LSTM_1.
        ensemble: whether LSTM_e is trained.
    """
    found = {LSTM_1: [[paper_options(0, seed, epochs=epochs)] for seed in range(seeds)]}
    if ensemble and kind is not SplitKind.FEWER:
        members = range(len(NETWORKS))
        found[LSTM_E] = [[paper_options(member, 0, epochs=epochs) for member in members]]
    if kind is SplitKind.LIST:
        support = {"features": FeatureKind.SUPPORT, "epochs": epochs}
        found[SUPPORT] = [[paper_options(0, 0, **support)]]
    return found


def _trained(
    lab: Lab,
    files: PaperFiles,
    cases: pd.DataFrame,
    part: pd.Series,
    epochs: int,
    budget: float,
    seeds: int,
    ensemble: bool,
) -> dict[SplitKind, SplitResult]:
    layouts, test = case_layouts(files, cases), (part == TEST).to_numpy(bool)
    made = {kind: folds(cases, part, kind) for kind in SplitKind}
    plans = {kind: ensembles_of(kind, epochs, seeds, ensemble) for kind in SplitKind}
    wanted = {
        (kind, fold.number, options): fold
        for kind, plan in plans.items()
        for fold in made[kind]
        for ensembles in plan.values()
        for members in ensembles
        for options in members
    }
    tested = networks_on_folds(
        Material(cases, layouts),
        [(fold, options) for (*_, options), fold in wanted.items()],
        lab.work,
        budget / len(wanted),
        workers=lab.workers,
        progress=lambda *of: lab.progress("training", *of),
    )
    networks = dict(zip(wanted, tested, strict=True))
    labels, found = steps_safe(cases), {}
    for kind, plan in plans.items():
        rights = {MEMORISER: _memorised(cases, layouts, made[kind])[:, test]}
        efforts: dict[str, list[Effort]] = {}
        for name, ensembles in plan.items():
            right, efforts[name] = np.zeros((len(ensembles), len(cases)), dtype=bool), []
            for own, members in zip(right, ensembles, strict=True):
                for fold in made[kind]:
                    told = [networks[kind, fold.number, options] for options in members]
                    own[fold.test] = items_safe_by(told, fold, cases) == labels[fold.test]
                    efforts[name] += [each.effort for each in told]
            rights[name] = right[:, test]
        twins = np.zeros(len(cases), dtype=bool)
        for fold in made[kind]:
            twins[fold.test] = share_with_twin(cases, fold)[fold.test]
        found[kind] = SplitResult(made[kind], rights, efforts, twins[test])
    return found


def _memorised(
    cases: pd.DataFrame, layouts: Sequence[Layout], parts: Sequence[Fold]
) -> NDArray[np.bool_]:
    """Mask of the cases of the test on which the memoriser is right, (1, cases)."""
    steps = [None if pd.isna(step) else int(step) for step in cases["failing_step"]]
    right = np.zeros((1, len(cases)), dtype=bool)
    for fold in parts:
        memoriser = Memoriser((layouts[k], steps[k]) for k in np.flatnonzero(fold.train).tolist())
        for k in np.flatnonzero(fold.test).tolist():
            right[0, k] = memoriser.failing_step(layouts[k]) == steps[k]
    return right
