"""Cascades: a stage decides what it is sure of, nothing else, and the rest goes on."""

import dataclasses
import json
import math
import sys
import types
from contextlib import closing

import numpy as np
import pytest

from steadyload.atomic import manifest_text
from steadyload.engines.registry import engines, world_class
from steadyload.engines.world import EngineNotInstalledError
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.model.question import Question, with_question
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods import registry
from steadyload.methods.cascade.cascade import Cascade
from steadyload.methods.cascade.thresholds import (
    Ladder,
    Larger,
    Stage,
    Thresholds,
    ThresholdsError,
    fingerprint,
    fitted_for,
    load_thresholds,
    write_thresholds,
)
from steadyload.methods.contract.method import (
    Finding,
    RefusedError,
    Status,
    StepScorer,
    Stopwatch,
)
from steadyload.methods.contract.spec import SpecError
from steadyload.methods.registry import make_method
from steadyload.methods.rules.base_support import FullBaseSupport
from steadyload.properties.property import MethodUnderTest
from steadyload.properties.registry import PROPERTIES
from steadyload.properties.search import search
from steadyload.stored import StoredFileError

LAST = "ps_opt@mujoco"


@pytest.fixture(scope="module")
def layouts():
    return random_layouts(24, seed=5)


@pytest.fixture
def cascade(tmp_path):
    """Makes a cascade of stages, each (method, low, high)."""

    def make(*stages, last=LAST, **told):
        ladder = Ladder(tuple(Stage(*stage) for stage in stages), last, {})
        made_of = {spec: fingerprint(make_method(spec)) for spec in ladder.methods} | told
        file = tmp_path / "thresholds.json"
        write_thresholds("mujoco", Thresholds(0.5, {0.5: ladder}, made_of, {}), file)
        return make_method(f"cascade@mujoco:thresholds={file}")

    return make


class Planted(FullBaseSupport):
    """Says of steps what the test tells it; keeps what it was asked."""

    asked: list[int]
    says = staticmethod(lambda layout, step: math.nan)
    finding = Finding()

    def steps(self, layout, watch):
        return _PlantedSteps(self, layout)


class _PlantedSteps(StepScorer):
    decision_threshold = 0.5

    def __init__(self, method, layout):
        self._method, self._layout = method, layout

    def step_score(self, step):
        self._method.asked.append(step)
        return self._method.says(self._layout, step)

    def finding(self, step):
        return self._method.finding


@pytest.fixture
def planted(monkeypatch):
    """Registers a method that says what it is told."""

    def make(says=None, name="planted", **members):
        judge = type("Judge", (Planted,), {"asked": [], **members})
        if says is not None:
            judge.says = staticmethod(says)
        monkeypatch.setitem(sys.modules, name, types.SimpleNamespace(Judge=judge))
        monkeypatch.setitem(registry.METHODS, name, f"{name}:Judge")
        return judge

    return make


STEPWISE = (
    "fbs",
    "pbs:alpha=0.7",
    "equilibrium",
    "equilibrium:sides=frictionless",
    "equilibrium:time=0.3",
    "lstm_1",
    "label@mujoco",
    "label@dart:scope=local",
    "ps_opt@bullet",
    "ps_opt@mujoco",
)


@pytest.mark.parametrize("spec", STEPWISE)
def test_the_first_step_above_the_decision_threshold_is_the_failing_step_of_the_method(
    spec, layouts
):
    method = make_method(spec)
    method.prepare()
    for layout in layouts[:8]:
        with closing(method.steps(layout, Stopwatch())) as judge:
            unstable = (
                s for s in range(len(layout)) if judge.step_score(s) > judge.decision_threshold
            )
            verdict = method.judge(layout)
            assert next(unstable, None) == verdict.failing_step
            if "@" in spec and verdict.failing_step is not None:
                assert judge.finding(verdict.failing_step).moved_item == verdict.moved_item


