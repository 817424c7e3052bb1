"""Labels for a set of layouts: traces by the reference, splits, and verdicts of further methods.

A folder is worked on in place. ``traces/`` and ``opinions/`` in it hold the results, in shards of a
:class:`steadyload.runs.store.Store`: an interrupted run is resumed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from steadyload.labelling.building.build import BuildOptions, build
from steadyload.labelling.building.real import (
    Before,
    ListInputs,
    RealInputs,
    RealOptions,
    build_further,
    build_real,
    further_manifest,
    list_sources,
    real_manifest,
)
from steadyload.labelling.building.splits import (
    FURTHER_DRAWS,
    SplitSizes,
    assign_splits,
    drawn_instances,
    splits_of_manifest,
)
from steadyload.labelling.label_rows import (
    CASE_SECONDS,
    LABEL,
    LIMITS,
    TRACES,
    TraceUnit,
    lost_row,
    trace_unit,
    traced_by,
)
from steadyload.layouts.benchmark.confidence import Reason
from steadyload.layouts.benchmark.dataset import KEYS, Benchmark, load_benchmark, stored_offsets
from steadyload.layouts.benchmark.parts import HELD_OUT
from steadyload.layouts.benchmark.tables import (
    CASES,
    OPINIONS,
    UNLABELLED,
    BenchmarkError,
    no_rows,
    read_tables,
    refuse_foreign,
    write_tables,
)
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.question import Question
from steadyload.layouts.model.scenarios import Scenario
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.progress import NamedProgress, Progress, silent
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.pool import IN_THIS_PROCESS, PartLimit
from steadyload.runs.provenance import provenance
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.runs.store import Store, locked, parquet
from steadyload.runs.units import timed_out_row

_SHARD = 48


@dataclass(frozen=True, slots=True)
class FurtherMethod:
    """A further method that judges validation and test, and the reason it may disagree."""

    reason: Reason
    spec: str


JUDGES: tuple[FurtherMethod, ...] = (
    FurtherMethod(Reason.NUMERICAL, f"{LABEL}:tolerance=1e-6"),
    FurtherMethod(Reason.NUMERICAL, f"{LABEL}:jitter=1e-5"),
    FurtherMethod(Reason.NUMERICAL, f"{LABEL}:jitter=1e-4"),
    # A hundredth of the stiffness: the limit that light items' contacts keep is a rate, its root.
    FurtherMethod(Reason.MODEL, f"{LABEL}:stiffness=1e7,most_rate=3e3"),
    FurtherMethod(Reason.MODEL, f"{LABEL}:friction=0.4"),
    FurtherMethod(Reason.MODEL, f"{LABEL}:friction=0.6"),
    FurtherMethod(Reason.MODEL, f"{LABEL}:damping_time=3e-4"),
    FurtherMethod(Reason.LOADING, f"{LABEL}:between_steps=carry"),
    FurtherMethod(Reason.ENGINE, "label@mujoco:frequency=1000"),
    FurtherMethod(Reason.ENGINE, "label@bullet:frequency=480"),
)
"""Further methods that simulate anew; thresholds and times (``limits``) are read off the traces."""

FEW_JUDGES = tuple(
    judge
    for judge in JUDGES
    if judge.spec in (f"{LABEL}:tolerance=1e-6", f"{LABEL}:friction=0.4", f"{LABEL}:friction=0.6")
)
"""One numerical change and two of the model, for minutes instead of hours, and a weaker ``robust``:
jitter opens and closes every contact, which costs the reference ten times as much."""

PANELS: Mapping[str, tuple[FurtherMethod, ...]] = {"all": JUDGES, "few": FEW_JUDGES, "none": ()}
"""Further methods by the name of their panel."""


def build_set(options: BuildOptions, directory: Path, progress: Progress = silent) -> int:
    """Write the layouts and unlabelled cases to ``directory``; returns the number of cases.

    Raises:
        PackingError: an option that is not allowed.
        BenchmarkError: the folder already holds a set.
    """
    _refuse_set(directory)
    # Lists that follow those of the large set share no geometry with it, not even by chance.
    known: frozenset[str] = frozenset()
    if options.first_instance:
        large = load_benchmark()
        known = _geometries(large, large.layouts.index)
    layouts, cases = build(options, progress, apart_from=known)
    manifest = {
        "origin": "generated",
        "seed": options.seed,
        "instances": options.instances,
        "first_instance": options.first_instance,
        "most_layouts": options.most_layouts,
        "item_counts": {str(k): v for k, v in options.item_counts.items()},
        "weights": str(options.weights),
        "planar": options.planar,
        "fewest_items": options.fewest_items,
        "splits": options.splits.stored(),
        "built_with": provenance(),
    }
    return write_unlabelled(directory, layouts, cases, manifest)


def _geometries(benchmark: Benchmark, names: Iterable[str]) -> frozenset[str]:
    """Hashes of the geometries of some layouts of a set."""
    return frozenset(benchmark.layout(n, str(Scenario.S1)).geometry_hash() for n in names)


def build_real_set(
    options: RealOptions, inputs: RealInputs, directory: Path, progress: Progress = silent
) -> int:
    """Write layouts of real size and unlabelled cases; returns the number of cases.

    Raises:
        UserError: see :func:`steadyload.labelling.building.real.build_real`.
        BenchmarkError: the folder already holds a set.
        OSError: a file cannot be read.
    """
    _refuse_set(directory)
    layouts, cases = build_real(options, inputs, progress)
    manifest = real_manifest(options, inputs) | {"built_with": provenance()}
    return write_unlabelled(directory, layouts, cases, manifest)


def extend_real_set(
    options: RealOptions, inputs: ListInputs, directory: Path, progress: Progress = silent
) -> int:
    """Add a further draw to a set of real size; returns the number of unlabelled cases added.

    What is there stays: layouts, cases, labels, and the splits and ranks of labelled cases. A run
    that was interrupted while it wrote can be repeated.

    Args:
        options: of the draw, :data:`steadyload.labelling.building.real.FURTHER`.
        inputs: the files that the set was made from.
        directory: of the set; its tables are written anew.
        progress: called with item lists packed and item lists in all.

    Raises:
        UserError: see :func:`steadyload.labelling.building.real.build_further`.
        BenchmarkError: no set of `benchmark build-real`, one that has a further draw, or other
            files.
        ResultsError: another run is at work in the folder.
        OSError: a file cannot be read.
    """
    benchmark = load_benchmark(directory)
    with locked(directory):
        layouts, cases, opinions, manifest = read_tables(directory)
        _refuse_draw(directory, manifest, inputs)
        # The manifest is written last: rows beyond its counts are of an interrupted run.
        layouts, cases = layouts.head(manifest["layouts"]), cases.head(manifest["cases"])
        before = Before(
            manifest["containers"],
            frozenset(layouts["instance"]),
            _geometries(benchmark, layouts["layout"]),
        )
        new, drawn = build_further(options, inputs, before, progress)
        draw = further_manifest(options, inputs, before, new) | {"built_with": provenance()}
        manifest = manifest | {FURTHER_DRAWS: [draw]}
        layouts = pd.concat([layouts, new], ignore_index=True)
        cases = pd.concat([cases, _unlabelled(drawn)], ignore_index=True)
        instance = cases["layout"].map(layouts.set_index("layout")["instance"])
        cases = splits_of_manifest(cases.assign(instance=instance), manifest)[CASES.names]
        write_tables(directory, layouts, cases, opinions, manifest, keep_further=True)
    return len(drawn)


def _refuse_draw(directory: Path, manifest: Mapping[str, Any], inputs: ListInputs) -> None:
    """Raises BenchmarkError where a further draw cannot be added."""
    if manifest.get("origin") != "real":
        raise BenchmarkError(
            f"{directory}: was not made by `benchmark build-real`; allowed: a set that was"
        )
    if FURTHER_DRAWS in manifest:
        raise BenchmarkError(f"{directory}: has a further draw already; allowed: a set without one")
    for name, source in list_sources(inputs).items():
        if source["files"] != manifest["sources"][name]["files"]:
            raise BenchmarkError(
                f"{name}: are other files than those that {directory} was made from; allowed: those"
            )


def _refuse_set(directory: Path) -> None:
    """Raises BenchmarkError where a new set cannot be written."""
    if (directory / "manifest.json").exists():
        raise BenchmarkError(f"{directory}: already holds something; choose another folder")
    refuse_foreign(directory)


def write_unlabelled(
    directory: Path,
    layouts: pd.DataFrame,
    cases: Sequence[tuple[str, Layout]],
    manifest: dict[str, Any],
) -> int:
    """Write a set without labels; returns the number of cases.

    Args:
        directory: made when it does not exist.
        layouts: a row a geometry, :data:`steadyload.layouts.benchmark.tables.LAYOUTS`.
        cases: scenario and layout with its centres of mass; names as in ``layouts``.
        manifest: holds at least the ``seed`` of the splits.
    """
    write_tables(directory, layouts, _unlabelled(cases), no_rows(OPINIONS), manifest)
    return len(cases)


def _unlabelled(cases: Sequence[tuple[str, Layout]]) -> pd.DataFrame:
    """Rows of the table of cases, without labels and splits."""
    rows = [
        {
            "layout": layout.name,
            "scenario": scenario,
            "item_count": len(layout),
            "offsets": stored_offsets(layout),
            "status": UNLABELLED,
        }
        for scenario, layout in cases
    ]
    return pd.DataFrame(rows).reindex(columns=CASES.names)


def label_set(
    directory: Path,
    *,
    sizes: SplitSizes | None = None,
    judges: Sequence[FurtherMethod] = JUDGES,
    workers: int = IN_THIS_PROCESS,
    progress: NamedProgress = silent,
) -> None:
    """Label all cases of a folder, split them, and judge validation and test by further methods.

    Args:
        directory: as :func:`build_set` leaves it; labels are written into its tables.
        sizes: of validation and test; None for those of the manifest, :func:`split_sizes`.
        judges: the further methods.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with the current work, cases done and cases in all.

    Raises:
        BenchmarkError: no such folder, one of an imported set, or too few stable or unstable cases
            for the splits.
        ResultsError: another run is at work in the folder.
        EngineNotInstalledError: a method's engine is missing.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    manifest = read_tables(directory)[3]
    if manifest.get("origin") == "real":
        raise BenchmarkError(
            f"{directory}: is a set of large layouts, which the reference alone takes weeks for; "
            f"run steadyload benchmark screen {directory}"
        )
    if manifest.get("origin") == "imported" or "seed" not in manifest:
        raise BenchmarkError(f"{directory}: was not made by `benchmark build`; its labels stay")
    for judge in judges:
        make_method(judge.spec).prepare()
    with locked(directory):
        _label(directory, sizes or split_sizes(manifest), judges, workers, progress)


