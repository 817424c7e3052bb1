"""CSV files as people have them: separators, units, axes, positions, names of columns, profiles."""

import gzip
import io
import logging
import pickle
import re
import time
import tracemalloc
import zipfile
from decimal import Context, Decimal
from itertools import islice

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import steadyload as sl
from steadyload.layouts import Item, Layout, LayoutError, Pallet
from steadyload.layouts.batch_files import read_batch
from steadyload.layouts.files.csv_reader import read_csv
from steadyload.layouts.files.dialect import Dialect, DialectError, columns_of, load_profile
from steadyload.layouts.files.record import FormatError, Refused, to_layout
from steadyload.layouts.formats import Format, read_layouts, scan_layouts, write_layouts

PLAIN = """\
layout,pallet_width,pallet_height,pallet_depth,sequence,item,x,y,z,width,height,depth,weight,offset_x,offset_y,offset_z
P-1,80,200,120,0,SKU-2001,0,0,0,39.5,21.1,29.8,8.611,0,0,1.5
P-1,80,200,120,1,SKU-2002,39.5,0,0,40.1,21.1,29.8,7.25,0.3,-1,0
P-1,80,200,120,2,SKU-2003,0,21.1,0.7,60,15.9,30,12,0,0,0
"""

# The same from a warehouse system of Germany: mm, g, z up, centres, decimal commas, own headers.
WAREHOUSE = """\
Palette;PL;PB;PH;Folge;Artikel;X;Y;Z;L;B;H;Gewicht;SX;SY;SZ
P-1;1200;800;2000;0;SKU-2001;149;197,5;105,5;298;395;211;8611;15;0;0
P-1;1200;800;2000;1;SKU-2002;149;595,5;105,5;298;401;211;7250;0;3;-10
P-1;1200;800;2000;2;SKU-2003;157;300;290,5;300;600;159;12000;0;0;0
"""

PROFILE = """\
units = "mm"
weight = "g"
up = "z"
positions = "centre"

[columns]
layout = "Palette"
pallet_length = "PL"
pallet_width = "PB"
pallet_height = "PH"
sequence = "Folge"
id = "Artikel"
length = "L"
width = "B"
height = "H"
weight = "Gewicht"
offset_x = "SX"
offset_y = "SY"
offset_z = "SZ"
"""


def write(path, text):
    path.write_text(text, encoding="utf-8")
    return path


def read(tmp_path, text, **dialect):
    return read_layouts(write(tmp_path / "file.csv", text), dialect=Dialect(**dialect))


def assert_equal(found, expected):
    for one, other in zip(found, expected, strict=True):
        assert (one.name, one.pallet, one.items) == (other.name, other.pallet, other.items)


def test_a_file_of_a_warehouse_is_the_plain_one(tmp_path):
    plain = sl.read(write(tmp_path / "plain.csv", PLAIN))
    profile = sl.load_profile(write(tmp_path / "wms.toml", PROFILE))
    assert_equal(sl.read(write(tmp_path / "wms.csv", WAREHOUSE), dialect=profile), plain)
    assert [item.name for item in plain[0].items] == ["SKU-2001", "SKU-2002", "SKU-2003"]


@pytest.mark.parametrize("separator", [";", "\t"])
@pytest.mark.parametrize("mark", [".", ","])
@pytest.mark.parametrize("first", ["", "sep=;\r\n", "\n\n"])
def test_separator_and_decimal_mark_are_told_by_the_file(tmp_path, separator, mark, first):
    text = PLAIN.replace(",", separator).replace(".", mark).replace("\n", "\r\n")
    plain = read(tmp_path, PLAIN)
    assert_equal(read(tmp_path, first.replace(";", separator) + text), plain)


def test_values_in_quotes_empty_rows_and_headers_in_capitals_are_read(tmp_path):
    head, *rows = PLAIN.replace(",", ";").splitlines()
    quoted = ";".join(f'"{name.upper()}"' for name in head.split(";"))
    empty = ";" * head.count(";")
    assert_equal(
        read(tmp_path, "\n".join([quoted, *rows, empty, empty]) + "\n"), read(tmp_path, PLAIN)
    )


