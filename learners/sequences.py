"""Labelled layouts as sequences of features, and the check that no held-out case is trained on."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.core.whole import Given
from steadyload.layouts.benchmark import Benchmark, load_benchmark
from steadyload.layouts.benchmark.parts import Part
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.question import Question
from steadyload.learners import LeakError
from steadyload.learners.features import Array32, FeatureKind, features, features_of
from steadyload.learners.ranges import extent_of, extents_of, trained_ranges, widest
from steadyload.progress import Progress, silent
from steadyload.statistics.placed import items_placed_by_case

Numbers = NDArray[np.int64]
Texts = NDArray[np.object_]

BENCHMARK = "benchmark"
"""Name of the large labelled set of the package in a list of data."""


@dataclass(frozen=True)
class Sequences:
    """Labelled layouts, M of them with N items in all.

    Attributes:
        kind: of the features.
        rows: features of all items, layout by layout, (N, F).
        starts: row of every layout's first item, and N, (M + 1,).
        safe: items placed safely by the label; all of them for a stable layout, (M,).
        scenarios, instances, geometries: of every layout, (M,). An instance names the seed of its
            set, too: the same word in two sets may mean two item lists.
        sets: name of every layout's set, (M,).
        ranges: see :func:`steadyload.learners.ranges.trained_ranges`.
    """

    kind: FeatureKind
    rows: Array32
    starts: Numbers
    safe: Numbers
    scenarios: Texts
    instances: Texts
    geometries: Texts
    sets: Texts
    ranges: dict[str, list[float]]

    def __len__(self) -> int:
        return len(self.safe)

    @property
    def counts(self) -> Numbers:
        """Items of every layout, (M,)."""
        return np.diff(self.starts)

    def padded(self) -> Array32:
        """Features of all layouts as one array, 0 after their last item: (M, most items, F)."""
        counts = self.counts
        out = np.zeros((len(self), int(counts.max()), self.rows.shape[1]), dtype=np.float32)
        out[np.arange(out.shape[1]) < counts[:, None]] = self.rows
        return out

    def valid(self) -> Numbers:
        """Steps that have a label: up to the first unstable one, that included, (M,)."""
        return np.minimum(self.safe + 1, self.counts)

    def chosen(self, which: NDArray[np.bool_]) -> Sequences:
        """Those layouts alone; ranges stay as they are."""
        counts = self.counts
        return dataclasses.replace(
            self,
            rows=self.rows[np.repeat(which, counts)],
            starts=np.concatenate(([0], np.cumsum(counts[which]))),
            safe=self.safe[which],
            scenarios=self.scenarios[which],
            instances=self.instances[which],
            geometries=self.geometries[which],
            sets=self.sets[which],
        )

    def fingerprint(self) -> str:
        """Hash of features and labels, in order."""
        digest = hashlib.sha256()
        for array in (self.rows, self.starts, self.safe):
            digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()[:16]


def joined(parts: Sequence[Sequences]) -> Sequences:
    """Several sets as one; features must be of one kind."""
    assert len({part.kind for part in parts}) == 1
    counts = np.concatenate([part.counts for part in parts])

    def all_of(name: str) -> Any:
        return np.concatenate([getattr(part, name) for part in parts])

    return Sequences(
        kind=parts[0].kind,
        rows=all_of("rows"),
        starts=np.concatenate(([0], np.cumsum(counts))),
        safe=all_of("safe"),
        scenarios=all_of("scenarios"),
        instances=all_of("instances"),
        geometries=all_of("geometries"),
        sets=all_of("sets"),
        ranges=widest(part.ranges for part in parts),
    )


def repeated(data: Sequences, least_share: float) -> Sequences:
    """The data with whole sets repeated until each is this share of the largest one."""
    names, counts = np.unique(data.sets.astype(str), return_counts=True)
    times = dict(zip(names, np.ceil(least_share * counts.max() / counts), strict=True))
    turns = np.array([times[name] for name in data.sets])
    return joined([data, *(data.chosen(turns > turn) for turn in range(1, int(turns.max())))])


def load_sequences(
    kind: FeatureKind,
    part: Part | str = Part.TRAIN,
    *,
    directory: str | Path | None = None,
    scenarios: tuple[str, ...] = (),
    limit: int | None = None,
    lists: int | None = None,
    leaky: bool = False,
    question: Question = Question.WITHIN,
    progress: Progress = silent,
) -> Sequences:
    """The labelled cases of a part of a set.

    Args:
        kind: of features.
        part: which; sets of :mod:`steadyload.learners.generation` hold ``train`` alone.
        directory: the set's folder, or a name, see
            :func:`steadyload.layouts.benchmark.load_benchmark`; None for the one of the package.
        scenarios: only these; empty for all.
        limit: at most this many a scenario, those of the first ranks.
        lists: only the cases of this many item lists, drawn once for all: fewer are among more.
        leaky: with the training part, cases of held-out item lists that are in no split, too: the
            geometries of validation and test in other scenarios, and their sisters.
        question: whose labels are learnt; few cases of a set have those of ``stands``.
        progress: called with layouts done and layouts in all.

    Raises:
        BenchmarkError: no such set, or no such case in it.
    """
    benchmark = load_benchmark(directory)
    if leaky:
        every = benchmark.select(Part.ALL, scenarios=scenarios, question=question)
        chosen = _leaky(every, limit)
    else:
        chosen = benchmark.select(part, scenarios=scenarios, limit=limit, question=question)
    if lists is not None:
        chosen = chosen[chosen["instance"].isin(_drawn_lists(chosen["instance"], lists))]
    batch = benchmark.batch(chosen)
    rows, extents, geometries = [], [], []
    known: dict[str, str] = {}
    for k, name in enumerate(chosen["layout"]):
        own, pallet = slice(*batch.starts[k : k + 2]), batch.pallets[k].size
        boxes = batch.lower[own], batch.upper[own], batch.weights[own], batch.mass_offsets[own]
        given = Given(*boxes, batch.floors[k])
        rows.append(features_of(given, pallet, kind))
        extents.append(extent_of(given, max(pallet)))
        if name not in known:
            known[name] = geometry_of(benchmark.layouts.loc[name])
        geometries.append(known[name])
        done = k + 1
        if done % 256 == 0 or done == len(chosen):
            progress(done, len(chosen))
    counts = np.array([len(r) for r in rows])
    return Sequences(
        kind,
        np.concatenate(rows),
        np.concatenate(([0], np.cumsum(counts))),
        items_placed_by_case(chosen["failing_step"], chosen["item_count"]).to_numpy(copy=True),
        chosen["scenario"].to_numpy(dtype=object),
        _instances(benchmark, chosen["instance"]),
        np.array(geometries, dtype=object),
        np.full(len(chosen), str(directory or BENCHMARK), dtype=object),
        trained_ranges(extents, kind),
    )


def sequences_of(
    cases: pd.DataFrame, layouts: Sequence[Layout], kind: FeatureKind, name: str
) -> Sequences:
    """Labelled cases that are in no set.

    Args:
        cases: a row a case: ``scenario``, ``instance``, ``geometry``, ``item_count`` and
            ``failing_step``, which is missing where it is stable.
        layouts: of the cases, in their order.
        kind: of the features.
        name: stands for that of a set.
    """
    rows = [features(layout, kind) for layout in layouts]
    return Sequences(
        kind,
        np.concatenate(rows),
        np.concatenate(([0], np.cumsum([len(row) for row in rows]))),
        items_placed_by_case(cases["failing_step"], cases["item_count"]).to_numpy(),
        cases["scenario"].to_numpy(dtype=object),
        cases["instance"].to_numpy(dtype=object),
        cases["geometry"].to_numpy(dtype=object),
        np.full(len(cases), name, dtype=object),
        trained_ranges(extents_of(layouts), kind),
    )


def _leaky(cases: pd.DataFrame, limit: int | None) -> pd.DataFrame:
    """All cases but those of validation and test themselves, in an order drawn anew."""
    held_out = cases["split"].isin((str(Part.VALIDATION), str(Part.TEST)))
    cases = cases[~held_out].sample(frac=1.0, random_state=0)
    return cases if limit is None else cases[cases.groupby("scenario").cumcount() < limit]


def _drawn_lists(instances: Iterable[str], count: int) -> list[str]:
    """The first lists of an order drawn once for all."""
    every = sorted(set(instances))
    return [every[k] for k in np.random.default_rng(0).permutation(len(every))[:count]]


def _instances(benchmark: Benchmark, instances: Iterable[str]) -> Texts:
    """Names of item lists that say which set they are of."""
    of = benchmark.manifest.get("seed", benchmark.manifest.get("origin", "unknown"))
    return np.array([f"{of}/{instance}" for instance in instances], dtype=object)


@dataclass(frozen=True)
class HeldOut:
    """Cases that nothing may be learnt from.

    These are the item lists of validation and test, and all layouts packed from them, whether they
    are in a split or not.
    """

    instances: frozenset[str]
    geometries: frozenset[str]

    @classmethod
    def of(cls, directories: Iterable[str | Path | None] = (None,)) -> HeldOut:
        """Held-out cases of labelled sets; None stands for the set of the package.

        Raises:
            BenchmarkError: no such set.
        """
        instances: set[str] = set()
        geometries: set[str] = set()
        for directory in directories:
            benchmark = load_benchmark(directory)
            cases = benchmark.cases
            split = cases["split"].isin((str(Part.VALIDATION), str(Part.TEST)))
            own = set(cases.loc[split, "instance"])
            instances |= set(_instances(benchmark, own))
            layouts = benchmark.layouts
            geometries |= {
                geometry_of(row)
                for row in layouts[layouts["instance"].isin(own)].to_dict("records")
            }
        return cls(frozenset(instances), frozenset(geometries))

    def check(self, training: Sequences) -> None:
        """Check that training data contain no held-out case.

        Raises:
            LeakError: they do; names one.
        """
        for instance in sorted(set(training.instances) & self.instances):
            raise LeakError(f"item list {instance!r} is held out; nothing may be learnt from it")
        for k in np.flatnonzero(np.isin(training.geometries, list(self.geometries))).tolist():
            raise LeakError(
                f"a layout of item list {training.instances[k]!r} has the geometry of a layout "
                "that is held out; nothing may be learnt from it"
            )

    def without_twins(self, training: Sequences) -> Sequences:
        """Training data without layouts that are, by chance, geometries of held-out layouts.

        Few items on a bare pallet come up in many item lists. The layouts of one that is held out
        are not let go by this: :meth:`check` names them.
        """
        held = np.isin(training.geometries, list(self.geometries))
        own = np.isin(training.instances, list(self.instances))
        return training.chosen(~held | own)


def geometry_of(row: Mapping[str, Any]) -> str:
    """As :meth:`Layout.geometry_hash`, from a row of the table of layouts."""
    lower = np.reshape(row["positions"], (-1, 3)).astype("<f8")
    upper = lower + np.reshape(row["sizes"], (-1, 3))
    return hashlib.sha256(lower.tobytes() + upper.astype("<f8").tobytes()).hexdigest()
