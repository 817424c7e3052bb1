"""Verdicts that are stored stay valid because these hold: see ``docs/studies.md``."""

import itertools
import json
from operator import itemgetter

import pytest
from golden_cases import FILE
from golden_methods import FACTORS, asked
from pairwise import pairs, pairwise
from verdicts import (
    FOLDER,
    KEYS,
    advice,
    differences,
    holding_on_one_machine,
    judged,
    machine,
    plan,
    read,
    turned,
)

from steadyload.engines import with_bullet
from steadyload.engines.with_bullet import BulletWorld
from steadyload.methods.rules.base_support import FullBaseSupport

ON_EDGE = "ps_opt@physx"
"""A method of single precision, some of whose verdicts turn."""

FIRST, STATIC = 2, 60
"""Of cases of a simulation and of a rule the quick test judges so many, and the deep one all; every
rule has more cases than the second, and every simulation fewer."""


def engine_of(spec):
    """The engine of a method; empty where it needs none."""
    return spec.partition("@")[2].partition(":")[0]


def changed(chosen, name="quick", *, every_case=False):
    """What is other than kept, of the chosen part of the plan; as many cases as were kept."""
    golden, on = read(FOLDER / f"{name}.parquet")
    every = plan(golden, deep=name == "deep")
    if not every_case:
        most = [STATIC if len(each.cases) > STATIC else FIRST for each in every]
        every = [each._replace(cases=each.cases[:n]) for each, n in zip(every, most, strict=True)]
    chosen_now = [each for each in every if chosen(each.spec)]
    rows = {method: list(of) for method, of in itertools.groupby(golden, itemgetter("method"))}
    kept = [row for each in chosen_now for row in rows[each.spec][: len(each.cases)]]
    now = judged(chosen_now)
    alone = holding_on_one_machine()
    return differences(kept, now, same_machine=on == machine(), one_machine=alone)


@pytest.mark.exact("verdicts were recorded from planned starts")
@pytest.mark.parametrize("engine", sorted({engine_of(each.spec) for each in asked(deep=False)}))
def test_verdicts_are_those_that_were_kept(engine):
    found = changed(lambda spec: engine_of(spec) == engine)
    assert not found, advice(found)


@pytest.mark.exact("verdicts were recorded from planned starts")
@pytest.mark.parametrize("name", ["quick", "deep"])
def test_verdicts_on_many_cases_are_those_that_were_kept(name):
    found = changed(lambda spec: True, name, every_case=True)
    assert not found, advice(found)


def test_a_changed_verdict_is_found(monkeypatch):
    """A rule that asks for a little less."""
    monkeypatch.setattr(FullBaseSupport, "_alpha", 0.9)
    found = changed(lambda spec: spec == "fbs")
    assert found
    assert "raise the version of" in advice(found)
    assert not changed(lambda spec: spec == "pbs0.9")


@pytest.fixture
def bullet_as_new():
    """What a test does to Bullet's clients goes with it."""
    yield
    for client in with_bullet._idle_clients:
        client.flags = None


def test_contacts_in_the_opposite_order_are_found(monkeypatch, bullet_as_new):
    """As Bullet's simple broad phase had them in every second world, when the body that was added
    first was removed first."""
    real = BulletWorld._close

    def first_one_first(world):
        world._all_bodies.reverse()
        real(world)

    bullet = [
        each._replace(spec="ps_opt@bullet:broad_phase=simple")
        for each in asked(deep=False)
        if each.spec == "ps_opt@bullet"
    ]
    # Held against verdicts of this machine: on another kind of it floats count for nothing.
    before = list(judged(bullet))
    assert not differences(before, judged(bullet), same_machine=True)
    monkeypatch.setattr(BulletWorld, "_close", first_one_first)
    assert differences(before, judged(bullet), same_machine=True)


def test_floats_count_on_the_same_kind_of_machine_alone():
    row = {
        "method": "m", "layout": "l", "scenario": "S1", "robust": True, "packages": "numpy=2",
        "status": "done", "failing_step": 3, "moved_item": 3, "displacement": 10.5, "rotation": 1.0,
    }  # fmt: skip
    rounded, other = row | {"displacement": 10.500000000000002}, row | {"failing_step": 4}
    assert differences([row], [rounded], same_machine=True)
    assert not differences([row], [rounded], same_machine=False)
    assert differences([row], [other], same_machine=False)
    fragile = row | {"robust": False}
    assert not differences([fragile], [other], same_machine=False)
    assert not differences([row], [other | {"packages": "numpy=3"}], same_machine=True)
    alone = {tuple(row[k] for k in KEYS)}
    assert not differences([row], [other], same_machine=False, one_machine=alone)
    assert differences([row], [other], same_machine=True, one_machine=alone)


def test_verdicts_that_hold_on_one_kind_of_machine_are_those_that_moved_starts_turn():
    """Of one method here, as record.py looks at all."""
    golden, on = read(FOLDER / "quick.parquet")
    every = golden + read(FOLDER / "deep.parquet")[0]
    alone = holding_on_one_machine()
    assert alone <= {tuple(row[k] for k in KEYS) for row in every}
    kept = [row for row in golden if row["method"] == ON_EDGE]
    found = turned(kept, [each for each in plan(golden, deep=False) if each.spec == ON_EDGE])
    assert found or on != machine()
    if on == machine():
        assert found <= alone


def test_half_of_the_cases_fail_and_a_third_are_near():
    golden, _ = read(FOLDER / "quick.parquet")
    labels = [row for row in golden if row["method"] == "label@mujoco"]
    assert 0.4 <= sum(row["failing_step"] is not None for row in labels) / len(labels) <= 0.6


def test_any_two_values_meet_in_the_array():
    rows = pairwise({"a": "12", "b": "12", "c": "123"}, lambda row: row["a"] + row["b"] != "11")
    met = set().union(*map(pairs, rows))
    assert len(met) == 3 + 6 + 6
    assert len(rows) <= 9
    assert frozenset((("a", "1"), ("b", "1"))) not in met


def test_every_engine_and_scope_meet_in_the_array_that_is_kept():
    specs = json.loads(FILE.read_text())["array"]
    assert 15 <= len(specs) <= 40
    for engine, scope in itertools.product(FACTORS["engine"], FACTORS["scope"]):
        assert any(f"@{engine}:" in spec and f"scope={scope}" in spec for spec in specs)
