"""Scoring a user's own layout files: one record per layout and method."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from steadyload.layouts.floor import FloorKind
from steadyload.layouts.formats import scan_layouts
from steadyload.layouts.model import Layout
from steadyload.layouts.record import Refused
from steadyload.layouts.scenarios import Scenario
from steadyload.methods.envelope import leaves
from steadyload.methods.method import Method, Status, Verdict, judge
from steadyload.methods.registry import make_method
from steadyload.methods.uncertainty import Uncertainty
from steadyload.runs.definition import case
from steadyload.runs.verdict_reliability import Sampling, VerdictReliability, verdict_reliability

Record = dict[str, Any]


def score_layouts(
    files: Sequence[str | Path],
    methods: Sequence[str],
    *,
    scenario: Scenario | None = None,
    seed: int = 0,
    max_items: int | None = None,
    limit: int | None = None,
    snap_gap: float = 0.0,
    overhang: float | None = None,
    floor: FloorKind | str | None = None,
    skip_invalid: bool = False,
    timeout: float | None = None,
    uncertainty: Uncertainty | None = None,
    sampling: Sampling | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> list[Record]:
    """Judge every layout of some files with every method. All input is checked before any judging.

    Args:
        files: layout files in any known format.
        methods: spec strings.
        scenario: draw centres of mass; None keeps those of the file.
        seed: seed of the scenario.
        max_items: judge only the first items of each layout.
        limit: use only the first layouts.
        snap_gap: close vertical gaps up to this when reading [cm]; 0 closes none.
        overhang: how far items may stand out over the edges of the deck [cm]; None for what a file
            states, or else 10.
        floor: ``auto``, ``deck`` or ``infinite``; None for what a file states, or else ``auto``,
            see :class:`steadyload.layouts.floor.FloorKind`.
        skip_invalid: make an invalid layout a record with status ``refused`` instead of an error.
        timeout: wall seconds a judgement may take.
        uncertainty: the quantities that deviate from the plans; None judges the plans alone.
        sampling: the rule by which sampling of deviations ends; None for the defaults.
        progress: called with the number of finished judgements and of all.

    Returns:
        Records with the keys ``layout, file, method, items, scenario, floor, score, failing_step,
        status, moved_item, displacement, rotation, reason, ignored, emulated, outside, seconds,
        cpu_seconds``; ``floor`` is ``deck`` or ``infinite``, times are wall and CPU seconds of the
        whole judgement, ``outside`` lists in which quantities the layout leaves the envelope of the
        method's engine.

    Raises:
        LayoutError: a file or layout is invalid (not with ``skip_invalid``, which still refuses a
            file that cannot be read at all).
        SpecError: a method does not exist.
        EngineNotInstalledError: a method's engine is missing.
    """
    judges = [make_method(spec) for spec in methods]
    for method in judges:
        method.prepare()
    reading = {"snap_gap": snap_gap, "overhang": overhang, "floor": floor}
    entries = _read(files, limit, reading, skip_invalid)
    records: list[Record] = []
    total = len(entries) * len(judges)
    progress(0, total)
    for file, entry in entries:
        if isinstance(entry, Layout):
            entry = case(entry, scenario, seed, max_items)
        for method in judges:
            found = None
            if uncertainty is not None and isinstance(entry, Layout):
                found = verdict_reliability(method, entry, uncertainty, sampling, timeout=timeout)
            record = _record(file, entry, method, scenario, timeout, found)
            if uncertainty is not None:
                record["uncertain"] = found and uncertain_record(found)
            records.append(record)
            progress(len(records), total)
    return records


def uncertain_record(found: VerdictReliability) -> Record:
    """The reliability of a verdict as values that JSON can hold.

    Returns:
        ``stands``, the probability that the whole load stands, with the ``interval`` that holds it
        (95 %); ``distribution``, the share of every failing step as a text, ``none`` for none;
        ``likeliest_step`` with ``likeliest_share``, null for none; ``expected_score``; ``samples``
        and those ``without_verdict`` by status, ``why`` the first of these; ``ending``,
        ``without_effect``; ``seconds`` and ``cpu_seconds`` for everything. See
        :class:`steadyload.runs.verdict_reliability.VerdictReliability`.
    """
    shares = found.shares
    likeliest = found.likeliest if shares else None
    return {
        "stands": found.stands,
        "interval": [found.low, found.high],
        "distribution": {"none" if k is None else str(k): share for k, share in shares.items()},
        "likeliest_step": likeliest,
        "likeliest_share": shares.get(likeliest),
        "expected_score": found.expected_score,
        "samples": found.samples,
        "without_verdict": dict(found.without_verdict),
        "why": found.why,
        "ending": str(found.ending),
        "without_effect": list(found.without_effect),
        "seconds": found.wall,
        "cpu_seconds": found.cpu,
    }


def _read(
    files: Sequence[str | Path], limit: int | None, reading: Mapping[str, Any], skip_invalid: bool
) -> list[tuple[str, Layout | Refused]]:
    entries: list[tuple[str, Layout | Refused]] = []
    for file in files:
        for entry in scan_layouts(file, **reading):
            if isinstance(entry, Refused) and not skip_invalid:
                raise entry.error
            entries.append((str(file), entry))
            if limit is not None and len(entries) == limit:
                return entries
    return entries


def _record(
    file: str,
    entry: Layout | Refused,
    method: Method,
    scenario: Scenario | None,
    timeout: float | None,
    found: VerdictReliability | None,
) -> Record:
    if isinstance(entry, Layout):
        verdict = judge(method, entry, timeout) if found is None else found.nominal
        items, outside = verdict.item_count, list(leaves(entry, method))
        floor = str(entry.floor.kind)
    else:
        verdict = Verdict(item_count=0, status=Status.REFUSED, reason=str(entry.error))
        items, outside, floor = None, [], None
    return {
        "layout": entry.name,
        "file": file,
        "method": str(method.spec),
        "items": items,
        "scenario": str(scenario) if scenario else None,
        "floor": floor,
        "score": verdict.score,
        "failing_step": verdict.failing_step,
        "status": str(verdict.status),
        "moved_item": verdict.moved_item,
        "displacement": verdict.displacement,
        "rotation": verdict.rotation,
        "reason": verdict.reason,
        "ignored": list(verdict.ignored),
        "emulated": list(verdict.emulated),
        "outside": outside,
        "seconds": verdict.wall.total,
        "cpu_seconds": verdict.cpu.total,
    }
