"""Frames of results as tables: titles and forms of columns are in one place."""

import math

import pandas as pd
import pytest

from steadyload.reports import frame_points, frames
from steadyload.reports.columns import TableError
from steadyload.statistics.estimate import NOTHING, Estimate


def half(n):
    return Estimate(0.5, 0.25, 0.75, n)


FRAME = pd.DataFrame(
    {
        "title": ["FBS", "SME", "None"],
        "right": pd.Series([half(8), half(6), math.nan], dtype=object),
        "cpu": pd.Series([Estimate(2.0, 1.0, 3.0, 8), None, NOTHING], dtype=object),
        "lost": pd.Series([math.nan, {"timeout": 2}, {"error": 1, "refused": 2}], dtype=object),
        "boxes_right:1 to 5 (n 3)": pd.Series([half(3), half(3), math.nan], dtype=object),
        "boxes_right:6": pd.Series([None, half(5), math.nan], dtype=object),
    }
)


def lines(table):
    return [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in str(table).splitlines()
        if not line.startswith("| --")
    ]


def test_columns_are_named_and_have_the_titles_and_forms_of_the_registry():
    table = frames.table(FRAME, "title right.n right cpu lost boxes_right:*", "Of all cases:")
    caption, header, *rows = lines(table)[0:1] + lines(table)[2:]
    assert caption == ["Of all cases:"]
    assert header == [
        "method", "n", "accuracy %", "CPU ms", "no verdict", "1 to 5 (n 3)", "6",
    ]  # fmt: skip
    shown = "50.0 [25.0, 75.0]"
    assert rows == [
        ["FBS", "8", shown, "2.00 [1.00, 3.00]", "-", shown, "-"],
        ["SME", "6", shown, "-", "2 timeout", shown, shown],
        ["None", "-", "-", "-", "1 error, 2 refused", "-", "-"],
    ]


def test_a_title_may_be_of_one_table_alone():
    header, *_ = lines(frames.table(FRAME, "title right", titles={"title": "cheapest method"}))
    assert header == ["cheapest method", "accuracy %"]


def test_texts_are_aligned_left_and_numbers_right_but_for_families_of_columns():
    frame = pd.DataFrame({"title": ["FBS"], "letters": ["ab"], "false_alarms:x": ["1 of 2"]})
    table = frames.table(frame, "title letters false_alarms:*")
    assert [column.left for column in table.columns] == [True, True, False]
    assert [column.alike for column in table.columns] == [False, False, True]


def test_no_rows_are_no_table():
    assert frames.table(FRAME.head(0), "title right") is None


@pytest.mark.parametrize(
    ("chosen", "message"),
    [
        ("titel", "no column 'titel'; did you mean 'title'"),
        ("title wall", "the frame has no 'wall'"),
        ("boxes_cpu", "the frame has no 'boxes_cpu'"),
    ],
)
def test_a_wrong_name_is_said(chosen, message):
    with pytest.raises(TableError, match=message):
        frames.table(FRAME, chosen)


def test_a_family_of_columns_may_have_none():
    assert lines(frames.table(FRAME, "title alarms:*"))[0] == ["method"]


def test_values_by_two_things_are_laid_across():
    index = pd.MultiIndex.from_tuples(
        [("a", "S1"), ("a", "S2a"), ("b", "S2a")], names=["method", "scenario"]
    )
    found = pd.Series([half(1), half(2), half(3)], index, dtype=object)
    wide = frames.across(found, "scenario", "scenario_right", {"S1": 4, "S2a": 5})
    assert list(wide) == ["scenario_right:S1 (n 4)", "scenario_right:S2a (n 5)"]
    assert wide.loc["b", "scenario_right:S2a (n 5)"] == half(3)
    assert pd.isna(wide.loc["b", "scenario_right:S1 (n 4)"])
    cells = frame_points.cells(found, {"b": "B", "a": "A"}, {"S1": "one", "S2a": "two"})
    assert [(c["line"], c["place"], c["value"].n) for c in cells] == [
        ("B", "one", 0), ("B", "two", 3), ("A", "one", 1), ("A", "two", 2),
    ]  # fmt: skip


def test_points_of_curves_are_those_that_have_a_value():
    index = pd.MultiIndex.from_tuples([("a", "x"), ("a", "y"), ("b", "x")])
    values = pd.Series([half(1), half(2), None], index, dtype=object)
    rows = pd.DataFrame({"key": ["A", "B"], "title": ["Aa", "Bb"]}, ["a", "b"])
    points = frame_points.points(rows, {"x": 1.0, "y": 2.0}, values)
    assert points == [
        {"key": "A", "title": "Aa", "x": 1.0, "value": half(1)},
        {"key": "A", "title": "Aa", "x": 2.0, "value": half(2)},
    ]


def test_charts_read_rows_by_name():
    assert [row["title"] for row in frames.records(FRAME.set_index("title", drop=False),
                                                   ["SME", "FBS"])] == ["SME", "FBS"]  # fmt: skip
    assert len(frames.records(FRAME)) == 3
