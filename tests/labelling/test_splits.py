"""Splits by item list."""

import json

import numpy as np
import pandas as pd
import pytest

from steadyload.labelling.building.splits import (
    MOST_STABLE,
    FurtherDraw,
    SplitSizes,
    assign_splits,
    split_by_instance,
    spread_over_lists,
)
from steadyload.layouts.benchmark import BenchmarkError
from steadyload.layouts.sizes import MOST_SMALL

SIZES = SplitSizes(test=40, validation=12, test_lists=3, validation_lists=1)


def labelled(instances=12, layouts=15, unlabelled=0):
    """Cases of three classes; every third layout is unstable in S1, every other one in S2b."""
    rows = [
        {
            "layout": f"{c}-{i}-{n}",
            "scenario": scenario,
            "instance": f"Class_{c}_Instance_{i}",
            "item_class": c,
            "item_count": 20,
            "status": "unlabelled" if n < unlabelled else "done",
            "failing_step": 1 if n % every == 0 else pd.NA,
        }
        for c in (1, 2, 3)
        for i in range(instances)
        for n in range(layouts)
        for scenario, every in (("S1", 3), ("S2b", 2))
    ]
    return pd.DataFrame(rows).astype({"failing_step": "Int16"})


def test_an_item_list_lies_in_one_split():
    cases = assign_splits(labelled(), seed=3, sizes=SIZES)
    splits = cases.dropna(subset=["split"]).groupby("instance")["split"].nunique()
    assert (splits == 1).all()
    used = set(cases.dropna(subset=["split"])["instance"])
    taken = cases[cases["split"].isin(("test", "validation"))]["instance"].unique()
    left_over = cases[cases["split"].isna()]
    assert len(left_over)
    assert set(left_over["instance"]) <= set(taken)
    assert len(used) == 36


@pytest.mark.parametrize(("split", "size"), [("test", 40), ("validation", 12)])
def test_every_even_prefix_is_half_stable(split, size):
    cases = assign_splits(labelled(), seed=3, sizes=SIZES)
    for scenario in ("S1", "S2b"):
        own = cases[(cases["split"] == split) & (cases["scenario"] == scenario)]
        own = own.sort_values("rank")
        assert own["rank"].tolist() == list(range(size))
        stable = own["failing_step"].isna().to_numpy()
        assert (stable.reshape(-1, 2).sum(axis=1) == 1).all()


def test_training_holds_all_cases_of_its_lists():
    cases = assign_splits(labelled(), seed=3, sizes=SIZES)
    train = cases[cases["split"] == "train"]
    assert (train.groupby(["instance", "scenario"]).size() == 15).all()
    for _, own in train.groupby("scenario"):
        assert sorted(own["rank"]) == list(range(len(own)))


def test_draws_depend_on_the_seed_alone():
    cases = labelled()
    first, second = (assign_splits(cases, seed=3, sizes=SIZES) for _ in range(2))
    pd.testing.assert_frame_equal(first, second)
    other = assign_splits(cases, seed=4, sizes=SIZES)
    assert (first["split"].fillna("") != other["split"].fillna("")).any()
    tests = set()
    for seed in range(6):
        drawn = assign_splits(cases, seed=seed, sizes=SIZES)
        tests.add(frozenset(drawn[drawn["split"] == "test"]["instance"]))
    assert len(tests) > 3


def test_all_classes_take_part_and_unlabelled_cases_do_not():
    cases = assign_splits(labelled(unlabelled=2), seed=3, sizes=SIZES)
    assert set(cases[cases["split"] == "test"]["item_class"]) == {1, 2, 3}
    assert cases[cases["status"] != "done"]["split"].isna().all()


def test_held_out_cases_come_from_as_many_lists_as_asked_for():
    for lists in (3, 5):
        sizes = SplitSizes(test=4, validation=2, test_lists=lists, validation_lists=2)
        cases = assign_splits(labelled(), seed=3, sizes=sizes)
        train = cases[cases["split"] == "train"]["instance"].nunique()
        assert train == 3 * (12 - lists - 2)


def test_sizes_are_even():
    with pytest.raises(BenchmarkError, match="test is 5; allowed: an even number"):
        SplitSizes(test=5)


def test_too_few_cases_are_refused():
    with pytest.raises(BenchmarkError, match=r"test: only \d+ stable or unstable .* 200 of each"):
        assign_splits(labelled(), seed=3, sizes=SplitSizes(400, 12, 3, 1))
    with pytest.raises(BenchmarkError, match="validation: only"):
        assign_splits(labelled(instances=3), seed=3, sizes=SplitSizes(40, 200, 1, 1))