def split_sizes(manifest: Mapping[str, Any]) -> SplitSizes:
    """Sizes of the splits in a set's manifest: as built, or as labelled last.

    Raises:
        BenchmarkError: the manifest's sizes are not allowed.
    """
    try:
        return SplitSizes(**manifest.get("splits", {}))
    except TypeError:
        raise BenchmarkError(f"manifest: splits is {manifest['splits']!r}") from None


def _label(
    directory: Path,
    sizes: SplitSizes,
    judges: Sequence[FurtherMethod],
    workers: int,
    progress: NamedProgress,
) -> None:
    traces = _traced(directory, workers, partial(progress, "labels"))
    layouts, cases, _, manifest = read_tables(directory)
    kept = cases[[*KEYS, "offsets", "split", "rank"]]
    cases = kept.merge(traces, on=KEYS, how="left", validate="1:1")
    groups = layouts.set_index("layout")[["instance", "item_class"]]
    cases = assign_splits(cases.join(groups, on="layout"), seed=manifest["seed"], sizes=sizes)
    asked = cases[cases["split"].isin(HELD_OUT)]
    opinions = _limits(asked)
    manifest = manifest | {"label": LABEL, "splits": sizes.stored(), "labelled_with": provenance()}
    write_tables(directory, layouts, cases, opinions, manifest)
    for part in sorted(asked["split"].unique(), reverse=True):
        said = _asked(directory, part, judges, workers, progress)
        opinions = pd.concat([opinions, said], ignore_index=True)
    write_tables(directory, layouts, cases, opinions, manifest)