def test_rows_of_a_layout_stand_together_in_any_order(tmp_path):
    head, *rows = PLAIN.splitlines()
    more = [row.replace("P-1", "P-2") for row in rows]
    mixed = [rows[2], rows[0], rows[1], more[2], more[1], more[0]]
    layouts = read(tmp_path, "\n".join([head, *mixed]))
    assert [layout.name for layout in layouts] == ["P-1", "P-2"]
    assert layouts[0].items == layouts[1].items == read(tmp_path, PLAIN)[0].items


def test_two_pallets_of_one_name_are_not_read_as_one(tmp_path):
    """Also where the numbers of the second go on after those of the first."""
    head, *rows = PLAIN.splitlines()
    [between] = [row.replace("P-1", "P-2") for row in rows if row.split(",")[4] == "0"]
    path = tmp_path / "file.csv"
    path.write_text("\n".join([head, *rows[:2], between, rows[2], between.replace("2", "3", 1)]))
    refused, other, last = scan_layouts(path)
    assert (other.name, last.name) == ("P-2", "P-3")
    told = (
        'layout "P-1": line 5 goes on with it after rows of another layout: do two pallets share '
        "this name? allowed: all rows of a layout together, and another name for each pallet"
    )
    assert str(refused.error) == f"{path}: {told}"
    for read_all in (read_layouts, read_batch):
        with pytest.raises(LayoutError, match=re.escape(told)):
            read_all(path)


def test_numbers_that_stand_there_twice_say_that_two_pallets_may_share_a_name(tmp_path):
    with pytest.raises(LayoutError) as caught:
        read(tmp_path, PLAIN + PLAIN.partition("\n")[2])
    assert str(caught.value).endswith(
        'layout "P-1": sequence 0 stands there twice: do two pallets share this name? allowed: '
        "each of 0 to 5 once, and another name for each pallet"
    )


def test_rows_without_a_name_say_so_wherever_they_stand(tmp_path):
    head, *rows = PLAIN.splitlines()
    unnamed = rows[0].replace("P-1", "")
    with pytest.raises(LayoutError, match="line 2 names no layout; allowed: its name"):
        read(tmp_path, "\n".join([head, unnamed, *rows, unnamed]))


def test_a_file_may_count_from_one_where_that_is_said(tmp_path):
    head, *rows = PLAIN.splitlines()
    place = head.split(",").index("sequence")
    for row in reversed(rows):
        assert row.split(",")[place] in "012"
    later = []
    for row in rows:
        cells = row.split(",")
        cells[place] = str(int(cells[place]) + 1)
        later.append(",".join(cells))
    text = "\n".join([head, *later]) + "\n"
    assert_equal(read(tmp_path, text, order="from-1"), read(tmp_path, PLAIN))
    with pytest.raises(LayoutError, match=r"begin at 1; allowed: each of 0 to 2 once,.* says"):
        read(tmp_path, text)
    with pytest.raises(LayoutError, match=r"begin at 0; allowed: each of 1 to 3 once as "):
        read(tmp_path, PLAIN, order="from-1")
    gap = text.replace(later[1] + "\n", "")
    with pytest.raises(LayoutError, match="sequence 1 is missing before 2"):
        read(tmp_path, gap, order="from-1")


@pytest.mark.parametrize(
    ("units", "text", "expected"),
    [("mm", "127", 12.7), ("cm", "12.7", 12.7), ("m", "0.127", 12.7), ("in", "5", 12.7)],
)
def test_lengths_are_exact_in_every_unit(tmp_path, units, text, expected):
    head = "layout;pallet_width;pallet_height;pallet_depth;sequence;x;y;z;width;height;depth;weight"
    row = f"A;{text};{text};{text};0;0;0;0;{text};{text};{text};2"
    (layout,) = read(tmp_path, f"{head}\n{row}\n", units=units)
    assert layout.pallet == Pallet(expected, expected, expected)
    assert layout.items[0].size == (expected, expected, expected)


@pytest.mark.parametrize(("unit", "kilograms"), [("g", 0.002), ("kg", 2.0), ("lb", 0.90718474)])
def test_weights_are_exact_in_every_unit(tmp_path, unit, kilograms):
    text = PLAIN.replace("8.611", "2")
    assert read(tmp_path, text, weight=unit)[0].items[0].weight == kilograms


