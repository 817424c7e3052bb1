"""Rows of the study of tuning, and the page that is made of them."""

import re
import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from steadyload.methods.naming import MethodKey
from steadyload.methods.tuned import TUNED, tuned
from steadyload.reports.pages.writing import write_page
from steadyload.reports.table import duration, factor
from steadyload.statistics.estimate import Estimate
from steadyload.studies.kit import Lab
from steadyload.studies.tuning import searching
from steadyload.studies.tuning.comparing import _Judged, _transferred, _within_budgets
from steadyload.studies.tuning.presets import Found
from steadyload.studies.tuning.searching import (
    Gene,
    Generation,
    Point,
    Searching,
    algorithms,
    genes,
    spread,
)
from steadyload.studies.tuning.study import Tuning
from steadyload.tuning import TuningError
from steadyload.tuning.ledger import Entry, Ledger
from steadyload.tuning.trial import TrialResult

ROOT = Path(__file__).parents[2]
SEARCHES = ROOT / "reports/published/tuning/searches"


def about(value, half=0.005):
    return Estimate(value, value - half, value + half, 400)


def outcome(family, engine="bullet", accuracy=0.98, cpu=5.0, **more):
    key = MethodKey(f"{family} @ {engine}", f"{family}@{engine}", family, engine)
    return {
        "key": key, "title": key.title, "engine": engine, "right": about(accuracy),
        "over": about(0.012), "under": about(0.007), "right_robust": None,
        "cpu": about(cpu, 0.1 * cpu), "ahead": None, "cost_ratio": None, **more,
    }  # fmt: skip


def on_engine(engine="bullet", *, accuracy=0.985, gain=0.013):
    return [
        outcome(TUNED, engine, accuracy, 5.2),
        outcome("ps3", engine, 0.893, 43.0, ahead=about(0.092), cost_ratio=about(0.13, 0.01)),
        outcome("ps5", engine, 0.905, 71.0, ahead=about(0.08), cost_ratio=about(0.07, 0.01)),
        outcome("label", engine, 0.972, 9.0, ahead=about(gain), cost_ratio=about(0.6)),
    ]


def search(name, engine="bullet", algorithm="genetic", volume=0.81, fitness=0.9731):
    return Searching(
        name=name, engine=engine, algorithm=algorithm, fitness=(0.91, fitness),
        accuracy=(0.92, 0.984), cost=(14.4, 5.1), hypervolume=volume, cpu=5400.0, wall=150.0,
        space="extended", seed=1, population=(40, 2), genotypes=61, whole=23, abandoned=38,
        repeats=19, known=2, parameter_sets=60, correlation=0.987, error=0.061,
        microseconds={"substep": 3.14}, cases="240 of part `validation` of the large set",
        goal=8.6, changed=(2, 3),
        history=[Generation(name, 20 * k, 0.9 + 0.02 * k, 0.5 + 0.1 * k) for k in (1, 2)],
    )  # fmt: skip


def frame(*rows):
    return pd.DataFrame(rows)


def carried(tuned_on, judged_on, ahead=None):
    gain = 0.0 if ahead is None else -ahead.value
    pair = {"tuned_on": tuned_on, "judged_on": judged_on, "ignored": "margin", "gain": gain}
    return outcome("x", judged_on, ahead=ahead, **pair)


