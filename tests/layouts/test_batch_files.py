"""Files read as a batch: the arrays that the reader of layouts gives, and its refusals."""

from itertools import product

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import steadyload as sl
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.batch_files import read_batch
from steadyload.layouts.files.csv_batch import _numbers as numbers
from steadyload.layouts.files.csv_batch import batch_of_csv
from steadyload.layouts.files.csv_cells import number
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.files.limits import MAX_ITEMS
from steadyload.layouts.formats import Format, read_layouts, write_layouts
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.floor import FloorError
from steadyload.layouts.model.layout import LayoutError
from steadyload.layouts.packing.packing import random_layouts
from steadyload.layouts.writers import as_csv
from steadyload.methods import make_method

PLAIN = """\
layout,pallet_width,pallet_height,pallet_depth,sequence,item,x,y,z,width,height,depth,weight,offset_x,offset_y,offset_z
P-1,80,200,120,1,SKU-2002,39.5,0,0,40.1,21.1,29.8,7.25,0.3,-1,0
P-1,80,200.,120,0,SKU-2001,0,0,0,39.5,21.1,29.8,8.611,0,0,1.5
P-2,80.0,200,1.2e2,0,'=1,0,0,0,60,15.9,30,12,+0,-0,.5
"""


def write(path, content):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def outcome(read, path, **reading):
    """All arrays and names of a batch as they lie in memory, or the error in words."""
    try:
        found = read(path, **reading)
    except (LayoutError, FloorError) as error:
        return type(error), str(error)
    batch = found if isinstance(found, LayoutBatch) else LayoutBatch.of(found)
    return {
        key: (values.dtype, values.shape, values.tobytes())
        if isinstance(values, np.ndarray)
        else values
        for key, values in vars(batch).items()
    }


def assert_read_alike(path, **reading):
    assert outcome(read_batch, path, **reading) == outcome(read_layouts, path, **reading)


def is_direct(content, **dialect):
    """True where no object an item was made."""
    content = content if isinstance(content, bytes) else content.encode()
    return batch_of_csv(content, Dialect(**dialect), {}) is not None


@pytest.mark.parametrize(
    "content",
    [
        PLAIN,
        PLAIN.replace("\n", "\r\n"),
        PLAIN.replace(",", ";"),
        PLAIN.replace(",", "\t"),
        PLAIN.rstrip("\n"),
        PLAIN.replace("\n", "\n\n"),
        "\ufeff" + PLAIN,
        PLAIN.replace("depth", "length").replace("item", "SKU"),
        PLAIN.replace("item", "offset_q").replace("offset_x", "item").replace("SKU", "q"),
        PLAIN.replace("P-1", "Säule").replace("SKU-2001", ""),
    ],
)
def test_a_plain_file_becomes_arrays_at_once(tmp_path, content):
    if "offset_q" not in content:
        assert is_direct(content)
    assert_read_alike(write(tmp_path / "file.csv", content))


def test_columns_of_ones_own_and_columns_left_out_are_read_at_once(tmp_path):
    content = PLAIN.replace("sequence", "Folge").replace("item", "Bemerkung")
    dialect = {"columns": {"sequence": "Folge"}, "other_columns": "ignore"}
    assert is_direct(content, **dialect)
    assert_read_alike(write(tmp_path / "file.csv", content), dialect=Dialect(**dialect))


OTHERWISE = [
    ("SKU-2001", '"SKU-2001"'),
    ("SKU-2001", '"SKU\n2001"'),
    ("SKU-2001", "S" * 1001),
    ("SKU-2001", "\0"),
    ("SKU-2001", "\x07"),
    ("8.611", " 8.611"),
    ("8.611", "8,611"),
    ("8.611", "8_611"),
    ("8.611", "٨"),
    ("8.611", "nan"),
    ("8.611", "1e-9999999"),
    ("8.611", "0" * 61 + "8.61"),
    ("8.611", "1e7"),
    ("8.611", ""),
    ("P-1,80,200,120,1", "P-1,81,200,120,1"),
    ("P-1,80,200,120,1", "P-1,80,200,120,2"),
    ("P-1,80,200,120,1", "P-1,80,200,120,0"),
    ("P-1,80,200,120,1", "P-1,80,200,120,0.5"),
    ("P-1,80,200,120,1", "P-1,80,200,120"),
    ("P-1,80,200,120,1", "P-1,0,200,120,1"),
    ("P-1", ""),
    ("39.5,0,0", "39,0,0"),
    ("item", "itme"),
    ("layout,", "\nlayout,"),
    ("layout,", "sep=,\nlayout,"),
    ("\nP-2", "\r\rP-2"),
    ("\nP-2", "\n,,,,,,,,,,,,,,,\nP-2"),
    ("\nP-2", "\n \nP-2"),
    (
        "\nP-2",
        "\nP-1,80,200,120,2,a,0,0,30,1,1,1,1,0,0,0\n'=x,80,200,120,0,a,0,0,0,1,1,1,1,0,0,0\n=x",
    ),
]


@pytest.mark.parametrize(("old", "new"), OTHERWISE)
def test_a_file_that_is_wrong_or_rare_is_read_as_layouts_are(tmp_path, old, new):
    assert old in PLAIN
    content = PLAIN.replace(old, new, 1)
    assert not is_direct(content)
    assert_read_alike(write(tmp_path / "file.csv", content))


def test_cells_of_the_marks_of_numbers_state_what_the_other_reader_finds():
    for text in map("".join, (t for k in range(6) for t in product("05.+-e", repeat=k))):
        exact = number(text)
        try:
            (found,) = numbers(pa.array([text]))
        except (ValueError, pa.ArrowException):
            assert exact is None, text
        else:
            assert exact is not None, text
            assert found.hex() == float(exact).hex(), text