def test_z_up_turns_a_layout_and_does_not_mirror_it(tmp_path):
    head = "layout,pallet_width,pallet_depth,pallet_height,sequence,x,y,z,width,depth,height,weight"
    (layout,) = read(tmp_path, f"{head}\nA,100,60,80,0,1,2,3,10,20,30,5\n", up="z")
    # The file's x, y, z are our z, x, y, an even permutation; width lies along x, depth along y.
    assert layout.pallet == Pallet(width=60.0, height=80.0, depth=100.0)
    assert layout.items[0].position == (2.0, 3.0, 1.0)
    assert layout.items[0].size == (20.0, 30.0, 10.0)
    assert_equal(
        read(
            tmp_path,
            f"{head.replace('depth', 'WIDTH').replace('width', 'length')}\n"
            "A,100,60,80,0,1,2,3,10,20,30,5\n",
            up="z",
        ),
        [layout],
    )


@pytest.mark.parametrize("header", ["id", "sku", "SKU", "name", "item"])
def test_the_id_of_a_box_is_read(tmp_path, header):
    (layout,) = read(tmp_path, PLAIN.replace("item", header))
    assert layout.items[1].name == "SKU-2002"


def test_columns_that_are_not_known_are_left_out_on_request(tmp_path):
    rows = [row + ";x" for row in PLAIN.replace(",", ";").splitlines()]
    text = "\n".join([rows[0].replace(";x", ";x", 1)[:-2] + ";customer", *rows[1:]])
    with pytest.raises(FormatError, match="unknown CSV column 'customer'"):
        read(tmp_path, text)
    assert_equal(read(tmp_path, text, other_columns="ignore"), read(tmp_path, PLAIN))


@pytest.mark.parametrize("separator", [";", ",", "\t"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_separator_at_the_end_of_each_line_is_no_column(tmp_path, separator, end):
    rows = PLAIN.replace(",", separator).splitlines()
    ended = separator + end
    found = read(tmp_path, ended.join(rows) + ended)
    assert_equal(found, read(tmp_path, PLAIN))
    (tmp_path / "both.csv").write_text(ended.join(rows) + ended)
    assert_equal(list(read_batch(tmp_path / "both.csv")), found)


def test_a_value_in_a_column_without_a_header_is_named(tmp_path):
    first, second, *rest = PLAIN.splitlines()
    text = "\n".join([f"{first},", f"{second},", *(f"{row},5" for row in rest)])
    with pytest.raises(FormatError, match="line 3 has the value '5' in a column without a header"):
        read(tmp_path, text)
    assert_equal(read(tmp_path, text, other_columns="ignore"), read(tmp_path, PLAIN))


@pytest.mark.parametrize("count", [2, 8, 9, 30])
def test_unknown_columns_are_named_together(tmp_path, count):
    names = [f"col{chr(97 + k // 26)}{chr(97 + k % 26)}" for k in range(count - 1)] + ["wieght"]
    header, *rows = PLAIN.splitlines()
    text = "\n".join([",".join([header, *reversed(names)]), *(row + count * ",1" for row in rows)])
    with pytest.raises(FormatError) as told:
        read(tmp_path, text)
    said = str(told.value)
    assert "has the unknown CSV columns 'wieght' (did you mean 'weight'?), 'col" in said
    assert said.count("'col") == min(count, 8) - 1
    assert (f" and {count - 8} more; allowed: " in said) == (count > 8)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("weight", "wieght", "unknown CSV column 'wieght'; did you mean 'weight'?"),
        ("item", "item;x", "one separator of columns in the whole file"),
        ("offset_x", "sku", "has two CSV columns for id, 'item' and 'sku'"),
        ("offset_x", "length", "has the CSV columns length and depth; allowed: one of them"),
        ("offset_x", "WEIGHT", "has the CSV column 'weight' twice"),
        ("1,SKU-2002,39.5", "1,SKU-2002;39.5", "line 3 has 15 values; allowed: 16"),
        ("8.611", '"8,611"', "weight is '8,611'; allowed: a number [kg]"),
        ("8.611", "1.008.611", "weight is '1.008.611'; allowed: a number [kg]"),
        ("8.611", "8" * 65, "allowed: a number [kg]"),
        ("8.611", "1e9999999", "allowed: a number [kg]"),
        ("SKU-2001", "S" * 1001, "line 2 has a cell of 1001 characters; allowed: 1000"),
        ("P-1,80,200,120,1", "P-1,81,200,120,1", "line 3 states another pallet size"),
    ],
)
def test_wrong_files_are_refused_in_a_sentence(tmp_path, old, new, message):
    with pytest.raises(LayoutError) as caught:
        read(tmp_path, PLAIN.replace(old, new, 1))
    assert message in str(caught.value)
    assert str(tmp_path / "file.csv") in str(caught.value)
    assert len(str(caught.value)) < 500


