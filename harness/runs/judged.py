"""Verdicts of several methods on the same cases, as a run folder holds them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
from numpy.typing import NDArray

from steadyload.layouts.model.question import Question, question_named
from steadyload.layouts.model.scenarios import in_usual_order
from steadyload.layouts.sizes import MOST_SMALL
from steadyload.methods.contract.spec import parse_spec
from steadyload.methods.naming import MethodKey, named
from steadyload.runs.definition import AS_GIVEN
from steadyload.runs.labels import LABELS, item_lists, labels_on, load_labels
from steadyload.runs.provenance import provenance_lines
from steadyload.runs.results import KEYS, ResultsError, each_table, in_order, load_manifest
from steadyload.statistics.metrics import outcomes

_COLUMNS = (
    *KEYS, "layout_hash", "item_count", "method_name", "engine", "parameters", "status",
    "failing_step", "score", "substeps", "body_substeps",
    *(f"cpu_{phase}" for phase in ("build", "step", "read", "total")), "wall_total",
)  # fmt: skip

_SETTINGS = ("ignored", "emulated")

NotHonoured = tuple[dict[str, None], dict[str, None]]
"""Settings that an engine ignored, and those that it emulated."""


@dataclass(frozen=True)
class JudgedCases:
    """The cases of a run that every method has judged, so that all have the same cases.

    Attributes:
        manifest: of the run folder.
        keys: methods by spec, in the order of the study.
        rows: result rows of the folder, those of other cases too.
        results: result rows of these cases.
        said: cases x specs, as :func:`steadyload.statistics.metrics.outcomes` gives it.
        labels: of the same cases in the same order, :data:`steadyload.runs.labels.LABELS`; None
            without labels.
        clusters: by case, the cluster for intervals: the item list where it is known, with its
            class of items as stratum, else the layout.
        not_honoured: by spec of a method on an engine, the settings that this ignored, and those
            that it emulated, in the order of the rows.
    """

    manifest: Mapping[str, Any]
    keys: Mapping[str, MethodKey]
    rows: int
    results: pd.DataFrame
    said: pd.DataFrame
    labels: pd.DataFrame | None
    clusters: pd.Series
    not_honoured: Mapping[str, NotHonoured] = field(default_factory=dict)

    @property
    def scenarios(self) -> tuple[str, ...]:
        """Scenarios of the cases, in their usual order."""
        return in_usual_order(map(str, self.said.index.get_level_values("scenario")))

    @property
    def screens(self) -> tuple[str, ...]:
        """Specs of the simulations on which labels of large layouts rest; none without such cases.

        Large is what has more than :data:`.MOST_SMALL` boxes.
        """
        found = self.manifest.get("labels", {}).get("screens", ())
        large = self.labels is not None and (self.labels["item_count"] > MOST_SMALL).any()
        return tuple(found) if large else ()

    @property
    def apart(self) -> frozenset[str]:
        """Specs of methods that are compared with no other: labels rest on their engines."""
        return self.on_screens if self.screens else frozenset()

    @property
    def on_screens(self) -> frozenset[str]:
        """Specs of methods on an engine of the set's screens, whether or not a case is large."""
        screens = self.manifest.get("labels", {}).get("screens", ())
        engines = {parse_spec(spec).engine for spec in screens}
        return frozenset(s for s, key in self.keys.items() if key.engine and key.engine in engines)

    def only(self, cases: NDArray[np.bool_]) -> JudgedCases:
        """Some of the cases.

        Args:
            cases: mask of those that are kept, shape (cases,), one or more.
        """
        said = self.said[cases]
        there = pd.MultiIndex.from_frame(self.results[["layout", "scenario"]]).isin(said.index)
        return replace(
            self,
            results=self.results[there],
            said=said,
            labels=None if self.labels is None else self.labels[cases],
            clusters=self.clusters[cases],
        )

    def beside(self, more: JudgedCases) -> JudgedCases:
        """The cases that two runs have, judged by the methods of both.

        Args:
            more: further methods on labelled cases.

        Raises:
            ResultsError: the runs have no case in common, or one that is not the same in both.
        """
        assert self.labels is not None, "the run is on a labelled set"
        assert more.labels is not None, "the other one is, too"
        own = self.only(self.said.index.isin(more.said.index))
        more = more.only(more.said.index.isin(own.said.index))
        cases = own.said.index
        hashes = [
            one.results.drop_duplicates(cases.names)
            .set_index(cases.names)["layout_hash"]
            .loc[cases]
            for one in (own, more)
        ]
        if not len(cases) or not hashes[0].equals(hashes[1]):
            raise ResultsError(
                f"studies {self.manifest['study']['name']!r} and {more.manifest['study']['name']!r}"
                f" have {len(cases)} cases of the same names; required: one or more, with the same "
                "layouts"
            )
        return replace(
            own,
            keys={**own.keys, **more.keys},
            rows=own.rows + more.rows,
            results=pd.concat([own.results, more.results], ignore_index=True),
            said=own.said.join(more.said),
            not_honoured={**own.not_honoured, **more.not_honoured},
        )

    def of(self, specs: Iterable[str]) -> JudgedCases:
        """Some of the methods, in the order of the study.

        Args:
            specs: canonical ones.
        """
        chosen = set(specs)
        keys = {spec: key for spec, key in self.keys.items() if spec in chosen}
        own = self.results[self.results["method"].isin(chosen)]
        return replace(self, keys=keys, results=own, said=self.said[list(keys)])

    def labelled_by(self, spec: str, classes: Mapping[str, str] | None = None) -> JudgedCases:
        """The cases on which one of the methods has a verdict, with that as the label.

        Args:
            spec: of the method, canonical.
            classes: of cases without labels, the class of every layout; classes are strata of
                intervals. None for one class.

        Raises:
            ResultsError: the method has a verdict on none of the cases.
        """
        known = self.said[spec].notna().to_numpy(bool)
        if not known.any():
            raise ResultsError(f"{spec} has a verdict on none of the cases; allowed: one or more")
        found = self.only(known)
        labels = found._unlabelled(classes or {}) if found.labels is None else found.labels
        placed = found.said[spec].astype("Int64")
        failing = placed.where(placed < labels["item_count"].astype("Int64"))
        about = found.manifest.get("labels") or {"part": spec, "natural_stable": {}}
        return replace(
            found,
            manifest={**found.manifest, "labels": about},
            labels=labels.assign(failing_step=failing),
            clusters=pd.Series(item_lists(labels), found.said.index),
        )

    def _unlabelled(self, classes: Mapping[str, str]) -> pd.DataFrame:
        """Labels of cases that have none; every layout is an item list of its own."""
        cases = self.said.index
        items = self.results.drop_duplicates(cases.names).set_index(cases.names)["item_count"]
        names = cases.get_level_values("layout")
        nothing = dict.fromkeys(set(LABELS.names) - set(cases.names))
        known = {
            "instance": names,
            "item_count": items.loc[cases].to_numpy(),
            "item_class": [classes.get(name, "") for name in names],
        }
        return pd.DataFrame({**nothing, **known}, index=cases).astype({"robust": "boolean"})

    def asked(self, question: Question) -> JudgedCases:
        """The cases that have a label of a question, with that as the label.

        The cases are labelled; none of them may have a label of the question. What is known of the
        labels of the question ``within`` alone, its ensemble and the share of stable layouts in the
        whole set, is left behind with them.
        """
        assert self.labels is not None, "the run is on a labelled set"
        if question_named(question) == Question.WITHIN:
            return self
        labels = labels_on(self.labels, question)
        found = self.only(self.labels.index.isin(labels.index))
        nothing = pd.array([pd.NA] * len(labels), "boolean")
        labels = labels.assign(confidence=math.nan, robust=nothing, stands=None)
        about = {**self.manifest["labels"], "natural_stable": {}}
        return replace(found, manifest={**self.manifest, "labels": about}, labels=labels)

    def with_confidence(self, sure: pd.DataFrame) -> JudgedCases:
        """The same cases, with what an ensemble of references says of their labels.

        Args:
            sure: by layout and scenario, see
                :func:`steadyload.layouts.benchmark.confidence.confidence`.
        """
        assert self.labels is not None, "the run is on a labelled set"
        columns = ["confidence", "robust"]
        known = sure[columns].reindex(self.labels.index).astype({"robust": "boolean"})
        return replace(self, labels=self.labels.assign(**{name: known[name] for name in columns}))


