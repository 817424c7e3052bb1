"""Properties of what boxes bear: a session refuses what crushes one, and nothing else for that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from steadyload.layouts.model.layout import Item, Layout
from steadyload.methods.session.session import LoadingSession
from steadyload.properties.property import (
    Case,
    MethodUnderTest,
    Property,
    Violation,
    check_done,
    errors_as_violations,
    spoken,
    steps_between,
)
from steadyload.properties.strategies import ordinary_layouts, towers

_BOX, _SHARE = "box", "share of what it comes to bear"

_TIE = 1e-6
"""A load so close to a limit, as a share of it, may crush a box or not."""


@st.composite
def _limited_columns(draw: DrawFn, tested: MethodUnderTest) -> Case:
    """A tower, a box of it that is not the last, and the share of its load that it may bear."""
    drawn = towers(most=8, planar=tested.planar).filter(lambda layout: len(layout) > 1)
    layout = draw(tested.within_range(drawn))
    box = draw(st.integers(0, len(layout) - 2))
    percent = draw(st.one_of(st.integers(1, 99), st.integers(101, 200)))
    return Case(layout, {_BOX: box, _SHARE: percent / 100.0})


def _piles(tested: MethodUnderTest) -> SearchStrategy[Case]:
    return tested.within_range(ordinary_layouts(planar=tested.planar)).map(Case)


def _loaded(tested: MethodUnderTest, layout: Layout) -> tuple[int | None, int | None]:
    """The failing step of a layout in a session, and the box that moved or was crushed.

    Raises:
        LayoutRefused, Violation: as :meth:`.MethodUnderTest.verdict`.
    """
    with errors_as_violations():
        session = LoadingSession(layout.pallet, tested.method, name=layout.name)
    with session:
        for item in layout.items:
            with errors_as_violations():
                verdict = session.try_place(item)
            check_done(verdict.status, verdict.reason)
            if not verdict.stable:
                return verdict.failing_step, verdict.moved_item
    return None, None


def _spoken(ended: tuple[int | None, int | None]) -> str:
    step, box = ended
    return spoken(step) if step is None else f"{spoken(step)} by box {box}"


def _allowed(layout: Layout, loads: dict[int, float]) -> Layout:
    """The layout with what some of its boxes may bear [kg], by number."""

    def limited(number: int, item: Item) -> Item:
        return replace(item, max_load=loads[number]) if number in loads else item

    items = tuple(limited(number, item) for number, item in enumerate(layout.items))
    return Layout(layout.name, layout.pallet, items)


def column_crushes_in_time(tested: MethodUnderTest, case: Case) -> bool:
    """A box of a column bears what stands above it: it is crushed at that step, or never."""
    layout, box = case.layout, int(case.change[_BOX])
    above = layout.weights[box + 1 :].cumsum()
    limit = case.change[_SHARE] * float(above[-1])
    if np.isclose(above, limit, rtol=_TIE).any():
        return False
    crushed_at = next((box + 1 + k for k, weight in enumerate(above) if weight > limit), None)
    expected = _loaded(tested, layout)
    if crushed_at is not None and (expected[0] is None or crushed_at < expected[0]):
        expected = crushed_at, box
    found = _loaded(tested, _allowed(layout, {box: limit}))
    if found != expected:
        raise Violation(
            f"box {box} may bear {limit:.3g} kg: {_spoken(found)}; expected: {_spoken(expected)}",
            steps=steps_between(layout, found[0], expected[0]),
        )
    return True


def whole_load_crushes_nothing(tested: MethodUnderTest, case: Case) -> bool:
    """Boxes that may bear the whole load are never crushed, and change no failing step."""
    layout = case.layout
    whole = float(layout.weights.sum())
    expected = _loaded(tested, layout)
    found = _loaded(tested, _allowed(layout, dict.fromkeys(range(len(layout)), whole)))
    if found != expected:
        raise Violation(
            f"{_spoken(expected)}; with boxes that may bear the whole load: {_spoken(found)}",
            steps=steps_between(layout, found[0], expected[0]),
        )
    return True


PROPERTIES = (
    Property(
        "crushed column",
        "A session refuses the box by which another in a column comes to bear more than it may, "
        "and none before.",
        _limited_columns,
        column_crushes_in_time,
    ),
    Property(
        "whole load borne",
        "Where every box may bear the whole load, a session places as many as without limits.",
        _piles,
        whole_load_crushes_nothing,
    ),
)
