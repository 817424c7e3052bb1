"""Pieces of half a millimetre: they tip in a hundredth of a second, so that rounding could grow."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from piles import top_below

from steadyload.core.constants import TOLERANCE
from steadyload.layouts import Item, Layout, Pallet
from steadyload.methods import make_method
from steadyload.methods.session.session import LoadingSession
from steadyload.statics.balance import VerticalBalance

PALLET = Pallet(40.0, 4000.0, 60.0)

PIECES = (
    (  # a plank of 1,000 t comes down 0.7 mm beside the piece that it stands on
        ((10.0, 0.0, 25.0), (20.005, 5.005, 20.0), 1e6),
        ((25.0, 5.014999, 30.0), (0.05, 0.05, 5.0), 1.0),
        ((15.0, 5.074999, 30.0), (20.005, 5.01, 20.0), 1e6),
    ),
    (((15.0, TOLERANCE + 1e-10, 30.0), (0.05, 0.05, 5.0), 1.0),),  # just above the floor
    (((30.0, TOLERANCE + 1e-10, 50.0), (10.0, 0.05, 0.06), 1e-9),),
    (((30.0, TOLERANCE + 1e-10, 30.0), (10.0, 0.05, 5.0), 1.0),),
)


def said(verdict):
    """All but the times of a verdict."""
    moved = verdict.moved_item, verdict.displacement, verdict.rotation
    return verdict.status, verdict.failing_step, verdict.reason, *moved


def compare(session, item):
    """Try an item; see that the verdict is that on the whole."""
    items = (*session.items, replace(item, sequence=len(session)))
    verdict = session.try_place(item)
    assert said(verdict) == said(session.method.judge(Layout("pieces", PALLET, items)))
    return verdict


@pytest.mark.parametrize("boxes", PIECES)
def test_a_piece_at_rest_stands_in_a_session_as_on_the_whole(boxes):
    session = LoadingSession(PALLET, "equilibrium:time=0.3")
    for at, size, weight in boxes:
        assert compare(session, Item(0, at, size, weight)).stable


@pytest.mark.parametrize("seconds", [0.3, 30.0])
@pytest.mark.parametrize("boxes", PIECES[1:])
def test_rounding_does_not_grow_to_a_fall(seconds, boxes):
    """By the compiled model, and by the same model for whole groups."""
    items = tuple(Item(k, *box) for k, box in enumerate(boxes))
    layout, method = Layout("piece", PALLET, items), make_method(f"equilibrium:time={seconds}")
    assert method.judge(layout).stable
    balance = VerticalBalance(layout)
    assert not any(method.judge_step(layout, balance, step) for step in range(len(layout)))


_piece = st.tuples(
    *[st.sampled_from((0.05, 0.05, 0.1, 1.0, 5.0, 20.005))] * 3,  # sides
    *[st.sampled_from((0.0, 5.0, 10.0, 10.02, 15.0, 20.0))] * 2,  # x, z
    st.sampled_from((0.0, 0.0, 0.009999, TOLERANCE + 1e-10, 0.02, 0.05)),  # above what is below
    st.sampled_from((1e-9, 1e-3, 1.0, 1.0, 1.0, 10.0, 1e6)),
)


@settings(max_examples=300, derandomize=True)
@given(pieces=st.lists(_piece, min_size=2, max_size=6), undo=st.booleans())
def test_a_session_says_of_pieces_what_is_said_of_the_whole(pieces, undo):
    session = LoadingSession(PALLET, "equilibrium:time=0.3")
    for width, height, depth, x, z, gap, weight in pieces:
        at = (x, top_below(session.items, x, z, width, depth) + gap, z)
        compare(session, Item(0, at, (width, height, depth), weight))
        if undo and len(session) == 2:
            session.undo()
