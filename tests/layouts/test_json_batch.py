"""JSON read as a batch: the arrays that the reader of layouts gives, and its refusals."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from steadyload.layouts import json_batch
from steadyload.layouts.batch_files import read_batch
from steadyload.layouts.files import limits
from steadyload.layouts.formats import read_layouts
from steadyload.layouts.json_batch import batch_of_json
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.layout import LayoutError
from steadyload.layouts.packing.packing import random_layouts
from steadyload.layouts.writers import as_native


def box(sequence, x, **stated):
    return {
        "sequence": sequence, "name": f"SKU-{x}", "position": [x, 0.0, 1e1],
        "size": [5.1, 20, 30.25], "weight": 0.3, "mass_offset": [0.1, -0.0, -0], **stated,
    }  # fmt: skip


def layout(name, *boxes, **stated):
    return {"name": name, "pallet": {"width": 80, "height": 200.0, "depth": 120.0, **stated},
            "items": list(boxes)}  # fmt: skip


def file_of(*layouts):
    return {"format": "steadyload-layouts", "version": 1, "layouts": list(layouts)}


LAYOUTS = [
    layout("one: 1", box(0, 0), box(1, 10)),
    layout("two", box(0, -9.5), floor="deck", deck_height=12),
    layout("three", box(1, 30.125), box(2, 0), box(0, 60)),
    layout("four", box(0, 7), overhang=-0.0),
]
TEXT = json.dumps(file_of(*LAYOUTS))
CHUNKS = (110, 250, 700, 10**6)


def write(path, content):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def in_memory(found):
    """All arrays and names of a batch as they lie in memory."""
    batch = found if isinstance(found, LayoutBatch) else LayoutBatch.of(found)
    return {
        key: (values.dtype, values.shape, values.tobytes())
        if isinstance(values, np.ndarray)
        else (values, repr(values))
        for key, values in {**vars(batch), "kinds": batch.pallets}.items()
    }


def outcome(read, path):
    """What is read, or the error in words."""
    try:
        return in_memory(read(path))
    except LayoutError as error:
        return type(error), str(error)


def directly(content, size=10**6):
    """The batch that is made without an object an item, of chunks of a size; None if there is none.

    The first chunk holds what stands before the layouts.
    """
    content = content if isinstance(content, bytes) else content.encode()
    parts = (content[k : k + size] for k in range(0, len(content), size))
    return batch_of_json(parts, {})


def renamed(old, new, boxes):
    return [{new if key == old else key: value for key, value in one.items()} for one in boxes]


def without(key):
    return [
        {**one, "items": [{k: v for k, v in item.items() if k != key} for item in one["items"]]}
        for one in LAYOUTS
    ]


def backwards(value):
    """The same with the keys of all objects below the top in the other order."""
    if isinstance(value, dict):
        return {key: backwards(below) for key, below in reversed(value.items())}
    return [backwards(below) for below in value] if isinstance(value, list) else value


@pytest.mark.parametrize("size", CHUNKS)
@pytest.mark.parametrize(
    "content",
    [
        TEXT,
        "".join(as_native(random_layouts(9, 3))),
        *(json.dumps(file_of(*LAYOUTS), indent=indent) for indent in (0, 1, 4, "\t")),
        json.dumps(file_of(*LAYOUTS), separators=(",", ":")),
        json.dumps(file_of(*LAYOUTS), indent=1).replace("\n", "\r\n"),
        "\ufeff \n" + TEXT + "\n\n",
        json.dumps(file_of(*backwards(LAYOUTS))),
        json.dumps(file_of(*without("mass_offset"))),
        json.dumps(file_of(*without("name"))),
        json.dumps(file_of(*({**one, "items": renamed("name", "id", one["items"])}
                             for one in LAYOUTS))),
        json.dumps(file_of(LAYOUTS[0])),
        TEXT.replace("SKU", "S\u00e4ule \U0001f4e6"),
        json.dumps(file_of(layout('S\u00e4ule \\ "\U0001f4e6"', box(0, 0)), *LAYOUTS)),
        TEXT.replace("SKU-0", "}]}, {"),
        TEXT.replace("5.1, 20,", "5.1000000000000000000000001, 5e-1,").replace("0.3", "3E-1"),
    ],
)  # fmt: skip
def test_a_plain_file_becomes_arrays_at_once(tmp_path, content, size):
    found = directly(content, size)
    assert found is not None
    read = read_layouts(write(tmp_path / "file.json", content))
    assert in_memory(found) == in_memory(read)


OTHERWISE = [
    ('"sequence": 1', '"sequence": 1.0'),
    ('"sequence": 1', '"sequence": 2'),
    ('"sequence": 1', '"sequence": 99999999999999999999'),
    ('"sequence": 1', '"sequence": -1'),
    ('"sequence": 1', '"sequence": true'),
    ('"sequence": 1', '"sequence": "1"'),
    ('"sequence": 1', '"sequence": 1, "sequence": 1'),
    ('"weight": 0.3', '"weight": 0.3, "weight": 0.3'),
    ('"weight": 0.3', '"weight": 0.3, "w\\u0065ight": 0.3'),
    ('"weight": 0.3', '"weight": true'),
    ('"weight": 0.3', '"weight": "0.3"'),
    ('"weight": 0.3', '"weight": NaN'),
    ('"weight": 0.3', '"weight": 1e999'),
    ('"weight": 0.3', '"weight": -0.3'),
    ('"weight": 0.3', f'"weight": {"9" * 400}'),
    ('"weight": 0.3', f'"weight": {"9" * 5000}'),
    ('"weight": 0.3', '"weight": 0.3, "max_load": 4'),
    ('"weight": 0.3', '"wieght": 0.3'),
    ('"weight": 0.3, ', ""),
    ('"weight": 0.3', '"weight": 0.3, "id": "a"'),
    ('"weight": 0.3', '"weight": .3'),
    ('"weight": 0.3', '"weight": 00.3'),
    ('"weight": 0.3', '"weight": 0.3,'),
    ('"weight": 0.3', '"weight": null'),
    ('"weight": 0.3', '"weight": ' + "[" * 2000 + "]" * 2000),
    ('"weight": 0.3', '"weight": ' + '{"a": ' * 20 + "1" + "}" * 20),
    ("[0.1, -0.0, 0]", "[0.1, -0.0]"),
    ("[0.1, -0.0, 0]", '"abc"'),
    ("[0.1, -0.0, 0]", "[0.1, -0.0, 30]"),
    ("[0.1, -0.0, 0]", "null"),
    ('"mass_offset": [0.1, -0.0, 0]', '"mass_offset": [0, 0, 0], "a": 1'),
    (', "mass_offset": [0.1, -0.0, 0]', ""),
    ('"SKU-0"', "null"),
    ('"SKU-0"', "7"),
    ('"SKU-0"', '"S\\u0007"'),
    ('"SKU-0"', '"S\x07"'),
    ('"SKU-0"', '"S\\ud800"'),
    ('"SKU-0"', '"S\\u003a"'),
    ('"SKU-0"', '"S\\x"'),
    ('"SKU-0"', '"S'),
    ('"SKU-0"', f'"{"S" * 1001}"'),
    ('"name": "SKU-0"', '"name": "a", "name": "\\u003a"'),
    ('"one: 1"', '"two"'),
    ('"one: 1"', '""'),
    ('"one: 1"', '" \\n"'),
    ('"one: 1"', f'"{"S" * 1001}"'),
    ('"one: 1"', "1"),
    ('"width": 80', '"width": "80"'),
    ('"width": 80', '"width": true'),
    ('"width": 80', '"width": 8, "width": 80'),
    ('"width": 80', '"breadth": 80'),
    ('"width": 80', '"width": [80]'),
    ('"floor": "deck"', '"floor": "sea:"'),
    ('"floor": "deck"', '"floor": {"a": 1}'),
    ('"pallet"', '"palette"'),
    ('"name": "two"', '"name": "two", "name": "two"'),
    ('"name": "two"', '"name": "two", "depth": 1'),
    ('"items": [{', '"items": [{}, {'),
    ('"items": [{', '"items": [[], {'),
    ('"items": [{', '"items": [{"items": [{"a": 1}], '),
    ('"version": 1', '"version": 1.0'),
    ('"version": 1', '"version": 2'),
    ('"version": 1', '"version": 1, "version": 1'),
    ('"format": "steadyload-layouts", ', ""),
    ('"layouts": [', '"layouts": [[], '),
    ('"layouts": [', '"layouts": [, '),
    ('"layouts": [', '"layouts": ['),
    ("}]}, {", "}]}, , {"),
    ("}]}, {", "}]} {"),
    ("}]}, {", "}]}], {"),
    ('[-9.5, 0.0, 10.0]', '[-10.5, 0.0, 10.0]'),
    ('[10, 0.0, 10.0]', '[4, 0.0, 10.0]'),
]  # fmt: skip
"""Changes, by the last of which and some others the file is still JSON; the one of none is cut."""


@pytest.mark.parametrize(("old", "new"), OTHERWISE)
def test_a_file_that_is_wrong_or_rare_is_read_as_layouts_are(tmp_path, old, new):
    assert old in TEXT
    content = TEXT.replace(old, new, 1) if old != new else TEXT.removesuffix("}")
    assert [directly(content, size) for size in CHUNKS] == [None] * len(CHUNKS)
    path = write(tmp_path / "file.json", content)
    assert outcome(read_batch, path) == outcome(read_layouts, path)


@pytest.mark.parametrize(
    "content",
    [
        TEXT + "x",
        TEXT + "]",
        TEXT.replace("SKU", "\u00fc").encode("latin-1"),
        TEXT.encode().replace(b"SKU", b"\xed\xa0\x80"),
        "\ufeff" + "\ufeff" + TEXT,
        json.dumps(file_of()),
        json.dumps(file_of(layout("none"))),
        json.dumps({"layouts": LAYOUTS, "format": "steadyload-layouts", "version": 1}),
        json.dumps({**file_of(*LAYOUTS), "more": 1}),
        TEXT.removesuffix("}"),
        TEXT.removesuffix("}]}]}"),
        TEXT.removesuffix("]}") + ", ]}",
    ],
)
def test_what_stands_around_layouts_is_read_as_layouts_are(tmp_path, content):
    assert directly(content) is None
    path = write(tmp_path / "file.json", content)
    assert outcome(read_batch, path) == outcome(read_layouts, path)


def test_too_many_items_are_refused_alike(tmp_path):
    boxes = [box(k, 0) for k in range(limits.MAX_ITEMS + 1)]
    content = json.dumps(file_of(*LAYOUTS, layout("many", *boxes)))
    assert directly(content, 64 * 1024) is None
    path = write(tmp_path / "file.json", content)
    assert outcome(read_batch, path) == outcome(read_layouts, path)


def test_what_is_stated_of_all_pallets_holds(tmp_path):
    path = write(tmp_path / "file.json", TEXT)
    for reading in ({"overhang": 20.0}, {"floor": "infinite"}, {"overhang": 12, "floor": "deck"}):
        found, expected = read_batch(path, **reading), read_layouts(path, **reading)
        assert in_memory(found) == in_memory(expected)


@pytest.mark.parametrize("size", [2_000, 64 * 1024])
def test_a_layout_is_given_up_when_it_is_longer_than_allowed(size):
    read = []

    def chunks():
        yield TEXT.encode().removesuffix(b"}]}]}") + b"}, "
        while sum(read) < 3 * limits.MAX_VALUE_LENGTH:
            read.append(size)
            yield b'{"sequence": 1, "name": "' + b"x" * size + b'"}, '

    assert batch_of_json(chunks(), {}) is None
    assert sum(read) <= limits.MAX_VALUE_LENGTH


def test_layouts_are_parsed_in_blocks(monkeypatch):
    content = json.dumps(file_of(*(layout(f"L{k}", box(0, 1)) for k in range(500))))
    lengths = []

    def loads(block, plain=json_batch.orjson.loads):
        lengths.append(len(block))
        return plain(block)

    monkeypatch.setattr(json_batch.orjson, "loads", loads)
    assert len(directly(content, 1000)) == 500
    assert max(lengths) < 2000


NUMBERS = st.one_of(
    st.integers(1, 9), st.floats(0.05, 9.0), st.sampled_from([0, -0.0, 1e-320, 2**70, True, "1"])
)
PIECES = st.sampled_from([
    b"", b"\n", b" ", b",", b":", b'"', b"\\", b"\\u003a", b"\\u00e4", b"\\ud800", b"{", b"}",
    b"[", b"]", b"{}", b"[]", b"null", b"true", b"NaN", b"-", b"-0", b"0", b"1e5", b"1e999", b".",
    b"9" * 30, b'"name"', b'"id"', b'"max_load": 1,', b'"weight": 1, ', b"\xff", b"\xef\xbb\xbf",
    b"\xed\xa0\x80", b"\0", b"}]}, {", b"two",
])  # fmt: skip


@settings(max_examples=150)
@given(
    st.lists(st.tuples(st.integers(0, len(TEXT)), st.integers(0, 3), PIECES), min_size=1,
             max_size=3),
    st.sampled_from(CHUNKS),
)  # fmt: skip
def test_a_file_with_mistakes_is_read_or_refused_alike(tmp_path_factory, changes, size):
    content = bytearray(TEXT.encode())
    for place, length, piece in changes:
        content[place : place + length] = piece
    path = write(tmp_path_factory.mktemp("files") / "file.json", bytes(content))
    expected = outcome(read_layouts, path)
    found = directly(bytes(content), size)
    assert found is None or in_memory(found) == expected
    assert outcome(read_batch, path) == expected


@settings(max_examples=60)
@given(st.lists(st.lists(NUMBERS, min_size=10, max_size=10), min_size=1, max_size=4))
def test_numbers_are_read_alike(tmp_path_factory, rows):
    boxes = [
        {"sequence": k, "position": [10 * k, *row[:2]], "size": row[2:5], "weight": row[5],
         "mass_offset": row[6:9]}
        for k, row in enumerate(rows)
    ]  # fmt: skip
    path = tmp_path_factory.mktemp("files") / "file.json"
    write(path, json.dumps(file_of(layout("one", *boxes))))
    assert outcome(read_batch, path) == outcome(read_layouts, path)