def test_a_stage_with_hardly_any_work_leaves_all_steps_to_the_last(cascade, layouts):
    """Stages that accept no step: what they decide is what they see move."""
    free = cascade(("equilibrium:time=0.3", None, 0.5))
    assert any(d.stage != LAST for layout in layouts for d in free.decisions(layout))
    limited, last = cascade(("equilibrium:time=0.3,work=0.5", None, 0.5)), make_method(LAST)
    for layout in layouts:
        assert {decision.stage for decision in limited.decisions(layout)} == {LAST}
        found, expected = limited.judge(layout), last.judge(layout)
        assert (found.status, found.failing_step) == (expected.status, expected.failing_step)
        assert found.moved_item == expected.moved_item
        assert found.displacement == expected.displacement


@pytest.mark.parametrize("spec", ["label@mujoco", "label@bullet", "ps_opt@mujoco", "ps_opt@dart"])
def test_a_simulated_step_hangs_on_no_step_that_was_left_out(spec, layouts):
    method = make_method(spec)
    for layout in layouts[:4]:
        with closing(method.steps(layout, Stopwatch())) as judge:
            one_by_one = [judge.step_score(step) for step in range(len(layout))]
        for step in range(len(layout) - 1, 0, -3):
            with closing(method.steps(layout, Stopwatch())) as judge:
                assert judge.step_score(step) == one_by_one[step]


def test_a_method_that_carries_the_state_over_has_no_single_steps(layouts):
    with pytest.raises(SpecError, match=r"carries the state over .* between_steps=reseat"):
        make_method("ps_opt-paper@mujoco").steps(layouts[0], Stopwatch())
    with pytest.raises(SpecError, match="sme: judges whole loadings"):
        make_method("sme").steps(layouts[0], Stopwatch())


def test_stages_that_are_sure_of_nothing_leave_the_last_method_alone(cascade, layouts):
    nothing = cascade(("equilibrium", None, None), ("lstm_1", None, None))
    alone = make_method(LAST)
    for layout in layouts:
        ours, theirs = nothing.judge(layout), alone.judge(layout)
        assert {d.stage for d in nothing.decisions(layout)} == {LAST}
        for what in ("failing_step", "moved_item", "displacement", "rotation", "ignored", "effort"):
            assert getattr(ours, what) == getattr(theirs, what)


def test_an_oracle_decides_all_and_nothing_is_simulated(cascade, planted, layouts):
    known = {x.content_hash(): make_method(LAST).judge(x).failing_step for x in layouts}
    planted(lambda layout, step: float(step == known[layout.content_hash()]))
    asked = cascade(("planted", 0.5, 0.5))
    for layout in layouts:
        verdict = asked.judge(layout)
        assert verdict.failing_step == known[layout.content_hash()]
        assert verdict.effort.worlds == 0
        assert bool(verdict.reason) == (verdict.failing_step is not None)
    assert 0 < sum(step is None for step in known.values()) < len(known)


def test_only_what_no_stage_is_sure_of_is_simulated(cascade, planted, layouts):
    """Every third step is left open, and is judged as the simulation judges it by itself."""
    planted(lambda layout, step: 0.4 if step % 3 == 2 else 0.1)
    asked = cascade(("planted", 0.2, 0.9))
    for layout in layouts[:6]:
        decisions = asked.decisions(layout)
        assert [d.step for d in decisions if d.stage == LAST] == [
            d.step for d in decisions if d.step % 3 == 2
        ]
        last = [d for d in decisions if d.stage == LAST]
        alone = make_method(LAST)
        for decision in last:
            with closing(alone.steps(layout, Stopwatch())) as judge:
                assert decision.unstable == (judge.step_score(decision.step) > 1.0)


