"""Fitting a cascade: losses are counted as they are, the budget is kept, the rest is cheap."""

import dataclasses
import itertools
import types
from contextlib import closing

import numpy as np
import pytest
from scipy.stats import binom

from steadyload.cli import main
from steadyload.layouts.benchmark.parts import CHOOSING, Part
from steadyload.layouts.model.question import Question
from steadyload.methods.cascade.thresholds import Larger, Stage, load_thresholds, write_thresholds
from steadyload.methods.contract.method import Stopwatch
from steadyload.methods.contract.spec import SpecError
from steadyload.methods.registry import make_method
from steadyload.methods.tuned import tuned_engines
from steadyload.statistics.metrics import effective_size
from steadyload.tuning import TuningError
from steadyload.tuning.cascade import fitted as fitted_module
from steadyload.tuning.cascade import fitting as fitting_module
from steadyload.tuning.cascade import sizes as sizes_module
from steadyload.tuning.cascade import step_scores as scores_module
from steadyload.tuning.cascade.evaluation import evaluate
from steadyload.tuning.cascade.fitted import FitOptions, check_remakable, fit_cascade
from steadyload.tuning.cascade.fitting import (
    allowed_losses,
    fit,
    independent_cases,
    left_out,
    upper_bound,
)
from steadyload.tuning.cascade.sizes import size_classes, size_weights, threshold_classes
from steadyload.tuning.cascade.stages import Rung, best_stage
from steadyload.tuning.cascade.step_scores import StepScores, Table, score_steps
from steadyload.tuning.cases import CaseSource, load_cases


def step_scores(scores, cost=1.0, opening=0.0, decision_threshold=0.5, cases=None, trained=True):
    scores = np.asarray(scores, dtype=float)
    count = len(scores) if cases is None else cases
    return StepScores(
        scores, np.full(len(scores), cost), np.full(count, opening), decision_threshold, trained
    )


@pytest.fixture
def three():
    """Three cases: one that fails at its step 1, one of two steps that is stable, one that fails at
    once; the last method is wrong about the third.
    """
    return Table(
        of=np.array([0, 0, 1, 1, 2]),
        fails=np.array([False, True, False, False, True]),
        lists=np.array(["a", "b", "b"], dtype=object),
        boxes=np.array([3, 2, 30]),
        step_scores={
            "quick": step_scores([0.1, 0.4, 0.3, 0.9, 0.8], cost=1.0, opening=10.0, cases=3),
            "last": step_scores(
                [0.0, 2.0, 0.0, 0.0, 0.0], cost=100.0, decision_threshold=1.0, cases=3
            ),
        },
    )


def test_a_table_of_three_cases_by_hand(three):
    found = evaluate(three, (Stage("quick", 0.35, 0.85),), "last")
    # Of case 0, quick says stable, last unstable. Of case 1, quick stable, then unstable, wrongly.
    # Of case 2, last says stable, wrongly.
    assert found.by.tolist() == [0, 1, 0, 0, 1]
    assert found.unstable.tolist() == [False, True, False, True, False]
    assert found.right.tolist() == [True, False, False]
    assert found.alone.tolist() == [True, True, False]
    assert found.lost.tolist() == [False, True, False]
    assert found.blamed.tolist() == [-1, 0, 1]
    assert found.cost.tolist() == [10 + 2 + 100, 10 + 2, 10 + 1 + 100]


def test_what_a_stage_gains_is_told_apart_from_what_it_loses(three):
    found = evaluate(three, (Stage("quick", 0.35, 0.7),), "last")
    assert found.gained.tolist() == [False, False, True]
    assert found.lost.tolist() == [False, True, False]


def test_nothing_is_asked_after_the_first_step_that_is_called_unstable(three):
    found = evaluate(three, (Stage("quick", None, 0.2),), "last")
    assert found.asked.tolist() == [True, True, True, False, True]
    assert found.cost[1] == 10 + 1


def test_without_an_opinion_of_the_last_there_is_no_right_verdict(three):
    three.step_scores["last"].scores[0] = np.nan
    assert evaluate(three, (), "last").right.tolist() == [False, True, False]
    # Nobody asks the last method of a step that a stage has decided.
    assert evaluate(three, (Stage("quick", 0.2, None),), "last").right.tolist()[0]


