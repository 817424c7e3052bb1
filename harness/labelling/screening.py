"""Labels of large layouts for both questions: MuJoCo screens every step, the reference decides.

The reference takes minutes for a pallet of 50 boxes and an hour for one of 100; MuJoCo at 1 kHz
moves boxes nearly as far in a tenth of the time. So MuJoCo answers about every step, and the
reference about those that are close: where MuJoCo sees something move too far, or by more than
half of a threshold, or comes to no end; where a box stands within 1 mm of its point of balance,
which both then simulate for all of 3 s; and about a random 5 % of all others, which shows what is
missed. Where it is asked, its answer counts. A step at which by MuJoCo the same item moves as far
as at an earlier one, where the reference agreed on how far, is not asked about again, nor is a box
whose balance is as narrow as it was: what has tipped into a gap does so at every later step, too.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa

from steadyload.engines.registry import package_versions
from steadyload.labelling.label_rows import LABEL, case_row
from steadyload.layouts.benchmark.dataset import KEYS, Part, load_benchmark
from steadyload.layouts.benchmark.splits import split_by_instance
from steadyload.layouts.benchmark.tables import (
    CASES,
    SCREENING,
    STANDS,
    UNLABELLED,
    BenchmarkError,
    read_further,
    read_tables,
    write_further,
    write_tables,
)
from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.methods.simulation import step_answers
from steadyload.methods.simulation.simulation import Simulation
from steadyload.methods.simulation.step_answers import StepAnswer, StepAnswers
from steadyload.progress import Progress, silent
from steadyload.runs.asked import AskedCases, asked
from steadyload.runs.pool import IN_THIS_PROCESS, PartLimit
from steadyload.runs.provenance import made_by, provenance
from steadyload.runs.store import Store, locked, parquet
from steadyload.statics.margins import margins

VERSION = 1
"""Version of rows: raised when they come out differently."""

SCREEN = "label@mujoco:frequency=1000"
"""The simulation that answers about every step."""

NEAR = 0.5
"""Multiple of a threshold from which the reference is asked."""

NARROW = 0.1
"""Where balance is lost or won by contact patches that are so much narrower or wider, the reference
is asked [cm]; see :mod:`steadyload.statics.margins`."""

SAME = 0.05
"""Two movements of an item are the same when they differ by less, in units of a threshold."""

CHECKED = 0.05
"""Share of all steps about which the reference is asked whatever MuJoCo says."""

CASE_SECONDS = 4 * 3600.0
"""Hard limit on the CPU time of a case."""

_SHARD = 1
_TURNS = {part: turn for turn, part in enumerate((Part.TEST, Part.VALIDATION, Part.TRAIN))}
_DIGITS = 4

_ROWS = pa.schema(
    [
        *(pa.field(name, pa.string(), nullable=False) for name in (*KEYS, "status", "reason")),
        pa.field("item_count", pa.int16(), nullable=False),
        pa.field("failing_step", pa.int16()),
        pa.field("stands", pa.string(), nullable=False),
        pa.field("failing_step_stands", pa.int16()),
        pa.field("moved_item", pa.int16()),
        pa.field("moved", pa.list_(pa.int16())),
        *(
            pa.field(f"{what}_{when}", pa.list_(pa.float32()))
            for what in ("corner", "angle")
            for when in ("last", "most")
        ),
        *(pa.field(name, pa.list_(pa.float32())) for name in ("margin", "screen", "reference")),
        pa.field("why", pa.list_(pa.string())),
    ]
)


class ScreenedUnit(AskedCases, question="both"):
    """Some cases to be labelled."""

    made_by: Mapping[str, str] = asked("made by")

    def describe(self, part: int) -> str:
        """Description of a case for messages."""
        return f"labels by screening of {super().describe(part)}"


def label_screened(
    directory: Path,
    *,
    most_items: int | None = None,
    workers: int = IN_THIS_PROCESS,
    progress: Progress = silent,
) -> int:
    """Label the unlabelled cases of a set for both questions; returns how many have labels now.

    The test part comes first, then validation and training, each in an order that does not depend
    on the size of layouts: labels of an interrupted run are a sample of all. Whatever is done when
    this ends, or is interrupted, is written into the tables, and is not done again.

    Args:
        directory: of the set; its tables are written anew.
        most_items: only cases of at most so many items; None for all.
        workers: see :func:`steadyload.runs.runner.run_study`.
        progress: called with the cases done and those to be done.

    Raises:
        BenchmarkError: no labelled set, or one of ``benchmark build``, which is labelled and split
            in another way.
        ResultsError: another run is at work in the folder.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    benchmark = load_benchmark(directory)
    if "splits" in benchmark.manifest:
        raise BenchmarkError(
            f"{directory}: was made by `benchmark build`; allowed: a set of large layouts, such as "
            f"`benchmark build-real` makes; for this one run steadyload benchmark label {directory}"
        )
    cases = benchmark.cases[benchmark.cases["status"] == UNLABELLED]
    if most_items is not None:
        cases = cases[cases["item_count"] <= most_items]
    turn = cases["split"].map(_TURNS.get).fillna(len(_TURNS))
    drawn = (cases["layout"] + " " + cases["scenario"]).map(lambda case: zlib.crc32(case.encode()))
    cases = cases.assign(turn=turn, drawn=drawn).sort_values(["turn", "drawn"], kind="stable")
    layouts = tuple(
        (scenario, benchmark.layout(name, scenario))
        for name, scenario in zip(cases["layout"], cases["scenario"], strict=True)
    )
    store = Store(directory / "screening", parquet(_ROWS))
    units = ScreenedUnit(layouts, screened_by()).in_shards(_SHARD)
    with locked(directory):
        try:
            store.complete(
                units,
                screened_rows,
                crashed=partial(_lost_row, Status.CRASHED),
                limit=PartLimit(CASE_SECONDS, partial(_lost_row, Status.TIMEOUT)),
                workers=workers,
                progress=progress,
            )
        finally:
            done = [store.read(unit.key) for unit in units if unit.key in store]
            if done:
                _merge(directory, pd.concat(done, ignore_index=True))
    return int((read_tables(directory)[1]["status"] != UNLABELLED).sum())


