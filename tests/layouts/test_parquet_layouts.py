"""Parquet files of layouts: there and back to the last bit, and every kind of wrong file."""

import io
import os
import random
import sys
from contextlib import suppress

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import steadyload as sl
from steadyload.cli import main
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.files import parquet_layouts, parquet_rows
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.files.limits import MAX_ITEMS
from steadyload.layouts.files.parquet_footer import Group, footer_of, groups_of
from steadyload.layouts.files.parquet_layouts import (
    REQUIRED,
    SCHEMA,
    batch_of,
    parquet_of,
    rows_of,
)
from steadyload.layouts.files.parquet_rows import row_batches
from steadyload.layouts.files.record import FormatError, Refused
from steadyload.layouts.files.sources import Content
from steadyload.layouts.formats import Format, read_layouts, scan_layouts, write_layouts
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.floor import FloorKind
from steadyload.layouts.model.layout import LayoutError
from steadyload.layouts.packing.packing import random_layouts
from steadyload.layouts.rewriting import Replanned, rewrite

PALLETS = (
    Pallet(120.0, 160.0, 80.0),
    Pallet(100.1, 90.0, 33.3, overhang=2.5),
    Pallet(80.0, 200.0, 120.0, deck_height=12.0, floor=FloorKind.DECK),
    Pallet(60.0, 50.0, 40.0, floor="infinite", overhang=0.0),
)
BOX = {"x": [1.0], "y": [0.0], "z": [2.0], "width": [30.0], "height": [20.0], "depth": [10.0],
       "weight": [5.0]}  # fmt: skip
PLAIN = {"layout": "A", "pallet_width": 120.0, "pallet_height": 160.0, "pallet_depth": 80.0, **BOX}


def drawn(count, seed=5):
    """Layouts of one to some items, on several pallets, with and without ids and offsets."""
    random_ = random.Random(seed)
    found = []
    for k, layout in enumerate(random_layouts(count, seed=seed)):
        kind = PALLETS[k % len(PALLETS)]
        pallet = Pallet(
            *layout.pallet.size,
            overhang=kind.overhang, deck_height=kind.deck_height, floor=kind.floor,
        )  # fmt: skip
        items = tuple(
            Item(
                i.sequence, i.position, i.size, i.weight * random_.random(),
                tuple(side * random_.uniform(-0.5, 0.5) if k % 3 else -0.0 for side in i.size),
                f"box {i.sequence} ü" if k % 2 and i.sequence else "",
            )
            for i in layout.items
        )  # fmt: skip
        found.append(Layout(f"L{k} é", pallet, items).first(1 + k % 12))
    return found


def bits(batch):
    return {
        key: values.tobytes() if isinstance(values, np.ndarray) else values
        for key, values in vars(batch).items()
    }


def table(*rows, **types):
    """A table of rows; columns of a type of their own are named."""
    names = dict.fromkeys(name for row in rows for name in row)
    kinds = [types.get(name, SCHEMA.field(name).type if name in SCHEMA.names else None)
             for name in names]  # fmt: skip
    return pa.table([pa.array([row.get(name) for row in rows], kind)
                     for name, kind in zip(names, kinds, strict=True)], list(names))  # fmt: skip


def write(path, found, **how):
    pq.write_table(found, path, **how)
    return path


def read_back(path):
    with path.open("rb") as file:
        return [(rows, batch_of(rows)) for rows in row_batches(file)]


@pytest.mark.parametrize("count", [1, 7, 60])
def test_a_batch_comes_back_to_the_last_bit(tmp_path, count):
    batch = LayoutBatch.of(drawn(count))
    (tmp_path / "file").write_bytes(b"".join(parquet_of([rows_of(batch)])))
    ((_, found),) = read_back(tmp_path / "file")
    assert bits(found) == bits(batch)


@pytest.mark.parametrize(("start", "stop"), [(0, 0), (3, 9), (9, 20)])
def test_a_part_of_a_batch_is_written_as_a_batch_of_its_own(start, stop):
    batch, layouts = LayoutBatch.of(drawn(20)), drawn(20)[start:stop]
    assert rows_of(batch[start:stop]).equals(rows_of(LayoutBatch.of(layouts)))


