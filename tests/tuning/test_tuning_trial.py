"""What a genotype is worth, when it is given up, what it costs, and what is written down of it."""

import itertools
import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from steadyload.engines.world import BroadPhase
from steadyload.methods.contract import stopwatch
from steadyload.methods.contract.method import Effort
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.simulation_parameters import SimulationParameters
from steadyload.tuning import TuningError, cost
from steadyload.tuning.cases import CaseSource, load_cases
from steadyload.tuning.cost import TERMS, CostModel, calibrate
from steadyload.tuning.ledger import Entry, GenerationEnd, Ledger
from steadyload.tuning.search import CHEAPEST, DEAREST, hypervolume, pareto_front
from steadyload.tuning.space import space_on
from steadyload.tuning.trial import (
    FitnessRace,
    FrontRace,
    TrialResult,
    TrialUnit,
    behind,
    estimated,
    fitness,
    run_trial,
)

FREE = CostModel(dict.fromkeys(TERMS, 0.0) | {"layout": 1000.0})
"""Every layout costs 1 ms."""


def trial(right, cost=1.0):
    marks = [mark == "+" for mark in right]
    return TrialResult(np.array(marks, dtype=bool), np.broadcast_to(float(cost), len(marks)).copy())


def entry(accuracy, cost, name=0):
    return Entry((name,), 0, trial("+" * round(100 * accuracy) + "-" * round(100 * (1 - accuracy)),
                                   cost))  # fmt: skip


# --- fitness, rounds, races ---------------------------------------------------------------------


def test_fitness_is_accuracy_and_speed():
    """0.85 * 3/4 + 0.15 * 2/5, and nothing gained below the goal."""
    goal = 2.0
    judged = TrialResult(np.array([True, True, False, True]), np.array([4.0, 6.0, 5.0, 5.0]))
    assert fitness(judged, goal) == pytest.approx(0.85 * 0.75 + 0.15 * 2 / 5)
    assert fitness(trial("++-+", 2.0), goal) == pytest.approx(0.85 * 0.75 + 0.15)
    assert fitness(trial("++-+", 0.1), goal) == fitness(trial("++-+", 2.0), goal)


def test_how_far_behind_by_hand():
    """4 right against 5 on the first 6 of 10; the rival has 1 wrong among the last 4."""
    rival = trial("++++-+" + "++-+")
    assert behind(trial("+-+-++"), rival) == (pytest.approx(0.1), pytest.approx(0.1))
    far = trial("++++++" + "-" * 94)
    # 3 behind; 2 sqrt(3 disagreements + 1) = 4 of 100, fewer than the 94 that the rival has wrong.
    assert behind(trial("+-+--+"), far) == (pytest.approx(0.03), pytest.approx(0.04))


def completions(ours, length):
    for rest in itertools.product("+-", repeat=length - len(ours)):
        yield trial(ours + "".join(rest))


@pytest.mark.parametrize("race", ["fitness", "front"])
@pytest.mark.parametrize("strict", [True, False], ids=["few wrong", "many wrong"])
def test_who_is_given_up_against_all_ways_it_could_end(race, strict):
    """At equal costs, all sheets of 5 of 9 cases against all completions."""
    goal = 1.0
    given_up = kept = 0
    for ours in map("".join, itertools.product("+-", repeat=5)):
        for rest in ("++++", "+++-", "-++-") if strict else ("----", "--+-"):
            rival = trial("++-++" + rest)
            judge = FitnessRace(goal, rival) if race == "fitness" else FrontRace((rival,))
            ends = [end.accuracy - rival.accuracy for end in completions(ours, 9)]
            if all(end < -1e-9 for end in ends):
                assert judge.lost(trial(ours)), (ours, rest)
            if strict and any(end > 1e-9 for end in ends):
                # Two disagreements or fewer are within what is not sure, whatever was seen.
                assert not judge.lost(trial(ours)), (ours, rest)
            lost = judge.lost(trial(ours))
            given_up, kept = given_up + lost, kept + (not lost)
    assert given_up
    assert kept


