"""The page of tuning: it says what its records hold, and nothing of what they do not."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from steadyload.methods.naming import MethodKey
from steadyload.methods.tuned import TUNED, tuned
from steadyload.reports.pages.writing import write_page
from steadyload.reports.table import duration, factor
from steadyload.runs.costs import CostKind, CostSource
from steadyload.runs.evaluation import MethodEvaluation
from steadyload.statistics.estimate import Estimate
from steadyload.studies.tuning.figures import plot_changes, plot_price
from steadyload.studies.tuning.page import tuning_page
from steadyload.studies.tuning.search_figures import front, plot_algorithms
from steadyload.studies.tuning.summary import (
    CostRow,
    GenerationRow,
    GeneRow,
    JudgedGenotype,
    KnowledgeStep,
    KnowledgeTable,
    PricePoint,
    SearchRow,
    SeedRow,
    TransferCell,
    TransferTable,
    TunedTable,
    Tuning,
    Variant,
    VariantTable,
)


def about(value, half=0.005):
    return Estimate(value, value - half, value + half, 400)


def outcome(title, engine, accuracy, cpu, ahead=None, cost_ratio=None):
    family = title.partition(" ")[0].lower().replace("_", "")
    return MethodEvaluation(
        method=MethodKey(f"{title} @ {engine}", f"{family}@{engine}", family, engine),
        accuracy=about(accuracy),
        over=about(0.012),
        under=about(0.007),
        cpu=about(cpu, 0.1 * cpu),
        ahead=ahead,
        cost_ratio=cost_ratio,
    )


def bought(engine, accuracy, cpu):
    return outcome("Bought", engine, accuracy, cpu)


def held_against(engine, *, accuracy=0.985, ahead_of_ps5=0.08, ratio=0.13):
    return TunedTable(
        engine,
        "test",
        outcome("Tuned", engine, accuracy, 5.2),
        (
            outcome("PS_3", engine, 0.893, 43.0, about(0.092), about(ratio, 0.01)),
            outcome("PS_5", engine, 0.905, 71.0, about(ahead_of_ps5), about(0.07, 0.01)),
        ),
    )


def search(engine, algorithm, seed, hypervolume, known=0):
    judged = [(0.7, 1.0, True), (0.9, 2.0, True), (0.85, 3.0, False), (0.984, 9.0, True)]
    return SearchRow(
        engine, algorithm, "all", seed, 40, 2, known, 61, 23, 19, 5400.0, 150.0,
        (0.91, 0.92, 14.4), (0.9731, 0.984, 5.1), hypervolume,
        tuple(
            GenerationRow(k, 0.9 + 0.03 * k, 0.5 + 0.1 * k, 0.98, 5.0, 20 * (k + 1), 0.5 + 0.1 * k)
            for k in range(3)
        ),
        tuple(JudgedGenotype(*point) for point in judged),
    )  # fmt: skip


def changes(*rows):
    return VariantTable(
        "bullet",
        "validation",
        tuple(
            Variant(
                name, "0.5", outcome(name, "bullet", 0.98 + change, 5.0 * cost), about(change), cost
            )
            for name, change, cost in rows
        ),
    )


def transfer(engines, lead):
    """``lead``: by pair (tuned on, judged on), how far the own parameters are ahead."""
    cells = [
        TransferCell(a, b, outcome("Tuned", b, 0.98, 5.0, None))
        if a == b
        else TransferCell(a, b, outcome("Tuned", b, 0.98 - lead[a, b], 5.0, about(lead[a, b])))
        for a in engines
        for b in engines
    ]
    return TransferTable("test", engines, tuple(cells), {engines: ("margin", "restitution")})


EMPTY = Tuning(
    {"bullet": {None: "validation"}, "dart": {None: "search", "real": "train"}},
    {"bullet": 900, "dart": 900},
    {"bullet": 8.6, "dart": 17.25},
)
PAIR = ("bullet", "dart")
FULL = replace(
    EMPTY,
    costs=(CostRow("bullet", {"substep": 3.14}, 60, 0.987, 0.061),),
    searches=(search("bullet", "genetic", 1, 0.81), search("bullet", "nsga2", 1, 0.84)),
    parameters={
        "bullet": (
            GeneRow("frequency", "Hz", "30 to 480 by 10", "60", "170"),
            GeneRow("friction", "", "0.3, 0.5, 0.7", "0.5", "0.5"),
            GeneRow("margin", "cm", "0 to 1 by 0.1", "0.1", "0.3"),
        )
    },
    tests=(held_against("bullet"), held_against("dart", accuracy=0.971)),
    knowledge=(
        KnowledgeTable(
            "bullet",
            "test",
            tuple(
                KnowledgeStep(title, outcome(title, "bullet", accuracy, 9.0), gain)
                for title, accuracy, gain in (
                    ("the paper's values", 0.88, None),
                    ("the label's protocol", 0.97, about(0.09)),
                    ("tuned", 0.98, about(0.01)),
                )
            ),
        ),
    ),
    seeds=tuple(
        SeedRow(
            "bullet", seed, 0.97, 0.985, outcome("Tuned", "bullet", accuracy, cpu),
            {"frequency": str(hertz), "friction": "0.5"},
        )
        for seed, accuracy, cpu, hertz in ((1, 0.98, 4.0, 170), (2, 0.984, 6.0, 190))
    ),
    left_out=(changes(("no early exit", 0.0, 2.5), ("start of friction", -0.031, 1.0)),),
    plausibility=(changes(("friction", -0.002, 1.0), ("restitution", -0.02, 1.0)),),
    transfer=(transfer(PAIR, {PAIR: 0.03, PAIR[::-1]: 0.02}),),
    prices=(
        PricePoint("bullet", 1.0, "", 0.0, None),
        PricePoint("bullet", 10.0, "frequency=170", 0.9861, bought("bullet", 0.981, 7.7)),
        PricePoint("dart", 1.0, "", 0.0, None),
        PricePoint("dart", 10.0, "frequency=90", 0.96, bought("dart", 0.957, 9.1)),
    ),
)  # fmt: skip
HEADINGS = {
    "tests": ["What came out"],
    "knowledge": ["What the protocol brings, and what the search brings"],
    "prices": ["The price of accuracy"],
    "parameters": ["What was searched and found"],
    "searches": ["The searches", "Genetic against multi-objective"],
    "seeds": ["How much luck"],
    "left_out": ["What the gain is made of"],
    "plausibility": ["Physical or fitted"],
    "transfer": ["Transfer between engines, part test"],
    "costs": ["How cost is modelled"],
}


def sections(tuning):
    return {s.title: s for s in tuning_page(tuning, {}).sections}


def cells(table, *starts):
    """The cells of the row whose first ones are ``starts``."""
    rows = [[c.strip() for c in line.strip("| ").split(" | ")] for line in str(table).splitlines()]
    (row,) = [row for row in rows if row[: len(starts)] == list(starts)]
    return row[len(starts) :]


def test_sections_come_in_order():
    assert list(sections(FULL)) == [t for titles in HEADINGS.values() for t in titles]
    assert not sections(EMPTY)


@pytest.mark.parametrize("part", HEADINGS)
def test_a_part_that_was_computed_has_its_sections_alone(part, tmp_path, undrawn):
    tuning = replace(EMPTY, **{part: getattr(FULL, part)})
    assert list(sections(tuning)) == HEADINGS[part]
    write_page(tuning_page(tuning, {}), tmp_path)


def test_one_algorithm_is_not_held_against_itself():
    alone = replace(EMPTY, searches=FULL.searches[:1])
    assert list(sections(alone)) == ["The searches"]
    elsewhere = replace(FULL.searches[1], engine="dart")
    assert list(sections(replace(EMPTY, searches=(FULL.searches[0], elsewhere)))) == [
        "The searches"
    ]


def test_a_page_says_what_searches_began_with():
    began = "Some searches had parameter sets in their first generation that an earlier"
    assert began not in sections(FULL)["The searches"].text
    known = replace(EMPTY, searches=(*FULL.searches, search("dart", "genetic", 4, 0.9, known=2)))
    text = sections(known)["The searches"].text
    assert (
        f"{began} search had found, beside the start and random ones: dart, genetic, seed 4 with 2."
        in text
    )


def test_a_page_has_its_pictures_and_the_same_bytes_again(tmp_path, assert_drawn):
    for folder in ("one", "two"):
        path = write_page(tuning_page(FULL, {"commit": "abc"}), tmp_path / folder)
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", path.read_text())
    assert len(pictures) == 5
    for name in pictures:
        assert_drawn(tmp_path / "two" / name)
    for name in ["report.md", *pictures]:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


@pytest.mark.parametrize(
    ("missing", "bar"),
    [
        ({"accuracy": 0.979}, "accuracy of at least 98 %"),
        ({"ratio": 0.21}, "costs at most a fifth of PS_3's CPU time"),
        ({"ahead_of_ps5": 0.004}, "beats PS_5"),
    ],
)
def test_a_missed_bar_is_said(missing, bar):
    tests = (held_against("bullet"), held_against("dart", **missing))
    text = sections(replace(EMPTY, tests=tests))["What came out"].text
    assert f"meet every bar on bullet; they miss one or more on dart ({bar})." in text
    bullet, dart = (line for line in text.splitlines() if line.startswith("- "))
    assert "Missed" not in bullet
    assert bar in dart.partition("Missed:")[2]
    assert bar not in dart.partition("Missed:")[0]


def test_bars_that_all_engines_meet_or_miss():
    good, bad = held_against("bullet"), held_against("dart", accuracy=0.96)
    text = sections(replace(EMPTY, tests=(good,)))["What came out"].text
    assert "meet every bar on bullet." in text
    assert "Their mean" not in text
    assert "on no engine; they miss" in sections(replace(EMPTY, tests=(bad,)))["What came out"].text
    both = sections(replace(EMPTY, tests=(good, bad)))["What came out"].text
    assert "mean accuracy over 2 engines is 97.2 %, below 98 %" in both


LABELS_OWN = "t_max=0.3,frequency=90,eps_t=10,eps_r=10,between_steps=reseat,criterion=adams"


def with_start(engine, gain, spec=LABELS_OWN):
    begun = replace(
        outcome("Start", engine, 0.98, 9.0, gain),
        method=MethodKey(f"start of the search @ {engine}", f"x@{engine}:{spec}", "label", engine),
    )
    table = held_against(engine)
    return replace(table, others=(*table.others, begun))


def test_a_page_gives_the_start_of_a_search_beside_what_the_search_adds():
    tests = (
        with_start("bullet", Estimate(0.013, 0.0, 0.043, 400)),
        with_start("dart", Estimate(0.03, 0.01, 0.05, 400)),
    )
    text = sections(replace(EMPTY, tests=tests))["What came out"].text
    assert "98.0 [97.5, 98.5] % on bullet; 98.0 [97.5, 98.5] % on dart." in text
    assert "add 1.3 [0.0, 4.3] points on bullet; 3.0 [1.0, 5.0] points on dart." in text
    assert "includes 0 on bullet. The interval of this gain excludes 0 on dart." in text
    assert "the label's own protocol" in text
    page = tuning_page(replace(EMPTY, tests=tests), {})
    first, _, _ = page.summary.partition("\n\n")
    assert "Without any search 98.0 % of these cases are right already" in first
    assert "at most 2.0 points here" in first
    assert "Without any search" not in tuning_page(FULL, {}).summary


def test_only_a_start_that_asks_the_labels_question_is_said_to_be_the_labels():
    table = with_start("bullet", about(0.0), LABELS_OWN.replace("eps_t=10", "eps_t=22"))
    text = sections(replace(EMPTY, tests=(table,)))["What came out"].text
    assert "start of the search" in text
    assert "protocol" not in text
    assert "begins with" not in sections(FULL)["What came out"].text


def test_the_published_page_and_docs_give_the_start_as_its_rows_do():
    root = Path(__file__).parents[2]
    published = (root / "reports" / "published" / "tuning" / "report.md").read_text()
    docs = (root / "docs" / "tuning.md").read_text()
    rows = re.findall(r"^\| start of the search @ (\w+) +\|(.*)", published, re.MULTILINE)
    assert {engine for engine, _ in rows} == set(tuned()[TUNED])
    for engine, row in rows:
        accuracy, gain = (cell.strip() for cell in row.split("|")[1:3])
        assert f"{accuracy} % on {engine}" in published
        assert f"{gain} points on {engine}" in published
        if engine != "chipmunk":
            assert re.search(rf"{accuracy.split()[0]} % \({engine}\)", docs, re.I)


def test_outcomes_have_the_numbers_of_their_records():
    (table,) = sections(FULL)["What came out"].tables
    assert cells(table, "PS_3 @ bullet") == [
        "400", "89.3 [88.8, 89.8]", "9.2 [8.7, 9.7]", "43.0 [38.7, 47.3]", "0.13 [0.12, 0.14]",
        "1.2 [0.7, 1.7]", "0.7 [0.2, 1.2]",
    ]  # fmt: skip
    assert cells(table, "Tuned @ dart")[1:4] == ["97.1 [96.6, 97.6]", "-", "5.20 [4.68, 5.72]"]


def test_what_the_protocol_brings_is_told_apart_from_what_the_search_brings():
    section = sections(FULL)["What the protocol brings, and what the search brings"]
    assert (
        "- bullet: 88.0 [87.5, 88.5] % (the paper's values); each on top of the one before, 9.0 "
        "[8.5, 9.5] points (the label's protocol), 1.0 [0.5, 1.5] points (tuned)."
    ) in section.text
    (table,) = section.tables
    assert cells(table, "tuned") == [
        "400",
        "98.0 [97.5, 98.5]",
        "1.0 [0.5, 1.5]",
        "9.00 [8.10, 9.90]",
    ]


def test_where_measured_times_come_from_is_said_where_there_are_some():
    assert "*CPU* is measured. Being cheaper" in tuning_page(FULL, {}).summary
    judged = replace(FULL, cost_source=CostSource(CostKind.JUDGING))
    assert "CPU times are of judging, where several" in tuning_page(judged, {}).summary


def test_a_budget_below_all_parameter_sets_buys_nothing():
    section = sections(FULL)["The price of accuracy"]
    matrix, chosen = section.tables
    assert cells(matrix, "1") == ["nothing", "nothing"]
    assert cells(matrix, "10") == ["98.1 [97.6, 98.6], 7.70 ms", "95.7 [95.2, 96.2], 9.10 ms"]
    assert cells(chosen, "bullet", "10") == ["frequency=170", "400", "98.6"]
    assert "- 1 ms a layout buys nothing on any engine." in section.text
    assert "- 10 ms a layout buys 98.1 [97.6, 98.6] % on bullet" in section.text


def test_searches_and_parameters_in_their_tables():
    found = sections(FULL)
    row = cells(found["The searches"].tables[0], "bullet", "genetic")
    assert row[:5] == ["61", "0.9100 → 0.9731", "92.0 → 98.4", "14.4 → 5.10", "0.810"]
    assert row[5:] == ["90 min", "2.5 min", "all", "1", "40 x 2", "23", "38", "19"]
    genes = found["What was searched and found"]
    assert cells(genes.tables[0], "frequency", "Hz") == ["30 to 480 by 10", "60", "170"]
    assert "- bullet: 2 of 3 parameters left" in genes.text
    assert genes.text.endswith("; friction stayed.")
    assert "nsga2, 0.840 against 0.810 (genetic)" in (found["Genetic against multi-objective"].text)
    assert cells(found["How cost is modelled"].tables[0], "bullet") == [
        "60", "0.987", "6.1", "3.14",
    ]  # fmt: skip


def test_luck_is_a_mean_a_range_and_what_differs():
    section = sections(FULL)["How much luck"]
    assert "98.2 % on average, from 98.0 to 98.4 %" in section.text
    assert (
        "5.00 ms, from 4.00 to 6.00 ms. Seeds differ in 1 of 2 parameters: frequency."
        in section.text
    )
    assert "friction" not in str(section.tables[0])
    assert cells(section.tables[0], "2")[-1] == "190"
    same = [replace(row, values=FULL.seeds[0].values) for row in FULL.seeds]
    text = sections(replace(EMPTY, seeds=tuple(same)))["How much luck"].text
    assert "All seeds found the same parameters." in text


def test_what_goes_back_at_no_loss_is_told_by_the_interval():
    text = sections(FULL)["Physical or fitted"].text
    assert "at no loss: friction; accuracy is lost by: restitution (-2.0 [-2.5, -1.5])." in text
    gain = sections(FULL)["What the gain is made of"].text
    assert "1 of 2 changes cost accuracy, most of all start of friction (-3.1" in gain
    assert "no early exit costs the most time, ×2.5" in gain


@pytest.mark.parametrize(
    ("leads", "answer", "apart"),
    [
        ((0.03, 0.02), "A tuning belongs to its engine.", "ahead in 2 and behind in 0; 0 are"),
        ((0.001, -0.02), "is seen to be better there", "ahead in 0 and behind in 1; 1 are"),
        ((0.03, 0.0), "belongs to its engine in part", "ahead in 1 and behind in 0; 1 are"),
    ],
)
def test_whose_a_tuning_is_follows_the_pairs(leads, answer, apart):
    table = transfer(PAIR, {PAIR: leads[0], PAIR[::-1]: leads[1]})
    (section,) = sections(replace(EMPTY, transfer=(table,))).values()
    assert answer in section.text
    assert apart in section.text
    mean = 98.0 - 50.0 * sum(leads)
    assert (
        f"98.0 % accurate on the engine that they were tuned on, and {mean:.1f} %" in section.text
    )
    assert "dart has no such setting as margin, restitution" in section.text
    own, taken = cells(section.tables[0], "bullet")
    assert own == "98.0 [97.5, 98.5]"
    assert taken.startswith(f"{98.0 - 100.0 * leads[0]:.1f} [")


def test_a_front_has_what_no_other_point_beats():
    generator = np.random.default_rng(4)
    points = [
        JudgedGenotype(float(a), float(c), on_front=True) for a, c in generator.random((60, 2))
    ]
    beaten = {
        p for p in points if any(q.accuracy >= p.accuracy and q.cost < p.cost for q in points)
    }
    assert set(front(points)) == set(points) - beaten
    assert not front([replace(p, on_front=False) for p in points])


def test_the_price_is_drawn_where_the_records_say():
    (axes,) = plot_price(FULL).axes
    drawn = {
        (float(x), round(float(y), 6))
        for line in axes.lines
        for x, y in zip(line.get_xdata(), line.get_ydata(), strict=True)
    }
    for outcome in [t for table in FULL.tests for t in (table.tuned, *table.others)]:
        assert (outcome.cpu.value, round(100 * outcome.accuracy.value, 6)) in drawn
    assert {(7.7, 98.1), (9.1, 95.7), (9.0, 98.4)} <= drawn
    height = {p: axes.transData.transform((1.0, p))[1] for p in (89.0, 90.0, 98.0, 99.0)}
    assert height[99.0] - height[98.0] > 5 * (height[90.0] - height[89.0])
    assert axes.get_ylim()[0] < 89.3


def test_an_inaccurate_and_a_dear_method_are_in_sight():
    poor = replace(held_against("chipmunk").others[0], accuracy=about(0.71), cpu=about(320.0, 9.0))
    table = replace(held_against("chipmunk"), others=(poor,))
    (axes,) = plot_price(replace(EMPTY, tests=(table,))).axes
    assert axes.get_ylim()[0] < 71.0
    assert axes.get_xlim()[1] > 329.0


def test_seeds_that_cross_are_no_rank():
    def rows(*volumes):
        found = ("genetic", "genetic", "nsga2", "nsga2")
        pairs = zip(found, volumes, strict=True)
        return tuple(search("bullet", a, k, v) for k, (a, v) in enumerate(pairs))

    def text(*volumes):
        found = sections(replace(EMPTY, searches=rows(*volumes)))
        return found["Genetic against multi-objective"].text

    assert "that of nsga2, 0.850 against 0.815 (genetic);" in text(0.81, 0.82, 0.83, 0.87)
    crossed = text(0.81, 0.84, 0.83, 0.87)
    assert "that of nsga2, 0.850 against 0.825 (genetic), not with every seed" in crossed
    assert "the same fitness (0.9731)" in crossed


@pytest.mark.parametrize("accuracy", [0.0, 1.0])
def test_the_ends_of_the_scale_can_be_drawn(accuracy, tmp_path):
    point = (JudgedGenotype(accuracy, 2.0, on_front=True),)
    searches = [replace(s, judged=point) for s in FULL.searches]
    low, high = plot_algorithms({"bullet": searches}).axes[1].get_ylim()
    assert low < high
    assert low <= 100 * accuracy
    assert 100 * min(accuracy, 0.9995) <= high


def test_large_losses_do_not_hide_small_ones():
    small = plot_changes([changes(("a", -0.004, 1.0), ("b", -0.02, 1.0))]).axes[0]
    large = plot_changes([changes(("a", -0.004, 1.0), ("b", -0.6, 1.0))]).axes[0]
    assert (small.get_xscale(), large.get_xscale()) == ("linear", "symlog")
    assert large.get_xlim()[0] < -60.5
    place = large.transAxes.inverted().transform(large.transData.transform((-0.4, 0.0)))[0]
    zero = large.transAxes.inverted().transform(large.transData.transform((0.0, 0.0)))[0]
    assert zero - place > 0.05


def test_times_and_factors_read_in_their_size():
    assert [duration(s) for s in (4.2, 99.0, 150.0, 5400.0, 90000.0)] == [
        "4.2 s", "99 s", "2.5 min", "90 min", "25 h",
    ]  # fmt: skip
    assert factor(Estimate(0.123, 0.0998, 2.0, 9)) == "0.12 [0.10, 2.0]"
    assert factor(None) == "-"