def screened_by() -> dict[str, str]:
    """Everything besides the cases that rows depend on, with the present code and packages."""
    return {
        **{f"screen: {name}": value for name, value in made_by(make_method(SCREEN)).items()},
        **{f"reference: {name}": value for name, value in made_by(make_method(LABEL)).items()},
        **package_versions(("numpy", "scipy")),
        "version of answers": str(step_answers.VERSION),
        "version of rows": str(VERSION),
    }


def screened_rows(unit: ScreenedUnit) -> Iterator[dict[str, Any]]:
    """Prepare, then label a unit's cases, in turn: a row for every one."""
    most = max(len(layout) for _, layout in unit.cases)
    for spec in (SCREEN, LABEL):
        make_method(spec).prepare(most)
    return (screened_row(scenario, layout) for scenario, layout in unit.cases)


def screened_row(scenario: str, layout: Layout) -> dict[str, Any]:
    """A case's labels for both questions, with what was seen at every step."""
    with closing(_Screened(scenario, layout)) as loading:
        return loading.row()


class _Screened:
    """One loading, step by step, by two simulations."""

    def __init__(self, scenario: str, layout: Layout) -> None:
        screen, reference = (make_method(spec) for spec in (SCREEN, LABEL))
        assert isinstance(screen, Simulation)
        assert isinstance(reference, Simulation)
        self._scenario, self._layout = scenario, layout
        self._screen = StepAnswers(layout, screen)
        self._reference = StepAnswers(layout, reference)
        seed = [zlib.crc32(layout.name.encode()), zlib.crc32(scenario.encode())]
        self._checked = np.random.default_rng(seed).random(len(layout)) < CHECKED
        self._margins = margins(layout, centres=False)
        # By item: movements on which both agreed, as the screen saw them.
        self._agreed: dict[int, list[float]] = {}
        self._narrow: set[tuple[int, float]] = set()
        self._answers: list[StepAnswer] = []
        self._seen: list[tuple[float, float, str]] = []

    def close(self) -> None:
        """Release resources."""
        self._screen.close()
        self._reference.close()

    def row(self) -> dict[str, Any]:
        """See :func:`screened_row`."""
        failing: int | None = None
        stands, standing, moved = Status.DONE, True, None
        step_stands: int | None = None
        for step in range(len(self._layout)):
            answer = self._answer(step, standing)
            if answer.status is not Status.DONE:
                if standing:
                    stands = answer.status
                return self._row(answer.status, answer.reason, None, stands, step_stands, moved)
            self._answers.append(answer)
            if standing and answer.fails_standing is not False:
                unsettled = answer.fails_standing is None
                stands = Status.UNSETTLED if unsettled else Status.DONE
                step_stands = None if unsettled else step
                standing, moved = False, answer.item
            if answer.fails_within:
                failing = step
                break
        return self._row(Status.DONE, "", failing, stands, step_stands, moved)

    def _answer(self, step: int, standing: bool) -> StepAnswer:
        narrow = self._is_narrow(step)
        seen = self._screen.ask(step, standing=standing, patient=narrow)
        why = self._why(step, seen, standing) or ("narrow" if narrow else "")
        if not why:
            self._seen.append((seen.beyond, np.nan, ""))
            return seen
        answer = self._reference.ask(step, standing=standing, patient=narrow)
        self._seen.append((seen.beyond, answer.beyond, why))
        if answer.status is Status.DONE and abs(answer.beyond - seen.beyond) < SAME:
            self._agreed.setdefault(seen.item, []).append(seen.beyond)
        return answer

    def _is_narrow(self, step: int) -> bool:
        """Whether a box that was not asked about before is within 1 mm of its point of balance."""
        margin = self._margins[step]
        if abs(margin.patches) >= NARROW:
            return False
        known, place = len(self._narrow), (margin.item, round(margin.patches, 3))
        self._narrow.add(place)
        return len(self._narrow) > known

    def _why(self, step: int, seen: StepAnswer, standing: bool) -> str:
        """The reason to ask the reference; empty for none."""
        if seen.status is not Status.DONE or (standing and seen.fails_standing is None):
            return "no end"
        if seen.fails_within or seen.fails_standing:
            return "fails"
        known = any(abs(seen.beyond - far) < SAME for far in self._agreed.get(seen.item, []))
        if seen.beyond > NEAR and not known:
            return "near"
        return "drawn" if self._checked[step] else ""

    def _row(
        self,
        status: Status,
        reason: str,
        failing: int | None,
        stands: Status,
        step_stands: int | None,
        moved: int | None,
    ) -> dict[str, Any]:
        def listed(name: str) -> list[float]:
            return [round(getattr(answer, name), _DIGITS) for answer in self._answers]

        screen, reference, why = (list(part) for part in zip(*self._seen, strict=True))
        return {
            **case_row(self._scenario, self._layout, status, reason),
            "failing_step": failing,
            "stands": str(stands),
            "failing_step_stands": step_stands,
            "moved_item": moved,
            "moved": [answer.item for answer in self._answers],
            **{
                f"{what}_{when}": listed(f"{what}_{when}")
                for what in ("corner", "angle")
                for when in ("last", "most")
            },
            "margin": [round(m.patches, 3) + 0.0 for m in self._margins[: len(self._answers)]],
            "screen": [round(far, _DIGITS) for far in screen],
            "reference": [round(far, _DIGITS) for far in reference],
            "why": why,
        }