def test_being_cheaper_keeps_a_genotype_in_the_race():
    rival, goal = trial("+" * 200, 10.0), 1.0
    worse = "+" * 54 + "-" * 6
    assert FitnessRace(goal, rival).lost(trial(worse, 10.0))
    assert not FitnessRace(goal, rival).lost(trial(worse, 1.0))
    assert FrontRace((rival,)).lost(trial(worse, 10.0))
    assert not FrontRace((rival,)).lost(trial(worse, 9.9))
    assert FrontRace((trial("+" * 200, 20.0), rival)).lost(trial(worse, 10.0))
    assert not FrontRace().lost(trial("-" * 60))


def test_what_was_given_up_is_worth_its_extrapolation():
    """Behind by 2 of 8 and twice as dear: 0.85 * (7/8 - 2/8) + 0.15 * 1/4."""
    rival = trial("++++" + "+++-", 2.0)
    worth, accuracy, cost = estimated(trial("+--+", 4.0), rival, 1.0)
    assert (accuracy, cost) == (pytest.approx(5 / 8), pytest.approx(4.0))
    assert worth == pytest.approx(0.85 * 5 / 8 + 0.15 / 4)
    grown = estimated(trial("+--+", 4.0), rival, 1.0, 1.5)
    assert grown[1] == pytest.approx(7 / 8 - 1.5 * 2 / 8)
    most = estimated(trial("+--+", 4.0), rival, 1.0, 5.0)
    assert most[1] == pytest.approx(7 / 8 - 4 / 8), "as if the other four cases were like these"


def test_judging_ends_at_the_first_round_that_is_lost():
    """Thresholds of nothing call every item moved, which is right nowhere but at the floor."""
    source = CaseSource(limit=14)
    cases = load_cases(source)
    space = space_on("mujoco", "table3")
    start = space.spec(space.start)
    [whole] = run_trial(TrialUnit(start, source, FREE, FrontRace()))
    assert len(whole) == len(cases) == 42
    method = make_method(start)
    said = [method.judge(case.layout) for case in cases]
    safe = [v.item_count if v.failing_step is None else v.failing_step for v in said]
    assert whole.right.tolist() == [a == case.safe for a, case in zip(safe, cases, strict=True)]
    assert whole.cost.tolist() == [1.0] * 42
    poor = space.spec(space.with_values(space.start, {"eps_t": 1, "eps_r": 5, "t_max": 3.0}))
    race = FrontRace((TrialResult(np.ones(42, dtype=bool), np.ones(42)),))
    [given_up] = run_trial(TrialUnit(poor, source, FREE, race))
    assert len(given_up) == 30
    [refused] = run_trial(TrialUnit("simulation@mujoco:t_max=-1", source, FREE, race))
    assert (len(refused), refused.accuracy, refused.mean_cost) == (0, 0.0, math.inf)
    assert "t_max is -1" in refused.reason


def test_cases_begin_with_fragile_labels_and_scenarios_take_turns():
    cases = load_cases(CaseSource(limit=14))
    robust = [case.robust is not False for case in cases]
    assert robust == sorted(robust)
    assert False in robust
    sure = [case.scenario for case in cases if case.robust is not False]
    assert len(set(sure[:3])) == 3


# --- fronts -------------------------------------------------------------------------------------


def test_a_front_against_its_definition():
    random = np.random.default_rng(3)
    entries = [
        entry(a / 100, float(c), k)
        for k, (a, c) in enumerate(random.integers(1, 30, (200, 2)))
    ]  # fmt: skip
    front = pareto_front(entries)
    points = [(e.trial.mean_cost, e.trial.accuracy) for e in entries]
    best = {
        (cost, accuracy)
        for cost, accuracy in points
        if not any((c <= cost and a > accuracy) or (c < cost and a >= accuracy) for c, a in points)
    }
    assert [(e.trial.mean_cost, e.trial.accuracy) for e in front] == sorted(best)
    assert pareto_front([]) == []