@pytest.mark.parametrize(("layouts", "items"), [(10_000, 250_000), (4, 250_000), (10_000, 15)])
def test_groups_are_bounded_and_a_file_is_read_group_by_group(
    tmp_path, monkeypatch, layouts, items
):
    for module in (parquet_layouts, parquet_rows):
        monkeypatch.setattr(module, "GROUP_LAYOUTS", layouts)
        monkeypatch.setattr(module, "GROUP_ITEMS", items)
    given = drawn(30)
    write_layouts(tmp_path / "file", given, Format.PARQUET)
    about = pq.read_metadata(tmp_path / "file")
    sizes = [about.row_group(k).num_rows for k in range(about.num_row_groups)]
    assert sum(sizes) == len(given)
    assert max(sizes) <= layouts
    assert len(sizes) > 1 or items > 15 < layouts
    for rows, batch in read_back(tmp_path / "file"):
        assert len(rows) <= layouts
        assert len(batch.weights) <= items or len(rows) == 1
    assert bits(LayoutBatch.of(read_layouts(tmp_path / "file"))) == bits(LayoutBatch.of(given))


def test_layouts_are_asked_for_as_their_group_is_written(tmp_path, monkeypatch):
    monkeypatch.setattr(parquet_layouts, "GROUP_LAYOUTS", 3)
    asked = []
    parts = parquet_layouts.as_parquet(asked.append(k) or one for k, one in enumerate(drawn(8)))
    next(parts)
    assert asked == [0, 1, 2, 3]


def test_a_file_of_another_program_is_read(tmp_path):
    """Whole numbers, floats of four bytes, large lists and texts, and no column that may lack."""
    kinds = {"x": pa.large_list(pa.int64()), "weight": pa.list_(pa.float32()),
             "layout": pa.large_string(), "pallet_width": pa.int16()}  # fmt: skip
    row = PLAIN | {"x": [1], "pallet_width": 120}
    path = write(tmp_path / "a.parquet", table(row, row | {"layout": "B"}, **kinds))
    first, second = read_layouts(path)
    assert (first.name, second.name) == ("A", "B")
    assert first.pallet == Pallet(120.0, 160.0, 80.0)
    assert first.items == (Item(0, (1.0, 0.0, 2.0), (30.0, 20.0, 10.0), 5.0),)
    assert set(table(PLAIN).column_names) == set(REQUIRED)


@pytest.mark.parametrize("how", [{}, {"use_dictionary": False}, {"compression": "gzip"},
                                 {"data_page_version": "2.0"}, {"row_group_size": 1}])  # fmt: skip
def test_it_does_not_matter_how_a_table_is_stored(tmp_path, how):
    layouts = drawn(9)
    rows = pa.Table.from_batches([rows_of(LayoutBatch.of(layouts))])
    file = write(tmp_path / "a", rows, **how)
    for found in (LayoutBatch.of(read_layouts(file)), sl.read_batch(file)):
        assert bits(found) == bits(LayoutBatch.of(layouts))


@pytest.mark.parametrize("kind", [pa.large_string(), pa.string_view()])
def test_texts_may_be_of_every_type(tmp_path, kind):
    layouts = drawn(9)
    rows = pa.Table.from_batches([rows_of(LayoutBatch.of(layouts))])
    place = rows.schema.get_field_index("layout")
    found = sl.read_batch(
        write(tmp_path / "a", rows.set_column(place, "layout", rows["layout"].cast(kind)))
    )
    assert found.names == tuple(layout.name for layout in layouts)


def test_nulls_stand_for_what_is_not_stated(tmp_path):
    stated = {"overhang": 3.0, "deck_height": 9.0, "floor": "deck", "id": ["a"], "max_load": [7.0],
              "offset_x": [1.0], "offset_y": [0.5], "offset_z": [0.0]}  # fmt: skip
    for more in ({}, {"max_load": [None]}):  # with loads rows become records, else a batch
        path = write(tmp_path / "a", table(PLAIN | stated | more, PLAIN | {"layout": "B"} | BOX))
        one, other = scan_layouts(path)
        assert one.pallet == Pallet(
            120.0, 160.0, 80.0, overhang=3.0, deck_height=9.0, floor=FloorKind.DECK
        )
        assert (one.ids, one.items[0].mass_offset) == (("a",), (1.0, 0.5, 0.0))
        assert one.items[0].max_load == (None if more else 7.0)
        assert (other.pallet, other.ids, other.max_loads) == (Pallet(120.0, 160.0, 80.0), (), ())
        assert other.items[0].mass_offset == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("loads", [{}, {"max_load": [9.0]}])
def test_an_option_comes_before_what_a_file_states(tmp_path, loads):
    over = PLAIN | {"x": [-9.0], "overhang": 9.5, "floor": "auto"} | loads
    path = write(tmp_path / "a", table(over))
    assert read_layouts(path)[0].floor.has_edges
    (found,) = read_layouts(path, overhang=20.0, floor="infinite")
    assert (found.pallet.overhang, found.floor.has_edges) == (20.0, False)
    with pytest.raises(LayoutError, match=r"allowed: inside the pallet's contour, -5 to 125 cm"):
        read_layouts(path, overhang=5.0)


