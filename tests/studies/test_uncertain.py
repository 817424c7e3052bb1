"""``score --uncertain`` and the study of uncertain verdicts."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from steadyload.cli import main
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.parts import LISTS
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.question import Question
from steadyload.methods.registry import make_method
from steadyload.reports.table import percent, plain_percent
from steadyload.runs.pool import IN_THIS_PROCESS
from steadyload.runs.verdict_reliability import Sampling
from steadyload.statics.load_margin import margin_as_planned
from steadyload.studies.kit import Lab
from steadyload.studies.uncertain import sampling
from steadyload.studies.uncertain.cases import SampledMethod, Unit, sample_unit
from steadyload.studies.uncertain.comparing import summarise
from steadyload.studies.uncertain.sampling import Sampled, sampled_cases
from steadyload.studies.uncertain.study import Uncertain


@pytest.fixture(scope="module")
def benchmark():
    return load_benchmark(LISTS)


@pytest.fixture
def layout_file(tmp_path, stack):
    layouts = [stack(0.0, 0.0).renamed("sure"), stack(0.0, 4.7).renamed("unsure")]
    write_layouts(tmp_path / "layouts.json", layouts, Format.NATIVE)
    return str(tmp_path / "layouts.json")


def test_scores_say_how_sure_they_are(layout_file, capsys):
    what = ("--uncertain", "com=5mm,friction=0.1", "--half-width", "0.04")
    assert main(["score", layout_file, "-m", "sme", *what, "--json"]) == 0
    out, err = capsys.readouterr()
    assert err == "sme: has no parameter friction; that it is uncertain has no effect\n"
    sure, unsure = json.loads(out)
    assert (sure["score"], sure["uncertain"]["distribution"]) == (1.0, {"none": 1.0})
    found = unsure["uncertain"]
    # The upper cube stands where its centre of mass deviates by less than 3 mm.
    truth = 0.5 * (1.0 + math.erf(0.3 / 0.5 / math.sqrt(2.0)))
    low, high = found["interval"]
    assert low <= truth <= high <= low + 0.08
    assert found["stands"] == found["distribution"]["none"] == 1.0 - found["distribution"]["1"]
    assert (found["likeliest_step"], found["likeliest_share"]) == (None, found["stands"])
    assert found["expected_score"] == pytest.approx(0.5 + 0.5 * found["stands"])
    assert (found["ending"], found["without_verdict"]) == ("narrow", {})
    assert main(["score", layout_file, "-m", "sme", "--json"]) == 0
    assert "uncertain" not in json.loads(capsys.readouterr().out)[0]


def test_the_table_has_probability_and_distribution(layout_file, capsys):
    what = ("--uncertain", "com=5mm", "--samples", "64")
    assert main(["score", layout_file, "-m", "sme", *what]) == 0
    header, sure, unsure = capsys.readouterr().out.splitlines()
    assert "stands %" in header
    assert "100.0 [94.4, 100.0]" in sure  # 0.025 ** (1 / 64), of a single look
    assert re.search(r" none \(7\d %\), 2 \(2\d %\) ", unsure), "boxes are counted from 1"
    assert "more samples would narrow the interval" in unsure


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--uncertain", "comm=5mm"), "did you mean 'com'?"),
        (("--uncertain", "com=5mm", "--decide", "2"), "decide is 2; allowed: a number, 0 to 1"),
        (("--uncertain", "com=5mm", "--half-width", "x"), "allowed: a finite number"),
        (
            ("--uncertain", "com=5mm", "--samples", "5"),
            "most is 5; allowed: a whole number, 64 to 65,536",
        ),
        (("--decide", "0.9"), "need --uncertain"),
    ],
)
def test_bad_input_is_one_sentence(layout_file, capsys, arguments, message):
    assert main(["score", layout_file, *arguments]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert message in err


@pytest.mark.parametrize("place", [0, -1])
def test_an_invalid_layout_has_no_outlook_and_hides_no_remark(place, tmp_path, layout_file, capsys):
    content = json.loads(Path(layout_file).read_text())
    content["layouts"][place]["items"][0]["weight"] = 0
    (tmp_path / "bad.json").write_text(json.dumps(content))
    what = ("--skip-invalid", "--uncertain", "com=5mm,friction=0.1", "--samples", "64")
    command = ["score", str(tmp_path / "bad.json"), "-m", "sme", *what]
    assert main([*command, "--json"]) == 0
    out, err = capsys.readouterr()
    bad, good = json.loads(out)[:: 1 if place == 0 else -1]
    assert (bad["status"], bad["uncertain"]) == ("refused", None)
    assert good["uncertain"]["samples"] == 64
    assert err == "sme: has no parameter friction; that it is uncertain has no effect\n"
    assert main(command) == 0
    assert "weight is 0 kg" in capsys.readouterr().out


def test_random_samples_of_a_case_agree():
    layout = load_benchmark().layout("H10_Class_2_Instance_12_ULD_0", "S1")
    sampled = SampledMethod("equilibrium", "com=5mm,position=3mm", Sampling(), 400)
    (row,) = sample_unit(Unit((("S1", layout),), sampled, {}))
    assert 0.0 < row["random"] < 1.0
    assert row["low"] - 0.08 <= row["random"] <= row["high"] + 0.08
    share = dict(row["safe"])[len(layout)] / row["samples"]
    assert 0.0 < row["variance"] < share * (1.0 - share) / row["samples"]


def few(monkeypatch, **values):
    """Few methods and cases."""
    for name, value in values.items():
        monkeypatch.setattr(sampling, name, value)


def test_a_run_goes_on_and_has_the_accuracy_of_the_plans(tmp_path, benchmark, monkeypatch):
    few(
        monkeypatch, METHODS={"within": ("sme", "ps3@mujoco")}, CASES=4, ENGINE_CASES=1,
        ALONE=("com=5mm",), CHECK_CASES=1, RANDOM=64,
    )  # fmt: skip

    def run(seen):
        progress = lambda _, *counts: seen.append(counts)  # noqa: E731
        return sampled_cases(Lab(tmp_path, IN_THIS_PROCESS, progress), "within")

    seen = []
    sampled = run(seen)
    # Twelve cases by the rule, three by the engine, for what matters, and to find unsure ones.
    assert seen[0] == (0, 21)
    stamps = {path: path.stat().st_mtime_ns for path in tmp_path.glob("cases/*.json")}
    next(iter(stamps)).write_text("cut o")
    again = []
    run(again)
    changed = [p for p, stamp in stamps.items() if not p.exists() or p.stat().st_mtime_ns != stamp]
    assert changed == [next(iter(stamps))]
    assert again[0][0] >= 11
    record = summarise(sampled, {})
    row = record.rows.loc["sme"]
    right = 0
    for case in benchmark.select("test", limit=4).itertuples():
        verdict = make_method("sme").judge(benchmark.layout(case.layout, case.scenario))
        label = None if case.failing_step is pd.NA else int(case.failing_step)
        right += verdict.failing_step == label
    assert row.plan_right.value == pytest.approx(right / 12)


def case(row, nominal, safe, **changes):
    samples = sum(count for _, count in safe)
    return {
        "layout": row.layout, "scenario": row.scenario, "item_count": row.item_count,
        "nominal": nominal, "safe": safe, "samples": samples, "lost": 0, "low": 0.4, "high": 0.6,
        "ending": "narrow", "variance": 0.001, "cpu": 0.5, "nominal_cpu": 0.001, "random": None,
    } | changes  # fmt: skip


def test_numbers_follow_from_samples(benchmark, assert_shown):
    chosen = benchmark.select("test", scenarios=("S1",), limit=8)
    whole, other, *_ = chosen[chosen["failing_step"].isna()].itertuples()
    falls, *_ = chosen[chosen["failing_step"].notna()].itertuples()
    count, step = other.item_count, int(falls.failing_step)
    table = pd.DataFrame(
        [
            case(whole, whole.item_count, [(whole.item_count, 64)]),
            # The plan is wrong, most samples are right.
            case(other, 0, [(0, 16), (count, 48)]),
            # No sample has a verdict.
            case(falls, step, [], samples=64, lost=64, ending="no verdict"),
        ]
    )
    check = pd.DataFrame(
        [
            case(other, 0, [(0, 32), (count, 32)], random=0.58),
            case(whole, 0, [(0, 16), (whole.item_count, 48)], low=0.7, high=0.8, random=0.6),
        ]
    )
    sampled = Sampled({"sme": table}, {"com=5mm": table.tail(2), "weight=5%": table.head(1)}, check)
    found = summarise(sampled, {})
    row = found.rows.loc["sme"]
    right = pytest.approx(2 / 3)
    assert (row.plan_right.value, row.likeliest.value, row.unjudged, row.samples_lost) == (
        right,
        right,
        1,
        64,
    )
    assert row.ahead.value == pytest.approx(0.0)
    assert row.unsure.value == pytest.approx(1 / 2)
    assert row.samples_change.value == pytest.approx((0.0 + 0.75) / 2)
    assert row.p_brier.value == pytest.approx((0.0 + 0.25**2) / 2)
    assert row.plan_brier.value == pytest.approx((0.0 + 1.0) / 2)
    assert row.cpu.value == pytest.approx(500.0)
    assert row.endings == {"narrow": 2, "no verdict": 1}
    assert [each.inside for each in found.check.rows] == [True, False]
    spread = (0.25 / 64 + 0.1875 / 64) / 2
    assert found.check.gain.value == pytest.approx(spread / 0.001)
    assert found.check.farthest == pytest.approx(15.0)
    assert [own.value for own in found.alone["samples_change"]] == pytest.approx([0.75, 0.0])
    shares = {}
    for one, stands in ((whole, 1.0), (other, 0.75)):
        if (margin := margin_as_planned(benchmark.layout(one.layout, "S1"))) is None:
            continue
        edges = (0.0, 0.1, 0.25, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0)
        low = max(edge for edge in edges if margin.cm >= edge)
        shares.setdefault(low, []).append(stands)
    assert shares
    rows = [own for _, own in found.worth.iterrows()]
    assert {float(own.margin.split()[0]): own.p_stands.n for own in rows} == {
        low: len(own) for low, own in shares.items()
    }
    for own in rows:
        here = shares[float(own.margin.split()[0])]
        assert own.p_stands.value == pytest.approx(np.mean(here))
        assert (own.p_least, own.firm.value) == (min(here), np.mean([one >= 0.95 for one in here]))
    assert_shown(
        Uncertain(),
        found,
        answer=[percent(row.samples_change), plain_percent(row.unsure.value), row.plan_right.n],
        charts=["reliability", "risk", "margins"],
    )


def test_a_limit_is_of_cases_a_scenario(tmp_path, monkeypatch):
    few(monkeypatch, METHODS={"within": ("sme",)}, ALONE=("com=1cm",), RANDOM=64)
    found = Uncertain(limit=10).run(Lab(tmp_path, 0))
    assert [(spec, own.n) for spec, own in found.rows["plan_right"].items()] == [("sme", 30)]
    assert {own.n for own in found.alone["samples_change"]} == {30}


def test_verdicts_are_compared_with_the_labels_of_the_question(tmp_path, benchmark, monkeypatch):
    few(
        monkeypatch, METHODS={"stands": ("sme",)}, CASES=20, ENGINE_CASES=1, CHECK_CASES=1,
        RANDOM=64,
    )  # fmt: skip
    found = Uncertain(asked="stands").run(Lab(tmp_path, 0))
    cases = benchmark.select("test", limit=20, question=Question.STANDS)
    right = [
        make_method("sme").judge(benchmark.layout(case.layout, case.scenario)).failing_step
        == (None if case.failing_step is pd.NA else int(case.failing_step))
        for case in cases.itertuples()
    ]
    row = found.rows.loc["sme"]
    assert row.plan_right.value == pytest.approx(np.mean(right))
    assert found.stable == pytest.approx(cases["failing_step"].isna().mean())
    assert found.stable < 0.5, "of the question within half of the cases are stable"
    sure = cases.merge(benchmark.confidence_on(Question.STANDS)["robust"], on=KEYS)["robust"]
    assert (row.change_robust.n, row.change_fragile.n) == (sure.sum(), (~sure).sum())
    assert row.change_fragile.n > 0
    assert found.alone_method == "Equilibrium"