@pytest.mark.parametrize("score", [0.2, 0.5, 0.9, math.nan])
def test_a_stage_at_or_between_its_thresholds_or_without_an_opinion_decides_nothing(
    score, cascade, planted, layouts
):
    planted(lambda layout, step: score)
    asked = cascade(("planted", 0.2, 0.9))
    assert {d.stage for layout in layouts[:3] for d in asked.decisions(layout)} == {LAST}


def test_the_first_unstable_step_ends_the_loading(cascade, planted):
    judge = planted(lambda layout, step: float(step >= 2))
    layout = next(x for x in random_layouts(5, seed=6) if len(x) > 4)
    verdict = cascade(("planted", 0.5, 0.5)).judge(layout)
    assert verdict.failing_step == 2
    assert judge.asked == [0, 1, 2]
    assert verdict.reason == "planted: risk 1"


def test_a_later_stage_is_asked_only_what_is_left(cascade, planted, layouts):
    first = planted(lambda layout, step: float(step % 2), name="first")
    second = planted(lambda layout, step: 0.0, name="second")
    asked = cascade(("first", 0.5, None), ("second", 0.5, None))
    layout = max(layouts, key=len)
    assert asked.judge(layout).stable
    assert first.asked == list(range(len(layout)))
    assert second.asked == list(range(1, len(layout), 2))


def test_a_stage_that_refuses_leaves_the_layout_to_the_next(cascade, planted, layouts):
    def refuse(self, layout, watch):
        raise RefusedError("not this one")

    planted(steps=refuse)
    asked = cascade(("planted", 0.5, 0.5))
    assert {d.stage for d in asked.decisions(layouts[0])} == {LAST}
    verdict = cascade(last="planted").judge(layouts[0])
    assert (verdict.status, verdict.reason) == (Status.REFUSED, "not this one")


def test_a_stage_is_not_brought_in_before_it_is_needed(cascade, planted, layouts):
    def never(self, layout, watch):
        raise AssertionError

    planted(lambda layout, step: 0.0, name="sure")
    planted(name="never", steps=never)
    assert cascade(("sure", 0.5, None), last="never").judge(layouts[0]).stable


@pytest.mark.parametrize(
    ("finding", "status", "reason"),
    [
        (Finding(status=Status.DIVERGED, reason="gone"), Status.DIVERGED, "gone"),
        (Finding(), Status.ERROR, "no stage has an opinion of step 0"),
    ],
)
def test_without_an_opinion_of_the_last_there_is_no_verdict(
    finding, status, reason, cascade, planted, layouts
):
    planted(finding=finding)
    verdict = cascade(last="planted").judge(layouts[0])
    assert (verdict.status, verdict.reason, verdict.score) == (status, reason, None)


def test_a_stage_of_few_items_is_asked_of_no_later_step(cascade, planted, layouts):
    layout = max(layouts, key=len)
    first = planted(lambda layout, step: 0.0, name="first")
    second = planted(lambda layout, step: 0.0, name="second")
    asked = cascade(("first", 0.5, None, 2), ("second", 0.5, None))
    decided = [d.stage for d in asked.decisions(layout)]
    assert decided == ["first"] * 2 + ["second"] * (len(layout) - 2)
    assert first.asked == [0, 1]
    assert second.asked == [*range(2, len(layout))]


def test_a_stage_past_its_items_is_not_set_up(cascade, planted, layouts):
    def never(self, layout, watch):
        raise AssertionError

    planted(name="never", steps=never)
    planted(lambda layout, step: float(step == 1), name="sure")
    asked = cascade(("never", 0.5, None, 0), ("sure", 0.5, 0.5))
    assert asked.judge(max(layouts, key=len)).failing_step == 1