def test_hypervolume_of_steps():
    decades = math.log10(DEAREST / CHEAPEST)
    assert hypervolume([]) == 0.0
    assert hypervolume([entry(0.8, 10.0)]) == pytest.approx(0.8 * math.log10(10) / decades)
    two = [entry(0.5, 1.0), entry(0.9, 10.0)]
    assert hypervolume(two) == pytest.approx((0.5 * 1 + 0.9 * 1) / decades)
    assert hypervolume([entry(1.0, CHEAPEST / 7)]) == pytest.approx(1.0)
    assert hypervolume([entry(1.0, DEAREST * 7)]) == 0.0
    assert hypervolume([*two, entry(1.0, DEAREST * 7)]) == pytest.approx(hypervolume(two))


# --- cost ---------------------------------------------------------------------------------------


def test_a_cost_by_hand():
    """1 layout, 3 worlds (simple), 7 boxes, 11 looks, 13 substeps, 17 body substeps of 5.

    Neighbours drawn in by 0.1 mm count as half as close.
    """
    effort = Effort(boxes=7, looks=11, substeps=13, body_substeps=17, worlds=3)
    weights = (1000.0, 100.0, 10.0, 2.0, 3.0, 5.0, 7.0, 4.0, 0.5)
    model = CostModel(dict(zip(TERMS, weights, strict=True)))
    simple = SimulationParameters(solver_iterations=5, broad_phase=BroadPhase.SIMPLE, shrink=1e-4)
    microseconds = 1000 + 300 + 30 + 14 + 33 + 65 + 119 + 34 + 0.5 * 85
    assert model.milliseconds(effort, simple) == pytest.approx(microseconds / 1000)
    usual = SimulationParameters()  # no broad phase; 50 iterations where none are asked for
    microseconds = 1000 + 300 + 14 + 33 + 65 + 119 + 68 + 0.5 * 850
    assert model.milliseconds(effort, usual) == pytest.approx(microseconds / 1000)


def test_a_model_finds_what_a_substep_and_a_box_cost(told_time):
    told_time("mujoco", stopwatch)
    source = CaseSource(limit=2)
    model = calibrate(space_on("mujoco"), source, workers=0, parameter_sets=10, cases=4, repeats=1)
    assert model.parameter_sets == 11  # and the preset that was found before
    assert tuple(model.microseconds) == TERMS
    assert model.microseconds == pytest.approx(
        dict.fromkeys(TERMS, 0.0) | {"substep": 1e3, "box placed": 20e3}, abs=1e-3
    )
    assert model.correlation > 0.99  # equal costs come in any order
    assert model.error < 1e-6


class Disturbed:
    """A method that takes 1 ms on the first layout, 2 ms on the second, and once a second more."""

    parameters = None

    def __init__(self, disturbed):
        self._times = iter([0.0, *(ms + (1e3 if k == disturbed else 0.0)
                                   for k, ms in enumerate([1.0, 2.0] * 3))])  # fmt: skip

    def prepare(self, most):
        """Nothing to prepare."""

    def judge(self, layout):
        seconds = 1e-3 * next(self._times)
        return SimpleNamespace(cpu=SimpleNamespace(total=seconds), effort=None)


@pytest.mark.parametrize("disturbed", range(6))
def test_what_a_parameter_set_costs_is_the_mean_over_cases_of_medians_over_repeats(
    disturbed, monkeypatch
):
    monkeypatch.setattr(cost, "make_method", lambda spec: Disturbed(disturbed))
    monkeypatch.setattr(cost, "counts", lambda effort, parameters: np.zeros(len(TERMS)))
    [(row, ms, spec)] = cost._measure(cost._Measurement("some", CaseSource(limit=1), 2, 3))
    assert ms == pytest.approx(1.5)
    assert (row, spec) == ([0.0] * len(TERMS), "some")


def test_a_genotype_that_cannot_be_is_not_measured():
    """Seed 80 draws 5 Hz for 0.1 s beside goal and start: half a substep."""
    space, source = space_on("mujoco", "table3"), CaseSource(limit=1)
    few = {"parameter_sets": 3, "cases": 1, "repeats": 1}
    assert calibrate(space, source, workers=0, seed=80, **few).parameter_sets == 2
    assert calibrate(space, source, workers=0, seed=81, **few).parameter_sets == 3