def test_small_gaps_are_closed_and_a_doubt_about_units_is_told(tmp_path, caplog):
    path = write(tmp_path / "a", table(PLAIN | {"y": [0.25], "weight": [5e5]}))
    assert read_layouts(path)[0].items[0].position[1] == 0.25
    assert "did you mean --weight g?" in caplog.text
    assert read_layouts(path, snap_gap=0.5)[0].items[0].position[1] == 0.0


WRONG = [
    ({"weight": [float("nan")]}, "item 0: weight is nan kg"),
    ({"weight": [-1.0]}, "weight is -1 kg"),
    ({"weight": [None]}, "item 0: weight is missing; allowed: a number [kg]"),
    ({"x": [float("inf")]}, "position x is inf cm"),
    ({"x": [105.0]}, "allowed: inside the pallet's contour, -10 to 130 cm"),
    ({"width": [0.0]}, "width is 0 cm"),
    ({"pallet_depth": None}, "pallet depth is missing; allowed: a number [cm]"),
    ({"pallet_depth": float("nan")}, "pallet depth is nan cm"),
    ({"overhang": -1.0}, "pallet overhang is -1 cm"),
    ({"deck_height": float("nan")}, "pallet deck_height is nan cm"),
    ({"floor": "desk"}, "pallet floor is 'desk'; allowed: auto, deck, infinite"),
    ({"offset_x": [20.0], "offset_y": [0.0], "offset_z": [0.0]},
     "centre-of-mass offset x is 20 cm"),
    ({"offset_x": [1.0]}, ""),
    ({"max_load": [-2.0]}, "max_load is -2 kg"),
    ({"id": ["a\x1b"]}, r"name is 'a\x1b'"),
    ({"height": None}, "height is missing; allowed: a list of numbers, one an item"),
    ({"height": [1.0, 2.0]}, "height has 2 entries, and x has 1; allowed: one an item"),
    ({"id": []}, "id has 0 entries, and x has 1; allowed: one an item"),
    ({key: [] for key in BOX}, "has no items; allowed: one or more"),
    ({key: values * (MAX_ITEMS + 1) for key, values in BOX.items()},
     "has 5,001 items; allowed: at most 5,000"),
    ({"layout": "\x1b[2J"}, "name is '\\x1b[2J'"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "message"), WRONG)
def test_a_wrong_layout_among_others_is_named_with_its_place(tmp_path, changes, message):
    rows = [PLAIN | {"layout": name} for name in "XYZ"]
    rows[1] |= changes
    path = write(tmp_path / "bad.parquet", table(*rows))
    first, wrong, last = scan_layouts(path)
    assert (first.name, last.name) == ("X", "Z")
    if not message:
        assert wrong.items[0].mass_offset == (1.0, 0.0, 0.0)
        return
    assert isinstance(wrong, Refused)
    assert message in str(wrong.error)
    assert str(wrong.error).startswith(f'{path}: layout "')
    assert "allowed" in str(wrong.error)
    assert str(wrong.error).isprintable()


def stated_footer(length):
    return lambda content: content[:-8] + length.to_bytes(4, "little") + content[-4:]


TABLES = [
    (lambda plain: plain.drop_columns("z"), "lacks the column 'z'; allowed: a row a layout"),
    (lambda plain: plain.append_column("sequence", [[0]]), "has the unknown column 'sequence'"),
    (lambda plain: plain.append_column("offset x", [[0]]), "did you mean 'offset_x'?"),
    (lambda plain: plain.append_column("x", [[[0.0]]]), "has the column 'x' twice"),
    (lambda plain: plain.set_column(0, "layout", [[7]]),
     "has the column 'layout' of type int64; allowed: texts"),
    (lambda plain: plain.set_column(4, "x", [[0.5]]),
     "has the column 'x' of type double; allowed: lists of numbers"),
    (lambda plain: plain.set_column(4, "x", [[["0.5"]]]), "lists of numbers"),
    (lambda plain: plain.set_column(4, "x", [[[True]]]), "lists of numbers"),
    (lambda plain: plain.set_column(4, "x", [[[2**60 + 1]]]), "cannot be read as Parquet"),
    (lambda plain: plain.set_column(0, "layout", [pa.nulls(1, pa.string())]),
     "row 0 (counted from 0) has layout missing; allowed: a text"),
    (lambda plain: plain.set_column(0, "layout", [["ü" * 1001]]),
     "has a text of 1,001 characters in the column 'layout'; allowed: at most 1,000"),
    (lambda plain: plain.append_column("id", [[["i" * 1001]]]), "in the column 'id'"),
    (lambda plain: pa.concat_tables([plain, plain]), "name stands there twice"),
    (lambda plain: plain.slice(0, 0), "holds no layouts"),
    (lambda plain: pa.table({}), "lacks the column"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "message"), TABLES)
