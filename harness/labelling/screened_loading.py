"""One loading labelled for both questions: fast simulations screen, the reference decides.

The reference takes minutes for a pallet of 50 boxes and an hour for one of 100. So fast simulations
answer about every step, and the reference about those that are close. Where it is asked, its answer
counts.

Up to :data:`MOST_BY_ONE` items one simulation screens, MuJoCo at 1 kHz, which moves boxes nearly as
far in a tenth of the time. The reference is asked where MuJoCo sees something move too far, or by
more than half of a threshold, or comes to no end; where a box stands within 1 mm of its point of
balance, which both then simulate for all of 3 s; and about a random 5 % of all others, which shows
what is missed. A step at which by MuJoCo the same item moves as far as at an earlier one, where the
reference agreed on how far, is not asked about again, nor is a box whose balance is as narrow as it
was: what has tipped into a gap does so at every later step, too.

Larger layouts are screened by two simulations of different kinds, Bullet and PhysX. The reference
is asked where these disagree whether something moves too far, where both see that, where one sees
something move by more than :data:`NEAR_BY_TWO` of a threshold, where both come to no end, where
balance is that narrow, and about steps drawn at random. Where one alone comes to no end, something
rattles in its place in that engine, and the other answers. Both let boxes that tip into a gap move
further than the reference does, so where both see a step fail it is the reference that says so.
What it has found to stay within the thresholds is not asked about again while both screens see the
same items move as far, and either no new box touches these or rests on them, or all three agree on
how far. Where the reference gives up and both screens say the same, that counts.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from steadyload.labelling.label_rows import LABEL, case_row
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.sizes import MOST_SMALL
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.simulation import Simulation
from steadyload.methods.simulation.step_answers import StepAnswer, StepAnswers
from steadyload.statics.margins import margins

MOST_BY_ONE = MOST_SMALL
"""Items of a layout that one simulation screens, at most."""

SCREEN = "label@mujoco:frequency=1000"
"""The simulation that answers about every step of a layout of so many items."""

SCREENS = ("label@bullet:frequency=240", "label@physx:frequency=480,solver_iterations=60")
"""The two that answer about every step of a larger one; movements that the reference was not asked
about are those of the first."""

NEAR = 0.5
"""Multiple of a threshold from which the reference is asked, with one screen."""

NEAR_BY_TWO = 0.85
"""The same with two screens."""

NARROW = 0.1
"""Where balance is lost or won by contact patches that are so much narrower or wider, the reference
is asked [cm]; see :mod:`steadyload.statics.margins`."""

SAME = 0.05
"""Two movements of an item are the same when they differ by less, in units of a threshold."""

SAME_BY_TWO = 0.15
"""The same for two screens, where two movements beyond a threshold are the same, too: a simulation
ends at the first look that sees one, at any multiple of the threshold."""

CHECKED = 0.05
"""Share of all steps about which the reference is asked whatever one screen says."""

CHECKED_BY_TWO: Mapping[float, float] = {0.1: 0.005, NEAR_BY_TWO: 0.012}
"""The same with two screens: up to a movement in units of a threshold, the share of steps."""

BESIDE = 2.0
"""Boxes that are no further apart than this along every axis can touch [cm]."""

_DIGITS = 4


def screens_of(items: int) -> tuple[str, ...]:
    """Specs of the simulations that screen a layout of so many items."""
    return (SCREEN,) if items <= MOST_BY_ONE else SCREENS


def share_checked(movement: float) -> float:
    """Share of the steps that two screens call stable about which the reference is asked.

    Args:
        movement: the larger one that they saw, in units of the threshold.
    """
    return next((share for most, share in CHECKED_BY_TWO.items() if movement <= most), 1.0)


class Asks(Protocol):
    """When the reference is asked."""

    def why(self, step: int, seen: Sequence[StepAnswer], standing: bool) -> str:
        """The reason to ask about a step; empty for none."""

    def known(self, step: int, why: str, seen: Sequence[StepAnswer]) -> StepAnswer | None:
        """The answer that is known already, though there is a reason to ask; None for none."""

    def note(self, step: int, seen: Sequence[StepAnswer], answer: StepAnswer) -> None:
        """Take in what the reference answered."""

    def agree(self, seen: Sequence[StepAnswer], standing: bool) -> bool:
        """Whether a step can be decided without the reference."""


class ScreenedLoading:
    """One loading, step by step, by fast simulations and the reference.

    Args:
        scenario: of the case, for its row and its random draws.
        layout: what is loaded.
    """

    def __init__(self, scenario: str, layout: Layout) -> None:
        self._scenario, self._layout = scenario, layout
        self._opened = ExitStack()
        self._screens = [self._opens(spec) for spec in screens_of(len(layout))]
        self._reference = self._opens(LABEL)
        seed = [zlib.crc32(layout.name.encode()), zlib.crc32(scenario.encode())]
        drawn = np.random.default_rng(seed).random(len(layout))
        self._asks: Asks = ByOne(drawn) if len(self._screens) == 1 else ByTwo(drawn, layout)
        self._margins = margins(layout, centres=False)
        self._narrow: set[tuple[int, float]] = set()
        self._answers: list[StepAnswer] = []
        self._seen: list[tuple[tuple[float, ...], float, str]] = []

    def _opens(self, spec: str) -> StepAnswers:
        method = make_method(spec)
        assert isinstance(method, Simulation)
        answers = StepAnswers(self._layout, method)
        self._opened.callback(answers.close)
        return answers

    def close(self) -> None:
        """Release resources."""
        self._opened.close()

    def row(self) -> dict[str, Any]:
        """The labels of both questions, with what was seen at every step."""
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
        seen = [each.ask(step, standing=standing, patient=narrow) for each in self._screens]
        far = tuple(each.beyond for each in seen)
        why = self._asks.why(step, seen, standing)
        first = next((a for a in seen if a.fails_standing is not None), seen[0])
        if why and (known := self._asks.known(step, why, seen)) is not None:
            self._seen.append((far, np.nan, ""))
            return known
        why = why or ("narrow" if narrow else "")
        if not why:
            self._seen.append((far, np.nan, ""))
            return first
        answer = self._reference.ask(step, standing=standing, patient=narrow)
        if answer.status is not Status.DONE and self._asks.agree(seen, standing):
            self._seen.append((far, np.nan, why))
            return first
        self._seen.append((far, answer.beyond, why))
        if answer.status is Status.DONE:
            self._asks.note(step, seen, answer)
        return answer

    def _is_narrow(self, step: int) -> bool:
        """Whether a box that was not asked about before is within 1 mm of its point of balance."""
        margin = self._margins[step]
        if abs(margin.patches) >= NARROW:
            return False
        known, place = len(self._narrow), (margin.item, round(margin.patches, 3))
        self._narrow.add(place)
        return len(self._narrow) > known

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

        far, reference, why = zip(*self._seen, strict=True)
        screens = [[round(each, _DIGITS) for each in own] for own in zip(*far, strict=True)]
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
            "screen": screens[0],
            "second": screens[1] if len(screens) > 1 else None,
            "reference": [round(each, _DIGITS) for each in reference],
            "why": list(why),
        }


class ByOne:
    """One screen.

    Args:
        drawn: a number a step, uniform between 0 and 1.
    """

    def __init__(self, drawn: NDArray[np.float64]) -> None:
        self._checked = drawn < CHECKED
        # By item: movements on which both agreed, as the screen saw them.
        self._agreed: dict[int, list[float]] = {}

    def why(self, step: int, seen: Sequence[StepAnswer], standing: bool) -> str:
        """See :class:`Asks`."""
        (own,) = seen
        if own.status is not Status.DONE or (standing and own.fails_standing is None):
            return "no end"
        if own.fails_within or own.fails_standing:
            return "fails"
        if own.beyond > NEAR and not self._has_agreed(own):
            return "near"
        return "drawn" if self._checked[step] else ""

    def _has_agreed(self, own: StepAnswer) -> bool:
        return any(abs(own.beyond - far) < SAME for far in self._agreed.get(own.item, []))

    def known(self, step: int, why: str, seen: Sequence[StepAnswer]) -> StepAnswer | None:
        """See :class:`Asks`."""
        return None

    def note(self, step: int, seen: Sequence[StepAnswer], answer: StepAnswer) -> None:
        """See :class:`Asks`."""
        (own,) = seen
        if abs(answer.beyond - own.beyond) < SAME:
            self._agreed.setdefault(own.item, []).append(own.beyond)

    def agree(self, seen: Sequence[StepAnswer], standing: bool) -> bool:
        """See :class:`Asks`: one screen never decides alone where there is a reason to ask."""
        return False


@dataclass(frozen=True, slots=True)
class _Stayed:
    """A step at which the reference saw nothing move too far."""

    step: int
    seen: Sequence[StepAnswer]
    answer: StepAnswer


class ByTwo:
    """Two screens.

    Args:
        drawn: a number a step, uniform between 0 and 1.
        layout: what is loaded.
    """

    def __init__(self, drawn: NDArray[np.float64], layout: Layout) -> None:
        self._drawn, self._affects = drawn, affecting(layout)
        self._stayed: list[_Stayed] = []

    def why(self, step: int, seen: Sequence[StepAnswer], standing: bool) -> str:
        """See :class:`Asks`."""
        if not _ended(seen, standing):
            return "no end"
        if not self.agree(seen, standing):
            return "differ"
        if any(a.fails_within or a.fails_standing for a in seen):
            return "fails"
        far = max(a.beyond for a in seen)
        if far > NEAR_BY_TWO:
            return "near"
        return "drawn" if self._drawn[step] < share_checked(far) else ""

    def known(self, step: int, why: str, seen: Sequence[StepAnswer]) -> StepAnswer | None:
        """See :class:`Asks`."""
        if why not in ("differ", "fails", "near"):
            return None
        for stayed in reversed(self._stayed):
            items = {each.item for each in (*stayed.seen, stayed.answer)}
            fresh = range(stayed.step + 1, step + 1)
            if not all(map(_alike, seen, stayed.seen)):
                continue
            agreed = why == "near" and all(_alike(stayed.answer, each) for each in stayed.seen)
            if agreed or not any(self._affects[new, item] for new in fresh for item in items):
                return stayed.answer
        return None

    def note(self, step: int, seen: Sequence[StepAnswer], answer: StepAnswer) -> None:
        """See :class:`Asks`."""
        if not answer.fails_within and not answer.fails_standing:
            self._stayed.append(_Stayed(step, seen, answer))

    def agree(self, seen: Sequence[StepAnswer], standing: bool) -> bool:
        """See :class:`Asks`."""
        verdicts = {(a.fails_within, bool(a.fails_standing)) for a in seen}
        return _ended(seen, standing) and len(verdicts) == 1


def _ended(seen: Sequence[StepAnswer], standing: bool) -> bool:
    """Whether all came to an end, but that something may still rattle in all but one."""
    rest = any(not standing or a.fails_standing is not None for a in seen)
    return rest and all(a.status is Status.DONE for a in seen)


def _alike(now: StepAnswer, then: StepAnswer) -> bool:
    """Whether the same item moved as far."""
    both_fail = now.beyond > 1.0 and then.beyond > 1.0
    return now.item == then.item and (both_fail or abs(now.beyond - then.beyond) < SAME_BY_TWO)


def affecting(layout: Layout) -> NDArray[np.bool_]:
    """Which items can change how another one moves: those that can touch it, or rest on it.

    Returns:
        ``affects[new, item]``, shape (J, J); an item that rests on others that rest on it is one.
    """
    low, high = layout.lower - BESIDE, layout.upper + BESIDE
    touches = ((low[:, None] < layout.upper[None]) & (layout.lower[None] < high[:, None])).all(2)
    carries = layout.contacts.carries
    rests = np.zeros_like(carries)
    for item in np.argsort(layout.lower[:, 1], kind="stable").tolist():
        below = carries[:, item]
        rests[item] = below | rests[below].any(axis=0)
    found: NDArray[np.bool_] = touches | rests
    return found
