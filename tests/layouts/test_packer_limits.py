"""Plans of packers that are too large, or damaged: refused by one sentence, in little time."""

import json
import time

import pytest

import steadyload as sl
from steadyload.layouts import LayoutError
from steadyload.layouts.files.limits import MAX_VALUE_LENGTH
from steadyload.layouts.formats import scan_layouts
from steadyload.layouts.packers.plan import Bin, Placed, plan

HEADER = "TYPE,ID,COPIES,BIN,X,Y,Z,LX,LY,LZ,ROTATION\n"
BIN = "BIN,0,{copies},{number},0,0,0,100,100,100,\n"
ITEM = "ITEM,7,1,{number},0,0,0,20,30,40,XYZ\n"


def certificate(path, *bins):
    """A file of bins, each of so many copies and items, which all lie in one place."""
    path.write_text(
        HEADER
        + "".join(
            BIN.format(copies=copies, number=number) + ITEM.format(number=number) * items
            for number, (copies, items) in enumerate(bins)
        )
    )
    return path


def refusal(path):
    """Names of the layouts that are valid, and the sentences on the others."""
    names, sentences = [], []
    for entry in scan_layouts(path):
        if hasattr(entry, "error"):
            sentences.append(str(entry.error))
        else:
            names.append(entry.name)
    return names, sentences


def test_a_bin_of_too_many_items_is_refused_and_the_others_are_read(tmp_path):
    path = certificate(tmp_path / "plan.csv", (1, 1), (1, 5_001), (2, 1))
    names, sentences = refusal(path)
    assert names == ["bin 0", "bin 2", "bin 2 copy 1"]
    assert sentences == [
        f'{path}: layout "bin 1": has more than 5,000 items; that is the most allowed'
    ]
    with pytest.raises(LayoutError, match=r"bin 1.*more than 5,000 items"):
        sl.from_packingsolver(path)


def test_copies_are_counted_with_their_items(tmp_path):
    path = certificate(tmp_path / "plan.csv", (10_000, 1), (10_000, 100))
    begun = time.process_time()
    with pytest.raises(LayoutError, match="more than 1,000,000 layouts or 1,000,000 items"):
        sl.from_packingsolver(path)
    assert time.process_time() - begun < 2.0


def test_copies_of_empty_bins_take_no_time(tmp_path):
    path = certificate(tmp_path / "plan.csv", *[(10_000, 0)] * 5_000, (1, 1))
    begun = time.process_time()
    assert [layout.name for layout in sl.read(path)] == ["bin 5000"]
    assert time.process_time() - begun < 2.0


@pytest.mark.parametrize(
    ("cell", "message"),
    [
        ("x" * 200_000, "line 2 is not CSV"),
        ("x" * 2_000, "line 2 has a cell of 2,000 characters; allowed: 1,000"),
        ("9" * 900, "line 2 has LX '9999"),
        ("1e9", "line 2 has LX '1e9'; allowed: a number"),
    ],
)
def test_a_cell_of_a_certificate_has_a_length(tmp_path, cell, message):
    path = tmp_path / "plan.csv"
    path.write_text(HEADER + BIN.format(copies=1, number=0).replace("100", cell, 1))
    for read in (sl.read, sl.from_packingsolver):
        with pytest.raises(LayoutError, match=message) as caught:
            read(path)
        assert len(str(caught.value)) < len(str(path)) + 200


def test_equal_names_are_numbered_in_linear_time():
    """Four times as many take four times as long, with as much again for a busy machine."""
    few, many = (min(numbered(count) for _ in range(3)) for count in (5_000, 20_000))
    assert many < 8.0 * few


