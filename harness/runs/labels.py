"""The layouts and cases of a study, with their labels when it runs on a labelled set.

A run folder with labels holds ``labels.parquet`` beside the layouts: a page needs nothing of
the labelled set itself.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
from numpy.typing import NDArray

from steadyload.layouts.benchmark import Benchmark, load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.parts import Part
from steadyload.layouts.benchmark.tables import (
    as_parquet,
    from_parquet,
    later,
)
from steadyload.layouts.files.record import Refused
from steadyload.layouts.files.refusals import Refusals
from steadyload.layouts.formats import read_written
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import Layout, LayoutError
from steadyload.layouts.model.question import Question, question_named
from steadyload.layouts.model.scenarios import Scenario
from steadyload.reading import MAX_TABLE_BYTES, content_of
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.provenance import provenance_lines
from steadyload.runs.results import kept_file

LABELS = pa.schema(
    [
        pa.field("layout", pa.string(), nullable=False),
        pa.field("scenario", pa.string(), nullable=False),
        pa.field("instance", pa.string(), nullable=False),
        pa.field("item_count", pa.int16(), nullable=False),
        pa.field("failing_step", pa.int16()),
        pa.field("confidence", pa.float64()),
        pa.field("robust", pa.bool_()),
        pa.field("offsets", pa.list_(pa.float64())),
        later(pa.field("item_class", pa.string())),
        later(pa.field("stands", pa.string())),
        later(pa.field("failing_step_stands", pa.int16())),
    ]
)
"""A row a case. ``instance``: the item list that the layout was packed from. ``failing_step``: the
label, counted from 0, null for a stable layout. ``confidence``, ``robust``: see
:func:`steadyload.layouts.benchmark.confidence.confidence`; null where there is no ensemble.
``offsets``: centre of mass minus geometric centre [cm], x, y, z of item 0, then of item 1, ...;
null when all are zero. ``item_class``: of the set, from which the item list was drawn.
``stands``: how labelling for the question ``stands`` ended, ``done``,
``unsettled`` or otherwise; null where it was not asked. ``failing_step_stands``: that label, where
it is ``done``."""

LABELS_FILE = "labels.parquet"


Case = tuple[str, Layout]
"""A scenario, and the layout as it is judged."""


@dataclass(frozen=True)
class Material:
    """The layouts and cases of a study. Both are iterated, so that there may be any number.

    Attributes:
        layouts: as the run folder keeps them, without scenarios; can be iterated once.
        cases: gives all cases in turn, once ``layouts`` were iterated, from the copy of them.
        labels: a row a case, :data:`LABELS`; None without labels.
        about: the manifest's entry on the labels; None without labels.
        refused: layouts of the files that are not valid; complete once ``layouts`` were iterated.
    """

    layouts: Iterable[LayoutBatch | Layout]
    cases: Callable[[Path], Iterable[Case]]
    labels: pd.DataFrame | None = None
    about: dict[str, Any] | None = None
    refused: Refusals = field(default_factory=Refusals)


def own_material(study: StudyDefinition) -> Material:
    """The material of a study without labels. Its files are read once, its layouts checked once.

    Args:
        study: its definition.

    Raises:
        LayoutError, StudyError: when its layouts are read, see
            :meth:`StudyDefinition.layouts`.
    """
    refused = Refusals()
    layouts = study.batches(lambda one: refused.add(_nameless(one)))
    return Material(layouts, lambda copy: study.cases(read_written(copy)), refused=refused)


def _nameless(one: Refused) -> str:
    """Why a layout was refused, without the folder of its file: a run folder may be handed on."""
    error = one.error
    name = None if error.file is None else Path(error.file).name
    return str(LayoutError(error.message, file=name, layout=one.name, item=error.item))


@dataclass(frozen=True)
class Cases:
    """Labelled cases, as a value.

    Attributes:
        benchmark: the labelled set.
        part: of the set.
        scenarios: only these; empty for all.
        limit: at most this many a scenario, those of the first ranks; None for all.
    """

    benchmark: Benchmark
    part: Part = Part.ALL
    scenarios: tuple[Scenario, ...] = ()
    limit: int | None = None


def labelled_cases(study: StudyDefinition, benchmark: Benchmark | None = None) -> list[Case]:
    """The cases of a study on a part of a labelled set; see :func:`labelled_material`."""
    return _chosen(study, benchmark)[2]


def _chosen(
    study: StudyDefinition, benchmark: Benchmark | None
) -> tuple[Benchmark, pd.DataFrame, list[Case]]:
    assert study.benchmark is not None
    if benchmark is None:
        benchmark = load_benchmark(study.benchmark_directory)
    chosen = benchmark.select(
        study.benchmark, scenarios=tuple(str(s) for s in study.scenarios), limit=study.limit
    )
    cases = [
        (scenario, benchmark.layout(name, scenario))
        for name, scenario in zip(chosen["layout"], chosen["scenario"], strict=True)
    ]
    return benchmark, chosen, cases


def labelled_material(study: StudyDefinition, benchmark: Benchmark | None = None) -> Material:
    """The material of a study on a part of a labelled set, with the labels.

    Args:
        study: its definition.
        benchmark: the labelled set; None reads that of the definition.

    Raises:
        BenchmarkError: not a labelled set, a damaged one, or it holds no such case.
    """
    benchmark, chosen, cases = _chosen(study, benchmark)
    layouts = {layout.name: layout for _, layout in cases}
    centred = [layout.with_mass_offsets(np.zeros((len(layout), 3))) for layout in layouts.values()]
    labels = _labels(benchmark, chosen)
    answers = labels.drop(columns=["offsets", "item_class"]).to_csv(index=False)
    about = {
        "part": str(study.benchmark),
        "cases": len(labels),
        "hash": hashlib.sha256(answers.encode()).hexdigest()[:16],
        "natural_stable": benchmark.natural_stable,
    }
    if "screens" in benchmark.manifest:
        about["screens"] = list(benchmark.manifest["screens"])
    if benchmark.word:
        about["set"] = benchmark.word
    return Material(centred, lambda copy: cases, labels, about)


def _labels(benchmark: Benchmark, chosen: pd.DataFrame) -> pd.DataFrame:
    sure = benchmark.confidence_on(Question.WITHIN)[["confidence", "robust"]]
    stands = benchmark.labels_on(Question.STANDS).set_index(KEYS)[["status", "failing_step"]]
    stands.columns = pd.Index(["stands", "failing_step_stands"])
    classes = benchmark.layouts["item_class"].astype(str)
    joined = chosen.join(sure, on=KEYS).join(stands, on=KEYS).join(classes, on="layout")
    return joined.astype({"robust": "boolean"})[LABELS.names]


def statuses_on(labels: pd.DataFrame, question: Question) -> pd.Series:
    """How labelling for a question ended, by case; missing where it was not asked."""
    within = question_named(question) == Question.WITHIN
    return pd.Series("done", labels.index) if within else labels["stands"]


def labels_on(labels: pd.DataFrame, question: Question) -> pd.DataFrame:
    """The rows of cases that have a label of a question, with that as ``failing_step``."""
    known = labels[(statuses_on(labels, question) == "done").fillna(False)]
    steps = {Question.WITHIN: "failing_step", Question.STANDS: "failing_step_stands"}
    return known.assign(failing_step=known[steps[question]])


def item_lists(labels: pd.DataFrame) -> NDArray[np.object_]:
    """The clusters of intervals: the item list of each case, with its class of items as stratum.

    Args:
        labels: a row a case, :data:`LABELS`.

    Returns:
        Pairs, as :meth:`steadyload.statistics.clusters.Clusters.of` takes them, shape (cases,).
    """
    found = np.empty(len(labels), dtype=object)
    found[:] = list(zip(labels["item_class"].fillna(""), labels["instance"], strict=True))
    return found


def as_labels(labels: pd.DataFrame) -> bytes:
    """Labels as the bytes of a run folder's file."""
    return as_parquet(labels, LABELS)


