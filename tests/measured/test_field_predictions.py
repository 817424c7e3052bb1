"""Predictions for field tests against closed forms, and the command that prints them."""

import json
import math
import re
from pathlib import Path

import pytest

from steadyload.cli import main
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.measured.errors import FieldTestError
from steadyload.measured.field_files import write_field_tests
from steadyload.measured.field_predictions import agreements, predictions
from steadyload.measured.field_tests import Done, FieldTest
from steadyload.numbers import NumberError

DOCS = Path(__file__).parents[2] / "docs"
EXAMPLE = DOCS / "field-test" / "tests.csv"
PALLET = Pallet(120.0, 200.0, 80.0)
FLAT = Layout("flat", PALLET, (Item(0, (40.0, 0.0, 30.0), (30.0, 10.0, 30.0), 8.0),))
TALL = Layout("tall", PALLET, (Item(0, (40.0, 0.0, 30.0), (12.0, 40.0, 30.0), 8.0, name="T"),))
LEANING = Layout(
    "leaning",
    PALLET,
    (
        Item(0, (40.0, 0.0, 30.0), (20.0, 20.0, 20.0), 5.0),
        Item(1, (52.0, 20.0, 30.0), (30.0, 20.0, 20.0), 5.0, name="L"),
    ),
)
EXACT = "equilibrium:sides=frictionless"


def tilted(layout, towards, reached, moved_at=None, **more):
    return FieldTest(
        name=f"{layout.name} {towards} {moved_at}", plan="p.json", layout=layout, done=Done.TILTED,
        towards_deg=towards, tilt_deg=reached, moved=moved_at is not None, moved_at_deg=moved_at,
        **more,
    )  # fmt: skip


def pushed(layout, towards, reached, moved_at=None):
    return FieldTest(
        name="push", plan="p.json", layout=layout, done=Done.ACCELERATED, towards_deg=towards,
        acceleration_g=reached, moved=moved_at is not None, moved_at_g=moved_at,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("layout", "towards", "friction", "tangent", "mode"),
    [
        (FLAT, 0.0, 0.5, 0.5, "slides"),
        (FLAT, 90.0, 0.3, 0.3, "slides"),
        (TALL, 0.0, 0.5, 6.0 / 20.0, "tips"),  # b / h
        (TALL, 90.0, 0.9, 15.0 / 20.0, "tips"),
        (TALL, 90.0, 0.5, 0.5, "slides"),
    ],
)
def test_the_angle_of_a_single_box_is_that_of_friction_or_of_its_edge(
    layout, towards, friction, tangent, mode
):
    test = tilted(layout, towards, 40.0, 39.0)
    exact, thumb = predictions([test], [f"{EXACT},friction={friction}"], deck_friction=friction)
    angle = math.degrees(math.atan(tangent))
    assert exact.limit_deg == pytest.approx(angle, abs=1e-4)
    assert thumb.limit_deg == pytest.approx(angle, abs=1e-9)
    assert (exact.mode, exact.moved_item, exact.limit_g) == (mode, 0, None)
    [push, _] = predictions(
        [pushed(layout, towards, 1.0)], [f"{EXACT},friction={friction}"], deck_friction=friction
    )
    assert push.limit_g == pytest.approx(tangent, abs=1e-6)


TIP = math.degrees(math.atan(0.3))  # of TALL to the right: 16.7 degrees


@pytest.mark.parametrize(
    ("reached", "moved_at", "agrees"),
    [
        (20.0, TIP + 1.9, True),
        (20.0, TIP + 2.1, False),
        (20.0, TIP - 1.9, True),
        (20.0, TIP - 2.1, False),
        (TIP + 1.9, None, True),
        (TIP + 2.1, None, False),
        (5.0, None, True),
    ],
)
def test_a_limit_agrees_within_the_tolerance(reached, moved_at, agrees):
    [found] = predictions([tilted(TALL, 0.0, reached, moved_at)], [EXACT], deck_friction=None)
    assert found.agrees is agrees


def test_the_box_that_moves_is_compared_where_both_are_known():
    seen = tilted(TALL, 0.0, 20.0, 17.0, moved_step=0)
    unseen = tilted(TALL, 0.0, 20.0, 16.0)
    found = predictions([seen, unseen], [EXACT])
    assert [one.same_box for one in found] == [True, None, None, None]  # b/h has no box


def test_a_simulation_predicts_a_tilt():
    [found] = predictions([tilted(TALL, 0.0, 20.0, 17.0)], ["label@mujoco"], deck_friction=None)
    assert found.limit_deg == pytest.approx(TIP, abs=1.0)
    assert found.agrees


def placed(layout, at=None, step=None):
    return FieldTest(
        name=f"{layout.name} {at}", plan="p.json", layout=layout, done=Done.PLACED,
        moved=at is not None, moved_at_step=at, moved_step=step,
    )  # fmt: skip


@pytest.mark.parametrize("method", ["sme", EXACT, "label@mujoco"])
def test_a_loading_is_compared_by_its_failing_step(method):
    """The second box stands out by 22 of 30 cm, more than half: it falls."""
    tests = [placed(LEANING, 1, 1), placed(LEANING), placed(FLAT)]
    found = predictions(tests, [method], deck_friction=None)
    assert [one.failing_step for one in found] == [1, 1, None]
    assert [one.agrees for one in found] == [True, False, True]
    assert found[0].same_box