def test_ranks_do_not_follow_the_order_of_the_table():
    cases = assign_splits(labelled(), seed=3, sizes=SIZES)
    own = cases[(cases["split"] == "test") & (cases["scenario"] == "S1")]
    ranks = own["rank"].to_numpy(int)
    assert np.corrcoef(np.arange(len(ranks)), ranks)[0, 1] < 0.9


def test_whole_instances_are_held_out_and_enough_of_their_cases_fail():
    cases = labelled()
    cases.loc[cases["layout"].str.endswith(("-3", "-6", "-9", "-12")), "failing_step"] = pd.NA
    found = split_by_instance(cases, seed=3, test=0.5, validation=0.25)
    named = found.dropna(subset="split")
    assert (named.groupby("instance")["split"].nunique() == 1).all()
    assert named.groupby("split")["instance"].nunique().to_dict() == {
        "test": 18, "train": 9, "validation": 9
    }  # fmt: skip
    left_over = found[found["split"].isna()]
    assert len(left_over)
    assert left_over["failing_step"].isna().all()
    assert left_over["rank"].isna().all()
    for part in ("test", "validation"):
        own = named[named["split"] == part]
        assert own["failing_step"].isna().mean() <= MOST_STABLE
        for _, ranked in own.groupby("scenario"):
            assert ranked["rank"].is_unique
            # A rank stays empty where a case is left out.
            assert set(ranked["rank"]) <= set(range(len(ranked) + len(left_over)))


def test_held_out_instances_do_not_depend_on_labels():
    cases = labelled()
    before = split_by_instance(labelled(unlabelled=15), seed=3, test=0.5, validation=0.25)
    after = split_by_instance(cases, seed=3, test=0.5, validation=0.25).dropna(subset="split")
    assert (before.loc[after.index, "split"] == after["split"]).all()
    assert before["split"].notna().all()


def same(found, other, index):
    """Whether splits and ranks of some cases are equal."""
    columns = ["split", "rank"]
    return found.loc[index, columns].equals(other.loc[index, columns])


def with_large(cases):
    """A third of the layouts is large."""
    return cases.assign(item_count=[70 if k % 6 < 2 else 20 for k in range(len(cases))])


@pytest.mark.parametrize("fails", [0.0, 0.1, 1.0])
def test_labels_of_large_cases_move_no_small_one(fails):
    cases = with_large(labelled())
    large = cases["item_count"] > MOST_SMALL
    unlabelled = cases.assign(status=cases["status"].mask(large, "unlabelled"))
    drawn = np.random.default_rng(5).random(len(cases)) < fails
    cases.loc[large, "failing_step"] = pd.array(np.where(drawn[large], 1, -1), "Int16")
    cases["failing_step"] = cases["failing_step"].mask(cases["failing_step"] == -1)
    rule = {"seed": 3, "test": 0.5, "validation": 0.25}
    before, after = split_by_instance(unlabelled, **rule), split_by_instance(cases, **rule)
    assert same(before, after, cases.index[~large])
    kept = after.index[after["split"].notna()]
    assert same(before, after, kept)
    for part in ("test", "validation"):
        own = after[(after["split"] == part) & large]
        assert own.empty if not fails else own["failing_step"].isna().mean() <= MOST_STABLE


def test_large_cases_come_last_in_held_out_parts():
    found = split_by_instance(with_large(labelled()), seed=3, test=0.5, validation=0.25)
    for (part, _), own in found.groupby(["split", "scenario"]):
        own = own.sort_values("rank")
        large = (own["item_count"] > MOST_SMALL).to_numpy()
        assert large.any()
        assert bool((np.diff(large.astype(int)) >= 0).all()) == (part != "train")


def test_a_further_draw_moves_nothing_and_trains_on_nothing():
    cases = with_large(labelled())
    rule = {"seed": 3, "test": 0.5, "validation": 0.25}
    before = split_by_instance(cases, **rule)
    new = with_large(labelled(instances=5)).assign(status="unlabelled", failing_step=pd.NA)
    new["instance"] = new["instance"].str.replace("Class", "Further")
    both = pd.concat([cases, new], ignore_index=True).astype({"failing_step": "Int16"})
    names = tuple(new["instance"].unique())
    found = split_by_instance(both, **rule, further=[FurtherDraw(names, seed=4, test=0.5)])
    assert same(before, found, cases.index)
    added = found.iloc[len(cases) :]
    assert (added.groupby("instance")["split"].nunique() == 1).all()
    assert added.groupby("split")["instance"].nunique().to_dict() == {"test": 8, "validation": 7}
    for (part, scenario), own in added.groupby(["split", "scenario"]):
        first = before[(before["split"] == part) & (before["scenario"] == scenario)]
        assert own["rank"].is_unique
        assert own["rank"].min() > first["rank"].max()
    other = split_by_instance(both, **rule, further=[FurtherDraw(names, seed=5, test=0.5)])
    assert same(before, other, cases.index)
    assert not same(found, other, added.index)


