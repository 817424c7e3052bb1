"""The benchmark measures what it says, keeps its figures."""

import json
import math
from dataclasses import replace

import pytest

from steadyload.atomic import manifest_text, write_atomically
from steadyload.cli import main
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.layout import Layout, LayoutError
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods.contract.declared import Trait
from steadyload.methods.contract.method import Status, Verdict
from steadyload.methods.registry import make_method
from steadyload.methods.session.session import LoadingSession
from steadyload.progress import silent
from steadyload.statistics.estimate import Estimate
from steadyload.stored import StoredFileError
from steadyload.studies.speed import config, growth, measuring, study
from steadyload.studies.speed.growth import growth_curves
from steadyload.studies.speed.kept import FILE, keep, last_run
from steadyload.studies.speed.measuring import Job, measure
from steadyload.studies.speed.page import speed_page
from steadyload.studies.speed.records import (
    CaseSet,
    Cost,
    GrowthCurve,
    GrowthPoint,
    Kind,
    SpeedRun,
    StepShares,
)
from steadyload.studies.speed.scenes import Cases, Scene, Source, cases_of, check_names, growing
from steadyload.studies.speed.steps import step_shares

TINY = study.Extent(repeats=2, draws=2, most_items=20, patience=1.0)


@pytest.fixture
def tiny(monkeypatch):
    """Quick runs are shorter still."""
    monkeypatch.setattr(study, "QUICK", TINY)
    monkeypatch.setattr(config, "_FEW", 2)


@pytest.fixture
def layout_file(tmp_path):
    path = tmp_path / "mine.json"
    write_layouts(path, random_layouts(12, seed=3), Format.NATIVE)
    return path


def strictly(text):
    """JSON without numbers that are none."""

    def refuse(name):
        raise AssertionError(name)

    return json.loads(text, parse_constant=refuse)


def test_the_command_writes_page_and_figures(tiny, layout_file, capsys, assert_drawn):
    out = layout_file.parent / "out"
    words = ["bench", "--quick", "-m", "sme", "-m", "equilibrium:sides=frictionless"]
    assert main([*words, "--layouts", str(layout_file), "-o", str(out)]) == 0
    assert capsys.readouterr().out == f"{out / 'report.md'}\n"
    text = (out / "report.md").read_text()
    for told in ("# What a judgement costs", "an empty verdict", "**File `mine`**", "placements",
                 "## Growth to 20 items", "A quick run"):  # fmt: skip
        assert told in text
    [growth] = (out / "figures").glob("growth.*.svg")
    assert_drawn(growth)

    assert main([*words, "--layouts", str(layout_file), "-o", str(out), "--json"]) == 0
    printed = strictly(capsys.readouterr().out)
    assert strictly((out / FILE).read_text()).items() >= printed.items()

    measured = {(c["cases"], c["kind"], c["method"]) for c in printed["costs"]}
    for cases in ("validation", "mine"):
        assert {(cases, "loop", ""), (cases, "empty", ""), (cases, "batch", "sme")} <= measured
        for spec in ("sme", "equilibrium:sides=frictionless"):
            assert {(cases, "judge", spec), (cases, "place", spec)} <= measured
        assert (cases, "batch", "equilibrium:sides=frictionless") not in measured
    assert all(c["microseconds"]["value"] > 0.0 for c in printed["costs"])
    assert all(c["microseconds"]["n"] == 2 for c in printed["costs"])
    assert {(c["scene"], c["method"]) for c in printed["growth"]} == {
        (scene, spec)
        for scene in ("piles", "mine")
        for spec in ("sme", "equilibrium:sides=frictionless")
    }
    on_piles = next(c for c in printed["growth"] if (c["scene"], c["method"]) == ("piles", "sme"))
    assert [(p["items"], p["microseconds"]["n"]) for p in on_piles["points"]] == [(10, 2), (20, 2)]


def test_work_is_done_in_turns_and_not_repeated_once_it_took_long():
    done = []

    def work(name, seconds):
        def one():
            done.append(name)
            return seconds

        return one

    jobs = [Job("a", 10, work("a", 0.5)), Job("b", 1, work("b", 1e-3)), Job("c", 2, work("c", 4.0))]
    measure(jobs, 3, silent, enough=6.0)
    assert done[:3] == ["a", "b", "c"]  # once before
    assert "".join(done[3:]) == "abbc" + "bbca" + "abb"
    assert [job.seconds for job in jobs] == [[0.05] * 3, [1e-3] * 3, [2.0] * 2]


def test_growth_has_the_exponents_of_the_times(monkeypatch):
    """Times are set: those of single judgements grow as J^1.3, those of batches as J^2."""
    monkeypatch.setattr(growth, "judging", lambda m, x: lambda: 1e-2 * len(x[0]) ** 1.3)
    monkeypatch.setattr(
        growth, "judging_together", lambda m, x: lambda: 1e-3 * len(x) * len(x[0]) ** 2
    )
    layouts = [x.first(12) for x in random_layouts(40, seed=5) if len(x) >= 12]
    sme = make_method("sme")
    sources = [Source(x, 10) for x in layouts]
    scene = Scene("some", lambda method, patience: sources)
    (curve,) = growth_curves({"sme": sme}, [scene], (5, 10, 12, 50), repeats=2, patience=1.0)
    stand = {n: sum(sme.judge(x.first(n)).stable for x in layouts) for n in (5, 10, 12)}
    assert {p.items: p.microseconds.n for p in curve.points} == stand
    assert {p.items: p.joined for p in curve.points} == {5: 0, 10: 0, 12: stand[12]}
    assert curve.exponent.value == pytest.approx(1.3)
    assert curve.batch.value == pytest.approx(2.0)
    assert curve.late.n == 0