def test_thresholds_of_larger_loads_hold_from_their_number_of_items_on(cascade, planted, layouts):
    """A score of 0.3 decides nothing to 2 items, then it is stable; above 4 none is scored."""
    layout = max(layouts, key=len)
    assert len(layout) > 5
    scored = planted(lambda layout, step: 0.3)
    planted(lambda layout, step: 0.0, name="rest")
    larger = (Larger(2, 0.5, None), Larger(4, None, None))
    asked = cascade(("planted", 0.2, 0.9, None, larger), ("rest", 0.5, None))
    decided = [d.stage for d in asked.decisions(layout)]
    assert decided == ["rest"] * 2 + ["planted"] * 2 + ["rest"] * (len(layout) - 4)
    assert scored.asked == [0, 1, 2, 3]


def test_one_scorer_judges_a_layout_by_all_thresholds_of_a_method(cascade, planted, layouts):
    opened = []

    def steps(self, layout, watch):
        opened.append(layout)
        return _PlantedSteps(self, layout)

    planted(lambda layout, step: 0.1 * step, steps=steps)
    larger = (Larger(1, 0.5, None), Larger(2, 0.6, None), Larger(3, 0.9, None))
    asked = cascade(("planted", 0.1, None, 4, larger))
    layout = max(layouts, key=len)
    assert [d.stage for d in asked.decisions(layout)][:5] == ["planted"] * 4 + [LAST]
    assert opened == [layout]


def test_a_stage_says_at_which_numbers_of_items_its_thresholds_change():
    nothing, low, other = (None, None), (0.1, 0.9), (0.3, None)
    for stage, said in (
        (Stage("fbs", *low), "fbs"),
        (Stage("fbs", *low, 40), "fbs to 40 items"),
        (Stage("fbs", *nothing, None, (Larger(60, *low),)), "fbs above 60 items"),
        (Stage("fbs", *nothing, 90, (Larger(60, *low),)), "fbs from 61 to 90 items"),
        (
            Stage("fbs", *low, 90, (Larger(20, *other), Larger(60, *low))),
            "fbs to 90 items (other thresholds above 20 and 60 items)",
        ),
    ):
        assert str(stage) == said


@pytest.mark.parametrize(
    ("items", "above"), [(None, (0,)), (None, (40, 20)), (None, (20, 20)), (40, (20, 40))]
)
def test_numbers_of_items_of_a_stage_ascend(items, above, tmp_path):
    larger = tuple(Larger(each, 0.1, None) for each in above)
    with pytest.raises(ValueError, match=r"numbers of items of fbs: .* do not ascend"):
        Stage("fbs", 0.1, None, items, larger)


def test_a_timeout_ends_a_cascade(cascade, planted, layouts):
    verdict = cascade(("equilibrium", None, None)).judge(max(layouts, key=len), timeout=1e-9)
    assert verdict.status is Status.TIMEOUT


def test_thresholds_fitted_with_other_judges_are_refused(cascade, layouts):
    stale = cascade(("lstm_1", 0.1, 0.9), lstm_1="of other weights")
    for ask in (stale.prepare, stale.made_of, lambda: stale.judge(layouts[0])):
        with pytest.raises(ThresholdsError, match=r"another lstm_1, .* cascade fit --engine muj"):
            ask()


def test_other_thresholds_are_another_method(cascade):
    one = cascade(("lstm_1", 0.1, 0.9)).made_of()
    assert one == cascade(("lstm_1", 0.1, 0.9)).made_of()
    assert one != cascade(("lstm_1", 0.1, 0.8)).made_of()
    sized = cascade(("lstm_1", 0.1, 0.9, None, (Larger(60, 0.3, 0.9),))).made_of()
    assert sized not in (
        one,
        cascade(("lstm_1", 0.1, 0.9, None, (Larger(60, 0.2, 0.9),))).made_of(),
    )


def test_a_fingerprint_tells_parameters_and_weights(tmp_path, monkeypatch):
    plain = fingerprint(make_method("pbs:alpha=0.7"))
    assert plain == fingerprint(make_method("pbs0.7")) != fingerprint(make_method("pbs0.5"))
    monkeypatch.setattr(FullBaseSupport, "made_of", lambda self: "other weights")
    assert fingerprint(make_method("fbs")) != plain


