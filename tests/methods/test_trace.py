"""Traces: what moves at every step, read under any thresholds and times."""

import numpy as np
import pytest

from steadyload.engines.world import EngineError
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.criteria import Criterion
from steadyload.methods.simulation.loading import Loading
from steadyload.methods.simulation.trace import LIMIT_T, UndecidedError, trace_loading

MUJOCO = "label@mujoco"


def trace(layout, spec=MUJOCO, t_max=0.3, samples=10):
    return trace_loading(layout, make_method(spec), t_max=t_max, samples=samples)


@pytest.fixture(scope="module")
def traced():
    """Layouts of up to nine items with their traces, which no judgement changes."""
    layouts = [layout.first(min(len(layout), 9)) for layout in random_layouts(24, seed=11)]
    return [(layout, trace(layout)) for layout in layouts]


def in_the_air(height):
    items = (Item(0, (0, 0, 0), (10, 10, 10), 1.0), Item(1, (40, height, 40), (10, 10, 10), 1.0))
    return Layout("in the air", Pallet(100, 100, 100), items)


def test_free_fall_is_followed_until_it_is_beyond_the_limit():
    seen = trace(in_the_air(60.0), f"{MUJOCO}:frequency=2000")
    times = 0.03 * np.arange(1, 11)
    fallen = 100.0 * 0.5 * 9.8 * times**2
    stop = int((fallen > LIMIT_T).argmax())
    np.testing.assert_allclose(seen.corner[1, : stop + 1], fallen[: stop + 1], rtol=0.02)
    np.testing.assert_allclose(seen.centre[1], seen.corner[1], rtol=1e-9)
    assert (seen.corner[1, stop:] == seen.corner[1, stop]).all()
    assert seen.angle[1].max() < 1e-3
    assert (seen.moved[1] == 1).all()
    assert seen.corner[0].max() < 0.01
    assert seen.status is Status.DONE


@pytest.mark.parametrize(
    ("eps_t", "samples"), [(3.0, 10), (10.0, 10), (15.0, 6), (19.0, 6), (19.0, 7)]
)
@pytest.mark.parametrize("criterion", Criterion)
def test_thresholds_and_times_are_read_off_a_fall(criterion, eps_t, samples):
    fallen = 100.0 * 0.5 * 9.8 * (0.03 * samples) ** 2
    found = trace(in_the_air(60.0)).failing_step(criterion, eps_t, 10.0, samples)
    assert found == (1 if fallen > eps_t else None)


@pytest.mark.parametrize(
    ("changes", "criterion", "eps_t", "eps_r"),
    [
        ("", Criterion.ADAMS, 10.0, 10.0),
        (":eps_t=4,eps_r=3", Criterion.ADAMS, 4.0, 3.0),
        (":criterion=paper,early_exit=0", Criterion.PAPER, 10.0, 10.0),
        (":criterion=paper,early_exit=0,eps_t=2", Criterion.PAPER, 2.0, 10.0),
    ],
)
def test_a_trace_gives_the_verdict_of_an_ordinary_judgement(
    traced, changes, criterion, eps_t, eps_r
):
    method, unstable = make_method(MUJOCO + changes), 0
    for layout, seen in traced:
        said = method.judge(layout).failing_step
        assert seen.failing_step(criterion, eps_t, eps_r, 10) == said, layout.name
        unstable += said is not None
    assert unstable > 3


def test_loading_goes_on_past_a_step_within_the_limits():
    """An item 12 cm above the floor fails at 10 cm, but not beyond 20 cm."""
    items = (*in_the_air(12.0).items, Item(2, (70, 0, 70), (10, 10, 10), 1.0))
    seen = trace(Layout("low", Pallet(100, 100, 100), items))
    assert len(seen.corner) == 3
    assert seen.failing_step(Criterion.ADAMS, 10.0, 10.0, 10) == 1
    assert seen.failing_step(Criterion.ADAMS, 15.0, 10.0, 10) is None


def three_items():
    """The second falls, by 15.9 cm at the sixth sample and 21.6 cm at the seventh."""
    items = (*in_the_air(60.0).items, Item(2, (70, 0, 70), (10, 10, 10), 1.0))
    return Layout("one falls", Pallet(100, 100, 100), items)


def test_a_later_sample_does_not_cut_off_an_earlier_question():
    method = make_method(MUJOCO)
    cut = trace_loading(three_items(), method, t_max=0.21, samples=7)
    assert len(cut.corner) == 2
    assert cut.failing_step(Criterion.ADAMS, 19.0, 10.0, 7) == 1
    with pytest.raises(UndecidedError, match="only 2 of 3 steps"):
        cut.failing_step(Criterion.ADAMS, 19.0, 10.0, 6)
    whole = trace_loading(three_items(), method, t_max=0.21, samples=7, ending=6)
    assert len(whole.corner) == 3
    assert whole.failing_step(Criterion.ADAMS, 19.0, 10.0, 6) is None
    assert whole.failing_step(Criterion.ADAMS, 19.0, 10.0, 7) == 1


def test_what_was_seen_before_an_engine_gave_up_still_counts(monkeypatch):
    settle = Loading._settle

    def give_up(self, step, *items):
        if step == 2:
            raise EngineError("gave up")
        return settle(self, step, *items)

    monkeypatch.setattr(Loading, "_settle", give_up)
    items = (*in_the_air(12.0).items, Item(2, (70, 0, 70), (10, 10, 10), 1.0))
    seen = trace(Layout("low", Pallet(100, 100, 100), items))
    assert seen.status is Status.ERROR
    assert seen.failing_step(Criterion.ADAMS, 10.0, 10.0, 10) == 1
    with pytest.raises(UndecidedError):
        seen.failing_step(Criterion.ADAMS, 15.0, 10.0, 10)


def test_what_a_trace_cannot_answer_is_refused():
    with pytest.raises(ValueError, match="between_steps=reseat"):
        trace(in_the_air(60.0), f"{MUJOCO}:between_steps=carry")
    seen = trace(in_the_air(60.0))
    with pytest.raises(ValueError, match="up to 20 cm and 20 degrees"):
        seen.failing_step(Criterion.ADAMS, 21.0, 10.0, 10)
    with pytest.raises(ValueError, match="allowed: 1 to 10"):
        seen.failing_step(Criterion.ADAMS, 10.0, 10.0, 11)


def test_a_trace_follows_everything_whatever_the_scope(stack):
    layout = stack(0.0, 4.0, 0.0)
    traces = [
        trace_loading(layout, make_method(f"label@mujoco{more}"), t_max=0.3, samples=10)
        for more in ("", ":scope=moving", ":question=stands")
    ]
    for other in traces[1:]:
        np.testing.assert_array_equal(other.corner, traces[0].corner)
        np.testing.assert_array_equal(other.angle, traces[0].angle)
