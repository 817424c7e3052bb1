"""Properties of a layout against the same layout moved, turned, mirrored or made heavier."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from steadyload.layouts.model.layout import WEIGHTS, Layout, replace_items
from steadyload.methods.contract.declared import Trait
from steadyload.properties.margin_filter import is_clear
from steadyload.properties.property import (
    Case,
    Check,
    MethodUnderTest,
    Property,
    Violation,
    declaring,
    spoken,
    steps_between,
)
from steadyload.properties.strategies import ordinary_layouts
from steadyload.properties.transforms import mirrored, quarter_turned, translated

_FARTHEST = 64
_HEAVIEST = 10

Change = Callable[[Layout, Case], Layout]


def _keeps_failing_step(what: str, change: Change) -> Check:
    """A check that a change of the layout keeps a clear failing step."""

    def check(tested: MethodUnderTest, case: Case) -> bool:
        first = tested.verdict(case.layout)
        if not is_clear(tested, case.layout, first):
            return False
        second = tested.verdict(change(case.layout, case)).failing_step
        if second != first.failing_step:
            raise Violation(
                f"{spoken(first.failing_step)}; {what}: {spoken(second)}",
                steps=steps_between(case.layout, first.failing_step, second),
            )
        return True

    return check


def _ordinary(tested: MethodUnderTest) -> SearchStrategy[Case]:
    return tested.within_range(ordinary_layouts(planar=tested.planar)).map(Case)


@st.composite
def _elsewhere(draw: DrawFn, tested: MethodUnderTest) -> Case:
    way = st.integers(0, _FARTHEST).map(float)
    layout = draw(tested.within_range(ordinary_layouts(planar=tested.planar)))
    x, z = (
        min(draw(way), max(0.0, tested.method.layout_range.pallet_side[1] - side))
        for side in (layout.pallet.width, layout.pallet.depth)
    )
    return Case(layout, {"along x": x, "along z": z})


@st.composite
def _heavier(draw: DrawFn, tested: MethodUnderTest) -> Case:
    layout = draw(tested.within_range(ordinary_layouts(planar=tested.planar)))
    return Case(layout, {"factor": draw(st.integers(2, _HEAVIEST).map(float))})


def _with_weights(layout: Layout, factor: float) -> Layout:
    return replace_items(
        layout,
        tuple(replace(item, weight=min(item.weight * factor, WEIGHTS[1])) for item in layout.items),
    )


def _rigid(tested: MethodUnderTest) -> bool:
    """True unless contacts give way with the load: heavier items may sink and tip sooner then."""
    facts = tested.capabilities
    return tested.has(Trait.STEPWISE) and (facts is None or not facts.compliant)


PROPERTIES = (
    Property(
        "translation",
        "The layout elsewhere on the pallet keeps a clear failing step.",
        _elsewhere,
        _keeps_failing_step(
            "elsewhere",
            lambda layout, case: translated(layout, case.change["along x"], case.change["along z"]),
        ),
        declaring(Trait.STEPWISE),
    ),
    Property(
        "quarter turn",
        "The layout turned by a quarter, centres of mass too, keeps a clear failing step.",
        _ordinary,
        _keeps_failing_step("turned", lambda layout, case: quarter_turned(layout)),
        declaring(Trait.STEPWISE),
    ),
    Property(
        "mirror",
        "The layout mirrored, centres of mass too, keeps a clear failing step.",
        _ordinary,
        _keeps_failing_step("mirrored", lambda layout, case: mirrored(layout)),
        declaring(Trait.STEPWISE),
    ),
    Property(
        "masses",
        "All weights up to ten times as large keep a clear failing step (rigid contacts).",
        _heavier,
        _keeps_failing_step(
            "heavier", lambda layout, case: _with_weights(layout, case.change["factor"])
        ),
        _rigid,
    ),
)