def test_a_missing_column_is_named_with_the_nearest_header(tmp_path):
    text = PLAIN.replace("weight", "weights", 1)
    with pytest.raises(FormatError) as caught:
        read(tmp_path, text, other_columns="ignore")
    assert "lacks the CSV column 'weight'; the nearest in its header is 'weights'" in str(
        caught.value
    )
    with pytest.raises(FormatError, match="lacks the CSV column 'Gewicht', named for weight"):
        read(tmp_path, PLAIN, columns={"weight": "Gewicht"}, other_columns="ignore")


def test_decimal_points_and_commas_are_not_mixed(tmp_path):
    text = PLAIN.replace(",", ";").replace("8.611", "8,611")
    with pytest.raises(FormatError) as caught:
        read(tmp_path, text)
    assert "a decimal point (line 2) and with a decimal comma (line 2)" in str(caught.value)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"layout": "nix"}, "lacks the CSV column 'nix', named for layout"),
        ({"layout": "lay"}, "named for layout; the nearest in its header is 'layout'"),
        ({"sequence": "item"}, "two CSV columns for sequence, 'item', as it is named, and "),
    ],
)  # fmt: skip
def test_a_column_is_not_suggested_in_its_own_place(tmp_path, columns, message):
    with pytest.raises(FormatError) as caught:
        read(tmp_path, PLAIN, columns=columns)
    assert message in str(caught.value)
    assert "did you mean" not in str(caught.value)


def test_a_dialect_is_stated_of_csv_files_only(tmp_path):
    write_layouts(tmp_path / "a.json", read(tmp_path, PLAIN), Format.NATIVE)
    with pytest.raises(FormatError, match="units and up can be stated of CSV files only"):
        read_layouts(tmp_path / "a.json", dialect=Dialect(units="mm", up="z"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('units = "mm."', "units is 'mm.'; did you mean 'mm'?"),
        ("weight = 3", "weight is 3; allowed: g, kg, lb"),
        ('unit = "mm"', "unknown key 'unit'; did you mean 'units'?"),
        ('columns = "L"', "columns is 'L'; allowed"),
        ('[columns]\nlenght = "L"', "columns: unknown word 'lenght'; did you mean 'length'?"),
        ("[columns]\nlength = 3", "columns[length] is 3; allowed: a text"),
        ('[columns]\nlength = "L"\nwidth = "l"', "columns: 'l' stands for two words"),
        ("units = ", "not valid TOML"),
        ("a = " + "[" * 30000, "not valid TOML"),
        ("units = 99999999999999999999", "units is 99999999999999999999; allowed"),
    ],
)
def test_a_wrong_profile_is_refused_in_a_sentence(tmp_path, text, message):
    profile = write(tmp_path / "wms.toml", text)
    with pytest.raises(DialectError) as caught:
        load_profile(profile)
    assert message in str(caught.value)
    assert str(profile) in str(caught.value)


def test_columns_are_named_in_a_text():
    assert columns_of("length=L, item = Art.-Nr.") == {"length": "L", "id": "Art.-Nr."}
    for text in ("length", "length=", "=L", "length=L,length=M", "lenght=L", ""):
        with pytest.raises(DialectError, match="allowed"):
            columns_of(text)


def test_a_dialect_is_a_value():
    one, other = (Dialect(units="mm", columns={"length": "L"}) for _ in range(2))
    assert one == other
    assert hash(one) == hash(other)
    assert one.stated() == {"units": "mm", "columns": {"length": "L"}}
    assert one.with_changes({"units": "m", "columns": {"width": "B"}}) == Dialect(
        units="m", columns={"length": "L", "width": "B"}
    )