ALONE = {
    "genes": [Gene("frequency (Hz)", "30 to 480, step 10", "60", {"bullet": "170", "dart": "90"})],
    "searches": [search("ga"), search("nsga", algorithm="nsga2", volume=0.84), search("d", "dart")],
    "algorithms": algorithms([search("ga"), search("nsga", algorithm="nsga2", volume=0.84)]),
    "made_with": {"commit": "abc"},
}
GROUPS, EVERYTHING, PHYSICAL = (
    frame(*(
        outcome("x", change=name, values="0.5", accuracy_change=about(change), cost_change=2.5)
        for name, change in changes.items()
    ))
    for changes in ({"gaps": -0.002, "friction": -0.031}, {"everything": -0.1}, {"margin": 0.0})
)  # fmt: skip
TESTED = [*on_engine(), *on_engine("dart", accuracy=0.971, gain=0.002)]
FULL = Found(
    **ALONE,
    parts=[
        {
            "part": "test", "rows": frame(*TESTED), "home": 0.97, "away": 0.92, "better": 1,
            "worse": 0, "alike": 1,
            "carried": frame(
                carried("bullet", "bullet"), carried("dart", "bullet", about(0.03)),
                carried("bullet", "dart", about(0.001)), carried("dart", "dart"),
            ),
        }
    ],
    shown=TESTED,
    gains=frame(*(
        {"question": question, "engine": engine, "start": about(start), "preset": about(found),
         "gain": about(gain), "shown": 0.007}
        for question, engine, start, found, gain in (
            ("within", "bullet", 0.92, 0.95, 0.03), ("stands", "bullet", 0.9, 0.95, 0.05),
            ("stands", "dart", 0.94, 0.94, 0.001),
        )
    )),
    steps=frame(outcome("paper", accuracy=0.88, gain=None), outcome("tuned", gain=about(0.1))),
    groups=GROUPS,
    everything=EVERYTHING,
    left_out=pd.concat([GROUPS, EVERYTHING]),
    most=GROUPS.iloc[1],
    physical=PHYSICAL,
    bought=frame(*(
        outcome("bought", engine, accuracy, 7.7, budget="10", validation=0.9861,
                values="frequency=170")
        for engine, accuracy in (("bullet", 0.957), ("dart", 0.981))
    )),
    fronts=[Point("bullet", 2.0, 0.9), Point("bullet", 9.0, 0.984)],
    luck=[
        {
            "engine": "bullet", "right": spread([0.98, 0.984]), "cpu": spread([4.0, 6.0]),
            "genes": 2, "differing": 1,
            "seeds": frame(*(
                outcome("s", seed=s, fitness=0.97, validation=0.985, **{"gene:frequency": s})
                for s in (1, 2)
            )),
        }
    ],
)  # fmt: skip
STUDY = Tuning(searches=(), limit=None, write_presets=False)


def test_the_page_of_all_results(tmp_path, assert_drawn):
    path = write_page(STUDY.page(FULL), tmp_path)
    [beside] = tmp_path.glob("report-details.*.md")
    written = path.read_text() + beside.read_text()
    text = " ".join(written.split())
    for said in (
        "adds at most 5.0 [4.5, 5.5] points of accuracy to the parameters that it starts with, on "
        "bullet for the question *stands*; it adds significantly for 2 of 3 pairs of engine and "
        "question. Of the groups of parameters the friction brings most, on bullet.",
        "| stands | dart | 400 | 94.0 [93.5, 94.5] | 94.0 [93.5, 94.5] | 0.1 [-0.4, 0.6] |",
        "| frequency (Hz) | 30 to 480, step 10 | 60 | 170 | 90 |",
        "3 searches judged 183 genotypes in 4.5 h of CPU time, 69 of them on all cases; the other "
        "114 were abandoned before.",
        "| ga | bullet | genetic | 0.9100 → 0.9731 | 92.0 → 98.4 | 14.4 → 5.10 |",
        "largest mean hypervolume is that of nsga2",
        "are right on 98.2 % on average, from 98.0 to 98.4 %, in 5.00 ms, from 4.00 to 6.00 ms. "
        "They differ in 1 of 2 parameters",
        "makes up for something else",
        "more accurate: 1; less: 0; neither: 1.",
        "| dart | 60 | 0.987 | 6.1 | 3.14 |",
    ):
        assert said in text
    pictures = re.findall(r"!\[.*?\]\((.*?)\)", written)
    assert len(pictures) == 7
    for name in pictures:
        assert_drawn(tmp_path / name)


def test_the_page_of_one_search_has_its_sections_alone(tmp_path, undrawn):
    alone = Found(**ALONE | {"searches": ALONE["searches"][:1], "algorithms": []})
    page = STUDY.page(alone)
    assert "are right on 98.4 % of the cases at 5.10 ms, those that the" in page.summary
    assert [section.title for section in page.details] == [
        "Parameters that were searched", "The searches", "How cost is modelled",
        "How to read this page",
    ]  # fmt: skip
    write_page(page, tmp_path)


def test_means_at_home_and_elsewhere_and_what_is_significant_there():
    """A difference is significant where its interval is on one side of 0."""
    carried = {("a", "a"): ("own", ()), ("b", "a"): ("x", ("margin",)), ("c", "a"): ("y", ())}
    rows = pd.DataFrame(
        {"right": [about(0.98), about(0.9), about(0.94), about(0.96)]}, ["own", "x", "y", "z"]
    )
    ahead = {("own", "x"): about(0.08), ("own", "y"): about(0.004)}
    found = _transferred(_Judged(rows, rows, pd.Series(ahead)), carried)
    assert (found["home"], found["away"]) == pytest.approx((0.98, 0.92))
    assert (found["better"], found["worse"], found["alike"]) == (1, 0, 1)
    shown = found["carried"]
    assert list(shown["gain"]) == [0.0, -0.08, -0.004]
    assert list(shown["ignored"]) == ["-", "margin", "-"]
    ahead[("own", "x")] = about(-0.02)
    found = _transferred(_Judged(rows, rows, pd.Series(ahead)), carried)
    assert (found["better"], found["worse"], found["alike"]) == (0, 1, 1)


