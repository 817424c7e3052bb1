"""The study of learners: real trainings, small ones, and numbers counted again by hand."""

import dataclasses
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from steadyload.cli import main
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.parts import Part
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.learners import LearnerError
from steadyload.learners.plans.plan import Section
from steadyload.learners.plans.plan_file import load_plan
from steadyload.learners.plans.trainings import Workshop
from steadyload.learners.weights import load_weights
from steadyload.methods.registry import make_method
from steadyload.studies.kit import Lab
from steadyload.studies.learned.comparing import compare
from steadyload.studies.learned.study import LearnedStudy

ROOT = Path(__file__).parents[2]
LIMIT = 12

PLAN = """
part = "validation"

[sets.rule]
lists = 1
label = "sme"
heuristics = 2
most = 2

[sets.forces]
lists = 1
label = "pbs:alpha=0.5"
heuristics = 2
most = 2

[trainings.small]
title = "small"
options = { hidden = 8, epochs = 6, batch = 16, learning_rate = 1e-2 }
limit = 60
seeds = [0, 1]

[trainings.fewer]
title = "few lists"
options = { hidden = 8, epochs = 1, batch = 16, learning_rate = 1e-2 }
limit = 60
lists = 5

[trainings.rule]
title = "labels of a rule"
options = { hidden = 8, epochs = 1 }
data = ["rule"]

[trainings.forces]
title = "labels of another rule"
options = { hidden = 8, epochs = 1 }
data = ["forces"]

[trainings.tuned]
title = "rule, then the labelled set"
options = { epochs = 1 }
limit = 20
start = "rule"

[trainings.leaky]
title = "leaky"
options = { hidden = 8, epochs = 1, batch = 16, learning_rate = 1e-2 }
limit = 60
leaky = true

[table]
methods = ["sme", "lstm_1"]
trainings = ["small"]
held = "lstm_1"
timed = 9
repeats = 2
batches = [2, 8]

[[size]]
title = "support features"
trainings = ["fewer", "small"]

[sources]
baseline = "rule"
trainings = ["forces", "tuned"]

[remedies]
baseline = "small"
trainings = ["fewer"]

[calibration]
judges = ["lstm_1", "small"]

[[leak]]
baseline = "small"
trainings = ["leaky"]

[foreign]
judges = ["lstm_1"]
others = ["sme", "pbs:alpha=0.5"]
max_items = 3
"""


def container(name: str, count: int, scale: float) -> Layout:
    """Cubes in a row that stand on the floor, the last of a larger size on the first one."""
    side = 10.0 * scale
    items = [Item(k, (k * side, 0.0, 0.0), (side, side, side), 2.0) for k in range(count - 1)]
    top = Item(count - 1, (0.0, side, 0.0), (1.8 * side, side, side), 2.0)
    return Layout(name, Pallet(60.0 * scale, 60.0 * scale, 60.0 * scale), (*items, top))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("learned")


@pytest.fixture(scope="module")
def plan(folder):
    file = folder / "plan.toml"
    file.write_text(PLAN)
    return load_plan(file)


@pytest.fixture(scope="module")
def foreign(folder):
    file = folder / "foreign.json"
    layouts = [container("inside", 3, 1.0), container("large", 3, 8.0), container("long", 5, 8.0)]
    write_layouts(file, layouts, Format.NATIVE)
    return file


@pytest.fixture(scope="module")
def learned(plan, folder, foreign):
    return compare(Lab(folder / "work", workers=0), plan, limit=LIMIT, foreign=[foreign])


@pytest.fixture(scope="module")
def workshop(plan, folder, learned):
    return Workshop(plan, folder / "work")


@pytest.fixture(scope="module")
def cases():
    benchmark = load_benchmark()
    chosen = benchmark.select("validation", limit=LIMIT)
    layouts = [benchmark.layout(*key) for key in chosen[KEYS].itertuples(index=False)]
    return chosen, layouts


