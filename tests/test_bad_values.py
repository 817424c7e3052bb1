"""Values that callers give and that mean nothing: each is refused in one short sentence."""

import io
import json
import math
from importlib import metadata
from types import MappingProxyType

import numpy as np
import pytest

import steadyload as sl
from steadyload.cli import main
from steadyload.errors import UserError
from steadyload.layouts.files.parquet_layouts import as_parquet
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.snapping import snap
from steadyload.layouts.writers import as_job, as_native
from steadyload.transport.history import constant
from steadyload.transport.limits import limits
from steadyload.transport.trials import under_history

BOX = sl.Item(0, (0, 0, 0), (40, 30, 40), 12)
LAYOUT = sl.Layout("one", sl.Pallet(120, 160, 80), (BOX,))
CONTENT = "".join(as_native([LAYOUT])).encode()
HUGE = 10**400


@pytest.fixture
def file(tmp_path):
    write_layouts(tmp_path / "one.json", [LAYOUT], Format.NATIVE)
    return tmp_path / "one.json"


def refused(door):
    with pytest.raises(UserError) as caught:
        door()
    told = str(caught.value)
    assert told.isprintable()
    assert "allowed" in told
    assert len(told) < 300
    return told


TIMED = {
    "check": lambda value: sl.check(LAYOUT, "sme", timeout=value),
    "judge": lambda value: sl.make_method("sme").judge(LAYOUT, timeout=value),
    "judge_many": lambda value: sl.make_method("sme").judge_many([LAYOUT], timeout=value),
    "session": lambda value: sl.LoadingSession(LAYOUT.pallet, timeout=value),
}


@pytest.mark.parametrize("value", [math.nan, math.inf, -1, 0, 1e9, HUGE, "soon"], ids=str)
@pytest.mark.parametrize("door", TIMED)
def test_a_time_limit_is_finite_and_above_zero(door, value):
    told = refused(lambda: TIMED[door](value))
    assert told.startswith("timeout is ")
    assert "allowed: a number of seconds above 0 and below 1,000,000,000, or None" in told


GIVEN_A_METHOD = {
    "check": lambda method: sl.check(LAYOUT, method),
    "repair": lambda method: sl.repair(LAYOUT, method=method),
    "session": lambda method: sl.LoadingSession(LAYOUT.pallet, method),
    "transport": lambda method: limits(LAYOUT, method=method),
    "make_method": sl.make_method,
}


@pytest.mark.parametrize("value", [5, ["sme"], sl.Pallet(1, 1, 1)], ids=str)
@pytest.mark.parametrize("door", GIVEN_A_METHOD)
def test_a_method_is_one_or_its_text(door, value):
    told = refused(lambda: GIVEN_A_METHOD[door](value))
    assert told.startswith("method is ")
    assert told.endswith("allowed: a text, such as sme or label@mujoco")


@pytest.mark.parametrize("value", [math.nan, -1, 0])
def test_score_refuses_such_a_time_limit_before_it_judges(file, value):
    refused(lambda: sl.score([file], ["sme"], timeout=value))


@pytest.mark.parametrize("value", [math.nan, math.inf, -1, HUGE, "far"], ids=str)
def test_a_gap_is_finite_and_not_negative(file, value):
    assert "snap_gap is" in refused(lambda: sl.read(file, snap_gap=value))
    assert "gap is" in refused(lambda: snap(LAYOUT, value))


@pytest.mark.parametrize("value", [math.nan, math.inf, HUGE, "east"], ids=str)
def test_a_direction_is_finite(value):
    assert "direction is" in refused(lambda: limits(LAYOUT, directions=[value]))
    history = constant(0.1, 0.1)
    refused(lambda: under_history(LAYOUT, history, [value], "label@mujoco"))
    refused(lambda: limits(LAYOUT, directions=[]))


@pytest.mark.parametrize("value", [math.nan, math.inf, -1, HUGE], ids=str)
def test_a_rise_is_finite_and_not_negative_also_where_no_time_is_known(value):
    assert "rise is" in refused(lambda: limits(LAYOUT, rise=value))


