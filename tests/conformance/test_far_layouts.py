"""Every engine judges a layout where it lies as it does at the pallet's corner."""

import pytest

from steadyload.engines.registry import world_class
from steadyload.layouts import Item, Layout, Pallet
from steadyload.methods import make_method
from steadyload.methods.session.recording import record_loading
from steadyload.methods.session.session import LoadingSession

PALLET = Pallet(100_000.0, 200.0, 100_000.0)
"""A kilometre: no pallet may be larger."""

FARTHEST = 99_900.0
CORNER = Item(0, (0.0, 0.0, 0.0), (20.0, 10.0, 20.0), 5.0)


def stack(across, shifts, *first):
    """Boxes on each other from a place on, each further along x by its shift."""
    x, z = across
    items = list(first)
    for level, shift in enumerate(shifts):
        position = (x + shift, 10.0 * level, z)
        items.append(Item(len(items), position, (20.0, 10.0, 20.0), 5.0))
    return Layout("far", PALLET, tuple(items))


STANDS, FALLS = (0.0, 8.0), (0.0, 14.0)


@pytest.mark.parametrize("distance", [1_000.0, 2_100.0, 50_000.0, FARTHEST])
def test_a_stack_far_from_the_corner_is_judged_as_at_it(any_engine, distance):
    method = make_method(f"simulation@{any_engine}:t_max=0.4")
    assert method.judge(stack((0.0, 0.0), STANDS)).stable
    near = method.judge(stack((0.0, 0.0), FALLS))
    assert near.failing_step == 1
    for where in ((distance, distance), (0.0, distance)):
        assert method.judge(stack(where, STANDS)).stable
        far = method.judge(stack(where, FALLS))
        assert far.failing_step == 1
        assert far.displacement == pytest.approx(near.displacement, abs=1.0)


def test_one_box_at_the_corner_changes_nothing_for_a_stack_a_kilometre_away(any_engine):
    if world_class(any_engine).capabilities.dimensions == 2:
        pytest.skip("not applicable: such a layout is not planar")
    method = make_method(f"simulation@{any_engine}:t_max=0.4")
    where = (FARTHEST, FARTHEST)
    assert method.judge(stack(where, STANDS, CORNER)).stable
    assert method.judge(stack(where, FALLS, CORNER)).failing_step == 2


def test_a_session_and_a_recording_lie_where_the_layout_does():
    lay = stack((FARTHEST, FARTHEST), FALLS)
    spec = "simulation@mujoco:t_max=0.4"
    with LoadingSession(PALLET, spec) as session:
        verdicts = [session.try_place(item) for item in lay.items]
    whole = make_method(spec).judge(lay)
    assert [v.stable for v in verdicts] == [True, False]
    assert verdicts[-1].displacement == whole.displacement
    recorded = record_loading(lay, make_method(spec))
    first = recorded.steps[0].poses.centres[0, 0]
    assert first == pytest.approx((FARTHEST + 10.0, 5.0, FARTHEST + 10.0), abs=0.1)