def rights(spec, cases):
    """Whether a method names the label's failing step, one layout at a time."""
    chosen, layouts = cases
    labels = [None if pd.isna(label) else int(label) for label in chosen["failing_step"]]
    said = [make_method(spec).judge(layout) for layout in layouts]
    pairs = zip(said, labels, strict=True)
    return np.array([v.status == "done" and v.failing_step == label for v, label in pairs])


def with_sections(plan, *names):
    """A plan without its other sections."""
    others = [f for f in dataclasses.fields(plan) if f.name in set(Section) - set(names)]
    return dataclasses.replace(plan, **{f.name: f.default for f in others})


def test_accuracies_are_those_counted_by_hand(learned, workshop, cases):
    row = learned.remedies[0]
    found = np.array([
        rights(f"lstm_1:weights={run.weights},outside=accept", cases)
        for run in workshop.runs("small")
    ])  # fmt: skip
    assert 0.2 < found.mean() < 1.0
    assert row.all_seeds == pytest.approx(found.mean(axis=1))
    assert row.accuracy["all"].value == pytest.approx(found.mean())
    assert row.accuracy["all"].n == 3 * LIMIT == learned.cases
    for scenario in ("S1", "S2a", "S2b"):
        which = (cases[0]["scenario"] == scenario).to_numpy()
        assert row.accuracy[scenario].value == pytest.approx(found[:, which].mean())
        assert row.accuracy[scenario].n == LIMIT
    assert row.lost == row.accuracy["S1"].value - row.accuracy["S2b"].value
    other = rights(f"lstm_1:weights={workshop.runs('fewer')[0].weights},outside=accept", cases)
    ahead = learned.remedies[1].difference["all"]
    assert ahead.value == pytest.approx((other - found.mean(axis=0)).mean())


def test_the_table_tells_every_method_alike(learned, workshop, cases):
    table = learned.table
    rule, shipped, own = (each.found for each in table.groups["all"])
    by_rule, by_shipped = rights("sme", cases), rights("lstm_1", cases)
    assert rule.accuracy.value == pytest.approx(by_rule.mean())
    assert rule.ahead.value == pytest.approx((1.0 * by_shipped - by_rule).mean())
    s2b = (cases[0]["scenario"] == "S2b").to_numpy()
    assert table.groups["S2b"][1].found.accuracy.value == pytest.approx(by_shipped[s2b].mean())
    assert shipped.ahead is None
    assert table.held == shipped.method
    assert table.held.title == "LSTM_1"
    printed = {"S1": 0.9733, "S2a": 0.76, "S2b": 0.7167, "all": 0.8167}
    assert {group: own.paper for group, own in table.own.items()} == pytest.approx(printed)
    assert [each.paper_wall_ms for each in table.timed] == [0.18, 3.67, None]
    assert own.method.title == "small, seed 0"
    for row in (rule, shipped):
        wrong = row.over.value + row.under.value
        assert wrong == pytest.approx(1.0 - row.accuracy.value)
        assert row.cpu.n == 9
    assert [list(each.rates) for each in table.timed] == [[], [2, 8], [2, 8]]
    assert [each.found for each in table.timed] == [rule, shipped, own]
    for each in table.timed[1:]:
        assert each.rate == each.rates[each.best_batch]


def test_the_table_is_of_the_set_that_it_names(plan, tmp_path):
    own = dataclasses.replace(plan.table, trainings=(), limit=3, timed=3)
    plan = dataclasses.replace(plan, part=Part.TEST, directory="lists", table=own)
    found = compare(Lab(tmp_path, 0), with_sections(plan, "table"))
    benchmark = load_benchmark("lists")
    chosen = benchmark.select("test", limit=3)
    layouts = [benchmark.layout(*key) for key in chosen[KEYS].itertuples(index=False)]
    table, [rule, _] = found.table, found.table.groups["all"]
    assert (table.labelled_set, table.part, table.cases) == ("lists", "test", 9)
    assert table.item_lists == chosen["instance"].nunique()
    assert rule.found.accuracy.value == pytest.approx(rights("sme", (chosen, layouts)).mean())
    page = LearnedStudy().page(found)
    assert "9 cases of part `test` of the set `lists`" in page.summary
    assert "historical" not in page.summary