def test_text_of_another_encoding_is_refused_alike(tmp_path):
    assert_read_alike(write(tmp_path / "file.csv", PLAIN.replace("P-2", "Ü").encode("latin-1")))


@pytest.mark.parametrize("kind", ["", "\n", PLAIN.partition("\n")[0], "hello", "layout"])
def test_a_file_without_layouts_is_refused_alike(tmp_path, kind):
    assert_read_alike(write(tmp_path / "file.csv", kind))


def test_too_many_items_are_refused_alike(tmp_path):
    head, _, _ = PLAIN.partition("\n")
    rows = (f"a,80,200,120,{k},i,0,0,0,1,1,1,1,0,0,0" for k in range(MAX_ITEMS + 1))
    assert_read_alike(write(tmp_path / "file.csv", "\n".join([head, *rows])))


@pytest.mark.parametrize(
    "reading",
    [
        {"overhang": 0.0},
        {"overhang": -1.0},
        {"floor": "deck"},
        {"floor": "sea"},
        {"snap_gap": 0.5},
        {"dialect": Dialect(units="mm")},
        {"dialect": Dialect(up="z")},
        {"dialect": Dialect(columns={"id": "Artikel"})},
    ],
)
def test_choices_in_reading_hold(tmp_path, reading):
    assert_read_alike(write(tmp_path / "file.csv", PLAIN), **reading)


@pytest.mark.parametrize("kind", [Format.NATIVE, Format.CSV, Format.JOB, Format.PARQUET])
def test_every_format_is_read(tmp_path, kind):
    layouts = [layout.renamed(f"L{k}") for k, layout in enumerate(random_layouts(30, seed=3))]
    write_layouts(tmp_path / "file", layouts, kind)
    assert_read_alike(tmp_path / "file")
    found = sl.read_batch(tmp_path / "file")
    assert [view.items for view in found] == [layout.items for layout in layouts]
    method = make_method("fbs")
    steps = [method.judge(layout).failing_step for layout in layouts]
    assert method.evaluate(found).failing_step.tolist() == [-1 if s is None else s for s in steps]


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_batch(tmp_path / "nothing.csv")


def test_standard_input_is_read(monkeypatch, tmp_path):
    with write(tmp_path / "file.csv", PLAIN).open() as file:
        monkeypatch.setattr("sys.stdin", file)
        assert read_batch("-").names == ("P-1", "P-2")


def test_all_real_schedules_and_pallets_are_read(aclpp_files, customers_pallets, tmp_path):
    for path in [min(aclpp_files, key=lambda file: file.stat().st_size), customers_pallets]:
        found = read_layouts(path)
        assert outcome(read_batch, path) == outcome(lambda _, found=found: found, path)
        layouts = [layout.on("auto") for layout in found]
        plain = [layout for layout in layouts if layout.pallet == Pallet(*layout.pallet.size)]
        if plain:
            write_layouts(tmp_path / "file.csv", plain, Format.CSV)
            assert_read_alike(tmp_path / "file.csv")


NUMBERS = st.one_of(
    st.floats(0.05, 90.0), st.integers(1, 90), st.integers(1, 900).map(lambda k: k / 10)
)
NAMES = st.text(
    st.characters(codec="utf-8", categories=("L", "N", "P", "S"), include_characters=" "),
    max_size=6,
)


@st.composite
def several(draw):
    """Layouts with boxes that stand beside each other along x."""
    made = []
    for name in draw(st.lists(NAMES.filter(bool), min_size=1, max_size=3, unique=True)):
        items, start = [], 0.0
        for sequence in range(draw(st.integers(1, 4))):
            size = tuple(draw(NUMBERS) for _ in range(3))
            offset = tuple(draw(st.floats(-0.4, 0.4)) * side for side in size)
            at = (start, 0.0, draw(NUMBERS))
            items.append(Item(sequence, at, size, draw(NUMBERS), offset, draw(NAMES)))
            start += size[0] + draw(NUMBERS)
        made.append(Layout(name, Pallet(start + 100.0, 190.0, 190.0), tuple(items)))
    return made


@pytest.mark.parametrize("together", [True, False])
@settings(max_examples=60)
@given(layouts=several(), random=st.randoms(use_true_random=False))
def test_written_files_in_any_order_are_read_alike(tmp_path_factory, together, layouts, random):
    head, *rows = as_csv(layouts).splitlines()
    random.shuffle(rows)
    if together:
        rows.sort(key=lambda row: row[: row.index(",", 1)])
    path = tmp_path_factory.mktemp("files") / "file.csv"
    assert_read_alike(write(path, "\n".join([head, *rows])))


PIECES = st.sampled_from([
    b"", b"\n", b"\r", b",", b";", b"\t", b'"', b"'", b" ", b"\0", b"-", b"+", b".", b"e", b"_",
    b"0", b"9", b"1e5", b"1e-400", b"nan", b"inf", b"0x1", b"\xc2\xa0", b"\xff", b"\xef\xbb\xbf",
    b"=", b"'=", b"\xd9\xa8", b"\x0b", b"\xe2\x80\xa8", b"\nP-1,", b"80", b"P-1", b"P-2",
])  # fmt: skip


@settings(max_examples=150)
@given(st.lists(st.tuples(st.integers(0, 400), st.integers(0, 3), PIECES), min_size=1, max_size=3))
def test_a_file_with_mistakes_is_read_or_refused_alike(tmp_path_factory, changes):
    content = bytearray(PLAIN.encode())
    for place, length, piece in changes:
        content[place : place + length] = piece
    assert_read_alike(write(tmp_path_factory.mktemp("files") / "file.csv", bytes(content)))
