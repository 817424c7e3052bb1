"""The paper's experiment: files, labels, splits, and every method on the same test files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.labelling.paper_labels import label_files, shipped_labels
from steadyload.layouts.benchmark import Part
from steadyload.layouts.benchmark.dataset import row_of, stored_offsets
from steadyload.layouts.benchmark.paper_files import FileOptions, PaperFiles, make_files
from steadyload.layouts.benchmark.tables import CASES, OPINIONS, write_tables
from steadyload.layouts.model.layout import Layout
from steadyload.learners.features import FeatureKind
from steadyload.learners.options import TrainingOptions
from steadyload.progress import NamedProgress, silent
from steadyload.runs.able import able_methods
from steadyload.runs.accuracy import verdicts_against_labels
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import evaluate
from steadyload.runs.judged import JudgedCases, load_judged
from steadyload.runs.provenance import provenance_lines
from steadyload.runs.runner import run_study
from steadyload.studies.replication.memoriser import Memoriser
from steadyload.studies.replication.methods import ALL_LINES
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

MEMORISER, LSTM_1, LSTM_E, SUPPORT = "memoriser", "LSTM_1", "LSTM_e", "support"
"""Names of what is trained on splits; ``support`` is LSTM_1 with our features, by list alone."""

_SHARD = 50


@dataclass(frozen=True, slots=True)
class ReplicationOptions:
    """Options of the study.

    Args:
        quick: every third file, labels of the package, one network a fold.
        files: the data set.
        seed: of the splits.
        epochs: most epochs of a training.
        budget: seconds of CPU time of all trainings; all have an equal share.
        seeds: trainings of LSTM_1 a fold.
        ensemble: whether LSTM_e is trained.
        methods: specs that are judged; empty for those of the page.
        sizes: of the held-out parts, by scenario.
    """

    quick: bool = False
    files: FileOptions = field(default_factory=FileOptions)
    seed: int = 0
    epochs: int = 700
    budget: float = 8.0 * 3600.0
    seeds: int = 3
    ensemble: bool = True
    methods: tuple[str, ...] = ()
    sizes: Mapping[str, PartSizes] = field(default_factory=lambda: TABLE_2)


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
        asked: the options.
        files: all files that took part.
        cases: labelled files by scenario, see
            :func:`steadyload.studies.replication.splits.labelled_cases`.
        part: of every case.
        unlabelled: files by scenario without a label, over all scenarios.
        judged: verdicts of the methods on the distinct cases of the test.
        rights: by spec, on the test files.
        splits: what was trained, by split.
        left_out: by spec, the reason why a method cannot judge.
        made_with: provenance.
    """

    asked: ReplicationOptions
    files: PaperFiles
    cases: pd.DataFrame
    part: pd.Series
    unlabelled: int
    judged: JudgedCases
    rights: Mapping[str, Rights]
    splits: Mapping[SplitKind, SplitResult]
    left_out: Mapping[str, str]
    made_with: Mapping[str, str]

    @property
    def tests(self) -> pd.DataFrame:
        """The test files, a row a file and scenario, in the order of all masks."""
        return self.cases[(self.part == TEST).to_numpy(bool)]