def _traced(directory: Path, workers: int, progress: Progress) -> pd.DataFrame:
    """Traces of all cases, computed where they are missing."""
    benchmark = load_benchmark(directory)
    names = zip(benchmark.cases["scenario"], benchmark.cases["layout"], strict=True)
    cases = tuple((scenario, benchmark.layout(name, scenario)) for scenario, name in names)
    units = TraceUnit(cases, traced_by()).in_shards(_SHARD)
    store = Store(directory / "traces", parquet(TRACES))
    store.complete(
        sorted(units, key=_turn(benchmark)),
        trace_unit,
        crashed=partial(lost_row, Status.CRASHED),
        limit=PartLimit(CASE_SECONDS, partial(lost_row, Status.TIMEOUT)),
        workers=workers,
        progress=progress,
    )
    return pd.concat([store.read(unit.key) for unit in units], ignore_index=True)


def _turn(benchmark: Benchmark) -> Callable[[TraceUnit], int]:
    """Sort key of units: held-out instances first, so that further methods can judge them early."""
    classes = benchmark.cases.join(benchmark.layouts["item_class"], on="layout")
    rounds = drawn_instances(classes, seed=benchmark.manifest["seed"])
    turn = {name: k for k, members in enumerate(rounds) for name in members}
    instances = benchmark.layouts["instance"]
    return lambda unit: min(turn[instances[layout.name]] for _, layout in unit.cases)


