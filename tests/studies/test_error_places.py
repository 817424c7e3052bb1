"""Where methods err: bins by items and by margin, against a loop over cases."""

import math
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest

from steadyload.studies.evaluation.error_places import MARGINS, class_bins, margin_bins, size_bins


def made_up(seed, cases=80):
    """Labels, two methods' verdicts and margins, drawn by chance."""
    random = np.random.default_rng(seed)
    count = random.integers(1, 21, cases)
    failing = np.where(random.random(cases) < 0.5, count, random.integers(0, count))
    labels = pd.DataFrame(
        {
            "instance": random.choice(list("abcde"), cases),
            "item_class": "1",
            "item_count": pd.array(count, "Int16"),
            "failing_step": pd.array(np.where(failing == count, -1, failing), "Int16"),
        }
    ).replace({"failing_step": {-1: pd.NA}})
    said = pd.DataFrame(
        {
            "one": pd.array(random.integers(0, count + 1), "Int32"),
            "two": pd.array(np.where(random.random(cases) < 0.8, failing, 0), "Int32"),
        }
    )
    said.loc[3, "one"] = pd.NA
    margins = [random.normal(0.0, 8.0, n).tolist() for n in np.minimum(failing + 1, count)]
    return labels, said, margins, failing


@pytest.mark.parametrize("seed", range(3))
def test_margins_are_counted_as_a_loop_over_steps_does(seed):
    labels, said, margins, failing = made_up(seed)
    found = margin_bins(said, labels, margins)
    assert [(b.low, b.high) for b in found] == list(pairwise(MARGINS))
    for method in said:
        for bin_ in found:
            alarms, misses = [], []
            for case, margin in enumerate(margins):
                own = said[method][case]
                for step, value in enumerate(margin):
                    if pd.isna(own) or step > own or not bin_.low <= value < bin_.high:
                        continue
                    if step == failing[case]:
                        misses.append(own > step)
                    else:
                        alarms.append(own == step)
            for estimate, hits in ((bin_.false_alarms, alarms), (bin_.misses, misses)):
                assert estimate[method].n == len(hits)
                if hits:
                    assert estimate[method].value == pytest.approx(np.mean(hits))
                else:
                    assert math.isnan(estimate[method].value)


def test_all_steps_of_labels_are_in_some_bin():
    labels, said, margins, failing = made_up(9)
    found = margin_bins(said, labels, margins)
    unstable = int((failing < labels["item_count"].astype(int)).sum())
    assert sum(b.failing for b in found) == unstable
    assert sum(b.holding for b in found) == sum(map(len, margins)) - unstable


def test_every_error_is_one_false_alarm_or_one_miss():
    labels, said, margins, failing = made_up(2)
    found = margin_bins(said, labels, margins)
    for method in said:
        errors = sum(
            round(e.value * e.n)
            for b in found
            for e in (b.false_alarms[method], b.misses[method])
            if e.n
        )
        assert errors == int((said[method].notna() & (said[method] != failing)).sum())


def test_without_margins_nothing_is_said_of_them():
    labels, said, margins, _ = made_up(1)
    assert margin_bins(said, labels, [*margins[:-1], None]) == ()


def test_sizes_hold_every_case_once():
    labels, said, _, failing = made_up(4)
    right = pd.DataFrame({m: (said[m] == failing).fillna(False).to_numpy(bool) for m in said})
    bins = size_bins(right, labels)
    assert sum(b.cases for b in bins) == len(labels)
    count = labels["item_count"].astype(int)
    for bin_ in bins:
        fewest, _, most = bin_.name.partition(" to ")
        here = ((count >= int(fewest)) & (count <= int(most or fewest))).to_numpy()
        assert bin_.cases == here.sum()
        assert bin_.accuracy["two"].value == pytest.approx(right["two"].to_numpy()[here].mean())


def test_classes_hold_every_case_once_and_one_class_says_nothing():
    labels, said, _, failing = made_up(4)
    right = pd.DataFrame({m: (said[m] == failing).fillna(False).to_numpy(bool) for m in said})
    classes = np.resize(["1", "2", "2"], len(labels))
    found = class_bins(right, labels.assign(item_class=classes))
    assert [(b.name, b.cases) for b in found] == [
        (name, int((classes == name).sum())) for name in ("1", "2")
    ]
    for bin_ in found:
        here = classes == bin_.name
        assert bin_.accuracy["two"].value == pytest.approx(right["two"].to_numpy()[here].mean())
        assert bin_.items == pytest.approx(labels["item_count"].to_numpy(float)[here].mean())
        assert bin_.item_lists == labels["instance"][here].nunique()
    assert class_bins(right, labels.assign(item_class="1")) == ()
    assert class_bins(right, labels.assign(item_class=None)) == ()


def test_larger_layouts_than_the_papers_are_in_a_last_bin():
    labels, *_ = made_up(5)
    labels.loc[0, "item_count"] = 31
    right = pd.DataFrame({"one": np.ones(len(labels), bool)})
    assert size_bins(right, labels)[-1].name == "31"
    assert sum(b.cases for b in size_bins(right, labels)) == len(labels)