def test_large_layouts_are_joined_of_what_a_method_calls_safe():
    cases = Cases("some", tuple(x for x in random_layouts(60, seed=8) if len(x) >= 10))
    sme = make_method("sme")
    sources = growing(cases, 40, 3).sources(sme, 1.0)
    assert len(sources) == 3
    for source in sources:
        assert len(source.layout) >= 40
        assert 10 <= source.alone <= 20
        assert sme.judge(source.layout).stable
        first = source.layout.first(source.alone).items
        assert any(
            [(i.position, i.size) for i in x.items[: source.alone]]
            == [(i.position, i.size) for i in first]
            for x in cases.layouts
        )


class _Slow:
    """A method that has no verdict in time on layouts with an even number of items."""

    def judge(self, layout, *, timeout=None):
        return Verdict(len(layout), Status.DONE if len(layout) % 2 else Status.TIMEOUT)


def test_layouts_without_a_verdict_are_left_out_and_counted(monkeypatch):
    layouts = random_layouts(25, seed=2)
    odd = [x for x in layouts if len(x) % 2]
    assert study._judged(_Slow(), layouts, 1.0) == (odd, 25 - len(odd))
    monkeypatch.setattr(study, "_LONGEST", -1.0)
    few = [layouts[0], layouts[10], layouts[20]]
    kept = [x for x in few if len(x) % 2]
    assert study._judged(_Slow(), layouts, 1.0) == (kept, 3 - len(kept))


def test_positions_are_measured_where_sessions_judge_them(monkeypatch):
    layout = next(x for x in random_layouts(20, seed=4) if make_method("sme").judge(x).stable)
    asked = []

    def feasible(session, item, positions):
        asked.append((len(session), item))
        assert positions.shape == (1000, 3)
        for position in positions[::50]:
            placed = replace(item, position=tuple(position.tolist()))
            Layout("free", layout.pallet, (*layout.items[:-1], placed))  # overlaps nothing
        assert len(set(positions[:, 1].tolist())) > 1

    monkeypatch.setattr(LoadingSession, "feasible", feasible, raising=False)
    work = measuring.judging_positions(make_method("sme"), layout)
    assert work() >= 0.0
    assert asked == [(len(layout) - 1, layout.items[-1])]


def of(kind, method, value, count=900):
    return Cost("validation", kind, method, count, 0, Estimate(value, value, value, 9))


RUN = SpeedRun(
    date="2026-11-22", source="git 1", machine="this", compiled=True, quick=False, load=1.0,
    patience=2.0, cases=(CaseSet("validation", 900, 9.4),),
    costs=(of(Kind.LOOP, "", 0.01), of(Kind.EMPTY, "", 6.0), of(Kind.JUDGE, "sme", 10.0)),
    steps=(), growth=(), made_with={"source": "git 1"},
)  # fmt: skip


def test_steps_are_shown_of_methods_that_count_them():
    class Counting:
        traits = frozenset((Trait.MOVEMENT,))

        def step_counts(self, layout):
            return (10, 9, 1) if layout == "flat" else (10, 6, 2)

    assert step_shares("validation", "sme", make_method("sme"), []) is None
    found = step_shares("validation", "sme", Counting(), ["flat", "high"])
    assert (found.steps, found.kept.value, found.asked.value) == (20, 0.75, 0.15)
    sections = {s.title: s for s in speed_page(replace(RUN, steps=(found,))).sections}
    (table,) = sections["Steps kept and asked"].tables
    assert [c.cell(found) for c in table.columns] == [
        "validation", "SME", "20", "75.0 [60.0, 90.0]", "15.0 [10.0, 20.0]",
    ]  # fmt: skip


def test_the_page_says_when_times_say_little():
    told = speed_page(replace(RUN, compiled=False, quick=True, load=4.0)).summary
    for words in ("**not compiled**", "A quick run", "The machine was busy"):
        assert words in told


def test_the_last_run_is_read_whole(tmp_path):
    assert last_run(tmp_path) is None
    nothing = Estimate(math.nan, math.nan, math.nan, 0)
    points = (GrowthPoint(5, 0, Estimate(1.0, 0.5, 2.0, 8), nothing),)
    curve = GrowthCurve("piles", "sme", points, Estimate(1.5, 1.0, 2.0, 4), nothing, nothing)
    shares = StepShares("validation", "sme", 4, Estimate(0.5, 0.1, 0.9, 4), nothing)
    full = replace(RUN, growth=(curve,), steps=(shares,), load=None)
    keep(RUN, tmp_path)
    keep(full, tmp_path)
    assert repr(last_run(tmp_path)) == repr(full)  # of numbers that are none, which equal nothing
    write_atomically(tmp_path / FILE, manifest_text({**RUN.to_json(), "costs": 3}))
    with pytest.raises(StoredFileError, match=r"times\.json: is damaged"):
        last_run(tmp_path)


def test_the_last_page_is_made_again_without_measuring(tmp_path, capsys, monkeypatch):
    keep(RUN, tmp_path)
    monkeypatch.setattr("steadyload.studies.speed.study.speed_run", None)
    before = (tmp_path / FILE).read_bytes()
    assert main(["bench", "--last", "-o", str(tmp_path)]) == 0
    assert "- source: git 1\n" in (tmp_path / "report.md").read_text()
    assert (tmp_path / FILE).read_bytes() == before


def test_sets_of_one_name_and_empty_files_are_refused(tmp_path):
    one = Cases("mine", tuple(random_layouts(1, seed=1)))
    with pytest.raises(LayoutError, match="two sets of layouts are called 'mine'"):
        check_names([one, one])
    path = tmp_path / "none.json"
    path.write_text('{"format": "steadyload-layouts", "version": 1, "layouts": []}')
    with pytest.raises(LayoutError, match=r"none\.json"):
        cases_of(path, None)