def test_a_part_of_a_table_is_the_table_of_those_cases(three):
    part = three.chosen(np.array([True, False, True]))
    assert part.of.tolist() == [0, 0, 1]
    assert part.starts.tolist() == [0, 2]
    whole, own = (evaluate(t, (Stage("quick", 0.35, 0.85),), "last") for t in (three, part))
    assert own.cost.tolist() == whole.cost[[0, 2]].tolist()
    assert own.right.tolist() == whole.right[[0, 2]].tolist()


def test_no_fall_that_counts_is_lost_and_stages_only_pass_steps():
    """40 cases of one step, half of which fall; to the stage two falls look safe."""
    fails = np.arange(40) % 2 == 1
    scores = np.where(fails, 0.9, 0.1)
    scores[[1, 3]] = 0.3, 0.05
    last = step_scores(np.where(fails, 2.0, 0.0), cost=100.0, decision_threshold=1.0, cases=40)
    table = Table(
        np.arange(40), fails, np.array([f"list {k}" for k in range(40)], dtype=object),
        np.full(40, 5), {"quick": step_scores(scores, cases=40), "last": last},
    )  # fmt: skip
    how = {"budget": 0.2, "confidence": 0.5, "independent": 40.0}
    free = fit(table, ["quick"], "last", **how)
    assert free.stages[0].high is not None
    assert free.evaluation.lost[[1, 3]].all()
    for counts, low, lost in (([1], 0.3, [3]), ([1, 3], None, []), ([], 0.5, [1, 3])):
        falls = np.isin(np.arange(40), counts)
        found = fit(dataclasses.replace(table, falls=falls), ["quick"], "last", **how)
        assert all(each.high is None for stage in found.stages for each in stage.ranges)
        assert [stage.low for stage in found.stages] == ([low] if low else [])
        assert np.flatnonzero(found.evaluation.lost).tolist() == lost


def test_a_stage_of_few_items_decides_and_costs_nothing_beyond_them(three):
    """As above, but the last method judges the second step of cases 0 and 1."""
    found = evaluate(three, (Stage("quick", 0.35, 0.85, items=1),), "last")
    assert found.by.tolist() == [0, 1, 0, 1, 1]
    assert found.unstable.tolist() == [False, True, False, False, False]
    assert found.right.tolist() == [True, True, False]
    assert found.cost.tolist() == [10 + 1 + 100, 10 + 1 + 100, 10 + 1 + 100]


def test_thresholds_of_larger_loads_hold_for_their_steps(three):
    """Of case 1, the second step is stable by them; of case 0, it is left to the last method."""
    for above in (Larger(1, 0.95, None), Larger(1, None, None)):
        stage = Stage("quick", 0.35, 0.85, None, (above,))
        found = evaluate(three, (stage,), "last")
        decided = above.low is not None
        assert found.by.tolist() == [0, int(not decided), 0, int(not decided), 1]
        assert found.unstable.tolist() == [False, not decided, False, False, False]
        assert found.cost[0] == 10 + 1 + (1 if decided else 100)


def test_few_cases_of_one_size_count_among_the_smaller():
    boxes = np.repeat([3, 30, 50, 75, 120], [40, 25, 5, 20, 30])
    found = size_classes(boxes)
    assert [found[boxes == size].tolist() for size in (3, 30, 50, 75, 120)] == [
        [0] * 40, [1] * 25, [2] * 5, [2] * 20, [3] * 30,
    ]  # fmt: skip
    assert size_classes(np.array([150, 3])).tolist() == [0, 0]
    assert size_classes(np.repeat([3, 150], [40, 5])).tolist() == [0] * 45


def test_the_last_method_alone_costs_one_in_any_mixture_of_sizes(three):
    assert size_weights(three, "last") @ evaluate(three, (), "last").cost == pytest.approx(1.0)


@pytest.fixture
def sized():
    """200 small cases of 5 steps, and 40 large ones of 50. The stage knows everything; the cost of
    its steps is that of the last method at 20 items, and grows faster.
    """
    counts = np.repeat([5, 50], [200, 40])
    of = np.repeat(np.arange(240), counts)
    fails = np.zeros(len(of), dtype=bool)
    fails[np.cumsum(counts)[::2] - 1] = True
    lists = np.array([f"list {k % 40}" for k in range(240)], dtype=object)
    sure = step_scores(np.where(fails, 0.9, 0.1), cases=240)
    items = 1.0 + np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts, counts)
    stage = dataclasses.replace(sure, cost=(items / 20.0) ** 2)
    last = dataclasses.replace(sure, cost=np.ones(len(of)))
    return Table(of, fails, lists, counts, {"stage": stage, "last": last})