def load_judged(directory: str | Path) -> JudgedCases:
    """The cases and verdicts that a run folder holds.

    Raises:
        ResultsError: not a run folder, or no case in it has been judged by all methods yet.
    """
    directory = Path(directory)
    manifest = load_manifest(directory)
    not_honoured: dict[str, NotHonoured] = {}
    tables = each_table(directory, manifest, [*_COLUMNS, *_SETTINGS])
    results = in_order([_without_settings(table, not_honoured) for table in tables])
    order = [m for m in manifest["study"]["methods"] if m in set(results["method"])]
    rows, results = len(results), _judged_by_all(results, len(order))
    if results.empty:
        raise ResultsError(f"{directory}: no case has been judged by all methods yet; resume it")
    first = results.drop_duplicates("method").set_index("method")
    said = outcomes(results)[order]
    labels = _labels(directory, manifest, said) if "labels" in manifest else None
    # Layouts packed from one item list are alike: where lists are known, they are the clusters.
    layouts = said.index.get_level_values("layout")
    clusters = pd.Series(layouts if labels is None else item_lists(labels), said.index)
    keys = {m: _key(m, first.loc[m]) for m in order}
    return JudgedCases(manifest, keys, rows, results, said, labels, clusters, not_honoured)


def _without_settings(table: pa.Table, found: dict[str, NotHonoured]) -> pa.Table:
    """A shard without the settings that were not honoured, which take as much memory as all else.

    Args:
        table: the shard.
        found: gets those of its methods on engines.
    """
    if table["engine"].null_count < len(table):
        rows = (table[name].to_pylist() for name in ("method", *_SETTINGS))
        for method, *settings in zip(*rows, strict=True):
            for names, more in zip(found.setdefault(method, ({}, {})), settings, strict=True):
                names |= dict.fromkeys(more)
    return table.drop_columns(list(_SETTINGS))