def test_too_many_items_refuse_a_layout_and_not_the_others(tmp_path):
    head = PLAIN.splitlines()[0].partition(",offset_x")[0]
    rows = [f"many,80,200,120,{k},,0,0,0,1,1,1,1" for k in range(5001)]
    rows.append("one,80,200,120,0,,0,0,0,1,1,1,1")
    many, one = scan_layouts(write(tmp_path / "a.csv", "\n".join([head, *rows])))
    assert isinstance(many, Refused)
    assert "has more than 5000 items" in str(many.error)
    assert one.name == "one"


def test_layouts_are_handed_out_as_they_are_complete(monkeypatch):
    head = PLAIN.splitlines()[0].partition(",offset_x")[0]
    rows = [f"L{k},80,200,120,0,,0,0,0,1,1,1,1" for k in range(6)]
    rows[4] = "L4,80"
    records = read_csv("\n".join([head, *rows]).encode(), Dialect())
    assert [next(records).name for _ in range(3)] == ["L0", "L1", "L2"]
    with pytest.raises(FormatError, match="line 6 has 2 values"):
        next(records)
    monkeypatch.setattr("steadyload.layouts.files.csv_reader.MAX_LAYOUTS", 3)
    with pytest.raises(FormatError, match="has more than 3 layouts"):
        next(read_csv("\n".join([head, *rows]).encode(), Dialect()))


@pytest.mark.parametrize(
    "text",
    [
        PLAIN + "P-1,80,200,120,3,," + "9" * 3_000_000 + ",0,0,1,1,1,1,0,0,0\n",
        PLAIN + "," * 3_000_000 + "\n",
        PLAIN.splitlines()[0] + ",a" * 1_500_000 + "\n",
        PLAIN.splitlines()[0] + ",x" * 1_500_000 + "\n",
        PLAIN + "\n" * 1_000_000,
        PLAIN + '"' * 3_000_001,
        "layout,sequence," + "x" * 3_000_000,
    ],
    ids=["digits", "cells", "headers", "equal headers", "lines", "quotes", "long header"],
)
def test_time_is_linear_in_the_size_of_a_file(tmp_path, text):
    path = write(tmp_path / "a.csv", text)
    start = time.process_time()
    try:
        read_layouts(path)
    except LayoutError as error:
        assert len(str(error)) < 600  # noqa: PT017 - either outcome is right, if it comes at once
    assert time.process_time() - start < 2.0


def test_a_pipe_and_standard_input_are_capped_as_files_are(tmp_path, monkeypatch):
    monkeypatch.setattr("steadyload.layouts.formats.MAX_FILE_BYTES", 2 * 1024**2)
    content = io.BytesIO(PLAIN.encode() + b"\n" * 3 * 1024**2)
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(content))
    with pytest.raises(FormatError, match="standard input: is too large; allowed for this"):
        read_layouts("-")
    assert content.tell() < 2.2 * 1024**2
    path = tmp_path / "large.csv"
    path.write_bytes(content.getvalue())
    with pytest.raises(FormatError, match="is too large; allowed for this format: 2 MiB"):
        read_layouts(path)


HIGH = (
    "layout,pallet_length,pallet_width,pallet_height,sequence,id,x,y,z,length,width,height,weight"
)


@pytest.mark.parametrize(
    ("second", "message"),
    [
        (
            "0,0,1700,400,400,400,9000",
            "box b (2nd): spans z = 1700 to 2100 mm; allowed: inside the pallet's contour, 0 to "
            "1800 mm (+-0.1)",
        ),
        (
            "-250,0,0,400,400,300,9000",
            "box b (2nd): spans x = -250 to 150 mm; allowed: inside the pallet's contour, -100 "
            "to 1300 mm (+-0.1): up to 100 mm over the edge of the deck",
        ),
        (
            "0,0,297.5,400,400,300,9000",
            "box b (2nd): overlaps box a (1st) by 2.5 mm or more along every axis; allowed: "
            "at most 0.1 mm",
        ),
        (
            "0,0,300,-400,400,300,9000",
            "side along x is -400 mm; allowed: a positive finite number, 0.5 to 1000000 mm",
        ),
        ("0,0,300,400,wide,300,9000", "side along y is 'wide'; allowed: a number [mm]"),
        ("0,near,300,400,400,300,9000", "position y is 'near'; allowed: a number [mm]"),
        (
            "0,0,300,400,400,300,-12.5",
            "weight is -12.5 g; allowed: a positive finite number, 1e-06 to 1000000000 g",
        ),
        ("0,0,300,400,400,300,heavy", "weight is 'heavy'; allowed: a number [g]"),
    ],
)
def test_a_refusal_speaks_the_axes_and_units_of_the_file(tmp_path, second, message):
    path = write(
        tmp_path / "high.csv",
        f"{HIGH}\nA,1200,800,1800,0,a,0,0,0,400,400,300,12000\nA,1200,800,1800,1,b,{second}\n",
    )
    with pytest.raises(LayoutError) as refusal:
        read_layouts(path, dialect=Dialect(units="mm", up="z", weight="g"))
    assert str(refusal.value).startswith(f'{path}: layout "A": box b (2nd): ')
    assert str(refusal.value).endswith(message)
    assert str(pickle.loads(pickle.dumps(refusal.value))) == str(refusal.value)