def test_a_stage_is_kept_for_the_steps_where_it_pays(sized):
    for budget in (0.01, 0.1):
        found = fit(sized, ("stage",), "last", budget=budget, confidence=0.5, independent=240.0)
        [stage] = found.stages
        assert stage.items == 20
        alone, whole, own = (
            evaluate(sized, stages, "last").cost[-1]
            for stages in ((), (dataclasses.replace(stage, items=None),), (stage,))
        )
        assert own < alone < whole


def test_cheap_large_loads_do_not_hide_what_small_ones_cost(sized):
    """The stage saves nine tenths of a small load, and decides no later step, at some cost."""
    early = sized.places < 5
    stage, last = sized.step_scores["stage"], sized.step_scores["last"]
    stage = dataclasses.replace(
        stage, scores=np.where(early, stage.scores, np.nan), cost=np.where(early, 0.1, 0.7)
    )
    few = dataclasses.replace(sized, step_scores={"stage": stage, "last": last})
    alone, found = (evaluate(few, of, "last").cost for of in ((), (Stage("stage", 0.5, 0.5),)))
    assert found.mean() > alone.mean()
    weights = size_weights(few, "last")
    assert weights @ found == pytest.approx((0.1 + (0.5 + 45 * 1.7) / 50) / 2)
    assert weights @ found < weights @ alone


def two_sizes(clear):
    """200 cases of 10 boxes and 60 of 100, half failing at the last step. At one size the quick
    method is clear: 0.4 for a stable step, 0.9 for a failing one. At the other it gives a stable
    step up to 0.35 and a failing one from 0.2 to 0.3. The first 20 steps of large loads have 0.1.
    """
    counts = np.repeat([10, 100], [200, 60])
    of = np.repeat(np.arange(260), counts)
    fails = np.zeros(len(of), dtype=bool)
    fails[np.cumsum(counts)[::2] - 1] = True
    lists = np.array([f"list {k % 26}" for k in range(260)], dtype=object)
    random = np.random.default_rng(3)
    dim = np.where(fails, random.uniform(0.2, 0.3, len(of)), random.uniform(0.0, 0.35, len(of)))
    scores = np.where(counts[of] == clear, np.where(fails, 0.9, 0.4), dim)
    items = 1 + np.arange(len(of)) - np.repeat(np.cumsum(counts) - counts, counts)
    scores = np.where((counts[of] == 100) & (items <= 20), 0.1, scores)
    table = {
        "quick": step_scores(scores, cost=0.01, cases=260),
        "last": step_scores(np.where(fails, 0.9, 0.1), cost=10.0, cases=260),
    }
    return Table(of, fails, lists, counts, table)


@pytest.fixture
def lenient():
    return two_sizes(clear=10)


def by_one_and_by_size(table):
    return (
        fit(
            table, ("quick",), "last",
            budget=0.01, confidence=0.5, independent=260.0, by_size=by_size,
        )
        for by_size in (False, True)
    )  # fmt: skip


def test_thresholds_by_size_save_what_one_pair_for_all_sizes_cannot(lenient):
    """The bold threshold of small loads would lose every failing load above 90 items."""
    one, sized = by_one_and_by_size(lenient)
    [single], [stage] = one.stages, sized.stages
    assert (single.low, single.items, single.larger) == (0.5, 90, ())
    assert [each.above for each in stage.larger] == [90]
    assert stage.larger[0].low < 0.3 < stage.low == 0.5
    for found in (one, sized):
        assert found.evaluation.lost.sum() <= found.most
    assert sized.evaluation.cost[200:].mean() < 0.9 * one.evaluation.cost[200:].mean()
    out = left_out(lenient, sized, budget=0.01, confidence=0.5)
    assert out.judged.all()
    assert out.lost[:200].sum() == 0