def numbered(count):
    """CPU seconds of numbering so many equal names."""
    box = Placed("box", (0.0, 0.0, 0.0), (10.0, 10.0, 10.0), 1.0)
    bins = [Bin(name, (50, 50, 50), [box]) for name in ["a (2)", *["a"] * count]]
    begun = time.process_time()
    names = [layout.name for layout in plan(bins, (), "height").layouts]
    spent = time.process_time() - begun
    assert names[:4] == ["a (2)", "a", "a (3)", "a (4)"]
    assert len(set(names)) == len(names)
    return spent


# --- Packvium -------------------------------------------------------------------------------------


def ticks(names, *values):
    pairs = zip(names, values, strict=True)
    return {name: {"ticks": 160_000 * value, "unit": "cm"} for name, value in pairs}


SIDES = ("length", "width", "height")


def container(name, items=1, item_id="a#1"):
    placement = {
        "item_id": item_id, "item_type": "a", "position": ticks("xyz", 0, 0, 0),
        "dimensions": ticks(SIDES, 20, 30, 40),
    }  # fmt: skip
    size = ticks(SIDES, 100, 100, 100)
    return {"id": name, "inner_dimensions": size, "placements": [placement] * items}


def result(path, *containers, **others):
    left = [{"item_id": "b#1", "reason": "too large"}]
    path.write_text(json.dumps({"containers": containers, "unpacked_items": left} | others))
    return path


def test_a_container_that_is_none_is_refused_and_the_others_are_read(tmp_path):
    path = result(
        tmp_path / "plan.json", container("one"), 7, container("two", 5_001),
        container("three", item_id="x" * 1_001), container("four"),
    )  # fmt: skip
    names, sentences = refusal(path)
    assert names == ["one", "four"]
    assert [sentence.removeprefix(f"{path}: ") for sentence in sentences] == [
        'layout "containers[1]": containers[1] is 7; allowed: an object',
        'layout "two": has 5,001 items; allowed: at most 5,000',
        'layout "three": item_id has 1,001 characters; allowed: at most 1,000',
    ]
    with pytest.raises(LayoutError, match=r"containers\[1\] is 7"):
        sl.from_packvium(path)


def test_a_result_may_be_larger_than_one_value_may_be(tmp_path):
    """Containers are read one by one; all of them exceed what a single value may have."""
    path = result(tmp_path / "plan.json", *[container(str(k), 5_000) for k in range(3)])
    assert path.stat().st_size > MAX_VALUE_LENGTH
    names, sentences = refusal(path)
    assert names == []
    assert len(sentences) == 3
    assert all("overlaps" in sentence for sentence in sentences)


def test_members_of_a_result_may_stand_in_any_order(tmp_path):
    path = tmp_path / "plan.json"
    whole = {"unpacked_items": [], "warnings": [], "containers": [container("one")]}
    path.write_text(json.dumps(whole))
    assert [layout.name for layout in sl.read(path)] == ["one"]
    (layout,) = sl.from_packvium(path).layouts
    assert layout.name == "one"


@pytest.mark.parametrize(
    ("others", "message"),
    [
        ({"containers": "abc"}, "containers is 'abc'; allowed: a list"),
        ({"unpacked_items": {"a": 1}}, "unpacked_items is {'a': 1}; allowed: a list"),
    ],
)
def test_members_of_a_result_are_lists(tmp_path, others, message):
    path = result(tmp_path / "plan.json", container("one"), **others)
    for read in (sl.read, sl.from_packvium):
        with pytest.raises(LayoutError, match=message):
            read(path)


def test_json_that_is_no_result_is_refused_with_its_place(tmp_path):
    path = tmp_path / "plan.json"
    for text, message in (
        ('{"containers": [', "is not valid JSON"),
        ("[" * 100_000, "is not valid JSON"),
        ('{"containers": [], "containers": []}', "twice in one object"),
        ('{"a": 1}', "is no result of Packvium"),
        ('{"containers": ' + "[" * 50_000, "nested too deeply"),
    ):
        path.write_text(text)
        with pytest.raises(LayoutError, match=message) as caught:
            sl.from_packvium(path)
        assert str(path) in str(caught.value)