def test_a_leak_is_measured_on_the_set_whose_lists_it_learns(plan, learned, folder):
    plan = dataclasses.replace(plan, part=Part.TEST, directory="lists")
    chosen = with_sections(plan, "remedies", "leak")
    found = compare(Lab(folder / "work", 0), chosen, limit=LIMIT)
    lists, large = load_benchmark("lists"), load_benchmark()
    for benchmark, rows, names in (
        (lists, found.remedies, ["small", "fewer"]), (large, found.leaks[0], ["small", "leaky"]),
    ):  # fmt: skip
        chosen = benchmark.select("test", limit=LIMIT)
        layouts = [benchmark.layout(*key) for key in chosen[KEYS].itertuples(index=False)]
        for row, name in zip(rows, names, strict=True):
            runs = Workshop(plan, folder / "work").runs(name)
            specs = [f"lstm_1:weights={run.weights},outside=accept" for run in runs]
            right = [rights(spec, (chosen, layouts)).mean() for spec in specs]
            assert row.all_seeds == pytest.approx(right)
    assert found.item_lists == lists.select("test", limit=LIMIT)["instance"].nunique()
    assert found.leak_lists == large.select("test", limit=LIMIT)["instance"].nunique()
    made = LearnedStudy().page(found)
    texts = (str(block) for part in (*made.sections, *made.details) for block in part.blocks)
    page = " ".join(" ".join(texts).split())
    assert f"the set `lists`: 36 cases (S1, S2a, S2b), packed from {found.item_lists}" in page
    assert f"36 cases, packed from {found.leak_lists} item lists, the historical part" in page


def test_an_interrupted_study_has_kept_what_was_trained(plan, tmp_path):
    def interrupt(work, done, _):
        if work == "trainings" and done == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        compare(Lab(tmp_path, 0, progress=interrupt), with_sections(plan, "remedies"), limit=2)
    assert len(list((tmp_path / "said").iterdir())) == 1


def test_label_sources_are_told_apart(learned, workshop):
    assert [row.labels for row in learned.sources] == [
        "sme", "pbs:alpha=0.5", "sme, then labelled set",
    ]  # fmt: skip
    one, two = (load_benchmark(workshop.set_folder(n)).cases for n in ("rule", "forces"))
    assert one[KEYS].to_numpy().tolist() != []
    both = one.merge(two, on=KEYS)
    assert len(both) == len(one) == len(two)  # the same layouts, in the same scenarios
    same = (both["failing_step_x"].fillna(-1) == both["failing_step_y"].fillna(-1)).mean()
    assert 0.0 < same < 1.0
    assert {one.what: one.same.value for one in learned.agreement} == {
        "pbs:alpha=0.5": pytest.approx(same)
    }
    assert learned.sources[0].cases == len(one)


def test_sizes_and_the_leak_are_what_was_asked(learned, workshop):
    fewer, small = learned.size[0].rows
    assert (fewer.item_lists, small.item_lists > 5) == (5, True)
    assert fewer.cases < small.cases == 180
    [[honest, leaky]] = learned.leaks
    manifest = load_weights(workshop.runs("leaky")[0].weights).manifest
    assert manifest["leaky"]
    assert "--leaky" in manifest["command"]
    assert (honest.cases, leaky.cases) == (180, 180)
    assert not load_weights(workshop.runs("small")[0].weights).manifest["leaky"]


def test_foreign_layouts_are_refused_for_what_is_outside(learned):
    [row] = learned.foreign.rows
    assert row.refused.value == pytest.approx(1 / 3)
    assert ("longest side", 1) in [(one.quantity, one.layouts) for one in learned.foreign.reasons]
    assert learned.foreign.layouts == 3
    # Only the first three items of the long row are judged: all stand on the floor.
    said = learned.foreign.others[0].fully_stable
    large, inside = container("large", 3, 8.0), container("inside", 3, 1.0)
    stable = [make_method("sme").judge(lay).stable for lay in (inside, large)]
    assert said.value == pytest.approx((sum(stable) + 1) / 3)
    assert row.inside["SME"].n == row.accepted == 2
    assert row.agreement["SME"].n == 3