def test_what_is_not_there_says_what_to_do(cascade, tmp_path):
    file = tmp_path / "none.json"
    with pytest.raises(
        ThresholdsError, match=r"none.json: no such file .*fit --engine dart -o .*n"
    ):
        make_method(f"cascade@dart:thresholds={file}").prepare()
    with pytest.raises(ThresholdsError, match="no such file of thresholds"):
        load_thresholds("dart", tmp_path)
    file.write_text(manifest_text({"fitted": []}))
    with pytest.raises(ThresholdsError, match="no engine yet; to fit them run steadyload cascade"):
        make_method(f"cascade@dart:thresholds={file}").prepare()
    asked = cascade()
    other = make_method(f"cascade@mujoco:budget=3,thresholds={asked.parameters.thresholds}")
    with pytest.raises(ThresholdsError, match=r"budget is 3; allowed: 0\.5$"):
        other.prepare()
    for record in ({}, {"default": 1, "budgets": {}}, {"default": 1, "budgets": 2}):
        fitted = {**record, "engine": "dart", "question": "within"}
        file.write_text(manifest_text({"fitted": [fitted]}))
        with pytest.raises(ThresholdsError, match=r"none.json: holds no thresholds for dart"):
            load_thresholds("dart", file)
    for text in ("{", "{}", '{"fitted": [{"engine": "dart"}]}', '{"fitted": {"dart": {}}}'):
        file.write_text(text)
        with pytest.raises(StoredFileError, match=r"none.json: is damaged; remove it to fit anew"):
            load_thresholds("dart", file)


def test_thresholds_are_read_as_they_were_written(tmp_path):
    ladder = Ladder((Stage("fbs", 0.1, None), Stage("lstm_1", None, 1 / 3)), LAST, {"lost": 1})
    written = Thresholds(1.0, {1.0: ladder, 0.25: ladder}, {"fbs": "x"}, {"git": "y"})
    file = tmp_path / "t.json"
    write_thresholds("dart", written, file)
    write_thresholds("mujoco", dataclasses.replace(written, default=0.25), file)
    assert load_thresholds("dart", file) == written
    assert load_thresholds("mujoco", file).default == 0.25
    records = json.loads(file.read_text())["fitted"]
    assert [record["engine"] for record in records] == ["dart", "mujoco"]


def test_only_a_stage_of_few_items_or_of_thresholds_by_size_states_them(tmp_path):
    """Ladders without such stages are stored, and are hashed, as they always were."""
    sized = Stage("lstm_e", 0.02, None, None, (Larger(60, 0.3, 0.9), Larger(90, None, 0.8)))
    ladder = Ladder((Stage("fbs", 0.1, None), Stage("lstm_1", None, 0.9, 40), sized), LAST, {})
    write_thresholds("dart", Thresholds(1.0, {1.0: ladder}, {}, {}), tmp_path / "t.json")
    stored = json.loads((tmp_path / "t.json").read_text())["fitted"][0]["budgets"]["1"]["stages"]
    assert stored == [
        {"method": "fbs", "low": 0.1, "high": None},
        {"method": "lstm_1", "low": None, "high": 0.9, "items": 40},
        {
            "method": "lstm_e",
            "low": 0.02,
            "high": None,
            "larger": [
                {"above": 60, "low": 0.3, "high": 0.9},
                {"above": 90, "low": None, "high": 0.8},
            ],
        },
    ]
    assert load_thresholds("dart", tmp_path / "t.json").ladders[1.0] == ladder


def test_a_file_whose_numbers_of_items_do_not_ascend_holds_no_thresholds(tmp_path):
    ladder = Ladder((Stage("fbs", 0.1, None, None, (Larger(60, 0.3, None),)),), LAST, {})
    file = tmp_path / "t.json"
    write_thresholds("dart", Thresholds(1.0, {1.0: ladder}, {}, {}), file)
    entries = json.loads(file.read_text())
    del entries["checksum"]
    entries["fitted"][0]["budgets"]["1"]["stages"][0]["larger"][0]["above"] = 0
    file.write_text(manifest_text(entries))
    with pytest.raises(ThresholdsError, match="holds no thresholds for dart"):
        load_thresholds("dart", file)