def test_a_wrong_table_is_refused_in_a_sentence(tmp_path, change, message):
    assert_refused(write(tmp_path / "bad.parquet", change(table(PLAIN))), message)


@pytest.mark.parametrize(("change", "message"), [
    (lambda content: content[:-9], "is a Parquet file that is cut off"),
    (stated_footer(2**21), "has a footer of 2 MiB; allowed: 1 MiB"),
    (stated_footer(2**20), "cannot be read as Parquet (its footer is damaged)"),
    (lambda content: b"PAR1", "cut off"),
    (lambda content: b"PAR1PAR1", "has a footer of 790 MiB; allowed"),
    (lambda content: content[:40] + bytes(80) + content[120:], "cannot be read as Parquet ("),
])  # fmt: skip
def test_a_damaged_file_is_refused_in_a_sentence(tmp_path, change, message):
    path = write(tmp_path / "bad.parquet", table(PLAIN))
    path.write_bytes(change(path.read_bytes()))
    assert_refused(path, message)


def assert_refused(path, message):
    with pytest.raises(FormatError) as caught:
        read_layouts(path)
    assert message in str(caught.value)
    assert str(caught.value).startswith(str(path))
    assert str(caught.value).isprintable()


def test_every_truncation_is_refused(tmp_path):
    path = tmp_path / "file"
    write_layouts(path, drawn(4), Format.PARQUET)
    content = path.read_bytes()
    for length in range(4, len(content), 97):
        path.write_bytes(content[:length])
        with pytest.raises(FormatError):
            read_layouts(path)


def test_a_changed_bit_gives_layouts_or_a_named_error(tmp_path):
    """Without packing, whose checks would notice most of them, and without checksums of pages."""
    rows = pa.Table.from_batches([rows_of(LayoutBatch.of(drawn(3)))])
    path = write(tmp_path / "file", rows, compression="none", write_statistics=False)
    content, draw = path.read_bytes(), random.Random(1)
    for place in range(4, 2_000, 3):
        flipped = bytes([content[place] ^ 1 << draw.randrange(8)])
        path.write_bytes(content[:place] + flipped + content[place + 1 :])
        with suppress(LayoutError):
            read_layouts(path)


@pytest.mark.parametrize(("limit", "most", "message"), [
    ("MAX_LAYOUTS", 2, "holds 3 layouts; allowed: at most 2"),
    ("MAX_GROUP_VALUES", 30, "has a row group of 33 values"),
    ("MAX_TABLE_BYTES", 100, "unpacked; allowed: 33,554,432 and 1 KiB, write fewer rows a group"),
])  # fmt: skip
def test_limits_are_looked_at_before_rows_are_read(tmp_path, monkeypatch, limit, most, message):
    path = write(tmp_path / "a", table(*(PLAIN | {"layout": name} for name in "XYZ")))
    assert len(read_layouts(path)) == 3
    monkeypatch.setattr(parquet_rows, limit, most)
    monkeypatch.setattr(pq.ParquetFile, "iter_batches", None)
    with pytest.raises(FormatError) as caught:
        read_layouts(path)
    assert message in str(caught.value)


@pytest.mark.parametrize("how", [{}, {"row_group_size": 4}, {"use_dictionary": False},
                                 {"write_statistics": False}])  # fmt: skip
def test_a_footer_says_of_its_groups_what_pyarrow_says(tmp_path, how):
    rows = pa.Table.from_batches([rows_of(LayoutBatch.of(drawn(11)))])
    path = write(tmp_path / "a", rows.replace_schema_metadata({"a": "b"}), **how)
    about, expected = pq.read_metadata(path), []
    for group in map(about.row_group, range(about.num_row_groups)):
        columns = [group.column(k) for k in range(group.num_columns)]
        values = [column.num_values for column in columns]
        size = sum(column.total_uncompressed_size for column in columns)
        expected.append(Group(group.num_rows, sum(values), max(values), size))
    with path.open("rb") as file:
        assert groups_of(footer_of(file)) == expected