def test_calibration_is_that_of_the_judge_itself(learned, cases):
    of_scores, shipped = learned.calibrated[1], learned.abstaining[0]
    found = rights("lstm_1", cases)
    assert shipped.every.value == pytest.approx(found.mean())
    # Every layout by itself, without batches: sure is what its score is given.
    judge, squares = make_method("lstm_1"), []
    for layout, right in zip(cases[1], found, strict=True):
        sure = 1.0
        for p in judge.probabilities(layout):
            sure *= p if p > 0.5 else 1.0 - p
            if p > 0.5:
                break
        squares.append((sure - right) ** 2)
    assert of_scores.brier.value == pytest.approx(np.mean(squares), abs=1e-5)


def test_again_nothing_is_made_and_weights_that_are_no_method_are_not_needed(
    learned, plan, folder, foreign, tmp_path
):
    work, aside = folder / "work", tmp_path / "aside"

    def stamps():
        return {p: p.stat().st_mtime_ns for p in work.rglob("*") if p.is_file()
                and p.name != ".lock"}  # fmt: skip

    assert [path.name[:8] for path in (work / "trainings").iterdir()] == ["small-0-"]
    (work / "checkpoints").rename(aside)
    try:
        before = stamps()
        assert compare(Lab(work, workers=0), plan, limit=LIMIT, foreign=[foreign]) == learned
        assert stamps() == before
    finally:
        aside.rename(work / "checkpoints")


CHILD = """
import sys
from pathlib import Path
from steadyload.learners.plans.plan import Section
from steadyload.learners.plans.plan_file import load_plan
from steadyload.learners.plans.trainings import Workshop
Workshop(load_plan(Path(sys.argv[1])), Path(sys.argv[2])).make([Section.SIZE], workers=0)
"""