def _limits(cases: pd.DataFrame) -> pd.DataFrame:
    """Failing steps of the traces under other thresholds and times."""
    said = [
        cases[KEYS].assign(
            question=str(Question.WITHIN),
            reason=str(Reason.LIMITS),
            judge=str(make_method(spec).spec),
            status=str(Status.DONE),
            failing_step=cases[spec],
        )
        for spec in LIMITS
    ]
    return pd.concat(said, ignore_index=True)


def _asked(
    directory: Path,
    part: str,
    judges: Sequence[FurtherMethod],
    workers: int,
    progress: NamedProgress,
) -> pd.DataFrame:
    """Verdicts of the further methods on a part."""
    if not judges:
        return no_rows(OPINIONS)
    study = StudyDefinition(
        name=f"opinions on {part}",
        methods=tuple(reasons_of(judges)),
        benchmark=part,
        benchmark_directory=directory,
        shard_size=50,
    )
    folder = directory / "opinions" / part
    rows = judged(study, folder, workers, partial(progress, part))
    return further_rows(rows, judges, Question.WITHIN)


def reasons_of(judges: Sequence[FurtherMethod]) -> dict[str, str]:
    """The reasons of further methods, by canonical spec."""
    return {str(make_method(judge.spec).spec): str(judge.reason) for judge in judges}


def further_rows(
    rows: pd.DataFrame, judges: Sequence[FurtherMethod], question: Question
) -> pd.DataFrame:
    """Result rows of further methods on a question as rows of the table of opinions."""
    return rows.assign(
        question=str(question),
        reason=rows["method"].map(reasons_of(judges)),
        judge=rows["method"],
        failing_step=rows["failing_step"].astype("Int16"),
    )[OPINIONS.names]


def judged(study: StudyDefinition, folder: Path, workers: int, progress: Progress) -> pd.DataFrame:
    """Rows of a study on cases that are labelled; what is there is not judged again."""
    folder.parent.mkdir(exist_ok=True)
    limit = PartLimit(CASE_SECONDS, timed_out_row)
    run_study(study, folder, workers=workers, limit=limit, progress=progress)
    return load_results(folder)