def test_thresholds_of_large_loads_are_no_wider_than_those_of_small_ones():
    """Though 0.4 is stable at each of the 60 large loads, 100 small ones fail at 0.2 to 0.3."""
    bold = two_sizes(clear=100)
    assert threshold_classes(bold, "last") == (0, 90)
    for found in by_one_and_by_size(bold):
        [stage] = found.stages
        assert max(each.low for each in stage.ranges if each.low is not None) < 0.3
    # Nor is more rejected: stable steps of small loads score up to 0.95, of large ones up to 0.4.
    small = np.where(bold.fails, 0.97, np.linspace(0.95, 0.0, len(bold.of)))
    scores = np.where(bold.boxes[bold.of] == 10, small, bold.step_scores["quick"].scores)
    quick = dataclasses.replace(bold.step_scores["quick"], scores=scores)
    table = dataclasses.replace(bold, step_scores={**bold.step_scores, "quick": quick})
    stage = best_stage(table, (), Rung("quick"), "last", (0, 90), (0, 0), np.ones(260))
    assert {each.high for each in stage.ranges} == {0.95}


@pytest.mark.parametrize("budget", [0.005, 0.01])
def test_losses_of_all_sizes_together_keep_to_one_budget(budget, drawn, monkeypatch):
    """With sizes of a few items; dearer ladders are those of one pair of thresholds."""
    for module in (fitting_module, sizes_module):
        monkeypatch.setattr(module, "SIZES", (2, 4, 6))
    assert threshold_classes(drawn, "last") == (0, 2, 4, 6)
    weights = size_weights(drawn, "last")
    one, sized = (
        fit(
            drawn, ("cheap",), "last",
            budget=budget, confidence=0.5, independent=500.0, by_size=by_size,
        )
        for by_size in (False, True)
    )  # fmt: skip
    assert sized.stages[0].larger
    assert sized.evaluation.lost.sum() <= sized.most == one.most
    assert sized.bound(0.5) <= budget
    assert weights @ sized.evaluation.cost < weights @ one.evaluation.cost


def test_a_size_with_few_failing_steps_has_the_thresholds_of_the_next_smaller():
    """Of 30 failing steps above 90 items, ten are kept at first, and then those of five lists."""
    lenient = two_sizes(clear=100)
    assert threshold_classes(lenient, "last") == (0, 90)
    large = lenient.boxes == 100
    assert threshold_classes(lenient.chosen(~large | (np.arange(260) < 220)), "last") == (0,)
    few = dataclasses.replace(lenient, lists=np.where(large, "one list", lenient.lists))
    assert threshold_classes(few, "last") == (0,)
    # What the last method gets wrong is no evidence against a threshold.
    wrong = dataclasses.replace(lenient, step_scores=dict(lenient.step_scores))
    wrong.step_scores["last"] = step_scores(np.full(len(lenient.of), 0.1), cost=10.0, cases=260)
    assert threshold_classes(wrong, "last") == (0,)
    [stage] = fit(
        few, ("quick",), "last", budget=0.01, confidence=0.5, independent=260.0
    ).stages  # fmt: skip
    assert stage.ranges[-1].low < 0.3


def test_a_stage_is_kept_for_large_loads_where_it_pays_there_alone(sized):
    """Its first steps cost what ten steps of the last method do."""
    stage = sized.step_scores["stage"]
    cost = np.where(sized.places < 20, 10.0, 0.1)
    late = dataclasses.replace(
        sized, step_scores=sized.step_scores | {"stage": dataclasses.replace(stage, cost=cost)}
    )
    [found] = fit(late, ("stage",), "last", budget=0.1, confidence=0.5, independent=240.0).stages
    assert not any(found.scores(step) for step in range(20))
    assert all(found.scores(step) for step in range(20, 60))
    assert str(found) == "stage above 20 items"


@pytest.mark.parametrize(("lost", "cases"), [(0, 50), (1, 200), (7, 900)])
@pytest.mark.parametrize("confidence", [0.5, 0.95])
def test_the_bound_is_the_share_at_which_so_few_losses_are_that_unlikely(lost, cases, confidence):
    bound = upper_bound(lost, cases, cases, confidence)
    assert binom.cdf(lost, cases, bound) == pytest.approx(1.0 - confidence)
    assert upper_bound(lost, cases, cases / 3, confidence) > bound


def test_as_many_losses_are_allowed_as_the_bound_lets():
    for budget, confidence in itertools.product((0.002, 0.01, 0.05), (0.5, 0.8)):
        most = allowed_losses(budget, 900, 400.0, confidence)
        if most >= 0:
            assert upper_bound(most, 900, 400.0, confidence) <= budget
        assert upper_bound(most + 1, 900, 400.0, confidence) > budget
    assert allowed_losses(0.001, 900, 400.0, 0.95) == -1
    assert allowed_losses(1.0, 5, 5.0, 0.5) == 5


