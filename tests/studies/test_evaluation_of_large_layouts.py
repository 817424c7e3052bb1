"""The page of layouts of real size, on towers of three to six cubes whose numbers are plain."""

import dataclasses
import math

import numpy as np
import pandas as pd
import pytest

from steadyload.app.recommend.kept import REAL
from steadyload.cli import main
from steadyload.labelling.screened import REASONS, screened_steps
from steadyload.labelling.screening import label_screened
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import BenchmarkError
from steadyload.layouts.benchmark.dataset import row_of
from steadyload.layouts.benchmark.real import NO_CLASS, PALLET_SOFTWARE
from steadyload.layouts.benchmark.tables import CASES, OPINIONS, UNLABELLED, write_tables
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.spec import SpecError
from steadyload.numbers import NumberError
from steadyload.reports.pages.writing import write_page
from steadyload.runs.able import able_methods
from steadyload.runs.costs import limited_costs
from steadyload.runs.definition import StudyError
from steadyload.runs.judged import load_judged
from steadyload.studies.evaluation.costing import (
    growth_of,
    summary_of,
)
from steadyload.studies.evaluation.delivered import CUSTOMERS, DELIVERED, PACKERS
from steadyload.studies.evaluation.floors import FLOORS
from steadyload.studies.evaluation.judging import limited_methods
from steadyload.studies.evaluation.study import Evaluation
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
    return Evaluation(
        methods=ASKED, directory=str(folder), asked="both", timeout=SHORT, sizes=(4,), pallets=5
    )


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
    """Results of a question by spec."""
    [own] = [one for one in found.sets if one.question is question]
    return {one.own.method.spec: one for one in own.results}


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
    one = results(found, question)[spec]
    assert (right(one.own.accuracy), right(one.failing)) == (overall, failing)


def test_a_method_is_compared_for_the_question_that_it_judges(found):
    assert list(results(found, WITHIN)) == [*ASKED]
    assert list(results(found, STANDS)) == [*ASKED[:2]]
    assert right(results(found, WITHIN)["lstm_e"].own.stands) == (5, 8)


def test_a_refusal_is_wrong_and_counted_apart(found):
    rows = [one.own for one in results(found, WITHIN).values()]
    assert [dict(r.without_verdict) for r in rows] == [{}, {}, {"refused": 2}, {"timeout": 8}]
    # Three methods are right on six of eight cases; the first of them is the best.
    assert [r.behind and r.behind.value for r in rows] == [None, 0.0, 0.0, -0.75]


def test_cases_are_counted_by_boxes(found):
    for own, fails in zip(found.sets, ((2, 1), (2, 2)), strict=True):
        few, many = own.sizes
        assert [(b.name, b.cases, b.item_lists, b.middle) for b in own.sizes] == [
            ("3 to 4", 4, 2, 3.5),
            ("5 to 6", 4, 4, 5.5),
        ]
        assert [4 - right(b.stable)[0] for b in own.sizes] == [*fails]
        assert right(few.accuracy["fbs"]) == (4, 4)
        assert right(many.accuracy["fbs"]) == (2 if own.question is WITHIN else 3, 4)
        assert right(own.stable) == (8 - sum(fails), 8)
    assert {row.label: right(row.share) for row in found.fails} == {
        "within, the cases of this page": (3, 8), "within, the whole set": (3, 8),
        "stands, the cases of this page": (4, 8), "stands, the whole set": (4, 8),
    }  # fmt: skip
    assert (found.small, dict(found.unlabelled)) == (False, {})


def test_a_judgement_that_was_given_up_costs_the_limit(cases):
    results = cases.results.assign(cpu_total=0.0)
    rest = dataclasses.replace(cases, results=results)
    costs = limited_costs(rest.results, 20.0)
    assert summary_of(costs.of("ps3@mujoco")) == (2e4, 2e4, 2e4, 2e4)
    assert summary_of(costs.of("lstm_e")) == (0.0, 0.0, 0.0, 0.0)
    assert len(costs.of("lstm_e")) == 6
    results["cpu_total"] = results["item_count"] / 1e3
    cost = summary_of(limited_costs(rest.results, 20.0).of("fbs"))
    boxes = results.loc[results["method"] == "fbs", "item_count"]
    assert (cost[0], cost[1], cost[3]) == (boxes.mean(), 4.5, 6.0)
    # The cost grows as the boxes do, and the exponent is of what a method calls stable.
    growth = growth_of("fbs", rest, rest)
    assert (growth.own.n, growth.everything.n) == (3, 6)
    assert math.isclose(growth.own.value, 1.0)
    assert growth_of("ps3@mujoco", rest, None).own.n == 0


