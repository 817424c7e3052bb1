"""When the reference is asked, by one screen and by two, on answers that are made up."""

import numpy as np
import pandas as pd
import pytest

from steadyload.labelling.screened import REASONS, screened_steps
from steadyload.labelling.screened_loading import SAME, SAME_BY_TWO, ByOne, ByTwo
from steadyload.labelling.screening import screened_row
from steadyload.layouts.benchmark.tables import SCREENED
from steadyload.methods.contract.method import Status
from steadyload.methods.simulation.step_answers import StepAnswer

NEVER, ALWAYS = np.full(4, 0.999), np.zeros(4)


def answer(beyond=0.1, *, within=None, standing=None, item=0, status=Status.DONE, rattles=False):
    """An answer of a box that moved so far, in units of a threshold."""
    fails = beyond > 1.0
    return StepAnswer(
        status, "", fails if within is None else within,
        None if rattles else fails if standing is None else standing,
        item, beyond, 0.0, 0.0, 0.0, 0.0,
    )  # fmt: skip


CALM, NEAR, FAILS = answer(), answer(0.9), answer(2.0)
RATTLES, LOST = answer(rattles=True), answer(status=Status.TIMEOUT)


@pytest.mark.parametrize(
    ("seen", "standing", "why"),
    [
        (CALM, True, ""), (answer(0.5), True, ""), (answer(0.51), True, "near"),
        (FAILS, True, "fails"), (answer(0.1, within=True), True, "fails"),
        (answer(0.1, standing=True), True, "fails"), (LOST, True, "no end"),
        (RATTLES, True, "no end"), (RATTLES, False, ""),
    ],
)  # fmt: skip
def test_one_screen_asks_where_something_fails_or_nearly_does(seen, standing, why):
    asks = ByOne(NEVER)
    assert asks.why(0, [seen], standing) == why
    assert not asks.agree([seen], standing)
    assert asks.known(0, why, [seen]) is None
    assert ByOne(ALWAYS).why(0, [seen], standing) == (why or "drawn")


def test_one_screen_does_not_ask_again_about_a_movement_that_was_agreed_on():
    asks = ByOne(NEVER)
    asks.note(0, [answer(0.8)], answer(0.8 + 1.1 * SAME))
    assert asks.why(1, [answer(0.8)], True) == "near"
    asks.note(1, [answer(0.8)], answer(0.8 + 0.9 * SAME))
    assert asks.why(2, [answer(0.8 + 0.9 * SAME)], True) == ""
    assert asks.why(2, [answer(0.8 + 1.1 * SAME)], True) == "near"
    assert asks.why(2, [answer(0.8, item=1)], True) == "near"


@pytest.mark.parametrize(
    ("one", "other", "standing", "why"),
    [
        (CALM, CALM, True, ""), (CALM, FAILS, True, "differ"), (FAILS, CALM, True, "differ"),
        (FAILS, FAILS, True, "fails"), (CALM, NEAR, True, "near"), (answer(0.85), CALM, True, ""),
        (answer(0.1, standing=True), CALM, True, "differ"),
        (answer(0.1, within=True), CALM, True, "differ"),
        (CALM, LOST, True, "no end"), (LOST, CALM, False, "no end"),
        (CALM, RATTLES, True, ""), (RATTLES, CALM, True, ""), (RATTLES, RATTLES, True, "no end"),
        (RATTLES, RATTLES, False, ""),
    ],
)  # fmt: skip
def test_two_screens_ask_where_they_disagree_or_something_fails(stack, one, other, standing, why):
    asks = ByTwo(NEVER, stack(0, 0, 0, 0))
    assert asks.why(0, [one, other], standing) == why
    assert asks.agree([one, other], standing) == (why in ("", "near", "fails"))
    drawn = ByTwo(ALWAYS, stack(0, 0, 0, 0)).why(0, [one, other], standing)
    assert drawn == (why or "drawn")


@pytest.mark.parametrize(("by", "is_known"), [(0.0, True), (0.9, True), (1.1, False)])
def test_screens_that_see_nearly_as_much_see_the_same(stack, by, is_known):
    asks = ByTwo(NEVER, stack(0))
    asks.note(0, [answer(0.9)] * 2, told := answer(0.3))
    now = [answer(0.9 + by * SAME_BY_TWO)] * 2
    assert asks.known(0, "near", now) == (told if is_known else None)
    assert asks.known(0, "drawn", now) is None


@pytest.mark.parametrize(
    ("item", "asked_at", "is_known"), [(0, 1, True), (0, 2, False), (1, 2, False)]
)
def test_what_rests_on_a_box_by_way_of_others_changes_how_it_moves(stack, item, asked_at, is_known):
    asks = ByTwo(NEVER, stack(0, 0, 0))
    seen = [answer(0.9, item=item)] * 2
    asks.note(1, seen, answer(0.3, item=item))
    assert (asks.known(asked_at, "near", seen) is not None) == is_known


def test_an_answer_that_something_moves_too_far_is_not_kept(stack):
    asks = ByTwo(NEVER, stack(0, 0))
    asks.note(0, [FAILS, FAILS], FAILS)
    assert asks.known(1, "fails", [FAILS, FAILS]) is None
    asks.note(0, [FAILS, answer(1.5)], CALM)
    assert asks.known(0, "fails", [FAILS, answer(9.0)]) == CALM


def test_a_row_has_the_columns_of_its_table_and_lists_every_step(stack):
    row = screened_row("S1", stack(0.0, 0.0))
    assert row.keys() == set(SCREENED.names)
    listed = [name for name, value in row.items() if isinstance(value, list)]
    assert len(listed) == 9
    assert {len(row[name]) for name in listed} == {2}
    assert row["second"] is None


def test_steps_are_counted_by_the_reason_for_which_the_reference_was_asked():
    nan = np.nan
    rows = pd.DataFrame({
        "screen": [[0.1, 2.0, 0.7], [3.0, 0.2]], "reference": [[nan, 1.5, 0.6], [0.4, 0.1]],
        "why": [["", "fails", "near"], ["fails", "drawn"]],
    })  # fmt: skip
    found = screened_steps(rows)
    assert (found.cases, found.steps) == (2, 5)
    counts = {
        reason: (r.steps, r.screen, r.reference, r.differ)
        for reason in REASONS if (r := found.of(reason))
    }  # fmt: skip
    assert counts == {"fails": (2, 2, 1, 1), "near": (1, 0, 0, 0), "drawn": (1, 0, 0, 0)}
    assert found.of("fails").share.value == 0.5
    assert found.of("differ") is None
    assert screened_steps(rows.iloc[:0]).steps == 0
