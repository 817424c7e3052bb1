"""Verdicts of trained weights on a part of the labelled set, kept: the weights may then go."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from steadyload.layouts.benchmark.parts import Part, set_named
from steadyload.learners.features import VERSION as FEATURES
from steadyload.learners.features import Array32, FeatureKind
from steadyload.learners.inference import VERSION as INFERENCE
from steadyload.learners.plans.trainings import Run
from steadyload.learners.scoring import items_safe
from steadyload.learners.sequences import BENCHMARK, Sequences, load_sequences
from steadyload.learners.weights import Weights, load_weights
from steadyload.runs.provenance import key_of
from steadyload.runs.store import JSON, Store, locked

VERSION = 1
"""Version of what is kept: raised when its meaning changes."""


class Said(NamedTuple):
    """Manifest and digest of weights, and a mask of the cases on which they are right, (cases,)."""

    manifest: Mapping[str, Any]
    digest: str
    right: NDArray[np.bool_]


class JudgedPart:
    """Cases with labels, in one order for all methods, and the verdicts of trained weights on them.

    Layouts outside of the training range are judged, too: a small training set has a narrow range
    whatever the features are.

    Args:
        part: of the labelled set.
        folder: of the verdicts.
        limit: largest number of cases a scenario; None for all.
        directory: word or folder of the set; None for the large set of the package.
    """

    def __init__(
        self, part: Part, folder: Path, limit: int | None = None, directory: str | None = None
    ) -> None:
        self._folder = folder
        own = set_named(directory)
        self._sequences = cache(lambda kind: load_sequences(kind, part, directory=own, limit=limit))
        self._store: Store[dict[str, Any], list[Any]] = Store(folder / "said", JSON)

    @cached_property
    def cases(self) -> Sequences:
        """The cases with their labels, scenarios and item lists, whatever the features."""
        return self._sequences(FeatureKind.PLAIN)

    def knows(self, run: Run) -> bool:
        """True if the verdicts of a run are kept."""
        return not self._store.missing([self._key(run)])

    def keep(self, run: Run) -> None:
        """Judge the part by the weights of a run, and keep the verdicts, unless they are kept.

        Raises:
            ResultsError: another run is at work in the folder.
            LearnerError: the weights cannot be read.
        """
        if self.knows(run):
            return
        weights = load_weights(run.weights)
        safe = items_safe(self.probabilities(weights), self.cases.counts)
        said = {"manifest": weights.manifest, "digest": weights.digest, "safe": safe.tolist()}
        with locked(self._folder):
            self._store.write(self._key(run), [said])

    def said(self, run: Run) -> Said:
        """The kept verdicts of a run."""
        (found,) = self._store.read(self._key(run))
        return Said(found["manifest"], found["digest"], np.equal(found["safe"], self.cases.safe))

    def label_sources(self, run: Run) -> str:
        """Sources of the labels of a run, those of the run that it continues first."""
        own = " and ".join(
            "labelled set" if data["name"] == BENCHMARK else str(data.get("label", data["name"]))
            for data in self.said(run).manifest["data"]
        )
        return f"{self.label_sources(run.start)}, then {own}" if run.start else own

    def probabilities(self, weights: Weights) -> Array32:
        """Probabilities that steps are unstable, (cases, most items): mean of all members."""
        rows = self._sequences(weights.kind).padded()
        found: Array32 = np.mean([n.probabilities_of_many(rows) for n in weights.networks], axis=0)
        return found

    def _key(self, run: Run) -> str:
        return key_of(
            {
                "training": run.folder.name,
                "cases": self.cases.fingerprint(),
                "version": VERSION,
                "features": FEATURES,
                "inference": INFERENCE,
            }
        )
