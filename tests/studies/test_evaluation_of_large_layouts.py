"""The page of layouts of real size, on towers of three to six cubes whose numbers are plain."""

import dataclasses
import math
import re

import numpy as np
import pandas as pd
import pytest

from steadyload.app.recommend import kept
from steadyload.app.recommend.folder import measured_in
from steadyload.app.recommend.front import front_for
from steadyload.app.recommend.kept import REAL, load_fronts
from steadyload.app.recommend.measured import front_of
from steadyload.cli import main
from steadyload.labelling.screened import REASONS, checked_screening, screened_steps
from steadyload.labelling.screening import label_screened
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import BenchmarkError, load_benchmark, tables
from steadyload.layouts.benchmark.dataset import KEYS, row_of
from steadyload.layouts.benchmark.parts import NO_CLASS, PALLET_SOFTWARE
from steadyload.layouts.benchmark.tables import (
    CASES,
    OPINIONS,
    UNLABELLED,
    write_further,
    write_tables,
)
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.spec import SpecError
from steadyload.numbers import NumberError
from steadyload.reports.pages.writing import write_page
from steadyload.reports.table import significant
from steadyload.runs import frames as v
from steadyload.runs import judged as judged_module
from steadyload.runs.able import able_methods
from steadyload.runs.judged import load_judged
from steadyload.studies.evaluation.floors import FLOORS
from steadyload.studies.evaluation.judging import Options, Ran, limited_methods
from steadyload.studies.evaluation.methods import (
    by_method,
    cheapest_near,
    every_method,
    exponents,
)
from steadyload.studies.evaluation.places import CONSTANT
from steadyload.studies.evaluation.study import Evaluation
from steadyload.studies.evaluation.verdicts import CUSTOMERS, PACKERS, costed
from steadyload.studies.kit import Lab

WITHIN, STANDS = Question.WITHIN, Question.STANDS
ASKED = ("fbs", "equilibrium:margin=0.01", "lstm_e", "ps3@mujoco")
SHORT = 1e-9
"""A time limit that simulations exceed at once, and rules do not look at [s]."""


def tower(name, *shifts, x=20.0, heavy=1.0, gap=0.0):
    """A tower of 10 cm cubes of 1 kg; the lowest one may be heavier, the last one hover."""
    last = len(shifts) - 1
    items = tuple(
        Item(
            step,
            (x + shift, 10.0 * step + (gap if step == last else 0.0), 20.0),
            (10.0, 10.0, 10.0),
            heavy if step == 0 else 1.0,
        )
        for step, shift in enumerate(shifts)
    )
    return Layout(name, Pallet(60.0, 100.0, 60.0), items)


