"""Where methods err: bins by items and by margin, against a loop over cases."""

import math
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest

from steadyload.studies.evaluation.places import MARGINS, bins_of, by_boxes, by_class, margins
from steadyload.studies.evaluation.verdicts import binned_by_boxes


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


ROWS = pd.DataFrame({"key": None, "title": ["One", "Two"], "right": None}, ["one", "two"])


def verdicts(labels, said, failing, **more):
    """The frame of verdicts of the two methods; a list is a cluster."""
    count = labels["item_count"].astype(int).to_numpy()
    case = {"layout": [f"l{k}" for k in range(len(labels))], "scenario": "S1"}
    about = {"list": labels["instance"], "cluster": labels["instance"], "items": count,
             "expected": failing, "stable": failing == count,
             "class": labels["item_class"]}  # fmt: skip
    return pd.concat(
        [
            pd.DataFrame({**case, **about, "method": m, "said": said[m],
                          "right": (said[m] == failing).fillna(False).astype(bool), **more})
            for m in said
        ],
        ignore_index=True,
    )  # fmt: skip


def by_margin(labels, said, failing, own):
    frame = verdicts(labels, said, failing)
    cases = pd.MultiIndex.from_frame(frame[["layout", "scenario"]].drop_duplicates())
    return margins(frame, pd.Series(own, cases), ROWS, ["one", "two"])


def name(low, high):
    return (
        f"< {high:g}"
        if math.isinf(low)
        else (f"≥ {low:g}" if math.isinf(high) else f"{low:g}…{high:g}")
    )


@pytest.mark.parametrize("seed", range(3))
def test_margins_are_counted_as_a_loop_over_steps_does(seed):
    labels, said, own_margins, failing = made_up(seed)
    found = by_margin(labels, said, failing, own_margins)
    cells = {
        kind: {(c["line"], c["place"].partition(" (n ")[0]): c["value"] for c in found[kind]}
        for kind in ("false_alarms", "misses")
    }
    seen = 0
    for method, title in (("one", "One"), ("two", "Two")):
        for low, high in pairwise(MARGINS):
            alarms, misses = [], []
            for case, margin in enumerate(own_margins):
                own = said[method][case]
                for step, value in enumerate(margin):
                    if pd.isna(own) or step > own or not low <= value < high:
                        continue
                    if step == failing[case]:
                        misses.append(own > step)
                    else:
                        alarms.append(own == step)
            for kind, hits in (("false_alarms", alarms), ("misses", misses)):
                estimate = cells[kind].get((title, name(low, high)))
                seen += len(hits)
                assert (estimate.n if estimate else 0) == len(hits)
                if hits:
                    assert estimate.value == pytest.approx(np.mean(hits))
    assert seen > 100


def test_all_steps_of_labels_are_in_some_bin():
    labels, said, own_margins, failing = made_up(9)
    found = by_margin(labels, said, failing, own_margins)
    places = {kind: {c["place"] for c in found[kind]} for kind in ("false_alarms", "misses")}
    counts = {
        kind: sum(int(place.partition(" (n ")[2][:-1]) for place in own)
        for kind, own in places.items()
    }
    unstable = int((failing < labels["item_count"].astype(int)).sum())
    assert counts["misses"] == unstable
    assert counts["false_alarms"] == sum(map(len, own_margins)) - unstable
    # Those below 0 are in a table, too, with the number of steps that a method comes to.
    below = [c for c in found["alarms"] if str(c).startswith("alarms:")]
    assert len(below) == 5
    assert all(c.endswith(")") for c in below)


def test_every_error_is_one_false_alarm_or_one_miss():
    labels, said, own_margins, failing = made_up(2)
    found = by_margin(labels, said, failing, own_margins)
    for method, title in (("one", "One"), ("two", "Two")):
        errors = sum(
            round(cell["value"].value * cell["value"].n)
            for kind in ("false_alarms", "misses")
            for cell in found[kind]
            if cell["line"] == title and cell["value"].n
        )
        assert errors == int((said[method].notna() & (said[method] != failing)).sum())


def test_without_margins_nothing_is_said_of_them():
    labels, said, own_margins, failing = made_up(1)
    found = by_margin(labels, said, failing, [*own_margins[:-1], None])
    assert (found["false_alarms"], found["misses"], found["alarms"].empty) == ([], [], True)


def test_sizes_hold_every_case_once():
    labels, said, _, failing = made_up(4)
    frame = binned_by_boxes(verdicts(labels, said, failing), real=False)
    found = by_boxes(frame, ROWS, ["two"])
    bins, count = found["bins"], labels["item_count"].astype(int)
    assert bins["cases"].sum() == len(labels)
    for bin_ in bins.itertuples():
        fewest, _, most = bin_.boxes.partition(" to ")
        here = ((count >= int(fewest)) & (count <= int(most or fewest))).to_numpy()
        assert bin_.cases == here.sum()
        right = found["by_boxes"].loc["two", f"boxes_right:{bin_.boxes} (n {bin_.cases})"]
        expected = (said["two"] == failing).fillna(False).to_numpy(bool)[here].mean()
        assert right.value == pytest.approx(expected)
        [at] = [p for p in found["size_curve"] if p["value"] == right]
        assert at["x"] == np.median(count[here])


def test_classes_hold_every_case_once_and_one_class_says_nothing():
    labels, said, _, failing = made_up(4)
    classes = np.resize(["1", "2", "2"], len(labels))
    frame = verdicts(labels.assign(item_class=classes), said, failing)
    found = by_class(frame, ROWS)
    for name_ in ("1", "2"):
        here = classes == name_
        right = found.loc["two", f"class_right:{name_} (n {here.sum()})"]
        expected = (said["two"] == failing).fillna(False).to_numpy(bool)[here].mean()
        assert right.value == pytest.approx(expected)
    assert bins_of(frame.sort_values("class"), "class")["cases"].sum() == len(labels)
    assert by_class(frame.assign(**{"class": "1"}), ROWS).empty
    assert by_class(frame.assign(**{"class": None}), ROWS).empty


def test_larger_layouts_than_the_papers_are_in_a_last_bin():
    labels, said, _, failing = made_up(5)
    labels.loc[0, "item_count"] = 31
    frame = binned_by_boxes(verdicts(labels, said, failing), real=False)
    bins = by_boxes(frame, ROWS, [])["bins"]
    assert bins.index[-1] == "31"
    assert bins["cases"].sum() == len(labels)
    real = by_boxes(binned_by_boxes(frame, real=True), ROWS, [])["bins"]
    assert list(real.index) == ["1 to 20", "25 to 37"]  # named by their ends