def test_a_stated_goal_is_not_measured():
    """PS_3 at 600 Hz takes minutes on a pile of real size, where nothing else does."""
    few = {"parameter_sets": 3, "cases": 1, "repeats": 1, "workers": 0}
    space, source = space_on("mujoco", "table3"), CaseSource(limit=1)
    measured = [
        calibrate(space, source, seed=81, with_goal=goal, **few).parameter_sets
        for goal in (True, False)
    ]
    assert measured == [3, 2]


# --- the ledger ---------------------------------------------------------------------------------

IDENTITY = {"engine": "mujoco", "seed": 3, "genes": {"eps_t": [1, 2]}}


@pytest.fixture
def ledger(tmp_path):
    ledger = Ledger(tmp_path, IDENTITY)
    ledger.state("goal", 1.5)
    ledger.add(Entry((1, 2), 0, TrialResult(np.arange(11) % 3 == 0, np.linspace(0.1, 9, 11), 0.5)))
    ledger.add(
        Entry((0, 4), 0, TrialResult(np.zeros(0, dtype=bool), np.zeros(0), reason="cannot be"))
    )
    ledger.end(GenerationEnd(0, 4, 0.25, 1.5))
    return ledger


def contents(ledger):
    entries = [
        (e.genotype, e.generation, e.trial.right.tolist(), e.trial.cost.tolist(), e.trial.reason)
        for e in ledger.entries.values()
    ]
    return ledger.facts, entries, ledger.ends


def test_a_ledger_holds_what_was_written(ledger, tmp_path):
    assert contents(Ledger(tmp_path, IDENTITY)) == contents(ledger)
    identity, found = Ledger.of(tmp_path)
    assert identity == IDENTITY
    assert contents(found) == contents(ledger)


def test_a_line_cut_off_in_writing_is_dropped(ledger, tmp_path):
    file = tmp_path / "search.jsonl"
    whole = file.read_bytes()
    for length in range(len(whole) - len(whole.splitlines()[-1]), len(whole)):
        file.write_bytes(whole[:length])
        found = Ledger(tmp_path, IDENTITY)
        assert found.ends == []
        assert list(found.entries) == [(1, 2), (0, 4)]
        assert file.read_bytes() == whole[:length], "reading changes nothing"
        found.end(GenerationEnd(0, 4, 0.25, 1.5))
        assert file.read_bytes() == whole


@pytest.mark.parametrize("length", [0, 9])
def test_a_search_killed_at_its_first_line_begins(ledger, tmp_path, length):
    file = tmp_path / "search.jsonl"
    file.write_bytes(file.read_bytes()[:length])
    Ledger(tmp_path, IDENTITY).state("goal", 3.0)
    assert Ledger(tmp_path, IDENTITY).facts == {"goal": 3.0}


def test_another_search_is_refused_by_what_differs(ledger, tmp_path):
    with pytest.raises(TuningError, match=r"another search \(population, seed differ\)"):
        Ledger(tmp_path, {**IDENTITY, "seed": 4, "population": 9})


@pytest.mark.parametrize(
    "damage", ['{"end": 1', "[1, 2]", '{"genotype": [1, 2]}', '{"end": 1}', '{"fact": "x"}']
)
def test_a_damaged_line_is_refused(ledger, tmp_path, damage):
    file = tmp_path / "search.jsonl"
    lines = file.read_text().splitlines()
    file.write_text("\n".join([*lines[:2], damage, *lines[3:], ""]))
    with pytest.raises(TuningError, match="is damaged; remove it to start anew"):
        Ledger(tmp_path, IDENTITY)


def test_what_is_no_search_is_refused(tmp_path):
    with pytest.raises(TuningError, match="holds no search"):
        Ledger.of(tmp_path)
    (tmp_path / "search.jsonl").write_text(json.dumps({"other": 1}) + "\n")
    for read in (Ledger.of, lambda folder: Ledger(folder, IDENTITY)):
        with pytest.raises(TuningError, match="is not the file of a search"):
            read(tmp_path)