def test_full_bases_have_no_risk_wherever_centres_of_mass_lie(stack):
    layout = stack(0.0, 0.0, 3.0, 3.0)
    with closing(make_method("fbs").steps(layout, Stopwatch())) as judge:
        # Item 3 stands on item 2 in full, which does not.
        assert [judge.step_score(step) for step in range(4)] == pytest.approx([0.0, 0.0, 0.3, 0.3])


def test_what_is_out_of_balance_disturbs_what_comes_after():
    """A cube past an edge, then one beside it on the floor: no proof that the first stays."""
    items = [((0, 0), (10, 10, 10)), ((6, 10), (10, 10, 10)), ((40, 0), (10, 10, 10))]
    layout = Layout(
        "edge",
        Pallet(100, 100, 100),
        tuple(Item(k, (x, y, 0), size, 1.0) for k, ((x, y), size) in enumerate(items)),
    )
    for spec, expected in (("equilibrium", 0.5), ("equilibrium:time=0.3", math.nan)):
        with closing(make_method(spec).steps(layout, Stopwatch())) as judge:
            scores = [judge.step_score(step) for step in range(3)]
        assert scores[0] == 0.0
        assert scores[1] >= 1.0
        np.testing.assert_equal(scores[2], expected)


def test_a_learner_has_no_opinion_from_the_first_item_on_that_it_does_not_know(stack):
    layout = stack(0.0, 0.0, 0.0, 0.0)
    heavy = dataclasses.replace(layout.items[2], weight=1e5)
    strange = Layout("strange", layout.pallet, (*layout.items[:2], heavy, layout.items[3]))
    learner = make_method("lstm_1")
    assert learner.judge(strange).status is Status.REFUSED
    with closing(learner.steps(strange, Stopwatch())) as judge:
        scores = [judge.step_score(step) for step in range(4)]
    assert np.isfinite(scores).tolist() == [True, True, False, False]
    with closing(learner.steps(strange.first(2), Stopwatch())) as judge:
        assert [judge.step_score(step) for step in range(2)] == scores[:2]


def test_a_layout_that_the_learner_refuses_is_judged_by_what_follows(cascade, stack):
    layout = stack(0.0, 0.0, 7.0)
    items = (*layout.items[:2], dataclasses.replace(layout.items[2], weight=1e5))
    strange = Layout("strange", layout.pallet, items)
    asked = cascade(("lstm_1", 0.5, 0.5))
    assert [d.stage for d in asked.decisions(strange)] == ["lstm_1", "lstm_1", LAST]
    assert asked.judge(strange).failing_step == make_method(LAST).judge(strange).failing_step == 2


@pytest.mark.parametrize("name", ["score", "repeat", "prefix"])
def test_a_cascade_is_judged_step_by_step(name, cascade):
    asked = cascade(("equilibrium", 0.5, None), ("lstm_1", 0.05, 0.95))
    assert PROPERTIES[name].applies(MethodUnderTest(str(asked.spec)))
    found = search(PROPERTIES[name], MethodUnderTest(str(asked.spec)), examples=15, seed=1)
    assert found.counterexample is None
    assert found.asked > 0


OPTIONAL = pytest.mark.deep("needs the extra rapier")
SHIPPED = [
    pytest.param(key, marks=OPTIONAL if engines()[key.partition(":")[0]].optional else ())
    for key in sorted(with_question(*names) for names in fitted_for())
]


def shipped_cascade(key):
    """The cascade of an engine that is installed."""
    try:
        world_class(key.partition(":")[0])
    except EngineNotInstalledError as error:
        pytest.skip(str(error))
    return make_method(f"cascade@{key}")