# --- a test alone, spread over many item lists --------------------------------------------------


@pytest.fixture
def spread():
    """At most 12 cases of a list: two stable and two unstable ones in each of two scenarios."""
    return spread_over_lists(labelled(), seed=3, most=12)


def test_a_test_alone_has_no_other_part_and_few_cases_of_every_list(spread):
    assert set(spread["split"].dropna()) == {"test"}
    held = spread[spread["split"] == "test"]
    assert held["instance"].nunique() == 36
    assert held.groupby("instance").size().max() <= 12
    kinds = held.groupby(["instance", "scenario", held["failing_step"].isna()]).size()
    assert kinds.max() == 2
    assert spread["rank"].notna().equals(spread["split"].notna())


def test_half_of_every_scenario_is_stable_at_any_even_rank(spread):
    for _, group in spread[spread["split"] == "test"].groupby("scenario"):
        stable = group.sort_values("rank")["failing_step"].isna().to_numpy()
        assert sorted(group["rank"]) == list(range(len(group)))
        assert (stable[::2] & ~stable[1::2]).all()


def test_the_first_ranks_come_from_as_many_lists_as_there_are(spread):
    held = spread[spread["split"] == "test"].sort_values("rank")
    for _, group in held.groupby("scenario"):
        for stable, own in group.groupby(group["failing_step"].isna()):
            assert own["instance"].iloc[:36].nunique() == 36, stable


def test_where_unstable_ones_run_out_stable_ones_are_as_few():
    cases = labelled(layouts=2)  # one of two is unstable in both scenarios
    cases.loc[cases["instance"].str.endswith(("1", "2")), "failing_step"] = pd.NA
    spread = spread_over_lists(cases, seed=3, most=40)
    held = spread[spread["split"] == "test"]
    unstable = cases["failing_step"].notna().groupby(cases["scenario"]).sum()
    assert held.groupby("scenario").size().to_dict() == (2 * unstable).to_dict()


def test_it_is_drawn_alike_again_and_otherwise_by_another_seed(spread):
    assert spread_over_lists(labelled(), seed=3, most=12).equals(spread)
    other = spread_over_lists(labelled(), seed=4, most=12)
    assert not other["split"].equals(spread["split"])


def test_the_sizes_of_a_set_choose_the_rule(spread):
    sizes = SplitSizes(most_of_list=12)
    assert assign_splits(labelled(), seed=3, sizes=sizes).equals(spread)
    with pytest.raises(BenchmarkError, match="most_of_list is 5; allowed: 6 or more"):
        SplitSizes(most_of_list=5)


def test_lists_are_dealt_to_parts_a_class_in_turn_and_every_part_is_balanced():
    sizes = SplitSizes(most_of_list=12, parts=("search", "fitting"))
    assert SplitSizes(**json.loads(json.dumps(sizes.stored()))) == sizes
    spread = assign_splits(labelled(), seed=3, sizes=sizes)
    held = spread[spread["split"].notna()]
    parts = held.groupby("instance")["split"].unique()
    assert (parts.str.len() == 1).all(), "an item list lies in two parts"
    of_class = held.groupby(["item_class", "split"])["instance"].nunique()
    assert of_class.nunique() == 1, "a class has more lists in one part than in the other"
    assert set(of_class.index.get_level_values("split")) == {"search", "fitting"}
    for _, group in held.groupby(["split", "scenario"]):
        stable = group.sort_values("rank")["failing_step"].isna().to_numpy()
        assert sorted(group["rank"]) == list(range(len(group)))
        assert (stable[::2] & ~stable[1::2]).all()


def test_a_scenario_without_an_unstable_case_is_told():
    cases = labelled().assign(failing_step=pd.array([pd.NA] * 1080, dtype="Int16"))
    with pytest.raises(BenchmarkError, match="no stable or no unstable case in scenario S1"):
        spread_over_lists(cases, seed=3, most=12)
