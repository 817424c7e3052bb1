"""The benchmark measures what it says, keeps its figures, and shows them."""

import json
from dataclasses import asdict, replace

import pytest

from steadyload.atomic import manifest_text
from steadyload.cli import main
from steadyload.config import ConfigError, bind
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.layout import Layout, LayoutError
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods.contract.declared import Trait
from steadyload.methods.contract.method import Status, Verdict
from steadyload.methods.registry import make_method
from steadyload.methods.session.session import LoadingSession
from steadyload.progress import silent
from steadyload.statistics.estimate import Estimate
from steadyload.studies.kit import Lab
from steadyload.studies.speed import measuring, running, scenes, study
from steadyload.studies.speed.measuring import Job, measure
from steadyload.studies.speed.records import CaseSet, Cost, Found, Growth, GrowthPoint
from steadyload.studies.speed.running import grown, step_shares
from steadyload.studies.speed.scenes import PILES, Extent, Source, case_sets, joined
from steadyload.studies.speed.study import FILE, Speed

TINY = Extent(repeats=2, draws=2, most_items=20, patience=1.0, limit=2)
SPECS = ("sme", "equilibrium:sides=frictionless")


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


def test_what_is_measured_is_kept_printed_and_shown_again(
    layout_file, capsys, monkeypatch, assert_drawn
):
    monkeypatch.setattr(scenes, "QUICK", TINY)
    out = layout_file.parent / "out"
    monkeypatch.setattr(study, "METHODS", SPECS)
    words = ["study", "speed", "--limit", "2", "--layouts", str(layout_file)]
    assert main([*words, "-o", str(out), "--json"]) == 0
    printed = strictly(capsys.readouterr().out)
    kept = (out / FILE).read_bytes()
    assert strictly(kept.decode()).items() >= printed.items()

    found = bind(Found, printed, "what was printed")
    assert [(c.name, c.layouts) for c in found.cases] == [("validation", 6), ("mine", 2)]
    assert found.quick
    by = {(cost.cases, cost.method): cost for cost in found.costs}
    assert set(by) == {(cases, spec) for cases in ("validation", "mine") for spec in SPECS}
    for (_, spec), cost in by.items():
        taken = [cost.judge, cost.placement, *([cost.batch] if spec == "sme" else [])]
        assert all(time.value > 0.0 and time.n == 2 for time in taken)
        assert spec == "sme" or cost.batch is cost.position is None
    curves = {(scene, spec) for scene in (PILES, "mine") for spec in SPECS}
    assert {(one.scene, one.method) for one in found.growth} == curves
    on_piles = [p for p in found.points if (p.scene, p.method) == (PILES, "sme")]
    assert [(p.items, p.judge.n) for p in on_piles] == [(10, 2), (20, 2)]

    monkeypatch.setattr(running, "run_speed", None)  # the last page measures nothing
    assert main(["study", "speed", "--last", "-o", str(out)]) == 0
    assert capsys.readouterr().out == f"{out / 'report.md'}\n"
    assert (out / FILE).read_bytes() == kept
    assert_drawn(*(out / "figures").glob("growth.*.svg"))


def test_work_is_done_in_turns_and_not_repeated_once_it_took_long():
    done = []

    def work(name, seconds):
        def one():
            done.append(name)
            return seconds

        return one

    jobs = [Job(work("a", 0.5), 10), Job(work("b", 1e-3)), Job(work("c", 4.0), 2)]
    measure(jobs, 3, silent, enough=6.0)
    assert done[:3] == ["a", "b", "c"]  # once before
    assert "".join(done[3:]) == "abbc" + "bbca" + "abb"
    assert [job.seconds for job in jobs] == [[0.05] * 3, [1e-3] * 3, [2.0] * 2]


def test_growth_has_the_exponents_of_the_times(monkeypatch):
    """Times are set: those of single judgements grow as J^1.3, those of batches as J^2."""

    def grows(power):
        return lambda method, layouts: Job(lambda: 1e-2 * len(layouts[0]) ** power)

    monkeypatch.setattr(running, "judging", grows(1.3))
    monkeypatch.setattr(running, "judging_together", grows(2.0))
    monkeypatch.setattr(running, "ITEM_COUNTS", (5, 10, 12, 50))
    layouts = [x.first(12) for x in random_layouts(40, seed=5) if len(x) >= 12]
    sme = make_method("sme")
    sources = [Source(x, 10) for x in layouts]
    extent = Extent(repeats=2, patience=1.0)
    (growth,), points = grown({"sme": sme}, {"some": lambda method: sources}, extent)
    stand = {n: sum(sme.judge(x.first(n)).stable for x in layouts) for n in (5, 10, 12)}
    assert {p.items: p.judge.n for p in points} == stand
    assert {p.items: p.joined for p in points} == {5: 0, 10: 0, 12: stand[12]}
    assert growth.exponent.value == pytest.approx(1.3)
    assert growth.batch.value == pytest.approx(2.0)
    assert growth.late is None