def _judged_by_all(results: pd.DataFrame, methods: int) -> pd.DataFrame:
    judged = results.groupby(["layout", "scenario"])["method"].transform("nunique")
    return results[judged == methods].copy()


def _key(spec: str, row: pd.Series) -> MethodKey:
    engine = None if pd.isna(row["engine"]) else str(row["engine"])
    return named(row["method_name"], spec, engine)


def _labels(directory: Path, manifest: Mapping[str, Any], said: pd.DataFrame) -> pd.DataFrame:
    """The labels of the cases that have been judged, in their order."""
    labels = load_labels(directory, manifest)
    missing = said.index.difference(labels.index)
    if len(missing):
        name, scenario = missing[0]
        raise ResultsError(
            f"{directory}: layout {name!r} has no label in scenario {scenario!r}; run the study "
            "again to write the labels anew"
        )
    return labels.loc[said.index]


def manifest_lines(judged: JudgedCases) -> dict[str, str]:
    """Provenance of a run, as a page shows it."""
    manifest = judged.manifest
    study, labels = manifest["study"], manifest.get("labels")
    source = {"layout files": ", ".join(study["files"])}
    drawn = {"scenarios": ", ".join(study["scenarios"]) or AS_GIVEN, "seed": str(study["seed"])}
    if labels is not None:
        source = {"labelled set": f"part {labels['part']}, {labels['cases']} cases "
                                  f"(labels {labels['hash']})"}  # fmt: skip
    return {
        "study": f"{study['name']} ({manifest['study_hash']})",
        **source,
        "layouts": f"{manifest['layouts']} (data {manifest['data_hash']})",
        **(drawn if labels is None else {}),
        "rows": str(judged.rows),
        **provenance_lines(manifest),
        "started": manifest["started"],
        "finished": manifest["finished"] or "not yet",
    }