def test_the_cheapest_of_the_best_is_chosen_by_the_median(found):
    own = found.own
    costs = {spec: taken.copy() for spec, taken in own.evaluation.costs.milliseconds.items()}
    for spec, median in (("fbs", 3.0), (ASKED[1], 2.0), ("lstm_e", 1.0), ("ps3@mujoco", 0.5)):
        costs[spec]["cpu_total"] = median
        costs[spec].iloc[0, costs[spec].columns.get_loc("cpu_total")] = 100.0 / median
    evaluation = dataclasses.replace(
        own.evaluation, costs=dataclasses.replace(own.evaluation.costs, milliseconds=costs)
    )
    chosen = dataclasses.replace(own, evaluation=evaluation).near_best
    assert chosen.method.spec == "lstm_e"


def test_customers_pallets_are_told_from_plans_of_packers(found):
    assert [(o.title, o.cases, o.layouts, o.item_lists) for o in found.origins] == [
        (CUSTOMERS, 1, 1, 1),
        (DELIVERED, 1, 1, 1),
        (PACKERS, 7, 7, 5),
    ]
    assert [right(o.failing[WITHIN]) for o in found.origins] == [(0, 1), (0, 1), (3, 7)]
    assert [right(o.failing[STANDS]) for o in found.origins] == [(0, 1), (0, 1), (4, 7)]


def test_gaps_and_edges_change_verdicts(found):
    assert [row.floor for row in found.floors] == list(FLOORS)
    assert {row.pallets for row in found.floors} == {1}
    (title,) = found.floors[0].stable
    assert title == "Equilibrium (margin=0.01)"
    # The cube that hovers 2 mm stands as soon as gaps are closed; the edge changes nothing.
    assert [row.stable[title].value for row in found.floors] == [0.0, 0.0, 1.0, 1.0, 1.0]
    assert [row.changed[title] for row in found.floors] == [0, 0, 1, 1, 1]


def test_cases_without_a_verdict_are_told_by_reason(found):
    refused, late = found.lost
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
    assert first.startswith("# Accuracy and cost of all methods on pallets of real size\n\nFor the")
    assert "1 of the cases are customers' pallets (1 pallets of 1 orders)" in first
    assert "1 of 1 by the label *within*" in text
    assert "FBS: 75.0 [" in first
    for of in found.sets:
        alike, others = of.alike
        title, names = of.best.method.title, ", ".join(pair.first.title for pair in alike)
        plural = "" if others == 1 else "s"
        assert f"Of {others} other method{plural}, each compared with {title} alone" in first
        assert f"do not differ from it significantly: {names or '-'}." in first
    assert "62.5 % (within), 50.0 % (stands)." in text


def test_the_command_judges_small_layouts_too_and_goes_on(folder, tmp_path, capsys):
    words = ["study", "evaluation", "--directory", str(folder), "-m", "fbs", "-m", "sme",
             "--small", "2", "--question", "both", "--timeout", "20", "--sizes", "4", "6",
             "--pallets", "60", "--work", str(tmp_path), "-j", "1"]  # fmt: skip
    for _ in range(2):
        assert main(words) == 0
        assert capsys.readouterr().out == f"{tmp_path}/report.md\n"
    text = (tmp_path / "report.md").read_text()
    assert "The first bin holds small layouts" in text
    assert "Every method came to a verdict on every case." in text
    assert "What the deck's edge" not in text  # none of the methods judges on several floors
    assert str(folder) not in text


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        ({"sizes": (5, 5)}, StudyError, "sizes are 5, 5; allowed: whole numbers that rise"),
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