@pytest.mark.parametrize(
    "door",
    [
        lambda value: sl.Item(0, (value, 0, 0), (1, 1, 1), 1),
        lambda value: sl.Item(0, (0, 0, 0), (value, 1, 1), 1),
        lambda value: sl.Item(0, (0, 0, 0), (1, 1, 1), value),
        lambda value: sl.Item(0, (0, 0, 0), (1, 1, 1), 1, (value, 0, 0)),
        lambda value: sl.Item(0, (0, 0, 0), (1, 1, 1), 1, max_load=value),
        lambda value: sl.Item(value, (0, 0, 0), (1, 1, 1), 1),
        lambda value: sl.Pallet(value, 1, 1),
        lambda value: sl.Pallet(1, 1, 1, overhang=value),
        lambda value: sl.Pallet(1, 1, 1, floor=value),
        lambda value: constant(value, 1.0),
        lambda value: sl.LoadingSession(LAYOUT.pallet).feasible(BOX, [[value, 0, 0]]),
        sl.make_method,
    ],
)
@pytest.mark.parametrize("value", [HUGE, 10**6000], ids=["400 digits", "6000 digits"])
def test_a_number_that_no_float_holds_is_refused(door, value):
    refused(lambda: door(value))


LONG = "x" * 1_000_000


@pytest.mark.parametrize(
    "door",
    [
        lambda: sl.make_method(LONG),
        lambda: sl.Pallet(1, 1, 1, floor=LONG),
        lambda: sl.Item(0, LONG, (1, 1, 1), 1),
        lambda: sl.check(LAYOUT, "sme", transport=LONG),
        lambda: sl.check(LONG),
        lambda: sl.make_method(f"pbs:alpha={LONG}"),
        lambda: sl.make_method(f"pbs:{LONG}=1"),
    ],
)
def test_a_long_text_is_cut(door):
    with pytest.raises(UserError) as caught:
        door()
    assert len(str(caught.value)) <= 4000
    assert "allowed" in str(caught.value)


def test_a_control_character_is_escaped_in_any_message():
    assert str(UserError("a\tb\x1b[2J\nc")) == r"a\tb\x1b[2J c"


def test_what_is_no_layout_is_refused_by_what_to_pass(tmp_path):
    told = refused(lambda: sl.check("pallets.csv"))
    assert "'pallets.csv' is no layout" in told
    assert "steadyload.read(file)" in told
    refused(lambda: sl.view("pallets.csv", ["sme"], tmp_path / "view.html"))
    refused(lambda: sl.make_method("sme").judge("pallets.csv"))
    refused(lambda: limits("pallets.csv"))


OF_A_TYPE = {
    "check frame": lambda value: sl.check(LAYOUT, "sme", frame=value),
    "check transport": lambda value: sl.check(LAYOUT, "sme", transport=value),
    "repair frame": lambda value: sl.repair(LAYOUT, method="sme", frame=value),
    "repair allow": lambda value: sl.repair(LAYOUT, value, method="sme"),
    "view frame": lambda value: sl.view(LAYOUT, ["sme"], "no.html", frame=value),
    "view methods": lambda value: sl.view(LAYOUT, value, "no.html"),
    "read": sl.read,
    "read_batch": sl.read_batch,
    "read dialect": lambda value: sl.read(CONTENT, dialect=value),
    "read_batch dialect": lambda value: sl.read_batch(CONTENT, dialect=value),
    "read floor": lambda value: sl.read(CONTENT, floor=value),
    "read snap_gap": lambda value: sl.read(CONTENT, snap_gap=value),
    "read with an unknown argument": lambda value: sl.read(CONTENT, snapgap=value),
    "session pallet": sl.LoadingSession,
    "session name": lambda value: sl.LoadingSession(LAYOUT.pallet, name=value),
    "try_place": lambda value: sl.LoadingSession(LAYOUT.pallet).try_place(value),
    "feasible": lambda value: sl.LoadingSession(LAYOUT.pallet).feasible(value, [[0, 0, 0]]),
    "undo": lambda value: sl.LoadingSession(LAYOUT.pallet).undo(value),
    "batch": sl.LayoutBatch.of,
    "judge": sl.make_method("sme").judge,
    "judge_many": sl.make_method("sme").judge_many,
    "layout name": lambda value: sl.Layout(value, LAYOUT.pallet, (BOX,)),
    "layout pallet": lambda value: sl.Layout("one", value, (BOX,)),
    "layout items": lambda value: sl.Layout("one", LAYOUT.pallet, value),
    "item name": lambda value: sl.Item(0, (0, 0, 0), (1, 1, 1), 1, name=value),
    "pallet floor": lambda value: sl.Pallet(1, 1, 1, floor=value),
    "renamed": LAYOUT.renamed,
    "limits": limits,
    "history": lambda value: under_history(LAYOUT, value, [0], "label@mujoco"),
    "score files": lambda value: sl.score(value, ["sme"]),
    "score methods": lambda value: sl.score([], value),
    "score scenario": lambda value: sl.score([], ["sme"], scenario=value),
    "score limit": lambda value: sl.score([], ["sme"], limit=value),
}
WRONG = [object(), (1, 2, 3), [(1, 2, 3)], {"a": 1}, np.array([1, 2]), np.eye(2)]


