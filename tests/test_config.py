"""Mappings become dataclasses, or one sentence says what is wrong, where, and what is allowed."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from enum import StrEnum
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from steadyload.config import (
    REQUIRED,
    ConfigError,
    bind,
    number_from_zero,
    operand,
    option,
    positive_number,
    values_of,
)


class Colour(StrEnum):
    RED = "red"
    BLUE = "blue"


@dataclass(frozen=True)
class Point:
    x: float
    y: float | None = None


@dataclass(frozen=True)
class Drawing:
    name: str
    points: tuple[Point, ...] = ()
    corners: Sequence[Point] = ()
    size: tuple[int, float] = (1, 1.0)
    colours: Mapping[Colour, int] = field(default_factory=dict)
    shade: Colour = Colour.RED
    anything: Any = None


@dataclass(frozen=True)
class Command:
    files: tuple[Path, ...] = operand(REQUIRED, "files", metavar="FILE")
    count: int = option(3, "how many", least=1, most=9)
    share: float | None = option(None, "of them", least=0.0)
    part: str = option("test", "of a set", choices=("test", "train"))
    question: str = option("within", "asked", choices="steadyload.layouts.model.question:Question")
    seconds: float = option(1.0, "time", read=positive_number)
    methods: tuple[str, ...] = option((), "compared")
    fast: bool = option(False, "or slow")
    config: str = option("", "its file")


def test_a_mapping_becomes_what_it_says():
    made = bind(
        Drawing,
        {
            "name": "a",
            "points": [{"x": 1}, {"x": 2.5, "y": None}],
            "corners": [{"x": 0, "y": 1}],
            "size": [2, 3],
            "colours": {"blue": 4},
            "shade": "blue",
            "anything": [1, {}],
        },
        "here",
    )
    assert made == Drawing(
        "a", (Point(1.0), Point(2.5)), [Point(0.0, 1.0)], (2, 3.0), {Colour.BLUE: 4}, Colour.BLUE,
        [1, {}],
    )  # fmt: skip
    assert type(made.points[0].x) is float
    stated = {"files": ["a"], "seconds": 2, "share": 1, "question": "stands", "fast": True}
    assert bind(Command, stated, "here") == Command(
        (Path("a"),), share=1.0, question="stands", seconds=2.0, fast=True
    )


@pytest.mark.parametrize(
    ("cls", "stated", "message"),
    [
        (Drawing, {}, "name is missing; allowed: a text"),
        (Drawing, {"nam": "a"}, "unknown key 'nam'; did you mean 'name'? allowed: anything, "
         "colours, corners, name, points, shade, size"),
        (Drawing, {"name": 1}, "name is 1; allowed: a text"),
        (Drawing, {"name": "a", "points": {"x": 1}}, "points is {'x': 1}; allowed: a list"),
        (Drawing, {"name": "a", "points": [{"x": 1}, 3]},
         "points[1] is 3; allowed: keys with values"),
        (Drawing, {"name": "a", "points": [{"x": "1"}]},
         "points[0]: x is '1'; allowed: a number"),
        (Drawing, {"name": "a", "points": [{"x": 1, "z": 1}]},
         "points[0]: unknown key 'z'; allowed: x, y"),
        (Drawing, {"name": "a", "points": [{}]}, "points[0]: x is missing; allowed: a number"),
        (Drawing, {"name": "a", "size": [1]}, "size is [1]; allowed: a list of 2 values"),
        (Drawing, {"name": "a", "size": [1.5, 1]}, "size[0] is 1.5; allowed: a whole number"),
        (Drawing, {"name": "a", "colours": {"green": 1}},
         "colours[green] is 'green'; allowed: blue, red"),
        (Drawing, {"name": "a", "colours": []}, "colours is []; allowed: values by blue, red"),
        (Drawing, {"name": "a", "shade": "redd"},
         "shade is 'redd'; did you mean 'red'? allowed: blue, red"),
        (Drawing, {"name": "a", "shade": ["red"]}, "shade is ['red']; allowed: blue, red"),
        (Command, {"count": 0}, "count is 0; allowed: a whole number, 1 to 9"),
        (Command, {"count": True}, "count is True; allowed: a whole number, 1 to 9"),
        (Command, {"count": "3"}, "count is '3'; allowed: a whole number, 1 to 9"),
        (Command, {"count": 3.0}, "count is 3.0; allowed: a whole number, 1 to 9"),
        (Command, {"share": -0.5}, "share is -0.5; allowed: a number, 0 or more"),
        (Command, {"share": math.nan}, "share is nan; allowed: a number, 0 or more"),
        (Command, {"share": 10**400},
         "share is a number of hundreds of digits; allowed: a number, 0 or more"),
        (Command, {"part": "tst"}, "part is 'tst'; did you mean 'test'? allowed: test, train"),
        (Command, {"question": "x"}, "question is 'x'; allowed: stands, within"),
        (Command, {"seconds": 0},
         "seconds is '0'; allowed: a number above 0 and below 1,000,000,000"),
        (Command, {"seconds": []}, "seconds is []; allowed: a value"),
        (Command, {"methods": "sme"}, "methods is 'sme'; allowed: a list"),
        (Command, {"methods": ["a", 1]}, "methods[1] is 1; allowed: a text"),
        (Command, {"fast": 1}, "fast is 1; allowed: true or false"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_sentence(cls, stated, message):
    with pytest.raises(ConfigError) as error:
        bind(cls, stated, "mine.toml")
    assert str(error.value) == f"mine.toml: {message}"


@dataclass(frozen=True)
class Placed:
    place: Path | None = None


@pytest.mark.parametrize("text", ["", "a\0b"])
def test_what_names_no_file_is_no_path(text):
    with pytest.raises(ConfigError, match=r"place is .*; allowed: a path"):
        bind(Placed, {"place": text}, "mine.toml")
    assert bind(Placed, {"place": "a b"}, "mine.toml").place == Path("a b")


@dataclass(frozen=True)
class Range:
    low: int
    high: int

    def __post_init__(self):
        if self.low > self.high:
            raise ValueError(f"low is {self.low}; allowed: at most high, {self.high}")


def test_what_a_class_refuses_is_said_with_its_place():
    with pytest.raises(ConfigError, match=r"^mine: low is 3; allowed: at most high, 2$"):
        bind(Range, {"low": 3, "high": 2}, "mine")


def test_some_fields_may_be_stated_and_some_may_not():
    assert values_of(Command, {"count": 4}, "f") == {"count": 4}
    with pytest.raises(ConfigError, match="f: unknown key 'config'; allowed: count, fast"):
        values_of(Command, {"config": "x"}, "f", apart={"config"})


def numbers():
    return st.floats(allow_infinity=False, allow_nan=False)


points = st.builds(Point, numbers(), st.none() | numbers())


@given(
    st.builds(
        Drawing,
        st.text(),
        st.lists(points).map(tuple),
        st.lists(points),
        st.tuples(st.integers(), numbers()),
        st.dictionaries(st.sampled_from(Colour), st.integers()),
        st.sampled_from(Colour),
        st.none() | st.integers(),
    )
)
def test_what_is_stored_as_json_is_read_as_it_was(drawing):
    assert bind(Drawing, json.loads(json.dumps(asdict(drawing))), "") == drawing


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | st.binary(),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["x", "y", "red", "z"]), inner, max_size=3)
    ),
    max_leaves=8,
)


@pytest.mark.parametrize("cls", [Drawing, Command])
@given(st.data())
def test_whatever_is_stated_is_bound_or_refused(cls, data):
    names = [one.name for one in fields(cls)]
    stated = data.draw(st.dictionaries(st.sampled_from([*names, "other"]), values))
    said = "here: allowed: "
    try:
        assert isinstance(bind(cls, stated, "here"), cls)
    except ConfigError as error:
        said = str(error)
    assert said.startswith("here: ")
    assert "allowed: " in said


def test_a_number_from_zero_is_one_below_a_hundred_thousand():
    assert [number_from_zero(text) for text in ("0", "0.05", "99999")] == [0.0, 0.05, 99999.0]
    for text in ("-0.01", "100000", "nan"):
        with pytest.raises(ValueError, match=f"'{text}'; allowed: a number, 0 or more, below 100"):
            number_from_zero(text)