@pytest.mark.parametrize("key", SHIPPED)
def test_the_shipped_thresholds_are_those_of_the_shipped_judges(key, layouts):
    shipped = shipped_cascade(key)
    assert isinstance(shipped, Cascade)
    shipped.prepare()
    last = make_method(shipped.ladder.last).parameters
    simulated = dataclasses.replace(last, early_stop=0.0)
    assert simulated == make_method(f"ps_opt@{key}").parameters
    assert shipped.thresholds.default in shipped.thresholds.ladders
    verdicts = shipped.judge_many(layouts[:4])
    assert all(verdict.status is Status.DONE for verdict in verdicts)


@pytest.mark.parametrize("key", SHIPPED)
def test_a_high_pile_is_judged_by_stages_and_by_the_simulation(key):
    """Twelve layers of ten boxes, the last one hardly supported; stages judge beyond step 68."""
    boxes = [
        Item(10 * y + k, (20.0 * (k % 5), 10.0 * y, 30.0 * (k // 5)), (20.0, 10.0, 30.0), 4.0)
        for y in range(12)
        for k in range(10)
    ]
    beyond = dataclasses.replace(boxes[-1], position=(95.0, 110.0, 30.0))
    falling = Layout("falling", Pallet(200.0, 200.0, 100.0), (*boxes[:-1], beyond))
    method = shipped_cascade(key)
    decisions = method.decisions(falling)
    assert [d.step for d in decisions if d.unstable] == [119]
    assert {d.stage for d in decisions[69:]} - {method.ladder.last}


@OPTIONAL
def test_a_ladder_on_rapier_is_refused_when_a_stage_has_changed(tmp_path, layouts):
    fitted = shipped_cascade("rapier").thresholds
    for spec in fitted.ladders[fitted.default].methods:
        file = tmp_path / "t.json"
        changed = {**fitted.made_of, spec: "other"}
        write_thresholds("rapier", dataclasses.replace(fitted, made_of=changed), file)
        with pytest.raises(ThresholdsError, match=r"another .* cascade fit --engine rapier$"):
            make_method(f"cascade@rapier:thresholds={file}").judge(layouts[0])


def test_every_question_has_thresholds_of_its_own(tmp_path):
    ladder = Ladder((Stage("fbs", 0.1, None),), LAST, {"lost": 1})
    within = Thresholds(1.0, {1.0: ladder}, {"fbs": "x"}, {"git": "y"})
    stands = dataclasses.replace(within, default=2.0, ladders={2.0: ladder})
    file = tmp_path / "t.json"
    write_thresholds("mujoco", within, file)
    with pytest.raises(ThresholdsError, match="fit --engine mujoco --question stands"):
        make_method(f"cascade@mujoco:question=stands,thresholds={file}").prepare()
    write_thresholds("mujoco", stands, file, Question.STANDS)
    assert load_thresholds("mujoco", file) == within
    assert load_thresholds("mujoco", file, Question.STANDS) == stands
    asked = make_method(f"cascade@mujoco:question=stands,thresholds={file}")
    assert asked.thresholds.default == 2.0


def test_the_cascade_that_is_asked_whether_a_load_stands_simulates_until_it_rests():
    method = make_method("cascade@mujoco:question=stands")
    assert method.ladder.last == "ps_opt@mujoco:question=stands"
    # The cube on top tips over its edge, too slowly for the time of a label.
    edge = Layout(
        "edge",
        Pallet(100.0, 100.0, 100.0),
        (
            Item(0, (40.0, 0.0, 40.0), (10.0, 10.0, 10.0), 1.0),
            Item(1, (45.02, 10.0, 40.0), (10.0, 10.0, 10.0), 1.0),
        ),
    )
    assert make_method("cascade@mujoco").judge(edge).failing_step in (None, 1)
    assert method.judge(edge).failing_step == 1
