"""Verdicts and labels of kept rows beside those that this machine gives, case by case.

A verdict differs where its status or its failing step does. Shares are 0 to 1.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from steadyload.app.recommend.kept import SPATIAL
from steadyload.layouts.benchmark import Benchmark, load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.methods.contract.method import Status
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.methods.tuned import TUNED, tuned_engines
from steadyload.reports.columns import column, compact, markdown, percent, row
from steadyload.runs.able import able_methods
from steadyload.runs.definition import StudyError
from steadyload.runs.kept_only import kept_only
from steadyload.runs.labels import Cases, item_lists, load_labels
from steadyload.runs.provenance import provenance, provenance_lines
from steadyload.runs.results import load_manifest, load_results
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.studies.kept_rows import unpacked_rows
from steadyload.studies.kit import Lab

PAGE = "evaluation"
"""The page whose verdicts are judged again."""

CASES, MADE_AGAIN = 300, 60
"""Cases that are drawn at random, and those of them whose labels are made again."""

_SEED = 0
"""Of the draw."""

JUDGED, LABELS = "judged", "labels"
"""Folders of the runs on this machine, of verdicts and of labels."""

_SHARD = 60
_COLUMNS = (
    *KEYS, "method", "repetition", "layout_hash", "parameters", "status", "failing_step",
    "displacement_cm", "rotation_deg",
)  # fmt: skip


def usual_methods() -> tuple[str, ...]:
    """Specs of the methods that the published page judges again, on all tuned engines."""
    tuned = (f"{TUNED}@{engine}" for engine in tuned_engines())
    return ("sme", "equilibrium", "equilibrium:time=0.3", "lstm_e", "cascade@mujoco", *tuned)


@row
class Again:
    """Verdicts of one method in the rows and here, on the same cases.

    ``numbers``: equal verdicts that say how far a box moved.
    """

    method: MethodKey = column(form=attrgetter("title"), left=True)
    n: int = column()
    differ: int = column(about="verdicts with another status or failing step")
    share: Estimate = column("differ %", percent)
    numbers: int
    equal: Estimate | None = column(
        "equal to the last bit %", percent, "of ``numbers``, distance and angle; None without any"
    )
    apart_cm: float | None = column(
        "most apart cm", compact, "greatest difference of these distances"
    )
    apart_deg: float | None = column("most apart degrees", compact, "greatest of the angles")


@row
class Difference:
    """A verdict that differs. A failing step counts from 0."""

    method: str = column()
    layout: str = column(form=markdown)
    scenario: str = column()
    label: str = column()
    then: str = column("in the rows")
    now: str = column("here")


@row
class Found:
    """Everything that the page shows.

    ``every``: share of all verdicts that differ. ``of``: cases of the rows, of which ``cases`` were
    drawn. ``then``, ``now``, ``labelled``: machines of the rows, of the verdicts here, of the
    labels. ``packages``: versions of packages that are others, those of the rows first.
    ``set_name``, ``part``: of the labelled set.
    """

    methods: Sequence[Again]
    every: Estimate
    labels: Again
    differences: Sequence[Difference]
    cases: int
    of: int
    layouts: int
    item_lists: int
    set_name: str
    part: str
    then: str
    now: str
    labelled: str
    packages: Mapping[str, tuple[str, str]]
    left_out: Mapping[str, str]
    made_with: Mapping[str, str]

    @property
    def number(self) -> int:
        """Verdicts that differ."""
        return sum(own.differ for own in self.methods)


def judge_again(lab: Lab, limit: int | None = None) -> Found:
    """Judge cases of kept rows again, as far as that is missing, and compare."""
    with _folder() as folder:
        then, manifest = _rows(folder), load_manifest(folder)
        known = load_labels(folder, manifest)
    labelled = load_benchmark(manifest["labels"]["set"])
    able, left_out = able_methods(
        (), lambda: filter(set(usual_methods()).__contains__, manifest["study"]["methods"])
    )
    again = known.sample(min(CASES, limit or CASES, len(known)), random_state=_SEED).index
    drawn = labelled.cases.set_index(KEYS).loc[again].reset_index()
    index = pd.MultiIndex.from_frame(drawn[KEYS])
    lists = pd.Series(item_lists(known), known.index)
    said = known["failing_step"].map(lambda step: _answer(Status.DONE, step))

    now, made = _judged(lab, able, labelled.drawn(drawn), JUDGED, manifest["study"]["timeout"])
    _refuse_others(then, now)
    pairs = {spec: _pairs(then.loc[spec], now.loc[spec], index) for spec in able}
    label, fewer = str(make_method(labelled.manifest["label"]).spec), drawn.head(MADE_AGAIN)
    own, _ = _judged(lab, (label,), labelled.drawn(fewer), LABELS, None)
    stored = known.assign(status=str(Status.DONE), displacement_cm=None, rotation_deg=None)
    pairs[label] = _pairs(stored, own.loc[label], pd.MultiIndex.from_frame(fewer[KEYS]))
    differs = pd.concat([pairs[spec]["differs"] for spec in able])
    return Found(
        methods=[_again(spec, pairs[spec], lists) for spec in able],
        every=share(differs, lists.loc[differs.index].to_numpy()),
        labels=_again(label, pairs[label], lists),
        differences=[one for spec, own in pairs.items() for one in _differences(spec, own, said)],
        cases=len(drawn),
        of=len(known),
        layouts=drawn["layout"].nunique(),
        item_lists=lists.loc[index].nunique(),
        set_name=manifest["labels"]["set"],
        part=manifest["labels"]["part"],
        then=manifest["machine"],
        now=made["machine"],
        labelled=labelled.manifest["labelled_with"]["machine"],
        packages={
            name: (version, made["versions"][name])
            for name, version in manifest["versions"].items()
            if made["versions"].get(name, version) != version
        },
        left_out=left_out,
        made_with=_made_with(manifest, made),
    )


@contextmanager
def _folder() -> Iterator[Path]:
    """The run folder of the packed rows, while the context lasts."""
    with tempfile.TemporaryDirectory() as folder:
        yield unpacked_rows(PAGE, Path(folder)) / SPATIAL


def _rows(folder: Path) -> pd.DataFrame:
    """First verdicts of a run folder, by method, layout and scenario."""
    rows = load_results(folder, _COLUMNS)
    return rows[rows["repetition"] == 0].set_index(["method", *KEYS]).sort_index()


def _judged(
    lab: Lab, specs: Sequence[str], cases: Benchmark, folder: str, timeout: float | None
) -> tuple[pd.DataFrame, Mapping[str, Any]]:
    """Verdicts on this machine, and the manifest of their run."""
    with _of_one_machine(lab.work / folder):
        lab.judge(
            specs, Cases(cases), timeout=timeout, folder=folder, name=f"determinism {folder}",
            shard_size=_SHARD,
        )  # fmt: skip
    return _rows(lab.work / folder), load_manifest(lab.work / folder)


def _of_one_machine(folder: Path) -> AbstractContextManager[None]:
    """Let nothing be judged here for a folder with verdicts of another machine."""
    if not (folder / "manifest.json").exists():
        return nullcontext()
    there, here = load_manifest(folder)["machine"], provenance()["machine"]
    if there == here:
        return nullcontext()
    return kept_only(
        f"those that are kept are of {there}, and this is {here}: name another folder with --work"
    )


def _refuse_others(then: pd.DataFrame, now: pd.DataFrame) -> None:
    """Refuse to compare verdicts on other layouts, or of other parameters.

    Raises:
        StudyError: they are.
    """
    told = then.reindex(now.index)
    for what in ("layout_hash", "parameters"):
        others = now.index[told[what].to_numpy() != now[what].to_numpy()]
        if len(others):
            method, layout, scenario = others[0]
            raise StudyError(
                f"method {method}, layout {layout!r}, {scenario}: {what} of the rows is "
                f"{told.loc[others[0], what]}, here {now.loc[others[0], what]}; allowed: rows that "
                "are not stale"
            )


def _pairs(then: pd.DataFrame, now: pd.DataFrame, cases: pd.MultiIndex) -> pd.DataFrame:
    """Answers of one method by case, in the rows and here, and what differs.

    ``apart_cm``, ``apart_deg`` and ``equal`` (1 or 0) are not numbers where verdicts differ or one
    of them says nothing of how far a box moved.
    """
    then, now = then.loc[cases], now.loc[cases]
    answers = {
        when: [_answer(*one) for one in zip(own["status"], own["failing_step"], strict=True)]
        for when, own in (("then", then), ("now", now))
    }
    found = pd.DataFrame(answers, index=cases)
    found["differs"] = found["then"] != found["now"]
    apart = {
        name: pd.Series(np.abs(then[said].to_numpy(float) - now[said].to_numpy(float)), cases)
        for name, said in (("apart_cm", "displacement_cm"), ("apart_deg", "rotation_deg"))
    }
    comparable = ~found["differs"] & apart["apart_cm"].notna() & apart["apart_deg"].notna()
    equal = (apart["apart_cm"] == 0.0) & (apart["apart_deg"] == 0.0)
    for name, values in {**apart, "equal": equal.astype(float)}.items():
        found[name] = values.where(comparable)
    return found


def _answer(status: str, failing_step: Any) -> str:
    if status != Status.DONE:
        return str(status)
    return "stable" if pd.isna(failing_step) else f"step {int(failing_step)}"


def _again(spec: str, pairs: pd.DataFrame, lists: pd.Series) -> Again:
    own = lists.loc[pairs.index]
    told = pairs["equal"].notna()
    return Again(
        method_key(make_method(spec)),
        n=len(pairs),
        differ=int(pairs["differs"].sum()),
        share=share(pairs["differs"], own.to_numpy()),
        numbers=int(told.sum()),
        equal=share(pairs["equal"][told] == 1.0, own[told].to_numpy()) if told.any() else None,
        apart_cm=float(pairs["apart_cm"].max()) if told.any() else None,
        apart_deg=float(pairs["apart_deg"].max()) if told.any() else None,
    )


def _differences(spec: str, pairs: pd.DataFrame, said: pd.Series) -> list[Difference]:
    title = method_key(make_method(spec)).title
    own = pairs[pairs["differs"]].sort_index().reset_index()
    return [
        Difference(title, layout, scenario, said[layout, scenario], then, now)
        for layout, scenario, then, now in zip(
            *(own[k] for k in (*KEYS, "then", "now")), strict=True
        )
    ]


def _made_with(then: Mapping[str, Any], now: Mapping[str, Any]) -> dict[str, str]:
    """Provenance of both runs."""
    times = {"started": now["started"], "finished": now["finished"] or "not yet"}
    return {**provenance_lines(then, of="rows"), **times, **provenance_lines(now)}
