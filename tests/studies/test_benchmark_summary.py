"""What is counted of a labelled set, and how robust its labels are."""

import pandas as pd
import pytest

from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import BenchmarkError, load_benchmark
from steadyload.layouts.benchmark.confidence import Reason
from steadyload.layouts.benchmark.dataset import row_of
from steadyload.layouts.benchmark.tables import CASES, OPINIONS, UNLABELLED, write_tables
from steadyload.layouts.model.question import Question
from steadyload.reports.table import percent
from steadyload.studies.benchmark.counting import Found, summarise
from steadyload.studies.benchmark.study import Benchmark

ENSEMBLE = [(Reason.NUMERICAL, "fine"), (Reason.MODEL, "smooth"), (Reason.LIMITS, "strict")]
MOVES = [f"{what}_{when}" for what in ("corner", "centre", "angle") for when in ("last", "most")]


def row(name, count, instance, packings=1):
    items = tuple(Item(k, (2.0 * k, 0.0, 0.0), (2.0, 1.0 + k, 2.0), 1.0) for k in range(count))
    layout = Layout(name, Pallet(100.0, 100.0, 100.0), items)
    return row_of(layout, instance, 1, tuple(f"{name}{k}" for k in range(packings)))


def case(name, count, step, corner=15.0, angle=2.0, **more):
    """Fails at ``step``; the item just placed moves."""
    known = count if step is None else step + 1
    moved = dict.fromkeys(MOVES, [0.0] * known)
    if step is not None:
        still = [0.0] * step
        moved |= {"corner_last": [*still, corner], "angle_last": [*still, angle]}
    return dict.fromkeys(CASES.names) | moved | {
        "layout": name, "scenario": "S1", "item_count": count, "split": "test", "status": "done",
        "failing_step": step, "failing_step_paper": step, "moved": list(range(known)),
        "margin": [1.0] * (known - 1) + [1.0 if step is None else -1.0],
    } | more  # fmt: skip


def opinions(name, step, engine_step, **said):
    """All of the ensemble say ``step`` but for those named; an engine says ``engine_step``."""
    judges = [(r, j, said.get(j, step)) for r, j in ENSEMBLE]
    return [
        {"layout": name, "scenario": "S1", "question": "within", "reason": str(reason),
         "judge": judge, "status": "done", "failing_step": answer}
        for reason, judge, answer in [*judges, (Reason.ENGINE, "engine", engine_step)]
    ]  # fmt: skip


def written(directory, layouts, cases, said=()):
    frames = [
        pd.DataFrame(layouts),
        pd.DataFrame(cases),
        pd.DataFrame(said, columns=OPINIONS.names),
    ]
    write_tables(directory, *frames, {"origin": "test", "seed": 1})
    return load_benchmark(directory)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    layouts = [
        row("stable", 4, "one", packings=3),
        row("slides", 10, "two"),
        row("tips", 10, "two"),
        row("falls", 10, "three"),
    ]
    cases = [
        case("stable", 4, None, rank=0),
        case("slides", 10, 3, corner=15.0, angle=2.0, rank=1),
        case("tips", 10, 6, corner=2.0, angle=15.0, rank=3, failing_step_paper=7),
        case("falls", 10, 9, corner=15.0, angle=15.0, rank=5, moved=[0] * 10),
    ]
    said = [
        *opinions("stable", None, None),
        *opinions("slides", 3, 3, strict=4),
        *opinions("tips", 6, 6),
        *opinions("falls", 9, None),
    ]
    return summarise(written(tmp_path_factory.mktemp("benchmark") / "set", layouts, cases, said))


def test_counts_and_shares(found):
    assert (found.layouts, found.cases, found.instances, found.without_label) == (4, 4, 3, 0)
    [natural] = found.natural.itertuples()
    assert natural.stable.value == pytest.approx(1 / 4)
    assert natural.of_packings.value == pytest.approx(3 / 6)
    assert natural.other_label.value == pytest.approx(1 / 4)
    assert natural.published == 0.79
    assert found.item_counts == [{"items": 4, "layouts": 1}, {"items": 10, "layouts": 3}]
    [test] = found.splits.itertuples()
    assert (test.split, test.cases, test.stable_cases, test.lists) == ("test", 4, 1, 3)


