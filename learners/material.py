"""The data of a training: what is learnt from, what is held out, and what stops it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import Part
from steadyload.layouts.model.question import Question
from steadyload.learners import LearnerError
from steadyload.learners.features import FeatureKind
from steadyload.learners.sequences import (
    BENCHMARK,
    HeldOut,
    Sequences,
    joined,
    load_sequences,
)
from steadyload.progress import Progress, silent


@dataclass(frozen=True)
class Material:
    """All data of a job, and a description of every set."""

    data: Sequences
    validation: Sequences
    held_out: HeldOut
    sources: list[dict[str, Any]]


def load_material(
    kind: FeatureKind,
    data: Sequence[str],
    *,
    limit: int | None,
    lists: int | None,
    leaky: bool,
    question: Question,
    loading: Progress = silent,
) -> Material:
    """The training parts of some sets, without what is held out, and what stops a training.

    Args:
        kind: of features.
        data: names and folders of labelled sets.
        limit: only so many cases a scenario of every set.
        lists: only the cases of so many item lists of every set.
        leaky: with layouts of held-out item lists.
        question: whose labels are learnt.
        loading: called with layouts read and layouts in all, for every set.

    Raises:
        LeakError: what is held out is in the data.
        LearnerError: no data are left.
        BenchmarkError: a set that is none.
    """
    parts, sources = [], []
    for name in data:
        folder = _folder(name)
        found = load_sequences(
            kind,
            directory=folder,
            limit=limit,
            lists=lists,
            leaky=leaky,
            question=question,
            progress=loading,
        )
        parts.append(found)
        source = {"name": name, "cases": len(found), "fingerprint": found.fingerprint()}
        if folder is not None:
            manifest = load_benchmark(folder).manifest
            told = ("label", "seed", "lists", "heuristics", "most", "scenarios")
            made = ("labelled_with", "labelled_with_before")
            source |= {key: manifest[key] for key in (*told, *made) if key in manifest}
        sources.append(source)
    held_out = HeldOut.of({None, *(_folder(name) for name in data)})
    if not leaky:
        whole, parts = sum(map(len, parts)), [held_out.without_twins(part) for part in parts]
        parts = [part for part in parts if len(part)]
        if not parts:
            raise LearnerError(
                f"{whole} of {whole} layouts are geometries of held-out layouts; nothing is left "
                "to learn from"
            )
    validation = [
        load_sequences(kind, Part.VALIDATION, directory=folder, question=question)
        for folder in map(_folder, dict.fromkeys((BENCHMARK, *data)))
        if folder is None or str(Part.VALIDATION) in set(load_benchmark(folder).cases["split"])
    ]
    return Material(joined(parts), joined(validation), held_out, sources)


def _folder(name: str) -> str | None:
    return None if name == BENCHMARK else name


def split_of(
    material: Material, number: int, *, left_out: float, seed: int
) -> tuple[Sequences, Sequences, list[str]]:
    """Training cases of a member, the cases that stop it, and the item lists that it leaves out.

    Raises:
        LearnerError: no item list is left to learn from.
    """
    data = material.data
    if not left_out:
        return data, material.validation, []
    lists = np.array(sorted(set(data.instances)), dtype=object)
    random = np.random.default_rng(np.random.SeedSequence([seed, number, 1]))
    count = max(1, round(left_out * len(lists)))
    out = sorted(random.choice(lists, count, replace=False).tolist())
    apart = np.isin(data.instances, out)
    if apart.all():
        raise LearnerError(
            "left_out leaves no item list to learn from; add data, or leave out none"
        )
    return data.chosen(~apart), data.chosen(apart), out