@pytest.fixture(scope="module")
def drawn():
    """600 cases of 60 lists: a cheap judge that errs now and then, a dear one that hardly does, and
    one that says nothing; lists differ in how often the cheap one errs.
    """
    random = np.random.default_rng(0)
    counts = random.integers(1, 8, 600)
    of = np.repeat(np.arange(600), counts)
    fails = np.zeros(len(of), dtype=bool)
    last = np.cumsum(counts) - 1
    fails[last] = random.random(600) < 0.5
    lists = np.array([f"list {k % 60}" for k in range(600)], dtype=object)
    noise = 0.15 + 0.15 * (np.arange(600) % 60 < 10)
    cheap = fails + random.normal(0.0, 1.0, len(of)) * noise[of]
    dear = fails + random.normal(0.0, 0.22, len(of))
    return Table(
        of,
        fails,
        lists,
        counts,
        {
            "cheap": step_scores(cheap, cost=0.01, opening=0.1, cases=600),
            "idle": step_scores(np.full(len(of), np.nan), cost=0.01, opening=0.1, cases=600),
            "costly": step_scores(dear, cost=50.0, cases=600),
            "last": step_scores(dear, cost=10.0, cases=600),
        },
    )


CANDIDATES = ("cheap", "idle", "costly")


@pytest.mark.parametrize("budget", [0.005, 0.02, 0.1])
def test_the_budget_is_kept_and_what_is_spent_goes_down_with_it(drawn, budget):
    independent = independent_cases(drawn, CANDIDATES, "last")
    found = fit(drawn, CANDIDATES, "last", budget=budget, confidence=0.5, independent=independent)
    assert [stage.method for stage in found.stages] == ["cheap"]
    assert found.evaluation.lost.sum() <= found.most
    assert found.bound(0.5) <= budget
    assert found.bound(0.95) > found.bound(0.5)
    alone = evaluate(drawn, (), "last").cost.mean()
    tighter = fit(drawn, CANDIDATES, "last", budget=0.003, confidence=0.5, independent=independent)
    assert found.evaluation.cost.mean() < tighter.evaluation.cost.mean() < alone


def test_no_other_thresholds_of_one_stage_pass_less_on(drawn):
    """Against every pair among the scores that are in the way."""
    found = fit(drawn, ("cheap",), "last", budget=0.02, confidence=0.5, independent=500.0)
    scores = drawn.step_scores["cheap"].scores
    lows = np.sort(scores[drawn.fails])[:30]
    highs = np.sort(scores[~drawn.fails])[-30:]
    tried = 0
    for low, high in itertools.product(lows[lows <= 0.5], highs[highs >= 0.5]):
        other = evaluate(drawn, (Stage("cheap", low, high),), "last")
        if other.lost.sum() <= found.most:
            tried += 1
            assert found.evaluation.cost.mean() <= other.cost.mean() + 1e-9
    assert tried > 20


def test_thresholds_stay_on_their_side_of_the_brink(drawn):
    """Where no case is in the way, nothing speaks for calling what looks unstable stable."""
    fine = dataclasses.replace(drawn, step_scores=dict(drawn.step_scores))
    scores = np.where(drawn.fails, 0.9, 0.1)
    fine.step_scores["cheap"] = step_scores(scores, cost=0.01, cases=600)
    fine.step_scores["last"] = step_scores(scores, cost=10.0, cases=600)
    [stage] = fit(fine, ("cheap",), "last", budget=0.5, confidence=0.5, independent=600.0).stages
    assert (stage.low, stage.high) == (0.5, 0.5)


def test_a_budget_that_the_cases_cannot_bear_is_an_error(drawn):
    with pytest.raises(TuningError) as caught:
        fit(drawn, CANDIDATES, "last", budget=0.001, confidence=0.95, independent=100.0)
    least = 1.0 - 0.05 ** (1 / 100.0)
    assert f"error budget is 0.1 points; allowed: {100 * least:.2f} or more" in str(caught.value)
    assert "600 cases of 60 item lists tell as much as 100 independent ones" in str(caught.value)


def test_cases_that_go_wrong_together_count_for_less(drawn):
    independent = independent_cases(drawn, CANDIDATES, "last")
    assert 60 < independent < 500
    shuffled = dataclasses.replace(drawn, lists=np.random.default_rng(1).permutation(drawn.lists))
    assert independent_cases(shuffled, CANDIDATES, "last") > 1.3 * independent
    assert effective_size(np.ones(4, dtype=bool), ["a", "a", "b", "b"]) == 2.0