def test_a_score_stands_in_its_own_tenth(found):
    """0.3, 0.6 and 0.9 are the lower ends of their tenths."""
    shares = [each["shares"]["S1"] for each in found.scores]
    assert shares == [0, 0, 0, 0.25, 0, 0, 0.25, 0, 0, 0.25, 0.25]


def events(found):
    shares = found.reasons.set_index("event")["scenario_right:S1"]
    return {event: share.value for event, share in shares.items()}


def test_reasons_of_failure(found):
    shares = events(found)
    third = pytest.approx(1 / 3)
    assert shares == {
        "beyond 10 cm only": third,
        "beyond 10 degrees only": third,
        "beyond both": third,
        "the item just placed moves furthest": pytest.approx(2 / 3),
        "no equilibrium (margin below 0)": 1.0,
        "at the last item of the layout": third,
    }


def test_a_movement_that_rounding_put_on_the_threshold_counts(tmp_path):
    layouts = [row("lands", 4, "one")]
    found = summarise(written(tmp_path / "set", layouts, [case("lands", 4, 2, corner=10.0)]))
    assert events(found)["beyond 10 cm only"] == 1.0


def test_firmness_and_disputes(found):
    [firm] = found.firmness.to_dict("records")
    assert firm["robust"].value == pytest.approx(3 / 4)
    assert firm["confidence"].value == pytest.approx((3 + 2 / 3) / 4)
    assert firm["part:limits"].value == pytest.approx(3 / 4)
    judges = found.judges.set_index("judge").loc
    assert judges["strict", "later"] == 1
    assert judges["engine", "pooled"].value == pytest.approx(3 / 4)
    assert judges["engine", "right_robust"].value == pytest.approx(2 / 3)
    assert judges["engine", "later"] == 1
    [dispute] = found.disputes.to_dict("records")
    assert dispute == {
        "layout": "falls", "scenario": "S1", "items": 10, "step": "9", "said_of:engine": "stable",
        "apart_at": 9, "corner": "15.0", "angle": "15.0", "apart_by": "-1.00",
    }  # fmt: skip


def test_half_an_ensemble_makes_no_label_robust(tmp_path):
    said = [o for o in opinions("A", None, None) if o["reason"] != "model"]
    rows, cases = [row("A", 2, "one"), row("B", 2, "two")], [case("A", 2, None), case("B", 2, None)]
    found = written(tmp_path / "set", rows, cases, [*said, *opinions("B", None, None)])
    sure = found.confidence_on(Question.WITHIN)
    assert sure["robust"].isna().tolist() == [True, False]
    assert sure["confidence"].tolist() == [1.0, 1.0]
    [firm] = summarise(found).firm
    assert firm.n == 1


def test_the_page_shows_what_was_found(found, assert_shown):
    [firm] = found.firm
    notes = "Looked at,\nline by line."
    text = assert_shown(
        Benchmark(),
        Found(**vars(found) | {"notes": notes}),
        answer=[found.layouts, found.instances, found.cases],
        charts=["robust", "item_counts", "scores", "judges"],
    )
    assert notes in text
    assert f"at least {percent(firm)} % of the labels of every scenario are robust" in text


def test_an_imported_set_has_a_page(tmp_path, assert_shown):
    """Movements, but no margins and no further judges."""
    bare = [case("A", 4, 1, margin=None, moved=None), case("B", 4, None, margin=None, split=None)]
    found = summarise(written(tmp_path / "set", [row("A", 4, "one"), row("B", 4, "two")], bare))
    assert not any(map(len, (found.reasons, found.firmness, found.judges)))
    assert_shown(
        Benchmark(),
        found,
        answer=[found.layouts, found.instances, found.cases],
        charts=["item_counts", "scores"],
        drawn=False,
    )


def test_an_unlabelled_set_has_none(tmp_path):
    found = written(tmp_path / "set", [row("A", 2, "one")], [case("A", 2, None, status=UNLABELLED)])
    with pytest.raises(BenchmarkError, match="nothing in this set is labelled"):
        summarise(found)