def test_a_killed_study_goes_on_to_the_same_weights(tmp_path, learned, workshop):
    file = tmp_path / "plan.toml"
    file.write_text(PLAN)
    killed = Workshop(load_plan(file), tmp_path / "work")
    [first], [second, third] = killed.runs("fewer"), killed.runs("small")
    child = subprocess.Popen(
        [sys.executable, "-c", CHILD, str(file), str(killed.folder)],
        cwd=ROOT, env={"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    while not (second.folder / "member_0").exists():
        assert child.poll() is None
        time.sleep(0.005)
    child.send_signal(signal.SIGKILL)
    assert child.wait() == -signal.SIGKILL
    assert first.finished
    assert not third.finished
    kept = (first.weights / "manifest.json").stat().st_mtime_ns
    told = []
    killed.make([Section.SIZE], workers=0, training=lambda done, total: told.append((done, total)))
    assert told[0][0] >= 1
    assert told[-1] == (3, 3)
    assert (first.weights / "manifest.json").stat().st_mtime_ns == kept
    whole = [*workshop.runs("fewer"), *workshop.runs("small")]
    for mine, theirs in zip((first, second, third), whole, strict=True):
        one, two = (load_weights(run.weights).manifest["hashes"] for run in (mine, theirs))
        assert one == two


def test_a_changed_plan_leaves_what_has_not_changed(plan, folder, workshop, tmp_path):
    file = tmp_path / "plan.toml"
    file.write_text(PLAN.replace("epochs = 6", "epochs = 7").replace("lists = 1", "lists = 2"))
    changed = Workshop(load_plan(file), folder / "work")
    assert not changed.runs("small")[0].finished
    assert changed.runs("leaky")[0].finished
    # A set that grows is gone on with; what learnt from it, and from those weights, is not.
    assert changed.set_folder("rule") == workshop.set_folder("rule")
    assert not changed.runs("rule")[0].finished
    assert not changed.runs("tuned")[0].finished


def test_only_what_is_planned_is_made_and_shown(tmp_path, capsys, learned, in_this_process):
    file, work = tmp_path / "plan.toml", tmp_path / "work"
    trainings, size = PLAN.partition("\n[table]")[0], 'title = "sizes"\ntrainings = ["fewer"]'
    file.write_text(f"{trainings}\n[[size]]\n{size}\n")
    command = ["study", "learned", "--plan", str(file), "--work", str(work), "-j", "1"]
    assert main([*command, "--limit", "4", "-o", str(tmp_path / "page")]) == 0
    path = Path(capsys.readouterr().out.strip())
    text = path.read_text()
    headings = [line[3:] for line in text.splitlines() if line.startswith("## ")]
    assert headings == [
        "How trainings are compared",
        "Size of the training set",
        "Details",
        "Made with",
    ]
    text += next(path.parent.glob("report-details.*.md")).read_text()
    [training] = (work / "checkpoints").iterdir()
    assert training.name.startswith("fewer-0-")
    assert not (work / "sets").exists()
    made = load_weights(training / "weights").manifest
    assert str(made["made_by"]["git"]) in text
    assert made["command"] in text
    page = LearnedStudy().page(learned)
    titles = [*(part.title for part in page.sections), *(part.title for part in page.details)]
    assert titles == [
        "Compared with other methods", "How trainings are compared", "Size of the training set",
        "Label source", "Shifted centres of mass", "Scenarios and batches",
        "Trainings by size of the training set", "Calibration, and abstaining",
        "What a leak gains", "Layouts of another kind", "Where the weights come from",
        "How to read this page",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("part =", "prt ="), "unknown key 'prt'; did you mean 'part'"),
        (
            ('"validation"', '"train"'),
            "part is 'train'; allowed: fitting, search, test, test-300, validation",
        ),
        (("hidden = 8", "hiden = 8"), "did you mean 'hidden'"),
        (('start = "rule"', 'start = "ruel"'), "start 'ruel'; none of that name"),
        (('start = "rule"', 'start = "tuned"'), "starts from itself in the end"),
        (('data = ["rule"]', 'data = ["rules"]'), "data 'rules'; did you mean 'rule'"),
        (('held = "lstm_1"', 'held = "lstm_e"'), "held is 'lstm_e'"),
        (("part =", 'directory = "list"\npart ='), "no folder; did you mean 'lists'"),
        (("repeats = 2", "repeats = -2"), "repeats is -2; allowed: a whole number, 0 or more"),
        (("seeds = [0, 1]", "seeds = [0, 0]"), "allowed: each of them once"),
        (('label = "sme"', 'label = "smee"'), "unknown method 'smee'"),
        (('baseline = "small"', 'baseline = "smal"'), "training 'smal'; did you mean 'small'"),
        (("part", "part]"), "not valid TOML"),
    ],
)
def test_a_plan_that_cannot_be(tmp_path, change, message):
    file = tmp_path / "plan.toml"
    file.write_text(PLAN.replace(*change, 1))
    with pytest.raises(LearnerError) as raised:
        load_plan(file)
    assert str(file) in str(raised.value)
    assert message in str(raised.value)


def test_a_file_that_is_not_there_is_refused_before_anything_is_trained(plan, tmp_path):
    work = tmp_path / "work"
    with pytest.raises(LearnerError, match=r"none\.json: no such file of layouts"):
        compare(Lab(work), plan, [Path("none.json")])
    assert not work.exists()


def test_the_shipped_plan_can_be_made_again_by_seed():
    plan = load_plan()
    needed = plan.needed(plan.sections())
    assert plan.sections() == list(Section)
    assert {t.name for t in needed} == set(plan.trainings)
    assert {t.budget for t in needed} == {86400.0}
    assert plan.part == "test"
    remedies = [plan.trainings[n] for n in (plan.remedies.baseline, *plan.remedies.trainings)]
    assert all(len(t.seeds) >= 3 for t in remedies if t.preset != "paper")