def test_a_row_without_a_layout_is_named_by_its_line(tmp_path):
    head = "layout,pallet_width,pallet_depth,pallet_height,sequence,x,y,z,width,depth,height,weight"
    path = write(tmp_path / "a.csv", f"{head}\n,100,60,80,0,1,2,3,10,20,30,5\n")
    with pytest.raises(FormatError, match="line 2 names no layout; allowed: its name"):
        read_layouts(path)


def zipped(text):
    """A ZIP file with one file."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("a.csv", text)
    return content.getvalue()


@pytest.mark.parametrize(
    ("packed", "kind"),
    [
        (gzip.compress, "compressed (gzip)"),
        (lambda text: text.decode().encode("utf-16"), "no text in UTF-8 but in UTF-16"),
        (zipped, "a spreadsheet (.xlsx) or another ZIP file"),
    ],
)
def test_a_file_that_is_packed_or_of_another_encoding_is_told_so(tmp_path, packed, kind):
    path = tmp_path / "a.csv"
    path.write_bytes(packed(b"layout,sequence\nA,0\n"))
    with pytest.raises(FormatError) as refusal:
        read_layouts(path)
    assert f"is {kind}; allowed: steadyload JSON, CSV" in str(refusal.value)


UPRIGHT = """\
layout,pallet_length,pallet_width,pallet_height,sequence,item,x,y,z,length,width,height,weight
A,120,80,180,0,a,0,0,0,40,60,30,10
A,120,80,180,1,b,0,0,30,40,60,130,10
"""
"""Boxes on each other, with z up: with y up they overlap."""


@pytest.mark.parametrize("sides", [("length", "width"), ("width", "depth")])
def test_where_z_is_up_a_refusal_asks_for_it_once(tmp_path, sides):
    header, rows = UPRIGHT.split("\n", 1)
    header = header.replace("width", sides[1]).replace("length", sides[0])
    text = "\n".join([header, rows + rows.replace("A,", "B,")])
    path = write(tmp_path / "file.csv", text)
    told = [str(entry.error) for entry in scan_layouts(path)]
    assert len(told) == 2
    assert told[0].endswith("allowed: at most 0.01 cm; did you mean --up z?")
    assert told[1].endswith("allowed: at most 0.01 cm")
    assert [len(layout) for layout in read(tmp_path, text, up="z")] == [2, 2]


def test_where_no_axis_helps_none_is_asked_for(tmp_path):
    with pytest.raises(LayoutError) as told:
        read(tmp_path, UPRIGHT.replace("0,0,30", "0,0,29"))
    assert "did you mean" not in str(told.value)
    with pytest.raises(LayoutError) as told:
        read(tmp_path, UPRIGHT.replace("0,0,30", "0,0,29"), up="z")
    assert "did you mean" not in str(told.value)


@pytest.mark.parametrize("blank", [0, 200_000])
def test_text_of_windows_is_read_and_said(tmp_path, caplog, blank):
    path, rows = tmp_path / "a.csv", PLAIN.replace("SKU", "Kühl-€")
    text = rows.replace("\n", "\n" + blank * "\n", 1)
    with caplog.at_level(logging.WARNING):
        path.write_bytes(text.encode("cp1252"))
        found = read_layouts(path)
        assert caplog.messages == [f"{path}: is no UTF-8 text, and is read as Windows-1252"]
        caplog.clear()
        assert_equal(list(read_batch(path)), found)
        path.write_text(text)
        assert_equal(read_layouts(path), found)
    assert found[0].items[0].name.startswith("Kühl-€")
    assert len(caplog.messages) <= 1


def test_text_of_another_encoding_is_refused_at_its_byte(tmp_path):
    path = tmp_path / "a.csv"
    for before in (PLAIN.encode(), PLAIN.encode() + b"\n" * 200_000):
        path.write_bytes(before + b"P-1,H\x81he")
        with pytest.raises(FormatError, match=rf"not UTF-8 text .byte {len(before) + 5}\b"):
            read_layouts(path)


def test_a_file_is_held_once_in_memory(tmp_path):
    row = b"L%d,80,200,120,0," + b"S" * 900 + b",0,0,0,1,1,1,1,0,0,0\n"
    path = tmp_path / "a.csv"
    rows = b"".join(row % (k // 100) for k in range(8_000))
    path.write_bytes(PLAIN.splitlines()[0].encode() + b"\n" + rows)
    tracemalloc.start()
    assert sum(1 for _ in islice(scan_layouts(path), 50)) == 50
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 1.8 * path.stat().st_size


def test_standard_input_is_read(tmp_path, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(PLAIN.encode())))
    assert_equal(read_layouts("-"), read(tmp_path, PLAIN))


@pytest.mark.parametrize("name", ["=1+1", "+A", "-7", "@SUM", "'=x", "''-", "'quoted'", "A=B"])
def test_a_name_is_no_formula_where_it_is_written_and_comes_back_as_it_was(tmp_path, name):
    layout = Layout(name, Pallet(9.0, 9.0, 9.0), (Item(0, (0, 0, 0), (1, 1, 1), 1.0, name=name),))
    write_layouts(tmp_path / "a.csv", [layout], Format.CSV)
    row = (tmp_path / "a.csv").read_text().splitlines()[1].split(",")
    assert row[0][0] not in "=+-@"
    assert row[5][0] not in "=+-@"
    assert_equal(read_layouts(tmp_path / "a.csv"), [layout])


DIGITS = Context(prec=34)
"""Twice as many as a float has, so that an inch is written as exactly as it is read."""

NUMBERS = st.one_of(
    st.floats(0.05, 90.0), st.integers(1, 90).map(float), st.integers(1, 900).map(lambda k: k / 10)
)
NAMES = st.text(st.characters(codec="utf-8", categories=("L", "N", "P", "S")), max_size=8)


@st.composite
def layouts(draw):
    """Boxes that stand beside each other along x."""
    items, start = [], 0.0
    for sequence in range(draw(st.integers(1, 4))):
        size = tuple(draw(NUMBERS) for _ in range(3))
        offset = tuple(draw(st.integers(-4, 4)) / 10.0 * side for side in size)
        items.append(
            Item(sequence, (start, 0.0, draw(NUMBERS)), size, draw(NUMBERS), offset, draw(NAMES))
        )
        start += size[0] + draw(NUMBERS)
    return Layout("one", Pallet(start + 100.0, draw(NUMBERS) + 90.0, 190.0), tuple(items))


DIALECTS = st.builds(
    Dialect,
    units=st.sampled_from(["mm", "cm", "m", "in"]),
    weight=st.sampled_from(["g", "kg", "lb"]),
    up=st.sampled_from("yz"),
    positions=st.sampled_from(["corner", "centre"]),
    columns=st.sampled_from([{}, {"length": "L", "id": "Artikel", "x": "pos x", "z": "pos z"}]),
)


def in_dialect(layout, dialect, separator, mark):
    """A CSV file in a dialect, written from the definition of each of its keys."""
    length = {"mm": "0.1", "cm": "1", "m": "100", "in": "2.54"}[dialect.units]
    mass = {"g": "0.001", "kg": "1", "lb": "0.45359237"}[dialect.weight]
    axes = {"y": (0, 1, 2), "z": (2, 0, 1)}[dialect.up]
    sides = {"y": ("width", "height", "length"), "z": ("length", "width", "height")}[dialect.up]
    words = ["layout", *(f"pallet_{s}" for s in sides), "sequence", "id", "x", "y", "z", *sides,
             "weight", "offset_x", "offset_y", "offset_z"]  # fmt: skip

    def text(value, unit=length):
        return str(DIGITS.divide(Decimal(value), Decimal(unit))).replace(".", mark)

    def along(values):
        return [Decimal(repr(values[axis])) for axis in axes]

    rows = [[dialect.columns.get(word, word) for word in words]]
    for item in layout.items:
        half = Decimal("0.5" if dialect.positions == "centre" else "0")
        at = [
            DIGITS.add(p, half * s)
            for p, s in zip(along(item.position), along(item.size), strict=True)
        ]
        quoted = '"' + item.name.replace('"', '""') + '"'
        rows.append([layout.name, *map(text, along(layout.pallet.size)), str(item.sequence), quoted,
                     *map(text, at), *map(text, along(item.size)),
                     text(Decimal(repr(item.weight)), mass),
                     *map(text, along(item.mass_offset))])  # fmt: skip
    return "\n".join(separator.join(row) for row in rows) + "\n"


@settings(max_examples=25)
@given(layouts(), DIALECTS, st.sampled_from([(",", "."), (";", ","), ("\t", ","), (";", ".")]))
def test_a_layout_in_any_dialect_reads_back_as_it_was(layout, dialect, marks):
    (record,) = read_csv(in_dialect(layout, dialect, *marks).encode(), dialect)
    found = to_layout(record)
    assert found.pallet == layout.pallet
    for one, other in zip(found.items, layout.items, strict=True):
        assert one.name == other.name.removeprefix("'") or one.name == other.name
        assert (one.size, one.weight, one.mass_offset) == (
            other.size, other.weight, other.mass_offset,
        )  # fmt: skip
        assert one.position == pytest.approx(other.position, abs=1e-12)


BARE = "layout;id;length;width;height;x;y;z;weight\n" \
    "P;a;400;300;200;0;0;0;5\nP;b;400;300,5;200;400;0;0;5\nQ;c;600;400;300;10;0;0;9\n"  # fmt: skip
WHOLE = "layout;sequence;pallet_length;pallet_width;pallet_height;id;length;width;height;x;y;z;" \
    "weight\nP;0;1200;800;1500;a;400;300;200;0;0;0;5\n" \
    "P;1;1200;800;1500;b;400;300,5;200;400;0;0;5\n" \
    "Q;0;1200;800;1500;c;600;400;300;10;0;0;9\n"  # fmt: skip


@pytest.mark.parametrize("up", ["y", "z"])
def test_pallet_and_order_may_be_stated_instead_of_columns(tmp_path, up):
    for name, text in (("bare.csv", BARE), ("whole.csv", WHOLE)):
        (tmp_path / name).write_text(text if up == "z" else text.replace("length", "depth"))
    sides = "1200x800x1500" if up == "z" else "800 x 1500 x 1200"
    stated = Dialect(units="mm", up=up, pallet=sides, order="rows")
    found, whole = (
        [
            (layout.name, layout.pallet, layout.items)
            for layout in sl.read(tmp_path / name, dialect=d)
        ]
        for name, d in (("bare.csv", stated), ("whole.csv", Dialect(units="mm", up=up)))
    )
    assert found == whole
    assert [len(items) for _, _, items in found] == [2, 1]


@pytest.mark.parametrize(
    ("dialect", "text", "message"),
    [
        ({}, BARE, "'pallet_length'.* --pallet 1200x800x1800"),
        ({"pallet": "1x1x1"}, BARE, "lacks the CSV column 'sequence'.* --order rows"),
        ({"pallet": "1x1x1", "order": "rows"}, WHOLE, "has the CSV column 'pallet_length', and "),
        ({"order": "rows"}, WHOLE, "'sequence', and order is rows; allowed: one of the two"),
    ],
)
def test_a_column_or_its_statement_is_needed_and_not_both(tmp_path, dialect, text, message):
    (tmp_path / "f.csv").write_text(text)
    with pytest.raises(LayoutError, match=message):
        sl.read(tmp_path / "f.csv", dialect=Dialect(units="mm", up="z", **dialect))


@pytest.mark.parametrize("sides", ["1200x800", "0x1x1", "axbxc", "1200x800x-5", 5, "1e9999x1x1"])
def test_sides_of_pallets_that_are_none_are_refused(sides):
    with pytest.raises(
        DialectError, match=r"pallet is .*; allowed: (its sides along the file|a text)"
    ):
        Dialect(pallet=sides)