def test_a_method_predicts_only_tests_of_its_kind():
    found = predictions([placed(FLAT), tilted(FLAT, 0.0, 10.0)], ["sme"])
    assert [(one.method, one.applies, one.agrees) for one in found] == [
        ("sme", True, True), ("b/h:friction=0.5", False, None),
        ("sme", False, None), ("b/h:friction=0.5", True, True),
    ]  # fmt: skip
    sme, thumb = agreements(found)
    assert (sme.counts, sme.unanswered) == ({Done.PLACED: (1, 1)}, 0)
    assert (thumb.counts, thumb.unanswered) == ({Done.TILTED: (1, 1)}, 0)


def test_a_load_that_hovers_has_no_rule_of_thumb_and_counts_as_unanswered():
    hovering = Layout("hovers", PALLET, (Item(0, (40.0, 5.0, 30.0), (30.0, 10.0, 30.0), 8.0),))
    exact, thumb = agreements(predictions([tilted(hovering, 0.0, 10.0)], [EXACT]))
    assert (thumb.unanswered, thumb.share.n) == (1, 0)
    assert (exact.unanswered, exact.counts) == (0, {Done.TILTED: (0, 1)})


def test_a_method_that_is_named_twice_is_asked_once():
    assert len(predictions([placed(FLAT)], ["sme", "sme"], deck_friction=None)) == 1


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"tolerance_deg": -1.0}, FieldTestError),
        ({"tolerance_g": math.nan}, FieldTestError),
        ({"deck_friction": math.inf}, FieldTestError),
        ({"timeout": 0.0}, NumberError),
    ],
)
def test_numbers_that_are_none_are_refused(options, error):
    with pytest.raises(error, match="allowed"):
        predictions([placed(FLAT)], ["sme"], **options)


# The command.


@pytest.fixture
def table(tmp_path):
    write_layouts(tmp_path / "p.json", [FLAT, TALL, LEANING], Format.NATIVE)
    tests = [tilted(TALL, 0.0, 20.0, 17.0, moved_step=0), placed(LEANING, 1, 1), placed(FLAT)]
    write_field_tests(tmp_path / "tests.csv", tests, ["of a test"])
    return tmp_path / "tests.csv"


def test_the_command_prints_a_row_a_test_and_method(table, capsys):
    assert main(["reality", "field", str(table), "-m", "sme", "-m", EXACT]) == 0
    printed = capsys.readouterr().out
    lines = [re.split(r"\s{2,}", line) for line in printed.splitlines()]
    assert lines[0] == ["of a test"]
    assert lines[1] == ["test", "done", "seen", "method", "predicted", "agrees"]
    name = "tall 0.0 17.0"
    assert lines[3] == [
        name, "tilted right to 20 degrees", "T at 17 degrees", EXACT, "T tips at 16.7 degrees",
        "yes",
    ]  # fmt: skip
    assert ["leaning 1", "placed", "L as L is placed", "sme", "L as L is placed", "yes"] in lines
    assert ["flat None", "placed", "holds", "sme", "holds", "yes"] in lines
    assert "sme: agrees on 2 of 2 tests" in printed
    assert f"{EXACT}: agrees on 3 of 3 tests: placed 2 of 2, tilted 1 of 1" in printed


def test_a_share_has_an_interval_from_five_tests_on(capsys):
    assert main(["reality", "field", str(EXAMPLE)]) == 0
    printed = capsys.readouterr().out
    assert printed.startswith("INVENTED EXAMPLE")
    assert re.search(rf"^{EXACT}: agrees on 4 of 5 tests \(80 %, \d+ % to \d+ %\): ", printed, re.M)
    assert re.search(r"^b/h:friction=0.5: agrees on 1 of 3 tests: ", printed, re.M)


def test_records_are_json_and_docs_list_their_fields(table, capsys):
    assert main(["reality", "field", str(table), "--json"]) == 0
    captured = capsys.readouterr()
    records = json.loads(captured.out)
    assert len(records) == 6
    assert "of a test" in captured.err
    text = (DOCS / "field-test.md").read_text()
    rows = text.split("| field of a prediction |")[1].split("\n\n")[0]
    listed = [field for row in rows.splitlines()[2:]
              for field in re.findall(r"`(\w+)`", row.split("|")[1])]  # fmt: skip
    assert listed == list(records[0])
    assert records[0]["limit_deg"] == pytest.approx(TIP, abs=1e-4)
    assert (records[0]["seen_box"], records[0]["moved_box"], records[0]["same_box"]) == (
        "T", "T", True,
    )  # fmt: skip


def test_exit_statuses(table, tmp_path, capsys):
    assert main(["reality", "field", str(tmp_path / "none.csv")]) == 2
    assert "none.csv: No such file or directory" in capsys.readouterr().err
    assert main(["reality", "field", str(table), "-m", "nope"]) == 2
    assert main(["reality", "field", str(table), "--tolerance-deg", "-1"]) == 2
    hovering = Layout("flat", PALLET, (Item(0, (40.0, 5.0, 30.0), (30.0, 10.0, 30.0), 8.0),))
    write_layouts(tmp_path / "p.json", [hovering], Format.NATIVE)
    write_field_tests(table, [tilted(hovering, 0.0, 10.0)])
    assert main(["reality", "field", str(table)]) == 3
    printed = capsys.readouterr().out
    assert "b/h:friction=0.5: predicts none of these tests; no prediction for 1" in printed
    assert main(["reality"]) == 0
    assert main(["reality", "fild"]) == 2
