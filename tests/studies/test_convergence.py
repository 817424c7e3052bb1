"""Labels of the reference beside changed references and other methods, counted by hand."""

import pandas as pd
import pytest

from steadyload.layouts.model.question import Question
from steadyload.reports.table import percent
from steadyload.runs.definition import StudyError
from steadyload.studies.convergence.comparing import compare
from steadyload.studies.convergence.judging import (
    BASE,
    ENGINES,
    LOOKED_AT,
    OF_STANDS,
    OPINIONS,
    VARIANTS,
    canonical,
    convergence_studies,
)
from steadyload.studies.convergence.study import Convergence
from steadyload.studies.kit import Lab

LABELS = {"a": None, "b": 2, "c": 3, "d": None}
LISTS = {"a": ("1", "x"), "b": ("1", "y"), "c": ("2", "z"), "d": ("2", "w")}
ITEMS = {"a": 4, "b": 8, "c": 8, "d": 12}
MUJOCO = canonical(LOOKED_AT[0])
BULLET = canonical("label@bullet:frequency=90")
TOLERANCE, FRICTION = "tolerance 1e-06", "friction 0.4"


def named(title):
    return next(variant for variant in VARIANTS if variant.title == title)


def judged(methods, **changes):
    """A row a method and layout: the label, or another failing step, or a status."""
    rows = []
    for method in (BASE, *methods):
        for layout, label in LABELS.items():
            said = changes.get(method, {}).get(layout, label)
            status = said if isinstance(said, str) else "done"
            step = None if isinstance(said, str) else said
            moved = None if step is None else 12.0
            rows.append(
                {"layout": layout, "scenario": "S1", "item_list": LISTS[layout],
                 "method": method, "status": status, "failing_step": step,
                 "item_count": ITEMS[layout], "cpu_total": 0.001 if method == BASE else 0.002,
                 "displacement_cm": moved, "rotation_deg": moved}
            )  # fmt: skip
    return pd.DataFrame(rows).astype({"failing_step": "Int64"})


@pytest.fixture(scope="module")
def found():
    decisive = [own.spec for own in VARIANTS if own.decisive]
    others = [own.spec for own in VARIANTS if not own.decisive]
    changed = {
        MUJOCO: {"c": 2}, BULLET: {"a": 3}, named(TOLERANCE).spec: {"d": 1},
        named(FRICTION).spec: {"a": "timeout", "b": None},
    }  # fmt: skip
    everything = judged([*decisive, *map(canonical, ENGINES)], **changed)
    opinions = judged(map(canonical, OPINIONS))
    return compare({"all: layouts": "4"}, everything, judged(others, **changed), opinions)


def by_title(rows, title):
    return next(own for _, own in rows.iterrows() if own.title == title)


def test_changed_labels_are_counted_by_direction(found):
    friction = by_title(found.others, FRICTION)
    # What a time limit ended is no other label.
    assert (friction.label_changed.value, friction.label_changed.n) == (pytest.approx(1 / 3), 3)
    assert (friction.stable_changed.value, friction.unstable_changed.value) == (0.0, 0.5)
    assert (friction.earlier, friction.later, friction.lost) == (0, 1, {"timeout": 1})
    tolerance = by_title(found.others, TOLERANCE)
    assert (tolerance.label_changed.value, tolerance.earlier, tolerance.later) == (0.25, 1, 0)
    assert (tolerance.cpu.value, tolerance.slowest) == pytest.approx((2.0, 2.0))
    assert by_title(found.others, "carry instead of reseat").label_changed.value == 0.0
    assert by_title(found.engines, "bullet at 90 Hz").equal.value == 0.75


def test_a_change_of_the_numerics_counts_and_one_of_the_model_does_not(found):
    assert (found.any_change.value, found.any_change.n) == (0.25, 4)
    assert {own["group"] for own in found.swept} < {own.group for own in VARIANTS}
    assert {own["value"] for own in found.swept if own["group"] == "friction"} == {0.4, 0.6}
    assert "loading" not in {own["group"] for own in found.swept}