def _lost_row(status: Status, unit: ScreenedUnit, part: int, reason: str) -> dict[str, Any]:
    own = case_row(*unit.cases[part], status, reason)
    return dict.fromkeys(_ROWS.names) | own | {"stands": str(status)}


def _merge(directory: Path, rows: pd.DataFrame) -> None:
    """Write labels into the tables of a set."""
    layouts, cases, opinions, manifest = read_tables(directory)
    stands = read_further(directory, "stands")
    screening = read_further(directory, "screening")
    shared = [name for name in CASES.names if name in rows and name not in KEYS]
    new = rows.set_index(KEYS)[shared]
    cases = cases.set_index(KEYS)
    for name in shared:
        cases[name] = cases[name].astype(object)
        cases.loc[new.index, name] = new[name].astype(object)
    cases = cases.reset_index().join(layouts.set_index("layout")["instance"], on="layout")
    shares = {name: manifest.get(name, 0.0) for name in ("test", "validation")}
    cases = split_by_instance(cases, seed=manifest.get("seed", 0), **shares)[CASES.names]
    own = rows[[*KEYS, "stands", "failing_step_stands", "moved_item"]].rename(
        columns={"stands": "status", "failing_step_stands": "failing_step"}
    )
    stands = _with(stands, own.reindex(columns=STANDS.names))
    steps = rows[[*KEYS, "screen", "reference", "why"]].dropna(subset="screen")
    screening = _with(screening, steps[SCREENING.names])
    made = {"label": LABEL, "screen": SCREEN, "labelled_with": provenance()}
    # The cases come last: what they call labelled is in the other tables by then.
    write_further(directory, "stands", stands, made)
    write_further(directory, "screening", screening, made)
    write_tables(directory, layouts, cases, opinions, {**manifest, **made}, keep_further=True)


def _with(table: pd.DataFrame, rows: pd.DataFrame) -> pd.DataFrame:
    """A table with further rows, which replace those of the same cases.

    An interrupted command may have written some of them before.
    """
    return pd.concat([table, rows]).drop_duplicates(KEYS, keep="last", ignore_index=True)