def load_labels(directory: str | Path, manifest: Mapping[str, Any] | None = None) -> pd.DataFrame:
    """The labels of a run folder, columns of :data:`LABELS`, indexed by layout and scenario.

    Numbers and truth values that may be missing come as pandas' nullable types.

    Args:
        directory: the run folder.
        manifest: of it; None reads it.

    Raises:
        ResultsError: there are none, or the file is damaged.
    """
    file = kept_file(directory, LABELS_FILE, manifest)
    frame = from_parquet(content_of(file, MAX_TABLE_BYTES), LABELS)
    return frame.astype({"robust": "boolean"}).set_index(KEYS)


def labelled_layout(layout: Layout, label: pd.Series) -> Layout:
    """A case's layout as it was judged, from the run folder's layout and the case's label row."""
    offsets = label["offsets"]
    return layout if offsets is None else layout.with_mass_offsets(np.reshape(offsets, (-1, 3)))


def made_with(benchmark: Benchmark) -> dict[str, str]:
    """Provenance of a set, as a page shows it."""
    manifest, lines = benchmark.manifest, {}
    for key in ("origin", "seed", "instances", "item_counts", "weights", "label", "source"):
        if key in manifest:
            lines[key.replace("_", " ")] = str(manifest[key])
    labels, opinions = manifest.get("labels", {}), manifest.get("judged_with", {})
    steps = {step: manifest.get(step) for step in ("built_with", "labelled_with")}
    steps["judged_with"] = opinions.get("within")
    steps["stands_labelled_with"] = labels.get("stands", {}).get("labelled_with")
    steps["stands_judged_with"] = opinions.get("stands")
    for step, found in steps.items():
        if found is not None:
            made = provenance_lines(found)
            lines |= {f"{step.replace('_', ' ')}: {k}": v for k, v in made.items()}
    return lines