TOWERS = {
    "order 1": [tower("three", 0, 0, 0), tower("four", 0, 0, 0, 0)],
    "order 2": [
        tower("heavy", *[0] * 6, heavy=5e4)
    ],  # to a ratio that networks were not trained on
    "order 3": [tower("falls at 2", 0, 0, 8), tower("falls at 3", 0, 0, 0, 8)],
    "order 4": [tower("falls at 5", 0, 0, 0, 0, 0, 8)],
    # Its last cube is 0.1 mm past the point of balance: it falls, but not within 0.3 s.
    "order 5": [tower("falls late", 0, 0, 0, 0, 5.01)],
    # It overhangs the deck, and its last cube hovers 2 mm above the one below.
    "order 6": [tower("a.order-1", 0, 0, 0, 0, 0, x=-4.0, gap=0.2)],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A labelled set of the towers, all of them in its test part."""
    made = tmp_path_factory.mktemp("set")
    rows, cases = [], []
    for instance, towers in TOWERS.items():
        for layout in towers:
            source = PALLET_SOFTWARE if "order-" in layout.name else "by hand"
            rows.append(row_of(layout, instance, NO_CLASS, (source,)))
            cases.append({"layout": layout.name, "scenario": "S1", "item_count": len(layout)})
    frame = pd.DataFrame(cases).assign(status=UNLABELLED).reindex(columns=CASES.names)
    opinions = pd.DataFrame(columns=OPINIONS.names)
    write_tables(made, pd.DataFrame(rows), frame, opinions, {"seed": 0, "test": 1.0})
    assert label_screened(made) == 8
    return made


@pytest.fixture(scope="module")
def study(folder):
    return Evaluation(methods=ASKED, directory=str(folder), asked="both", timeout=SHORT)


@pytest.fixture(scope="module")
def work(tmp_path_factory):
    return tmp_path_factory.mktemp("work")


@pytest.fixture(scope="module")
def found(study, work):
    return study.run(Lab(work, workers=0))


@pytest.fixture(scope="module")
def cases(found, work):
    return load_judged(work / REAL)


def right(estimate):
    """Cases on which a method is right, and all of them."""
    return round(estimate.value * estimate.n) if estimate.n else 0, estimate.n


def results(found, question):
    """The rows of methods of a question."""
    [own] = [one for one in found.sets if one["question"] is question]
    return own["rows"]


@pytest.mark.parametrize(
    ("spec", "question", "overall", "failing"),
    [
        # It calls the late fall and the overhanging pallet unstable.
        ("fbs", WITHIN, (6, 8), (3, 3)),
        ("fbs", STANDS, (7, 8), (4, 4)),
        # It calls the late fall and the hovering cube unstable.
        ("equilibrium:margin=0.01", WITHIN, (6, 8), (3, 3)),
        ("equilibrium:margin=0.01", STANDS, (7, 8), (4, 4)),
        # It refuses the heavy cube and the deck, and does not see the late fall.
        ("lstm_e", WITHIN, (6, 8), (3, 3)),
        ("ps3@mujoco", WITHIN, (0, 8), (0, 3)),
    ],
)
def test_both_questions_have_their_accuracies(found, spec, question, overall, failing):
    one = results(found, question).loc[spec]
    assert (right(one["right"]), right(one["right_failing"])) == (overall, failing)


def test_a_method_is_compared_for_the_question_that_it_judges(found):
    assert list(results(found, WITHIN).index) == [*ASKED]
    assert list(results(found, STANDS).index) == [*ASKED[:2]]
    assert right(results(found, WITHIN).loc["lstm_e", "right_stands"]) == (5, 8)


def test_a_refusal_is_wrong_and_counted_apart(found):
    rows = results(found, WITHIN)
    assert rows["lost"].dropna().to_dict() == {
        "lstm_e": {"refused": 2}, "ps3@mujoco": {"timeout": 8},
    }  # fmt: skip
    # Three methods are right on six of eight cases; the first of them is the best.
    behind = {method: one.value for method, one in rows["behind"].dropna().items()}
    assert behind == {ASKED[1]: 0.0, "lstm_e": 0.0, "ps3@mujoco": -0.75}


def test_cases_are_counted_by_boxes(found):
    for own, fails in zip(found.sets, (3, 4), strict=True):
        [few] = own["bins"].itertuples()
        assert (few.boxes, few.cases, few.lists, few.middle) == ("1 to 20", 8, 6, 4.5)
        assert 8 - right(few.stable)[0] == fails
        own_right = own["by_boxes"].loc["fbs", "boxes_right:1 to 20 (n 8)"]
        assert right(own_right) == (6 if own["question"] is WITHIN else 7, 8)
        assert right(own["stable_share"]) == (8 - fails, 8)
    assert {row.case_label: right(row.fails) for row in found.fails.itertuples()} == {
        "within, the cases of this page": (3, 8), "within, the whole set": (3, 8),
        "stands, the cases of this page": (4, 8), "stands, the whole set": (4, 8),
    }  # fmt: skip
    assert (found.small, dict(found.unlabelled)) == (False, {})


def test_a_judgement_that_was_given_up_costs_the_limit(cases):
    def frame_of(taken):
        given = dataclasses.replace(cases, results=cases.results.assign(cpu_total=taken))
        ran = Ran(None, None, None)
        return costed(given, ran, Options(("fbs",), timeout=20.0))

    rows = by_method(frame_of(0.0))
    late, refusing = rows.loc["ps3@mujoco"], rows.loc["lstm_e"]
    assert (late["cpu"].value, late["median"], late["ninety"], late["worst"]) == (2e4,) * 4
    assert (right(late["brief"]), right(late["long"])) == ((0, 8), (0, 8))
    assert (refusing["cpu"].value, refusing["cpu"].n, refusing["worst"]) == (0.0, 6, 0.0)
    assert right(refusing["brief"]) == (6, 8)  # what is refused is not judged
    boxes = cases.results["item_count"]
    frame = frame_of(boxes / 1e3)
    cost, own = by_method(frame).loc["fbs"], boxes[cases.results["method"] == "fbs"]
    assert (cost["cpu"].value, cost["median"], cost["worst"]) == (own.mean(), 4.5, 6.0)
    assert cost["ninety"] == pytest.approx(np.sort(own)[[6, 7]] @ (0.7, 0.3))
    slow = by_method(frame_of(boxes / 10)).loc["fbs"]  # 0.3 to 0.6 s
    assert (right(slow["brief"]), right(slow["long"])) == ((2, 8), (8, 8))
    # The cost grows as the boxes do, and the exponent is of what a method calls stable.
    growth, twice = exponents(frame), exponents(pd.concat([frame, frame]))
    assert (growth["fbs"].n, twice["fbs"].n) == (3, 6)
    assert math.isclose(growth["fbs"].value, 1.0)
    assert "ps3@mujoco" not in growth.index


def test_the_cheapest_of_the_best_is_chosen_by_the_median(found):
    rows = results(found, WITHIN)
    medians = {"fbs": 3.0, ASKED[1]: 2.0, "lstm_e": 1.0, "ps3@mujoco": 0.5}
    # A mean would choose another one, and the cheapest of all is not as accurate.
    assert cheapest_near(rows.assign(median=pd.Series(medians))) == "lstm_e"


def test_customers_pallets_are_told_from_plans_of_packers(found):
    planned = found.who_planned
    assert [(o.origin, o.cases, o.layouts, o.lists) for o in planned.itertuples()] == [
        (CUSTOMERS, 1, 1, 1),
        (f"{CUSTOMERS}, as delivered (S1)", 1, 1, 1),
        (PACKERS, 7, 7, 5),
    ]
    assert [right(one) for one in planned["fails_by:within"]] == [(0, 1), (0, 1), (3, 7)]
    assert [right(one) for one in planned["fails_by:stands"]] == [(0, 1), (0, 1), (4, 7)]


def test_gaps_and_edges_change_verdicts(found):
    floors = found.floors
    assert list(floors["floor"]) == list(FLOORS)
    assert set(floors["pallets"]) == {1}
    title = "Equilibrium (margin=0.01)"
    assert [c for c in floors if ":" in c] == [f"floor_stable:{title}", f"floor_changed:{title}"]
    # The cube that hovers 2 mm stands as soon as gaps are closed; the edge changes nothing.
    assert [one.value for one in floors[f"floor_stable:{title}"]] == [0.0, 0.0, 1.0, 1.0, 1.0]
    assert list(floors[f"floor_changed:{title}"]) == [0, 0, 1, 1, 1]


def test_cases_without_a_verdict_are_told_by_reason(found):
    refused, late = found.lost.itertuples()
    assert (refused.status, refused.cases, refused.boxes) == ("refused", 2, "5 to 6")
    assert refused.reason.startswith("item 1: heaviest over lightest is 50000;")
    assert (late.status, late.cases) == ("timeout", 8)


def test_screen_and_reference_are_compared():
    steps = pd.DataFrame(
        {
            "layout": ["a", "b"],
            "scenario": ["S1", "S1"],
            "screen": [[0.1, 0.6, 1.2], [0.0, 2.0]],
            "reference": [[np.nan, 1.1, 0.9], [0.2, 2.5]],
            "why": [["", "near", "fails"], ["drawn", "fails"]],
        }
    )
    seen = screened_steps(steps)
    assert (seen.cases, seen.steps) == (2, 5)
    assert {
        key: (part.steps, part.screen, part.reference, part.differ)
        for key in REASONS
        if (part := seen.of(key))
    } == {"fails": (2, 2, 1, 1), "near": (1, 0, 1, 1), "drawn": (1, 0, 0, 0)}
    assert screened_steps(steps.head(0)).reasons == ()


def test_the_page_answers_first(study, found, tmp_path):
    text = write_page(study.page(found), tmp_path).read_text()
    first = text.partition("\n## ")[0]
    title, answer, figure, _, data = first.split("\n\n")
    assert title == "# Accuracy and cost of all methods on pallets of real size"
    assert answer.startswith(
        "For the question *stands*, the most accurate method is FBS, which is right on 87.5 ["
    )
    assert "It finds 100.0 % of plans of packers that fall, and says of 0 of 3 that stand" in answer
    assert figure.startswith("![Accuracy against CPU time")
    assert data.startswith("4 methods a question on 8 cases")
    assert "(1 customers' pallets) of " in data
    assert "4 are stable. Customers' pallets fall in " in data
    assert "Estimate(" not in "".join(part.read_text() for part in tmp_path.rglob("*.md"))
    for of in found.sets:
        assert f"alone: {', '.join(of['alike']['titles'])}" in text
        [span] = of["spans"].itertuples()
        assert span.title == of["leading"]["title"]


SCREEN = "label@mujoco:frequency=480"


def with_costs(judged):
    """Verdicts with the columns that rows of methods need, without a yardstick."""
    frame = v.costed(judged)
    return frame.assign(yardstick=None, unit=None, brief=True, long=True)


def test_methods_on_an_engine_that_gave_the_labels_are_compared_with_none(cases, monkeypatch):
    """The simulation is right on every case here, and wins all the same only where it may."""
    own = cases.results["method"] == "ps3@mujoco"
    steps = cases.labels["failing_step"].reindex(pd.MultiIndex.from_frame(cases.results[KEYS]))
    results = cases.results.assign(
        failing_step=cases.results["failing_step"].mask(own, pd.Series(steps.array, own.index)),
        status=cases.results["status"].mask(own, "done"),
    )
    about = {**cases.manifest["labels"], "screens": [SCREEN]}
    found = dataclasses.replace(
        cases, results=results, manifest={**cases.manifest, "labels": about}
    )
    assert (found.screens, found.apart) == ((), frozenset())  # no layout is large
    small = every_method(with_costs(found), {})
    assert v.best(small["right"]) == "ps3@mujoco"
    assert len(v.comparable(with_costs(found))["method"].unique()) == 4

    for module in (judged_module, v):
        monkeypatch.setattr(module, "MOST_SMALL", 4)
    assert (found.screens, found.apart) == ((SCREEN,), frozenset({"ps3@mujoco"}))
    frame = with_costs(found)
    large, compared = every_method(frame, {}), v.comparable(frame)
    assert list(compared["method"].unique()) == [*ASKED[:3]]
    assert v.best(large["right"].drop("ps3@mujoco")) == "fbs"
    assert large["right"]["ps3@mujoco"].value == 1.0  # shown
    assert pd.isna(large["behind"]["ps3@mujoco"])
    assert large["behind"]["lstm_e"].value == 0.0  # behind FBS
    assert small["behind"]["lstm_e"].value == -0.25
    front = front_of(found, WITHIN, large, "", {"machine": ""})
    assert front.left_out == {"ps3@mujoco": f"labels of its cases rest on {SCREEN}"}
    few = found.only((found.labels["item_count"] <= 4).to_numpy(bool))
    assert few.apart == frozenset()


def wall(name, boxes, *, hovers=False):
    """Cubes beside each other, 144 a layer; the last one may hang in the air."""
    items = tuple(
        Item(k, (10.0 * (k % 12), 10.0 * (k // 144), 10.0 * (k // 12 % 12)), (10.0,) * 3, 1.0)
        for k in range(boxes)
    )
    if hovers:
        x, y, z = items[-1].position
        items = (*items[:-1], Item(boxes - 1, (x, y + 30.0, z), (10.0,) * 3, 1.0))
    return Layout(name, Pallet(120.0, 200.0, 120.0), items)


WALLS = {"a": 40, "b": 61, "c": 62, "d": 80, "e": 100, "f": 101, "g": 150}
OF_CUSTOMERS, HOVERING = "adg", "bcf"


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """The study on layouts of 40 to 150 boxes, whose labels rest on a simulation from 62 on."""
    folder = tmp_path_factory.mktemp("large") / "set"
    walls = [wall(name, n, hovers=name in HOVERING) for name, n in WALLS.items()]
    sources = [(PALLET_SOFTWARE if name in OF_CUSTOMERS else "py3dbp",) for name in WALLS]
    rows = [row_of(w, w.name, NO_CLASS, by) for w, by in zip(walls, sources, strict=True)]
    labels = [
        {"layout": w.name, "scenario": "S1", "status": "done",
         "failing_step": len(w) - 1 if w.name in HOVERING else None}
        for w in walls
    ]  # fmt: skip
    cases = pd.DataFrame(labels).assign(item_count=[*WALLS.values()], split="test", rank=range(7))
    empty, manifest = pd.DataFrame(columns=OPINIONS.names), {"seed": 0, "screens": [SCREEN]}
    layouts, frame = pd.DataFrame(rows), cases.reindex(columns=CASES.names)
    write_tables(folder, layouts, frame, empty, manifest)
    standing = pd.DataFrame(labels).assign(question="stands")
    write_further(folder, "labels", standing.reindex(columns=tables.LABELS.names), {})
    work = tmp_path_factory.mktemp("large work")
    asked = ("fbs", "sme", "ps3@mujoco")
    study = Evaluation(methods=asked, directory=str(folder), asked="both", timeout=SHORT)
    return study, study.run(Lab(work, workers=0)), work


def test_sizes_and_origins_are_told_apart(large):
    _, found, _ = large
    for own in found.sets:
        sizes = ["38 to 61", "62 to 100", "101 to 150"]
        assert [(b.origin, b.boxes, b.cases) for b in own["origin_bins"].itertuples()] == [
            (origin, size, n)
            for origin, counts in (
                ("all cases", (2, 3, 2)), (CUSTOMERS, (1, 1, 1)), (PACKERS, (1, 2, 1)),
            )
            for size, n in zip(sizes, counts, strict=True)
        ]  # fmt: skip
        assert [right(part["stable"]) for part in own["origins"]] == [(3, 3), (1, 4)]
        assert [(part.size, right(part.stable)) for part in own["spans"].itertuples()] == [
            ("25 to 61", (1, 2)), ("62 to 100", (2, 3)), ("101 to 150", (1, 2)),
        ]  # fmt: skip
        constant = own["origins"][1]["by_boxes"].iloc[-1]
        assert constant["title"] == CONSTANT
        assert [right(e) for e in constant.iloc[1:]] == [(0, 1), (1, 2), (0, 1)]
        assert list(own["size_costs"]) == sizes


def test_the_page_answers_for_every_size_and_says_what_is_not_compared(large, tmp_path):
    study, found, _ = large
    text = write_page(study.page(found), tmp_path).read_text()
    _, _, _, _, data, *_ = text.split("\n\n")
    assert "`mujoco`, on which labels above 61 boxes rest, " in data
    spans = found.sets[0]["spans"]
    part = text[text.index("The most accurate method, and the cheapest") :]
    printed = re.search(r"(?:^\|.*\n)+", part, re.MULTILINE)[0].splitlines()
    header, _, *lines = ([cell.strip() for cell in line.strip("|").split("|")] for line in printed)
    assert header[2:4] == ["most accurate", "accuracy %"]
    assert [line[0] for line in lines] == list(spans["size"])
    assert [line[0] for line in lines] == ["25 to 61", "62 to 100", "101 to 150"]
    assert [line[2] for line in lines] == list(spans["title"])
    [details] = tmp_path.glob("report-details.*.md")
    assert found.apart[0].title in details.read_text()
    assert "| the constant verdict *stable* |" in details.read_text()
    [data] = [p.interactive.data() for p in study.page(found).drawn if p.name == "accuracy_within"]
    groups = {group["title"]: group["points"] for group in data["groups"]}
    names = [part["name"] for part in found.sets[0]["origins"]]
    assert [*groups] == ["all scenarios", *names, *spans["size"]]
    for span in spans.itertuples():
        told = {point["title"]: point["told"] for point in groups[span.size]}
        assert f"(median {significant(span.median)} ms, 90 % within " in told[span.title]


def test_large_layouts_have_their_own_recommendations(large, tmp_path, monkeypatch, capsys):
    _, _, work = large
    fronts = measured_in(work)
    assert [(f.fewest, f.most, [*f.left_out.values()]) for f in fronts if f.question is WITHIN] == [
        (40, 61, ["no verdict on any of 2 cases"]),
        (62, 100, [f"labels of its cases rest on {SCREEN}"]),
        (101, 150, [f"labels of its cases rest on {SCREEN}"]),
    ]
    assert front_for(fronts, STANDS, 110).fewest == 101
    monkeypatch.setattr(kept, "FILE", tmp_path / "fronts.json")
    assert main(["recommend", "--from", str(work), "--write"]) == 0
    assert len(load_fronts(tmp_path / "fronts.json")) == len(fronts) == 6
    assert main(["recommend", "--from", str(work), "--boxes", "110"]) == 0
    assert "measured on 2 cases of 101 to 150 boxes" in capsys.readouterr().out


def test_labels_by_the_screen_alone_are_counted_by_size(folder):
    benchmark = load_benchmark(folder)
    assert len(benchmark.screening) == 8
    why = [[""], ["", "drawn"], ["near", ""], *[["fails"]] * 5]
    screening = benchmark.screening.assign(
        why=why,
        screen=[[0.0] * len(w) for w in why],
        reference=[[0.0 if each else np.nan for each in w] for w in why],
    )
    [found] = checked_screening(screening, benchmark.cases)
    assert (found.boxes, right(found.cases_alone), found.drawn) == ("1 to 24", (2, 8), 1)
    assert (found.steps, found.alone) == (10, pytest.approx(3 / 10))
    assert checked_screening(screening.head(0), benchmark.cases) == ()


def test_the_command_goes_on_and_names_no_folder(folder, tmp_path, capsys):
    words = ["study", "evaluation", "--directory", str(folder), "-m", "fbs", "-m", "sme",
             "--question", "both", "--timeout", "20", "--work", str(tmp_path),
             "-j", "1"]  # fmt: skip
    for _ in range(2):
        assert main(words) == 0
        assert capsys.readouterr().out == f"{tmp_path}/report.md\n"
    text = "".join(path.read_text() for path in tmp_path.glob("report*.md"))
    assert "Every method came to a verdict on every case." in text
    assert "What the deck's edge" not in text  # none of the methods judges on several floors
    assert str(folder) not in text


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        ({"timeout": 0.0}, NumberError, "timeout is 0.0; allowed: a number of seconds above 0"),
        ({"methods": ("fbt",)}, SpecError, "did you mean 'fbs'"),
    ],
)
def test_what_cannot_be_is_refused(given, error, message, tmp_path):
    with pytest.raises(error, match=message):
        Evaluation(**{"methods": ("fbs",), **given}).run(Lab(tmp_path))


def test_without_a_set_there_is_no_study(tmp_path):
    study = Evaluation(methods=("fbs",), directory=str(tmp_path / "none"), timeout=20.0)
    with pytest.raises(BenchmarkError, match="no manifest"):
        study.run(Lab(tmp_path / "work"))


@pytest.mark.engine("bullet")
def test_usual_methods_exist_and_judge_both_questions():
    assert able_methods((), limited_methods) == (limited_methods(), {})
