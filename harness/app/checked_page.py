"""The page of a check: every pallet with its picture and answer, each opening its player."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from steadyload.app.answers import close_to, counted, on_the_road, too_far
from steadyload.app.checking import Answer, Check
from steadyload.app.notebook_figures import accuracy_fact, load_picture, moved_boxes
from steadyload.app.repair_results import Outcome, Repair
from steadyload.app.viewing import view_of
from steadyload.atomic import write_atomically
from steadyload.engines.errors import EngineNotInstalledError
from steadyload.layouts.files.record import Refused
from steadyload.layouts.files.sources import distinct_names
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.naming import label_in
from steadyload.methods.contract.verdict import Status, Verdict
from steadyload.methods.session.recording import (
    Recording,
    record_failure,
    record_plan,
    simulation_of,
)
from steadyload.progress import Progress, silent
from steadyload.reports.viewer.gallery import gallery_html
from steadyload.reports.viewer.page import MARKS, player_html
from steadyload.reports.viewer.picture import AMBER, MARKED
from steadyload.reports.viewer.records import Card, Gallery
from steadyload.runs.methods_here import method_named
from steadyload.runs.pool import PartLimit, SinglePart, run_units
from steadyload.runs.provenance import provenance_lines

PAGE = "index.html"

PLAYED = "ps_opt@mujoco:question=stands"
"""The simulation that shows the fall where the method that answered moves nothing."""

_PATIENCE = 60.0
"""CPU seconds that a simulation may take for a player; then the plan is shown."""

_KINDS = tuple(
    map(str, (Answer.FAILS, Answer.HOVERS, Answer.NOT_JUDGED, Answer.BAD_INPUT, Answer.STANDS))
)

CRUSHED, NOT_HELD, CLOSE = "crushed", "road: no", "close call"
"""Badges of loads of which a box is crushed, of those that do not hold the rule of the road, and of
those that stand by little."""


def write_checked(
    entries: Sequence[tuple[str, Layout | Refused]],
    found: Sequence[Check],
    folder: Path,
    *,
    repairs: Mapping[int, Repair] | None = None,
    workers: int = 1,
    progress: Progress = silent,
) -> Path:
    """Write the page of a check into a folder; returns its path.

    Of a load that fails the failing step is simulated once more, and its fall recorded; of the
    others the plan is shown box by box.

    Args:
        entries: what was checked.
        found: the answers, in the same order.
        folder: is made where it does not exist; the page in it is replaced.
        repairs: of loads that do not stand, by their place; a card that has one also plays the
            repaired plan.
        workers: processes that simulate; 0 does so in this one.
        progress: called with the cards done and those in all.

    Raises:
        ThreeJsError: the library that draws is missing.
        OSError: the page cannot be written.
        WorkerDiedError: see :func:`steadyload.runs.pool.run_units`.
    """
    cards: list[Card | None] = [None] * len(found)
    units, made = [], provenance_lines()
    names = distinct_names(check.file for check in found)
    for place, ((_, entry), check) in enumerate(zip(entries, found, strict=True)):
        check = dataclasses.replace(check, file=names[check.file])
        if isinstance(entry, Layout):
            units.append(_Unit(place, entry, check, made, (repairs or {}).get(place)))
        else:
            cards[place] = _card(check)
    done = len(found) - len(units)
    progress(done, len(found))
    for unit, [card] in run_units(
        _play, units, workers=min(workers, len(units)), crashed=_as_planned,
        limit=PartLimit(_PATIENCE, _as_planned),
    ):  # fmt: skip
        cards[unit.place] = card
        done += 1
        progress(done, len(found))
    folder.mkdir(parents=True, exist_ok=True)
    gallery = _gallery([card for card in cards if card is not None], _notes(found), made)
    write_atomically(folder / PAGE, gallery_html(gallery))
    return folder / PAGE


def _gallery(cards: Sequence[Card], notes: tuple[str, ...], made: Mapping[str, str]) -> Gallery:
    told = counted(card.kind for card in cards)
    marks = {CLOSE: "by little", CRUSHED: "with a crushed box", NOT_HELD: "fail on the road"}
    for badge, words in marks.items():
        if count := sum(badge in card.badges for card in cards):
            told.append(f"{count} {words}")
    return Gallery(
        title="Do these pallets stand while they are loaded?",
        summary=f"{len(cards)} pallet{'s' if len(cards) != 1 else ''}: {', '.join(told)}.",
        kinds=_KINDS,
        cards=tuple(cards),
        notes=notes,
        manifest=made,
    )


def _notes(found: Sequence[Check]) -> tuple[str, ...]:
    """Below the cards: how to read them, in the axes and with the limit on gaps of the check."""
    frame, limit = (found[0].frame, found[0].gaps_cm) if found else (Frame(), math.inf)
    rules = {check.transport.rule: None for check in found if check.transport is not None}
    return (
        "A picture shows a load up to the box at whose placement it fails; the box that moves "
        "too far, or hovers, is red, one that is crushed or moves only on the road is amber, "
        "and it shines through others. Colours are the order of loading. Arrows show the axes of "
        f"the file: a box that leans to +{frame.axes[0]} leans where the arrow +{frame.axes[0]} "
        "points.",
        "Accuracy on similar labelled pallets: the share of labelled cases of about so many boxes "
        "on which the method names the box at which the load fails; it is the same for each pallet "
        "of such a size, and is not the probability that this one stands.",
        too_far(frame, limit),
        close_to(frame),
        *map(on_the_road, rules),
        "A fall is simulated from the plan by the method that answered, or the last stage of "
        f"a cascade, or {PLAYED} where neither simulates; where it lets the load stand, the "
        "plan is shown.",
    )


@dataclass(frozen=True)
class _Unit(SinglePart):
    """A unit of work: one card. ``place``: among all; ``made``: provenance of the page."""

    place: int
    layout: Layout
    check: Check
    made: Mapping[str, str]
    repair: Repair | None = None

    def describe(self, part: int) -> str:
        return f"the player of {self.layout.name!r}"


def _play(unit: _Unit) -> Iterator[Card]:
    yield _played(unit, _recorded(unit))


def _as_planned(unit: _Unit, _: int, __: str) -> Card:
    return _played(unit, _plan(unit))


def _recorded(unit: _Unit) -> Recording:
    """The recording of the fall; of the plan where nothing falls or no engine shows it."""
    layout, check = unit.layout, unit.check
    if check.verdict is None or check.verdict.failing_step is None or check.crushed is not None:
        return _plan(unit)
    try:
        shown_by = simulation_of(method_named(check.method)) or simulation_of(method_named(PLAYED))
        assert shown_by is not None, "the method that plays is a simulation"
        shown_by.prepare(len(layout))
    except EngineNotInstalledError:
        return _plan(unit)
    return record_failure(layout, check.method, check.verdict, shown_by)


def _plan(unit: _Unit) -> Recording:
    """The plan; of a load of which a box is crushed up to the step at which it is."""
    shown, crushed = _shown(unit.check), unit.check.crushed
    recording = record_plan(unit.layout, unit.check.method, shown)
    if crushed is None:
        return recording
    return dataclasses.replace(recording, headline=crushed.sentence(unit.check.frame), crushed=True)


def _shown(check: Check) -> Verdict:
    """The verdict, or in its place one on the box that is crushed first."""
    assert check.verdict is not None, "a valid layout has a verdict"
    crushed = check.crushed
    if crushed is None:
        return check.verdict
    return dataclasses.replace(
        check.verdict, status=Status.DONE, failing_step=crushed.step, moved_item=crushed.item,
        displacement=None, rotation=None, reason="",
    )  # fmt: skip


def _played(unit: _Unit, recording: Recording) -> Card:
    """The card of a layout, with its picture and player."""
    check, road = unit.check, None
    drawn = load_picture(unit.layout, _shown(check), check.frame)
    if check.stands and _fails_on_the_road(check):
        assert check.transport is not None
        road = None if check.transport.worst is None else check.transport.worst.moved_item
    return dataclasses.replace(
        _card(check, *_road_fact(check, unit.layout), *_repair_fact(unit.repair)),
        picture=dataclasses.replace(
            drawn,
            marked=_marked(check, drawn.marked) if road is None else road,
            mark=AMBER if check.crushed is not None or road is not None else MARKED,
        ),
        player=player_html(
            view_of(
                unit.layout,
                [recording],
                unit.made,
                gaps_cm=check.gaps_cm,
                frame=check.frame,
            ),
            MARKS,
        ),
        repaired=_repaired_player(unit),
    )


def _repair_fact(repair: Repair | None) -> tuple[str, ...]:
    return () if repair is None else (f"repair: {repair.sentence}",)


def _repaired_player(unit: _Unit) -> str:
    """The page that plays the repaired plan, box by box; empty where there is none."""
    repair = unit.repair
    if repair is None or repair.outcome is not Outcome.REPAIRED:
        return ""
    layout, after = repair.layout, repair.after
    assert layout is not None, "a repaired plan is one"
    assert after is not None, "it was confirmed"
    assert after.verdict is not None, "by a verdict"
    recording = record_plan(layout, after.method, after.verdict)
    view = view_of(
        layout, [recording], unit.made, gaps_cm=after.gaps_cm, frame=unit.check.frame,
    )  # fmt: skip
    repaired = dataclasses.replace(view, changes=tuple(repair.sentences), moved=moved_boxes(repair))
    return player_html(repaired, MARKS)


def _marked(check: Check, at_fault: int | None) -> int | None:
    return check.gap.item if check.answer is Answer.HOVERS and check.gap else at_fault


def _card(check: Check, *more: str) -> Card:
    """The facts that are known of a layout without its plan, and more."""
    facts = [] if check.items is None else [f"{check.items} box{'es' if check.items != 1 else ''}"]
    facts += [*check.notes, *more]
    if check.reliability is not None:
        facts += [": ".join(said) for said in accuracy_fact(check.reliability).items()]
    if check.file:
        facts.append(check.file)
    kind = str(check.answer)
    answer = check.reason if check.answer is Answer.BAD_INPUT else check.sentence
    badges = [CRUSHED] * (check.crushed is not None) + [NOT_HELD] * _fails_on_the_road(check)
    badges += [CLOSE] * check.close_call
    return Card(check.layout, kind, answer, tuple(facts), badges=tuple(badges))


def _fails_on_the_road(check: Check) -> bool:
    return check.transport is not None and check.transport.held is False


def _road_fact(check: Check, layout: Layout) -> tuple[str, ...]:
    """Whether the load holds the rule, in a few words; empty where none was asked."""
    road = check.transport
    if road is None:
        return ()
    worst = road.worst
    if worst is None:
        return (f"holds {road.rule}",)
    if worst.held is None or worst.moved_item is None:
        return (f"{road.rule}: no answer",)
    box = label_in(layout.items, worst.moved_item)
    return (f"{road.rule}: {box} {worst.mode} at {worst.direction_deg:g} degrees",)