def test_soft_contacts_are_a_change_of_the_model_with_a_section_of_their_own(found):
    assert found.compliant["value"].tolist() == [1e5, 1e6, 1e7, 3e7]
    assert set(found.compliant["title"]).isdisjoint(found.others["title"])
    assert len(found.compliant) + len(found.others) == len(VARIANTS)


def test_a_layout_on_which_a_fine_engine_differs_is_a_dispute(found):
    (dispute,) = found.disputes
    assert (dispute.layout, dispute.scenario) == ("c", "S1")
    assert (dispute.item_count, dispute.label) == (8, "3")
    assert dispute.moved == (12.0, 12.0)
    assert dispute.said["mujoco 480 Hz"] == "2"
    assert dispute.said["bullet 480 Hz"] == dispute.said["mujoco 1000 Hz"] == "3"
    assert dispute.changes_under == [f"none of {len(VARIANTS)}"]


def test_the_page_shows_what_was_found(found, assert_shown):
    assert_shown(
        Convergence(),
        found,
        answer=[found.any_change.n, percent(found.any_change)],
        charts=["sweeps", "engines"],
    )


@pytest.fixture(scope="module")
def standing():
    """The question *stands*: the reference alone is changed, in fewer ways."""
    tried = [own for own in VARIANTS if own.title in OF_STANDS]
    assert len(tried) == len(OF_STANDS)
    decisive = [own.spec for own in tried if own.decisive]
    others = [own.spec for own in tried if not own.decisive]
    changed = {named(TOLERANCE).spec: {"d": 1}, named("stiffness 100000").spec: {"a": 1, "b": None}}
    everything, sweep = judged(decisive, **changed), judged(others, **changed)
    return compare({"all: layouts": "4"}, everything, sweep, asked="stands")


def test_the_question_stands_has_the_changes_that_were_tried(standing, assert_shown):
    assert {*standing.compliant["title"], *standing.others["title"]} == OF_STANDS
    assert (standing.agreeing, len(standing.opinions), standing.disputes) == ([], 0, [])
    assert by_title(standing.compliant, "stiffness 100000").label_changed.value == 0.5
    assert (standing.any_change.value, standing.any_change.n) == (0.25, 4)
    assert_shown(
        Convergence(asked="stands"),
        standing,
        answer=[
            "labels of the question *stands*",
            standing.any_change.n,
            percent(standing.any_change),
        ],
        charts=["sweeps"],
    )
    page = Convergence(asked="stands").page(standing)
    assert "whether a load stands" in page.title
    assert {section.title for section in (*page.sections, *page.details)}.isdisjoint(
        {"Other engines", "Second opinions", "Disagreements"}
    )


def test_rows_of_the_question_stands_are_of_methods_asked_it():
    studies = convergence_studies(question=Question.STANDS)
    within = convergence_studies()
    assert set(studies).isdisjoint(within)
    assert [study.limit for study in (*within.values(), *studies.values())] == [100, 67, 17, 67, 67]
    assert [study.limit for study in convergence_studies(limit=20).values()] == [20, 20, 17]
    for study in studies.values():
        assert all("question=stands" in method for method in study.methods)
    assert not any("question" in m for study in within.values() for m in study.methods)


def test_a_second_model_judges_for_the_question_within_alone(tmp_path):
    with pytest.raises(StudyError, match="not allowed with --question stands; allowed: within"):
        Convergence(asked="stands", second_model=True).run(Lab(tmp_path / "work", 0))
    assert not (tmp_path / "work").exists()


def test_labels_are_judged_once(tmp_path):
    asked, lab = Convergence(limit=1), Lab(tmp_path, 0)
    found = asked.run(lab)
    assert {own.n for own in found.others["label_changed"]} == {3}
    assert set(found.opinions["title"]) == {canonical(spec) for spec in OPINIONS}
    stamps = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.parquet")}
    assert repr(asked.run(lab)) == repr(found), "equal but for what is no number"
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.parquet")} == stamps