def test_lists_that_were_left_out_lose_more_than_those_fitted_on(drawn):
    independent = independent_cases(drawn, CANDIDATES, "last")
    found = fit(drawn, CANDIDATES, "last", budget=0.02, confidence=0.5, independent=independent)
    out = left_out(drawn, found, budget=0.02, confidence=0.5)
    assert out.judged.all()
    assert found.evaluation.lost.sum() < out.lost.sum() < 60


def test_lists_that_were_left_out_are_counted_by_number_of_boxes(lenient):
    """All that fail of 200 small loads, one of which does not count, and none of 60 large ones."""
    judged = np.arange(260) != 8
    fails = np.bincount(lenient.of, lenient.fails) > 0
    out = fitted_module.LeftOut(fails & judged & (lenient.boxes == 10), judged, fails)
    assert fitted_module._by_size(lenient, out) == [
        {"above": 0, "lost": 99, "cases": 199},
        {"above": 90, "lost": 0, "cases": 60},
    ]


@pytest.fixture(scope="module")
def real():
    """Twelve labelled cases, and cheap methods that stand in for the default ones."""
    return load_cases(CaseSource(Part.FITTING, CHOOSING, 4))


def test_methods_are_asked_of_every_step_that_has_a_label(real):
    table = score_steps(["fbs", "equilibrium"], real)
    assert len(table.of) == sum(min(case.safe + 1, len(case.layout)) for case in real)
    assert table.fails.sum() == sum(case.safe < len(case.layout) for case in real)
    for number, case in enumerate(real):
        own = table.of == number
        failing = np.flatnonzero(table.fails[own])
        assert failing.tolist() == ([case.safe] if case.safe < len(case.layout) else [])
        with closing(make_method("equilibrium").steps(case.layout, Stopwatch())) as judge:
            expected = [judge.step_score(step) for step in range(int(own.sum()))]
        assert table.step_scores["equilibrium"].scores[own].tolist() == expected
    assert not table.step_scores["fbs"].trained


@pytest.fixture(scope="module")
def fitted():
    options = FitOptions(
        "mujoco", budgets=(60.0, 30.0), candidates=("equilibrium", "lstm_1"), limit=4
    )
    return fit_cascade(options)


def test_a_fitted_cascade_comes_to_what_its_table_says(fitted, real, tmp_path):
    file = tmp_path / "t.json"
    write_thresholds("mujoco", fitted, file)
    for budget, ladder in fitted.ladders.items():
        cascade = make_method(f"cascade@mujoco:budget={budget:g},thresholds={file}")
        said = [cascade.judge(case.layout).failing_step for case in real]
        right = [
            step == (case.safe if case.safe < len(case.layout) else None)
            for step, case in zip(said, real, strict=True)
        ]
        assert np.mean(right) == pytest.approx(ladder.found["accuracy"], abs=1e-6)
        found = ladder.found
        assert found["lost"] - found["gained"] == pytest.approx(
            12 * (found["alone"] - found["accuracy"]), abs=1e-4
        )
        assert found["lost"] <= found["allowed"]
        assert sum(stage["lost"] for stage in found["decided"]) == found["lost"]
        [all_small] = found["left_out_by_size"]
        assert all_small == {"above": 0, **found["left_out"]}
    assert fitted.default == 60.0


def test_what_learnt_nothing_is_held_against_other_cases_too(fitted):
    for ladder in fitted.ladders.values():
        told = {entry["method"] for entry in ladder.found["elsewhere"]}
        assert told == {stage.method for stage in ladder.stages} - {"lstm_1"}


def test_thresholds_say_what_they_were_made_by(fitted):
    made_by = fitted.made_by
    assert made_by["candidates"] == ["equilibrium", "lstm_1"]
    assert {"git", "versions", "cases", "confidence"} <= set(made_by)
    with pytest.raises(TuningError, match="which is in no commit"):
        check_remakable({"git": "0123456789ab-dirty"})
    check_remakable({"git": "0123456789ab"})


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"engine": "mojuco"}, "did you mean 'mujoco'"),
        ({"budgets": (0.0,)}, "error budget is 0 points; allowed: above 0, to 100"),
        ({"budgets": ()}, "allowed: one or more"),
        ({"confidence": 1.0}, "confidence is 1; allowed: between 0 and 1"),
        ({"candidates": ("smee",)}, "did you mean 'sme'"),
    ],
)
def test_wrong_options_say_what_is_allowed(given, message):
    with pytest.raises((SpecError, TuningError), match=message):
        FitOptions(**({"engine": "mujoco"} | given))