def test_a_footer_of_nonsense_is_refused():
    draw = random.Random(4)
    for content in (b"", b"\x00", b"\x1c" * 5000, b"\x49\xfc\xff\xff\xff\x0f", b"\x4b\xff" * 9):
        with suppress(FormatError):
            groups_of(content)
    for _ in range(300):
        with suppress(FormatError):
            groups_of(draw.randbytes(draw.randrange(200)))


def test_a_damaged_entry_of_a_column_ends_no_process(tmp_path):
    """pyarrow throws where nobody catches it when it is asked for the sizes of such a column."""
    write_layouts(tmp_path / "a", drawn(3), Format.PARQUET)
    content = (tmp_path / "a").read_bytes()
    length = int.from_bytes(content[-8:-4], "little")
    three = content.index(b"\x19\x36\x00\x00", len(content) - 8 - length)  # a list of three levels
    (tmp_path / "b").write_bytes(  # of two
        content[: three + 1] + b"\x26" + content[three + 3 : -8]
        + (length - 1).to_bytes(4, "little") + content[-4:]
    )  # fmt: skip
    assert_refused(tmp_path / "b", "cannot be read as Parquet (Definition level histogram size")


def test_a_file_without_end_is_refused_before_it_is_read(tmp_path):
    path = write(tmp_path / "a", table(PLAIN))
    os.truncate(path, 5 * 10**9)
    with pytest.raises(FormatError, match="is too large; allowed for this format: 4096 MiB"):
        read_layouts(path)


def test_a_text_that_stands_there_very_often_takes_no_memory(tmp_path, monkeypatch):
    """A name of a megabyte in every row would be ten gigabytes."""
    texts = pa.DictionaryArray.from_arrays(pa.array([0] * 10_000, pa.int32()), ["x" * 10**6])
    many = table(*[PLAIN] * 10_000).set_column(0, "layout", texts)
    path = write(tmp_path / "a", many)
    before = pa.default_memory_pool().max_memory()
    with pytest.raises(FormatError, match="has a text of 1,000,000 characters"):
        read_layouts(path)
    assert pa.default_memory_pool().max_memory() - before < 200 * 10**6


def test_a_pipe_is_read(tmp_path, monkeypatch):
    write_layouts(tmp_path / "a", drawn(5), Format.PARQUET)
    ours, theirs = os.pipe()
    os.write(theirs, (tmp_path / "a").read_bytes())
    os.close(theirs)
    with os.fdopen(ours) as pipe:
        monkeypatch.setattr(sys, "stdin", pipe)
        assert bits(sl.read_batch("-")) == bits(LayoutBatch.of(drawn(5)))


@pytest.mark.parametrize("read", [read_layouts, sl.read_batch])
def test_a_dialect_is_of_csv_files_alone(tmp_path, read):
    path = write(tmp_path / "a", table(PLAIN))
    with pytest.raises(FormatError, match="is no CSV file; units can be stated of CSV files only"):
        read(path, dialect=Dialect(units="mm"))


def test_commands_take_and_write_it(tmp_path, capsys):
    write_layouts(tmp_path / "a.json", drawn(3), Format.NATIVE)
    there, back = tmp_path / "a.parquet", tmp_path / "b.json"
    assert main(["convert", str(tmp_path / "a.json"), "-o", str(there)]) == 0
    assert there.read_bytes()[:4] == b"PAR1"
    assert main(["convert", str(there), "-o", str(back)]) == 0
    assert back.read_text() == (tmp_path / "a.json").read_text()
    capsys.readouterr()
    answers = []
    for file in (back, there):
        status = main(["check", str(file), "-m", "sme"])
        answers.append((status, capsys.readouterr().out.replace(str(file), "FILE")))
    assert answers[0] == answers[1]
    assert "L0" in answers[0][1]


def test_it_is_not_rewritten_as_a_text(tmp_path):
    layouts = drawn(2)
    write_layouts(tmp_path / "a.parquet", layouts, Format.PARQUET)
    with pytest.raises(FormatError, match="is a Parquet file, which has no text to change; allow"):
        rewrite(
            Content.of(tmp_path / "a.parquet"),
            tmp_path / "b.parquet",
            {layouts[0].name: Replanned(layouts[0], (0,))},
        )
    assert not (tmp_path / "b.parquet").exists()


def test_bytes_do_not_depend_on_how_layouts_came(tmp_path):
    """A view on a batch has no items yet; a layout of items has them."""
    layouts = drawn(6)
    for name, given in (("a", layouts), ("b", list(LayoutBatch.of(layouts)))):
        write_layouts(tmp_path / name, given, Format.PARQUET)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    assert "items" not in vars(given[0])
    assert io.BytesIO((tmp_path / "a").read_bytes()).read(4) == b"PAR1"
