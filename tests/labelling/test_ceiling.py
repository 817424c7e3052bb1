"""What labels' noise leaves to be reached, against counting and against simulation."""

from itertools import combinations

import numpy as np
import pandas as pd
import pytest

from steadyload.labelling.ceiling import label_ceiling, plurality, twins
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.model.question import Question

NONE = float("nan")


def test_twins_and_plurality_counted_by_hand():
    answers = np.array(
        [
            [3, 3, 3, 3],  # all agree
            [3, 3, 3, 5],  # 3 of 6 pairs; the fourth answer is never led by the others
            [3, 3, 5, 5],  # 2 of 6 pairs; without one of a pair the other pair leads
            [1, 2, 3, 4],  # no pair; without one three answers lead, none of them the one left out
            [-1, -1, NONE, NONE],  # no verdict agrees with nothing
        ]
    )
    assert twins(answers) == pytest.approx([1.0, 3 / 6, 2 / 6, 0.0, 1 / 6])
    assert plurality(answers) == pytest.approx([1.0, 3 / 4, 0.0, 0.0, 2 / 4])


@pytest.mark.parametrize("seed", range(4))
def test_twins_are_the_share_of_equal_pairs(seed):
    answers = np.random.default_rng(seed).integers(0, 4, (20, 6)).astype(float)
    pairs = [[a == b for a, b in combinations(row, 2)] for row in answers.tolist()]
    assert twins(answers) == pytest.approx(np.mean(pairs, axis=1))


def test_twins_estimate_what_two_independent_draws_agree_in():
    random = np.random.default_rng(7)
    law = np.array([0.7, 0.2, 0.1])
    answers = random.choice(3, (20000, 5), p=law).astype(float)
    assert twins(answers).mean() == pytest.approx((law**2).sum(), abs=0.006)
    # Who names the likeliest is right in 70 %; four other draws do not always tell which it is.
    assert (law**2).sum() < plurality(answers).mean() < 0.7


@pytest.fixture(scope="module")
def judged():
    benchmark = load_benchmark()
    labels = benchmark.select("test", limit=40)
    sure = benchmark.confidence_on(Question.WITHIN)[["confidence", "robust"]]
    classes = benchmark.layouts["item_class"].astype(str)
    labels = labels.join(sure, on=KEYS).join(classes, on="layout").set_index(KEYS)
    return labels, benchmark.further_verdicts_on(Question.WITHIN)


def test_scenarios_have_their_usual_order_whatever_the_order_of_the_cases(judged):
    labels, opinions = judged
    orders = labels, labels[::-1], labels.sort_values("instance")
    found = [list(label_ceiling(each, opinions).by_group) for each in orders]
    assert found == [["all", "S1", "S2a", "S2b"]] * 3


def test_against_the_label_it_is_the_mean_confidence(judged):
    labels, opinions = judged
    ceiling = label_ceiling(labels, opinions)
    assert list(ceiling.by_group) == ["all", "S1", "S2a", "S2b"]
    for group, rows in ceiling.by_group.items():
        here = labels if group == "all" else labels.xs(group, level="scenario")
        assert rows[-1].label.value == pytest.approx(here["confidence"].mean())
        assert rows[-1].label.n == len(here)
        assert [row.judges for row in rows] == [3, 7, 11]


def test_robust_labels_have_no_noise_and_fragile_ones_have(judged):
    labels, opinions = judged
    robust = labels["robust"].astype(bool)
    assert 0 < (~robust).sum() < 60
    sure = label_ceiling(labels[robust], opinions).by_group["all"][-1]
    assert (sure.twin.value, sure.plurality.value, sure.label.value) == (1.0, 1.0, 1.0)
    unsure = label_ceiling(labels[~robust], opinions).by_group["all"][-1]
    assert unsure.twin.value < 1.0


def test_the_order_of_cases_means_nothing(judged):
    labels, opinions = judged
    mixed = opinions.sample(frac=1.0, random_state=3)
    assert label_ceiling(labels, mixed) == label_ceiling(labels, opinions)


def test_every_further_method_has_its_share_and_engines_are_no_part_of_the_ensemble(judged):
    labels, opinions = judged
    ceiling = label_ceiling(labels, opinions)
    pairs = {(row.reason, row.method) for row in ceiling.methods}
    assert pairs == set(zip(opinions["reason"], opinions["judge"], strict=True))
    own = opinions.set_index(KEYS).loc[labels.index]
    step = own["failing_step"].fillna(-1).astype(int)
    truth = labels["failing_step"].fillna(-1).astype(int).reindex(own.index)
    same = (step == truth) & (own["status"] == "done")
    for row in ceiling.methods:
        assert row.same.value == pytest.approx(same[own["judge"] == row.method].mean())
    without = opinions[opinions["reason"] != "engine"]
    assert label_ceiling(labels, without).by_group == ceiling.by_group


def test_the_question_stands_has_no_time_that_could_be_another(judged):
    names = {q: label_ceiling(*judged, q).by_group["all"][-1].name for q in Question}
    assert names[Question.WITHIN] == "numerics, contact model, thresholds and time"
    assert names[Question.STANDS] == "numerics, contact model and thresholds"


def test_there_is_no_ceiling_without_an_ensemble(judged):
    labels, opinions = judged
    assert label_ceiling(labels, opinions[opinions["reason"] == "limits"]) is None
    assert label_ceiling(labels, pd.DataFrame(columns=opinions.columns)) is None


def test_it_is_of_the_cases_that_all_further_methods_have_judged(judged):
    labels, opinions = judged
    rest = labels.index[::3]
    late = (opinions["reason"] == "numerical") & pd.MultiIndex.from_frame(opinions[KEYS]).isin(rest)
    part = label_ceiling(labels, opinions[~late])
    alone = label_ceiling(labels[~labels.index.isin(rest)], opinions)
    assert part.by_group["all"][-1].label.n == len(labels) - len(rest)
    for one, other in zip(part.by_group["all"], alone.by_group["all"], strict=True):
        assert (one.label, one.twin, one.plurality) == (other.label, other.twin, other.plurality)
    assert label_ceiling(labels, opinions[opinions["reason"] != "numerical"]) is None
    assert label_ceiling(labels.loc[rest], opinions[~late]) is None