def replicate(
    asked: ReplicationOptions, work: Path, *, workers: int = 1, progress: NamedProgress = silent
) -> Replicated:
    """Make, label, judge and train what is missing; an interrupted run is resumed.

    Args:
        asked: the options.
        work: folder of labels, verdicts and trainings.
        workers: processes that label, judge and train.
        progress: of item lists, labels, verdicts and epochs.

    Raises:
        SplitError: too few files are labelled.
        SpecError, EngineNotInstalledError: a named method cannot judge.
        LearnerError: training needs an extra, or a folder holds another training.
        ResultsError, WorkerDiedError: see :func:`steadyload.runs.runner.run_study`.
    """
    files = make_files(asked.files, lambda *of: progress("packing", *of))
    if asked.quick:
        files, labels = files.quick(), shipped_labels()
    else:
        found = label_files(
            files, work, workers=workers, progress=lambda *of: progress("labelling", *of)
        )
        labels = dict(found.labels)
    cases = labelled_cases(files, labels)
    part = draw_parts(cases, seed=asked.seed, sizes=asked.sizes)
    test = (part == TEST).to_numpy(bool)
    named, left_out = able_methods(
        asked.methods, lambda: dict.fromkeys(line.spec for line in ALL_LINES)
    )
    write_test_set(files, cases[test], work / "set")
    definition = StudyDefinition(
        "replication",
        named,
        benchmark=Part.TEST,
        benchmark_directory=work / "set",
        shard_size=_SHARD,
    )
    run_study(
        definition, work / "judged", workers=workers,
        progress=lambda *of: progress("judging", *of),
    )  # fmt: skip
    judged = load_judged(work / "judged")
    layouts = case_layouts(files, cases)
    return Replicated(
        asked=asked,
        files=files,
        cases=cases,
        part=part,
        unlabelled=len(files.table) * len(TABLE_2) - len(cases),
        judged=judged,
        rights={spec: rights_of(judged, spec, cases[test])[None] for spec in named},
        splits=_trained(asked, cases, part, layouts, work, workers, progress),
        left_out=left_out,
        made_with=provenance_lines(),
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


def write_test_set(files: PaperFiles, tests: pd.DataFrame, folder: Path) -> None:
    """Write the distinct cases of the test as a labelled set."""
    cases = tests.drop_duplicates(["name", "scenario"])
    layouts = case_layouts(files, cases)
    rows: dict[str, dict[str, object]] = {}
    for layout, instance, number in zip(
        layouts, cases["instance"], cases["item_class"], strict=True
    ):
        rows.setdefault(layout.name, row_of(layout, instance, int(number), (layout.name,)))
    table = pd.DataFrame(
        {
            "layout": cases["name"].to_numpy(),
            "scenario": cases["scenario"].to_numpy(),
            "item_count": cases["item_count"].to_numpy(),
            "offsets": list(map(stored_offsets, layouts)),
            "split": str(Part.TEST),
            "rank": cases.groupby("scenario").cumcount().to_numpy(),
            "status": "done",
            "failing_step": cases["failing_step"].array,
        }
    )
    none = pd.DataFrame(columns=OPINIONS.names)
    layout_table = pd.DataFrame(list(rows.values()))
    write_tables(
        folder, layout_table, table.reindex(columns=CASES.names), none, {"origin": "files"}
    )


def rights_of(judged: JudgedCases, spec: str, tests: pd.DataFrame) -> NDArray[np.bool_]:
    """Mask of the test files on which a method is right; twins share a verdict in S1."""
    keys = list(zip(tests["name"], tests["scenario"], strict=True))
    said = judged.said[spec].reindex(pd.MultiIndex.from_tuples(keys))
    found: NDArray[np.bool_] = verdicts_against_labels(said, tests)["right"].to_numpy(bool)
    return found


def costs_of(judged: JudgedCases) -> Mapping[str, float]:
    """Mean CPU time of a judgement by spec [ms]."""
    return {row.method.spec: row.cpu.value for row in evaluate(judged, by_scenario=False).methods}


@dataclass(frozen=True, slots=True)
class Member:
    """A network of a split: its place in Table 4, seed and features."""

    place: int
    seed: int
    features: FeatureKind

    def options(self, epochs: int) -> TrainingOptions:
        """The options of its training."""
        return paper_options(self.place, self.seed, features=self.features, epochs=epochs)


def ensembles_of(kind: SplitKind, asked: ReplicationOptions) -> dict[str, list[list[Member]]]:
    """By name the ensembles that are trained on every fold of a split, each with its members."""
    plain = FeatureKind.PLAIN
    found = {LSTM_1: [[Member(0, seed, plain)] for seed in range(asked.seeds)]}
    if asked.ensemble and kind is not SplitKind.FEWER:
        found[LSTM_E] = [[Member(place, 0, plain) for place in range(len(NETWORKS))]]
    if kind is SplitKind.LIST:
        found[SUPPORT] = [[Member(0, 0, FeatureKind.SUPPORT)]]
    return found


def _trained(
    asked: ReplicationOptions,
    cases: pd.DataFrame,
    part: pd.Series,
    layouts: Sequence[Layout],
    work: Path,
    workers: int,
    progress: NamedProgress,
) -> dict[SplitKind, SplitResult]:
    made = {kind: folds(cases, part, kind) for kind in SplitKind}
    plans = {kind: ensembles_of(kind, asked) for kind in SplitKind}
    wanted = {
        (kind, fold.number, member.options(asked.epochs)): fold
        for kind, own in plans.items()
        for fold in made[kind]
        for ensembles in own.values()
        for ensemble in ensembles
        for member in ensemble
    }
    material, test = Material(cases, layouts), (part == TEST).to_numpy(bool)
    tested = networks_on_folds(
        material,
        [(fold, options) for (*_, options), fold in wanted.items()],
        work,
        asked.budget / len(wanted),
        workers=workers,
        progress=lambda *of: progress("training", *of),
    )
    networks = dict(zip(wanted, tested, strict=True))
    labels, found = steps_safe(cases), {}
    for kind, own in plans.items():
        rights = {MEMORISER: _memorised(cases, layouts, made[kind])[:, test]}
        efforts: dict[str, list[Effort]] = {}
        for name, ensembles in own.items():
            right = np.zeros((len(ensembles), len(cases)), dtype=bool)
            for which, ensemble in enumerate(ensembles):
                for fold in made[kind]:
                    told = [
                        networks[kind, fold.number, member.options(asked.epochs)]
                        for member in ensemble
                    ]
                    safe = items_safe_by(told, fold, cases)
                    right[which, fold.test] = safe == labels[fold.test]
                    efforts.setdefault(name, []).extend(each.effort for each in told)
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