@pytest.mark.parametrize("value", WRONG, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize("door", OF_A_TYPE)
def test_a_value_of_another_type_is_refused_by_what_is_allowed(door, value):
    refused(lambda: OF_A_TYPE[door](value))


@pytest.mark.parametrize("door", ["read dialect", "check frame", "view frame", "read snap_gap"])
def test_an_empty_list_is_not_taken_for_none(door):
    refused(lambda: OF_A_TYPE[door]([]))


def test_a_text_is_no_list_of_files_or_methods():
    told = refused(lambda: sl.score("pallets.csv", ["sme"]))
    assert told == "files is 'pallets.csv'; allowed: a list of files"
    refused(lambda: sl.score([], "sme"))
    refused(lambda: sl.view(LAYOUT, "sme", "no.html"))


def test_a_misspelt_argument_of_reading_is_named_with_the_nearest():
    told = refused(lambda: sl.read(CONTENT, snapgap=1))
    assert told.startswith("unknown argument 'snapgap'; did you mean 'snap_gap'? allowed: dialect")


@pytest.mark.parametrize("read", [sl.read, sl.read_batch])
def test_bytes_and_open_files_are_read_as_files_are(read, file):
    content = file.read_bytes()
    with file.open("rb") as opened:
        given = [content, bytearray(content), memoryview(content), io.BytesIO(content), opened]
        for one in given:
            [layout] = read(one)
            assert layout.content_hash() == LAYOUT.content_hash()
    with file.open() as text:
        assert "opened to be read as bytes" in refused(lambda: read(text))
    with pytest.raises(UserError, match=r"^the given bytes: holds no layouts; allowed"):
        read(content.partition(b"[")[0] + b"[]}")
    assert len(read(io.BytesIO(as_parquet_bytes()))) == 1


@pytest.mark.parametrize("read", [sl.read, sl.read_batch])
@pytest.mark.parametrize("written", [as_native, as_job])
def test_a_mapping_is_read_as_the_json_file_that_has_it(read, written):
    content = json.loads("".join(written([LAYOUT])))
    for given in (content, MappingProxyType(content)):
        [layout] = read(given)
        assert layout.content_hash() == LAYOUT.content_hash()
    assert refused(lambda: read({})).startswith("the given mapping: is JSON of another kind; ")
    told = refused(lambda: read({**content, "more": object()}))
    assert told.startswith("the given mapping: has what JSON has not")


def as_parquet_bytes():
    return b"".join(as_parquet([LAYOUT]))


def test_a_layout_is_shown_in_one_line():
    assert repr(LAYOUT) == str(LAYOUT)
    assert str(LAYOUT) == "<Layout 'one': 1 box, 12 kg, on a pallet of 120 x 80 cm, up to 160 cm>"
    [seen] = sl.LayoutBatch.of([LAYOUT])
    assert repr(seen) == repr(LAYOUT)
    assert "items" not in vars(seen)


def test_a_missing_file_is_bad_input_and_a_missing_file():
    with pytest.raises(UserError, match=r"^nope.csv: No such file or directory$") as caught:
        sl.read("nope.csv")
    assert isinstance(caught.value, FileNotFoundError)
    with pytest.raises(UserError):
        sl.read_batch("nope.csv")


@pytest.mark.parametrize("read", [sl.read, sl.read_batch])
def test_a_folder_is_bad_input_and_a_folder(read, tmp_path):
    with pytest.raises(UserError) as caught:
        read(tmp_path)
    assert isinstance(caught.value, IsADirectoryError)
    assert str(caught.value) == f"{tmp_path}: is a folder; allowed: a file of layouts"


def test_the_version_is_that_of_the_distribution():
    assert sl.__version__ == metadata.version("steadyload")


def test_methods_explains_the_name_that_check_prints(capsys):
    assert main(["methods", "cascade@mujoco:question=within"]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert ["question", "within", "within|stands"] in [row[:3] for row in rows]
    assert main(["methods", "cascade@mujoco:question=never"]) == 2
    assert "question is 'never'" in capsys.readouterr().err
