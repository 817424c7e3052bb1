"""Properties of verdicts among themselves: they hold by definition, for every method."""

from __future__ import annotations

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.methods.contract.declared import LayoutRange, Trait
from steadyload.methods.envelope import leaves
from steadyload.methods.registry import make_method
from steadyload.properties.margin_filter import is_clear
from steadyload.properties.property import (
    Case,
    MethodUnderTest,
    Property,
    Violation,
    declaring,
    spoken,
    steps_between,
)
from steadyload.properties.strategies import density_weight, layouts
from steadyload.statistics.placed import failing_step_of, items_placed

_FAR = 150.0
"""How far away a far item stands [cm]; nothing moves that far within a placement."""


def _any_layout(tested: MethodUnderTest) -> SearchStrategy[Case]:
    return tested.within_range(layouts(planar=tested.planar)).map(Case)


def score_is_a_share_of_items(tested: MethodUnderTest, case: Case) -> bool:
    """The score is k / J, and k counts the items placed safely."""
    count = len(case.layout)
    verdict = tested.verdict(case.layout)
    placed = items_placed(verdict.failing_step, count)
    if not 0 <= placed <= count or verdict.score != placed / count:
        raise Violation(f"score {verdict.score} with {placed} of {count} items placed")
    if verdict.stable != (placed == count):
        raise Violation(f"{placed} of {count} items placed, but stable is {verdict.stable}")
    if verdict.moved_item is not None and not verdict.moved_item <= placed:
        raise Violation(f"item {verdict.moved_item} moved at step {placed}, before it was placed")
    return True


def repeats(tested: MethodUnderTest, case: Case) -> bool:
    """Judging again, and by a method made anew, gives the same verdict."""
    first = tested.verdict(case.layout)
    for again in (tested, MethodUnderTest(tested.spec)):
        verdict = again.verdict(case.layout)
        for what in ("failing_step", "moved_item", "displacement", "rotation"):
            before, after = getattr(first, what), getattr(verdict, what)
            if before != after:
                raise Violation(f"{what.replace('_', ' ')} {before!r}, then {after!r}")
    return True


@st.composite
def _cut(draw: DrawFn, tested: MethodUnderTest) -> Case:
    layout = draw(tested.within_range(layouts(planar=tested.planar)))
    # Fewer than all: the whole layout alone would only be judged twice.
    return Case(layout, {"items": draw(st.integers(1, max(1, len(layout) - 1)))})


def first_items_alone(tested: MethodUnderTest, case: Case) -> bool:
    """The first k items judged alone get the verdict that the whole layout has on them."""
    kept = int(case.change["items"])
    if kept == len(case.layout):
        return False
    whole = items_placed(tested.verdict(case.layout).failing_step, len(case.layout))
    alone = tested.verdict(case.layout.first(kept)).failing_step
    expected = failing_step_of(whole, kept)
    if alone != expected:
        raise Violation(
            f"the first {kept} alone: {spoken(alone)}; in the whole layout: {spoken(expected)}",
            steps=steps_between(case.layout.first(kept), alone, expected),
        )
    return True


def far_item_changes_nothing(tested: MethodUnderTest, case: Case) -> bool:
    """An item placed last on the floor, far away, changes no clear failing step.

    Its placement judges all the others once more: a verdict that is not clear may fall otherwise,
    and so may one beyond the engine's envelope.
    """
    verdict = tested.verdict(case.layout)
    if leaves(case.layout, tested.method) or not is_clear(tested, case.layout, verdict):
        return False
    before = verdict.failing_step
    wider = _with_far_item(case.layout, tested.method.layout_range)
    after = tested.verdict(wider).failing_step
    if before != after:
        raise Violation(
            f"{spoken(before)}; with an item far away: {spoken(after)}",
            steps=steps_between(case.layout, before, after),
        )
    return True


def _with_far_item(layout: Layout, declared: LayoutRange) -> Layout:
    """The layout on a wider pallet, and a low item on the floor that shares item 0's depth.

    Its weight is that of its size, or the nearest one that keeps the declared ratio of weights.
    """
    width, height, depth = layout.pallet.size
    first = layout.items[0]
    size = (20.0, 10.0, first.size[2])
    heaviest, lightest = float(layout.weights.max()), float(layout.weights.min())
    weight = max(density_weight(size), heaviest / declared.weight_ratio, declared.weight[0])
    weight = min(weight, lightest * declared.weight_ratio, declared.weight[1])
    far = Item(len(layout), (width + _FAR, 0.0, first.position[2]), size, weight)
    pallet = Pallet(width + _FAR + size[0], max(height, size[1]), depth)
    return Layout(layout.name, pallet, (*layout.items, far))


def full_support_is_partial_support(tested: MethodUnderTest, case: Case) -> bool:
    """PBS accepts everything that FBS accepts: every loading, and every first part of one."""
    full = items_placed(make_method("fbs").judge(case.layout).failing_step, len(case.layout))
    partial = items_placed(tested.verdict(case.layout).failing_step, len(case.layout))
    if partial < full:
        raise Violation(f"{full} items placed with full base support, but {partial} with partial")
    return True


@st.composite
def _two_shares(draw: DrawFn, tested: MethodUnderTest) -> Case:
    low, high = sorted(draw(st.tuples(st.integers(0, 100), st.integers(0, 100))))
    layout = draw(tested.within_range(layouts(planar=tested.planar)))
    return Case(layout, {"lower alpha": low / 100.0, "higher alpha": high / 100.0})


def more_support_fails_no_later(tested: MethodUnderTest, case: Case) -> bool:
    """Requiring more support never makes a loading fail later."""
    steps = []
    for which in ("lower", "higher"):
        spec = f"{tested.method.spec.name}:alpha={case.change[f'{which} alpha']:g}"
        verdict = MethodUnderTest(spec).verdict(case.layout)
        steps.append(items_placed(verdict.failing_step, len(case.layout)))
    if steps[1] > steps[0]:
        raise Violation(f"{steps[0]} items with less support asked for, {steps[1]} with more")
    return True


def _partial(tested: MethodUnderTest) -> bool:
    return tested.has(Trait.BASE_SUPPORT) and hasattr(tested.method.parameters, "alpha")


PROPERTIES = (
    Property(
        "score",
        "The score is k / J, k the items placed safely.",
        _any_layout,
        score_is_a_share_of_items,
    ),
    Property("repeat", "A repeat gives the same verdict, to the last bit.", _any_layout, repeats),
    Property(
        "prefix",
        "The first k items judged alone get the verdict that the whole layout has on them.",
        _cut,
        first_items_alone,
        declaring(Trait.STEPWISE),
    ),
    Property(
        "far item",
        "An item placed last on the floor, far away, changes no clear failing step.",
        _any_layout,
        far_item_changes_nothing,
        declaring(Trait.STEPWISE),
    ),
    Property(
        "full implies partial",
        "What full base support accepts, partial base support accepts.",
        _any_layout,
        full_support_is_partial_support,
        _partial,
    ),
    Property(
        "monotone in alpha",
        "Asking for a larger supported share never lets a loading get further.",
        _two_shares,
        more_support_fails_no_later,
        _partial,
    ),
)