def test_a_budget_may_be_as_small_as_one_likes():
    assert FitOptions("mujoco", budgets=(0.01, 100.0)).budgets == (0.01, 100.0)


@pytest.mark.parametrize("engine", tuned_engines())
@pytest.mark.parametrize("question", Question)
def test_every_engine_that_a_simulation_was_tuned_for_can_be_fitted(engine, question):
    options = FitOptions(engine, question=question)
    last = make_method(options.last)
    assert last.spec.engine == engine
    assert last.parameters.question is question
    # For stands only margins pass steps, and only the last method says that a load fails.
    own = {engine} if question is Question.WITHIN else set()
    assert {make_method(spec).spec.engine for spec in options.candidates} == {None, *own}


def test_the_last_method_may_have_parameters_and_is_stored():
    spec = "ps_opt@{engine}:samples=5"
    options = FitOptions("mujoco", last=spec, candidates=("fbs",), limit=4, budgets=(60.0,))
    assert options.last == "ps_opt@mujoco:samples=5"
    asked = FitOptions("mujoco", last=spec, question=Question.STANDS)
    assert asked.last == "ps_opt@mujoco:samples=5,question=stands"
    fitted = fit_cascade(options)
    assert fitted.made_by["last"] == options.last
    assert [ladder.last for ladder in fitted.ladders.values()] == [options.last]
    assert options.last in fitted.made_of
    for wrong, message in (
        ("ps_opt@bullet", "last method is ps_opt@bullet; allowed: one on the engine mujoco"),
        ("sme", "last method is sme; allowed: one on the engine mujoco"),
        ("ps_opt@mujoco:question=stands", "allowed: the question within, whose labels count"),
        ("ps_opd@mujoco", "did you mean 'ps_opt'"),
    ):
        with pytest.raises((SpecError, TuningError), match=message):
            FitOptions("mujoco", last=wrong)


def test_costs_are_cpu_time_of_all_threads_of_the_process(real, monkeypatch):
    """Rapier computes in a thread of its own, while that of the caller is idle."""
    ticks = itertools.count()
    clock = types.SimpleNamespace(process_time=lambda: float(next(ticks)))
    monkeypatch.setattr(scores_module, "time", clock)
    found = score_steps(["label@mujoco"], real[:4]).step_scores["label@mujoco"]
    assert set(found.cost) == set(found.opening) == {1000.0}


def test_a_two_dimensional_engine_is_fitted_on_the_planar_set():
    real = FitOptions("mujoco", data=("real",))
    assert [source.part for source in real.sources()] == ["fitting", "validation"]
    options = FitOptions("chipmunk")
    assert options.sources()[0].directory == "planar"
    assert options.last == "ps_opt@chipmunk"
    assert options.candidates[-1] == "ps_opt@chipmunk:scope=local"


def test_as_many_stable_as_unstable_cases_are_fitted_on(real):
    few = fitted_module._balanced([c for c in real if c.safe < len(c.layout) or c.scenario == "S1"])
    assert {c.scenario for c in few} == {"S1"}
    assert sum(c.safe < len(c.layout) for c in few) * 2 == len(few) == 4


def test_the_command_fits_and_prints(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(fitted_module, "ELSEWHERE", 2)
    file = tmp_path / "t.json"
    fit_few = ["cascade", "fit", "-o", str(file), "--limit", "4", "--candidate", "equilibrium"]
    assert main([*fit_few, "--error-budget", "60", "--last", "ps_opt@{engine}:samples=5"]) == 0
    assert load_thresholds("mujoco", file).ladders[60.0].last == "ps_opt@mujoco:samples=5"
    printed = capsys.readouterr().out
    assert "cascade@mujoco" in printed
    assert printed.endswith(f"{file}\n")
    assert main([*fit_few, "--limit", "2", "--error-budget", "60"]) == 2
    assert "cases to fit on: of 1 item lists; allowed: 2 or more" in capsys.readouterr().err
    assert main([*fit_few, "--error-budget", "1"]) == 2
    assert "error budget is 1 points; allowed: " in capsys.readouterr().err
