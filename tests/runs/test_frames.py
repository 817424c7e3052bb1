"""Questions to frames give what the table of methods and the comparison of methods give."""

import math
from dataclasses import asdict

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.methods.naming import named
from steadyload.runs import frames
from steadyload.runs.comparison import Compared
from steadyload.runs.evaluation import ALL, evaluate
from steadyload.runs.judged import JudgedCases
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import outcomes

SPECS = {"fbs": None, "sme": None, "ps3@mujoco": "mujoco", "label@rapier": "rapier"}
SCREENS = ("label@rapier:frequency=480",)


@st.composite
def runs(draw):
    """Labelled cases of up to 80 boxes, judged by four methods, with and without verdicts."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    cases, lists = draw(st.integers(1, 25)), draw(st.integers(1, 8))
    scenarios = draw(st.sampled_from([("S1",), ("S1", "S2a"), ("S1", "S2a", "S2b")]))
    index = pd.MultiIndex.from_product([[f"l{k}" for k in range(cases)], scenarios], names=KEYS)
    n = len(index)
    items = np.repeat(random.integers(1, draw(st.sampled_from([6, 80])), cases), len(scenarios))

    def steps(share_of_stable):
        step = random.integers(0, items)
        return pd.array(np.where(random.random(n) < share_of_stable, -1, step), "Int16")

    def missing(values):
        return values.to_numpy(dtype=float, na_value=np.nan) < 0

    def column(values):
        return pd.array(np.where(missing(values), None, values), "Int16")

    robust = random.integers(0, 3, n)
    labels = pd.DataFrame(
        {
            "instance": np.repeat([f"list {random.integers(lists)}" for _ in range(cases)],
                                  len(scenarios)),
            "item_class": "1", "item_count": items.astype(np.int16),
            "failing_step": column(steps(0.5)), "confidence": 1.0,
            "robust": pd.array([[True, False, None][k] for k in robust], "boolean"),
            "offsets": None,
            "stands": [[None, "done", "unsettled"][k] for k in random.integers(0, 3, n)],
            "failing_step_stands": column(steps(0.5)),
        },
        index,
    )  # fmt: skip
    rows = []
    for spec, engine in SPECS.items():
        status = random.choice(["done", "done", "done", "timeout", "refused"], n)
        said = column(steps(0.5))
        rows.append(
            pd.DataFrame(
                {
                    "method": spec, "method_name": spec.partition("@")[0], "engine": engine,
                    "repetition": 0, "item_count": items, "status": status,
                    "failing_step": pd.Series(said).where(pd.Series(status == "done")).array,
                    "score": 1.0, "substeps": 0, "body_substeps": 0,
                    "cpu_total": random.exponential(1.0, n), "wall_total": 1.0,
                    "cpu_build": 0.0, "cpu_step": 0.0, "cpu_read": 0.0,
                },
                index,
            ).reset_index()
        )  # fmt: skip
    results = pd.concat(rows, ignore_index=True)
    natural = {s: 0.1 + 0.2 * k for k, s in enumerate(scenarios)}
    about = {
        "part": "test",
        "natural_stable": natural,
        "screens": list(draw(st.sampled_from([(), SCREENS]))),
    }
    clusters = pd.Series(
        list(zip(labels["item_class"], labels["instance"], strict=True)), index, dtype=object
    )
    keys = {spec: named(spec.partition("@")[0], spec, engine) for spec, engine in SPECS.items()}
    said = outcomes(results)[list(SPECS)].loc[index]
    return JudgedCases(
        {"labels": about, "study": {"name": "drawn"}}, keys, len(results), results, said, labels,
        clusters,
    )  # fmt: skip


def same(one, other):
    """Two estimates with the same numbers; a missing one is none of no case."""
    if not isinstance(one, Estimate):
        assert other is None or other.n == 0, other
        return
    for name, value in asdict(one).items():
        assert value == pytest.approx(getattr(other, name), abs=1e-12, nan_ok=True), (one, other)


SHARES = {
    "right": "accuracy", "over": "over", "under": "under", "under_or_none": "under_or_none",
    "stable_or_not": "stable_or_not", "right_robust": "robust", "right_fragile": "fragile",
    "right_stands": "stands",
}  # fmt: skip


@settings(max_examples=5)
@given(runs())
def test_shares_are_those_of_the_table_of_methods(judged):
    frame, table = frames.grouped(frames.verdicts(judged)), evaluate(judged)
    natural = frames.at_prevalence(frame, judged.manifest["labels"]["natural_stable"],
                                   ["group", "method"])  # fmt: skip
    cpu = frames.mean(frame.assign(cpu=1e3 * frame["cpu_total"]), "cpu", ["group", "method"])
    assert tuple(frame["group"].unique()) == table.groups
    shares = {name: frames.share(frame, name, ["group", "method"]) for name in SHARES}
    for group in table.groups:
        for row in table.rows[group]:
            at = group, row.method.spec
            for name, field in SHARES.items():
                same(shares[name].get(at), getattr(row, field))
            same(cpu[at], row.cpu)
            if len(table.groups) == 1 or group == ALL:
                same(natural[at] if not math.isnan(natural[at].value) else None, row.natural)


@settings(max_examples=5)
@given(runs())
def test_tests_are_those_of_the_comparison(judged):
    table, frame = evaluate(judged), frames.comparable(frames.verdicts(judged))
    assert list(frame["method"].unique()) == [row.method.spec for row in table.comparable]
    accuracy = frames.share(frame, "right", ["method"])
    assert frames.best(accuracy) == table.best.method.spec
    tests, expected = frames.pairs(frame), table.pairs()
    held = table.best.method
    one_by_one = frames.versus(tests, held.spec), table.versus(held.spec)
    chosen = [(m, held.spec) for m in accuracy.index if m != held.spec]
    alone = frames.pairs(frame, chosen=chosen), table.versus(held.spec)
    for found, family in ((tests, expected), one_by_one, alone):
        assert list(found.index) == [(t.first.spec, t.second.spec) for t in family.tests] or (
            found.index.nlevels == 1 and list(found.index) == [t.first.spec for t in family.tests]
        )
        for own, test in zip(found.itertuples(), family.tests, strict=True):
            same(own.difference, test.difference)
            assert own.p == pytest.approx(test.p)
            assert own.corrected == pytest.approx(test.corrected)
    letters = frames.letters(tests, accuracy)
    assert dict(letters) == {key.spec: signs for key, signs in expected.letters.items()}
    same_as_best, alike = frames.alike(one_by_one[0]), one_by_one[1].alike
    assert list(same_as_best.index) == [test.first.spec for test in alike.tests]
    shown = same_as_best["shown"].dropna()
    assert (shown.min(), shown.max()) == pytest.approx(alike.shown) if alike.shown else shown.empty


@settings(max_examples=5)
@given(runs(), st.integers(0, 2**32 - 1))
def test_methods_are_compared_on_the_cases_that_both_have(judged, seed):
    frame = frames.verdicts(judged)
    holes = np.random.default_rng(seed).random(len(frame)) < 0.3
    right = frame["right"].astype(object).mask(holes, np.nan)
    own = frame.assign(some=right)
    wide = own.pivot(index=KEYS, columns="method", values="some").astype(float)
    labels = frames.once(frame).set_index(KEYS)["cluster"].reindex(wide.index)
    both = wide["fbs"].notna() & wide["sme"].notna()
    if not both.any():
        return
    found = frames.pairs(own, "some", [("fbs", "sme")])
    expected = Compared({m: wide[m].to_numpy() for m in ("fbs", "sme")}, labels).versus("sme")
    same(found["difference"].iloc[0], expected.tests[0].difference)
    assert found["p"].iloc[0] == pytest.approx(expected.tests[0].p)


def test_methods_on_engines_that_gave_labels_are_compared_where_no_case_is_large():
    rows = pd.DataFrame({
        "method": ["one", "two"] * 2, "gave_labels": [True, False] * 2, "items": [5, 5, 90, 90],
    })  # fmt: skip
    assert set(frames.comparable(rows)["method"]) == {"two"}
    assert set(frames.comparable(rows[rows["items"] == 5])["method"]) == {"one", "two"}
    alone = rows[rows["method"] == "one"]
    assert set(frames.comparable(alone)["method"]) == {"one"}  # no other is there


def test_errors_cost_what_their_shares_say():
    over = pd.Series({"a": Estimate(0.1, 0.0, 0.2, 9), "b": Estimate(0.0, 0.0, 0.1, 9)})
    under = pd.Series({"a": Estimate(0.0, 0.0, 0.1, 9), "b": Estimate(0.4, 0.3, 0.5, 9)})
    costs = frames.error_costs(over, under, (1.0, 10.0))
    assert [costs["a", 10.0].value, costs["b", 10.0].value] == pytest.approx([1.0, 0.4])
    least = frames.cheapest(over, under)
    assert list(least.index) == ["a", "b"]
    assert least["most"].iloc[0] == pytest.approx(4.0, rel=0.05)


def test_a_front_has_no_method_that_a_cheaper_one_equals():
    right = {"a": 0.9, "b": 0.9, "c": 0.5, "d": 0.95, "e": 0.99}
    taken = {"a": 2.0, "b": 3.0, "c": 1.0, "d": 9.0}
    accuracy = pd.Series({m: Estimate(own, own, own, 9) for m, own in right.items()})
    cost = pd.Series({m: Estimate(own, own, own, 9) for m, own in taken.items()}, dtype=object)
    assert frames.front(accuracy, cost.reindex(accuracy.index)) == ["c", "a", "d"]
