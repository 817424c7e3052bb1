"""Scoring a user's own layout files: one record per layout and method."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Unpack

from steadyload.errors import WrongTypeError, required, required_list
from steadyload.escaping import shown
from steadyload.layouts.files.record import Refused
from steadyload.layouts.files.sources import Source
from steadyload.layouts.formats import Reading
from steadyload.layouts.model.layout import Item, Layout
from steadyload.layouts.model.naming import box_id, with_ids
from steadyload.layouts.model.scenarios import Scenario
from steadyload.methods.contract.method import Method, Status, Verdict, judge
from steadyload.methods.contract.verdict import record_of
from steadyload.methods.doubt import doubt
from steadyload.methods.envelope import leaves
from steadyload.methods.uncertainty import Uncertainty
from steadyload.numbers import seconds_allowed
from steadyload.progress import Progress, silent
from steadyload.runs.able import asked_question, asked_to_stand
from steadyload.runs.definition import case
from steadyload.runs.entries import Entries, Entry, scan_entries
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
    strict: bool = False,
    timeout: float | None = None,
    uncertainty: Uncertainty | None = None,
    sampling: Sampling | None = None,
    progress: Progress = silent,
    **reading: Unpack[Reading],
) -> list[Record]:
    """Judge every layout of some files with every method. All input is checked before any judging.

    Args:
        files: layout files in any known format.
        methods: spec strings.
        scenario: draw centres of mass; None keeps those of the file.
        seed: seed of the scenario.
        max_items: judge only the first items of each layout.
        limit: use only the first layouts.
        strict: end at the first layout that is not valid, instead of a record with the status
            ``refused``.
        timeout: CPU seconds a judgement may take.
        uncertainty: the quantities that deviate from the plans; None judges the plans alone.
        sampling: the rule by which sampling of deviations ends; None for the defaults.
        progress: called with the number of finished judgements and of all.
        reading: see :class:`steadyload.layouts.formats.Reading`.

    Returns:
        Records with the keys ``layout, file, method, question, scenario, floor``, those of
        :func:`steadyload.methods.contract.verdict.record_of`, ``failing_box, moved_box, outside,
        doubt``; ``question`` is that of a method that knows several, ``floor`` is ``deck`` or
        ``infinite``, ``failing_box`` and ``moved_box`` are ids, None where a box has none,
        ``outside`` lists in which quantities the layout leaves the envelope of the method's
        engine, and ``doubt`` is a sentence on a load that a simulation sees fall although contact
        forces balance it, else empty.

    Raises:
        LayoutError: a file cannot be read as a whole; or a layout is not valid, if ``strict``.
        NumberError: the timeout is no finite number above 0.
        WrongTypeError: another argument is of a type that is not allowed.
        SpecError: a method does not exist.
        EngineNotInstalledError: a method's engine is missing.
    """
    seconds_allowed(timeout)
    if scenario is not None and not (isinstance(scenario, str) and scenario in list(Scenario)):
        allowed = ", ".join(Scenario)
        raise WrongTypeError(f"scenario is {shown(scenario)}; allowed: {allowed}, or None")
    for name, count in (("limit", limit), ("max_items", max_items)):
        if count is not None:
            required(name, count, int, "a whole number, or None")
    named = required_list("files", files, "a list of files")
    specs = required_list("methods", methods, "a list of methods")
    judges = [asked_to_stand(spec) for spec in specs]
    with Entries(scan_entries(named, limit=limit, strict=strict, **reading)) as entries:
        return list(
            score_entries(
                entries,
                judges,
                scenario=scenario,
                seed=seed,
                max_items=max_items,
                timeout=timeout,
                uncertainty=uncertainty,
                sampling=sampling,
                progress=progress,
            )
        )


def score_entries(
    entries: Entries,
    judges: Sequence[Method],
    *,
    scenario: Scenario | None = None,
    seed: int = 0,
    max_items: int | None = None,
    timeout: float | None = None,
    uncertainty: Uncertainty | None = None,
    sampling: Sampling | None = None,
    progress: Progress = silent,
) -> Iterator[Record]:
    """The records of :func:`score_layouts`, each as soon as it is known; none is kept.

    Args:
        entries: the layouts.
        judges: the methods.
        scenario: see :func:`score_layouts`, as for all others.
        seed: likewise.
        max_items: likewise.
        timeout: likewise.
        uncertainty: likewise.
        sampling: likewise.
        progress: likewise.

    Raises:
        EngineNotInstalledError: a method's engine is missing; before the first record.
    """
    if entries.valid:
        for method in judges:
            method.prepare()
    done, total = 0, len(entries) * len(judges)
    progress(done, total)
    for file, entry in entries:
        if isinstance(entry, Layout):
            entry = case(entry, scenario, seed, max_items)
        for method in judges:
            found = uncertain = None
            if uncertainty is not None and isinstance(entry, Layout):
                found = verdict_reliability(method, entry, uncertainty, sampling, timeout=timeout)
                uncertain = uncertain_record(found, entry.items)
            record = _record(file, entry, method, scenario, timeout, found)
            if uncertainty is not None:
                record["uncertain"] = uncertain
            yield record
            done += 1
            progress(done, total)


def uncertain_record(found: VerdictReliability, boxes: Sequence[Item] = ()) -> Record:
    """The reliability of a verdict as values that JSON can hold.

    Args:
        found: the reliability.
        boxes: those of the layout, by whose ids the reason names them.

    Returns:
        ``stands``, the probability that the whole load stands, with the ``interval`` that holds it
        (95 %); ``distribution``, the share of every failing step as a text, ``none`` for none;
        ``likeliest_step`` with ``likeliest_share``, null for none; ``expected_score``; ``samples``
        and those ``without_verdict`` by status, ``why`` the first of these; ``ending``,
        ``without_effect``; ``wall_seconds`` and ``cpu_seconds`` for everything. See
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
        "why": with_ids(found.why, boxes),
        "ending": str(found.ending),
        "without_effect": list(found.without_effect),
        "cpu_seconds": found.cpu,
        "wall_seconds": found.wall,
    }


def read_entries(
    files: Sequence[Source], *, limit: int | None = None, **reading: Unpack[Reading]
) -> list[Entry]:
    """The layouts of some files in memory, each with the name of its file.

    Takes the arguments of :func:`steadyload.runs.entries.scan_entries`, and raises what it raises.
    """
    return [*scan_entries(files, limit=limit, **reading)]


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
        doubtful = with_ids(doubt(entry, method, verdict), entry.items)
        boxes: Sequence[Item] = entry.items
        floor = str(entry.floor.kind)
    else:
        verdict = Verdict(item_count=0, status=Status.REFUSED, reason=str(entry.error))
        items, outside, boxes, floor, doubtful = None, [], (), None, ""
    return {
        "layout": entry.name,
        "file": file,
        "method": str(method.spec),
        "question": asked_question(method),
        "scenario": str(scenario) if scenario else None,
        "floor": floor,
        **record_of(verdict),
        "items": items,
        "reason": with_ids(verdict.reason, boxes),
        "failing_box": box_id(boxes, verdict.failing_step),
        "moved_box": box_id(boxes, verdict.moved_item),
        "outside": outside,
        "doubt": doubtful,
    }