def test_large_layouts_are_joined_of_what_a_method_calls_safe():
    layouts = [x for x in random_layouts(60, seed=8) if len(x) >= 10]
    sme = make_method("sme")
    sources = joined("some", layouts, Extent(draws=3, most_items=40, patience=1.0), sme)
    assert len(sources) == 3
    for source in sources:
        assert len(source.layout) >= 40
        assert 10 <= source.alone <= 20
        assert sme.judge(source.layout).stable
        first = source.layout.first(source.alone).items
        assert any(
            [(i.position, i.size) for i in x.items[: source.alone]]
            == [(i.position, i.size) for i in first]
            for x in layouts
        )


class _Slow:
    """A method that has no verdict in time on layouts with an even number of items."""

    def judge(self, layout, *, timeout=None):
        return Verdict(len(layout), Status.DONE if len(layout) % 2 else Status.TIMEOUT)


def test_layouts_without_a_verdict_are_left_out_and_counted(monkeypatch):
    layouts = random_layouts(25, seed=2)
    odd = [x for x in layouts if len(x) % 2]
    assert running._judged(_Slow(), layouts, 1.0) == (odd, 25 - len(odd))
    monkeypatch.setattr(running, "_LONGEST", -1.0)
    few = [layouts[0], layouts[10], layouts[20]]
    kept = [x for x in few if len(x) % 2]
    assert running._judged(_Slow(), layouts, 1.0) == (kept, 3 - len(kept))


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
    job = measuring.judging_positions(make_method("sme"), layout)
    assert job.work() >= 0.0
    assert asked == [(len(layout) - 1, layout.items[-1])]


def test_steps_are_shown_of_methods_that_count_them():
    class Counting:
        traits = frozenset((Trait.MOVEMENT,))

        def step_counts(self, layout):
            return (10, 9, 1) if layout == "flat" else (10, 6, 2)

    assert step_shares(make_method("sme"), []) == {}
    found = step_shares(Counting(), ["flat", "high"])
    assert (found["steps"], found["kept"].value, found["asked"].value) == (20, 0.75, 0.15)


TEN = Estimate(10.0, 9.0, 11.0, 9)
RUN = Found(
    date="2026-11-22", quick=False, load=1.0, patience=2.0,
    cases=[CaseSet("validation", 900, 9.4, TEN, TEN), CaseSet("mine", 3, 20.0, TEN, TEN)],
    costs=[
        Cost("validation", "fbs", 900, 0, 4000, TEN, TEN, TEN, TEN, 10, TEN, TEN),
        Cost("mine", "fbs", 2, 1, 9, Estimate(2e5, 1e5, 4e5, 9)),
    ],
    growth=[Growth("mine", "fbs", TEN, None, None)],
    points=[GrowthPoint("mine", "fbs", 10, 1, TEN, None)],
    made_with={"processor": "this"},
)  # fmt: skip


def test_the_page_shows_what_was_found():
    page = Speed().page(RUN)
    assert page.summary.startswith(
        "A judgement of a layout of 9.4 items on average takes 10.0 us of CPU time by FBS; larger"
    )
    assert "on this, one core, warm" in page.summary
    sections = [*page.sections, *page.details]
    text = "\n".join(str(block) for section in sections for block in section.placed)
    for shown in (
        "**Labelled set, validation**: 900 layouts", "100,000 [90,900, 111,000]",
        "**File `mine`**", "FBS: 1 of 3 layouts had no verdict within 2 s",
        "| FBS    |   9 | 10.00 [9.00, 11.00]",
    ):  # fmt: skip
        assert shown in text
    told = Speed().page(replace(RUN, quick=True, load=4.0)).summary
    for words in ("A quick run", "The machine was busy"):
        assert words in told


def test_a_damaged_file_of_figures_is_refused(tmp_path):
    (tmp_path / FILE).write_text(manifest_text({**asdict(RUN), "costs": 3}))
    with pytest.raises(ConfigError, match=r"times\.json: costs is 3; allowed: a list"):
        Speed(last=True).run(Lab(tmp_path))


def test_sets_of_one_name_and_empty_files_are_refused(layout_file):
    with pytest.raises(LayoutError, match="two sets of layouts are called 'mine'"):
        case_sets([layout_file, layout_file], 1)
    path = layout_file.with_name("none.json")
    path.write_text('{"format": "steadyload-layouts", "version": 1, "layouts": []}')
    with pytest.raises(LayoutError, match=r"none\.json"):
        case_sets([path], 1)