def test_engines_show_the_search_that_found_the_preset_and_the_one_that_judged_most():
    few = replace(search("few"), genotypes=16)
    found = Found(**ALONE | {"searches": [search("d", "dart"), few, search("many")]})
    assert [one.name for one in found.finders] == ["few", "d"]
    assert {one.name for one in found.largest} == {"many", "d"}


def test_algorithms_are_compared_on_one_engine_and_in_one_space():
    one, other = search("ga"), search("nsga", algorithm="nsga2")
    assert algorithms([one, replace(other, engine="dart")]) == []
    assert algorithms([one, replace(other, space="table3")]) == []
    first, second = algorithms([one, search("again", volume=0.85), other])
    assert (first.algorithm, first.searches, first.hypervolume) == (
        "genetic", 2, Estimate(pytest.approx(0.83), 0.81, 0.85, 2),
    )  # fmt: skip
    assert (second.algorithm, len(first.history)) == ("nsga2", 4)
    both = [replace(s, space=space) for s in (one, other) for space in ("extended", "table3")]
    assert {row.searched for row in algorithms(both)} == {"bullet, extended", "bullet, table3"}


def test_a_parameter_stands_apart_where_its_values_or_its_start_are_others(monkeypatch):
    values = {
        "bullet": [("friction", "0.3, 0.5", "0.5", "0.3"), ("margin (m)", "0, 1", "0", "1")],
        "dart": [("friction", "0.3, 0.5", "0.5", "0.5"), ("margin (m)", "0, 2", "0", "2")],
    }
    monkeypatch.setattr(searching, "_values", lambda one: values[one.options.engine])
    found = genes(SimpleNamespace(options=SimpleNamespace(engine=engine)) for engine in values)
    assert found == [
        Gene("friction", "0.3, 0.5", "0.5", {"bullet": "0.3", "dart": "0.5"}),
        Gene("margin (m)", "0, 1", "0", {"bullet": "1"}),
        Gene("margin (m)", "0, 2", "0", {"dart": "2"}),
    ]


def test_a_budget_buys_the_most_accurate_set_that_costs_no_more():
    front = [Entry((k,), 0, TrialResult(np.ones(1, bool), np.array([cost])))
             for k, cost in enumerate((2.0, 3.0, 9.0))]  # fmt: skip
    space = SimpleNamespace(spec=lambda genotype: f"simulation@mujoco:frequency={90 + genotype[0]}")
    found = list(_within_budgets([SimpleNamespace(space=space, whole=lambda: front)], front))
    assert [(budget, entry.genotype) for budget, entry, _ in found] == [
        (3.0, (1,)), (10.0, (2,)), (30.0, (2,)),
    ]  # fmt: skip
    assert found[0][2] == "simulation@mujoco:frequency=91"


def test_searches_of_one_name_are_refused_and_others_are_kept_beside_the_page(tmp_path):
    kept = tmp_path / "chipmunk-seed-0"
    shutil.copytree(SEARCHES / kept.name, kept)
    with pytest.raises(TuningError, match="chipmunk-seed-0, chipmunk-seed-0; allowed: names that"):
        replace(STUDY, searches=(kept, SEARCHES / kept.name))
    replace(STUDY, searches=(kept,)).beside(FULL, tmp_path / "page")
    again = Ledger.of(tmp_path / "page/searches" / kept.name)
    assert again[1].entries.keys() == Ledger.of(kept)[1].entries.keys()


def test_presets_are_written_before_they_are_compared(tmp_path, monkeypatch):
    monkeypatch.setattr("steadyload.methods.tuned.FILE", tmp_path / "tuned.json")
    monkeypatch.setattr(
        "steadyload.studies.tuning.comparing.compare",
        lambda lab, searches, limit: (tuned(), [one.name for one in searches], limit),
    )
    study = replace(STUDY, searches=(SEARCHES / "chipmunk-seed-0",), write_presets=True, limit=7)
    presets, names, limit = study.run(Lab(tmp_path))
    assert list(presets) == ["chipmunk"]
    assert (names, limit) == (["chipmunk-seed-0"], 7)
    assert str(tmp_path / "tuned.json") in study.remarks(FULL)[0]
    assert STUDY.remarks(FULL) == []


def test_times_and_factors_read_in_their_size():
    assert [duration(s) for s in (4.2, 99.0, 150.0, 5400.0, 90000.0)] == [
        "4.2 s", "99 s", "2.5 min", "90 min", "25 h",
    ]  # fmt: skip
    assert factor(Estimate(0.123, 0.0998, 2.0, 9)) == "0.12 [0.10, 2.0]"
    assert factor(None) == "-"
