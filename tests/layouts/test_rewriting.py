"""Changed plans written back: read as the new plan, and all else in the file as it was."""

import csv
import io
import json
import math
from dataclasses import replace
from decimal import Context, Decimal

import orjson
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

import steadyload as sl
from steadyload.layouts import Item, Layout, LayoutError, Pallet
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.files.sources import Content
from steadyload.layouts.formats import Format, read_layouts, write_layouts
from steadyload.layouts.rewriting import Replanned, rewrite
from steadyload.layouts.rewriting import plans as plans_module

DIGITS = Context(prec=30)
CELL = 100.0
"""Side of the square that a box may move and turn in [cm]."""


def turned(item):
    """The box after a quarter turn about the vertical: x goes to z, and z to -x."""
    (w, h, d), (x, y, z) = item.size, item.mass_offset
    return replace(item, size=(d, h, w), mass_offset=(0.0 - z, y, x))


def replan(layout, *, order=None, moved=None, turn=()):
    """A changed plan: steps in their new order, those of boxes left out not among them."""
    order = tuple(range(len(layout))) if order is None else tuple(order)
    items = []
    for sequence, step in enumerate(order):
        item = layout.items[step]
        item = turned(item) if step in turn else item
        position = (moved or {}).get(step, item.position)
        items.append(replace(item, sequence=sequence, position=position))
    return Replanned(Layout(layout.name, layout.pallet, tuple(items)), order)


def assert_reads_as(path, changed, others=(), **reading):
    """The file reads as the changed plans, and as it did elsewhere."""
    found = {layout.name: layout for layout in read_layouts(path, **reading)}
    assert found.keys() == {*changed, *(layout.name for layout in others)}
    for layout in others:
        if layout.name not in changed:
            assert found[layout.name].items == layout.items
    for name, plan in changed.items():
        assert found[name].pallet == plan.layout.pallet
        for one, other in zip(found[name].items, plan.layout.items, strict=True):
            assert (one.sequence, one.name, one.max_load) == (
                other.sequence, other.name, other.max_load,
            )  # fmt: skip
            assert one.weight == pytest.approx(other.weight, rel=1e-6)
            for key in ("position", "size", "mass_offset"):
                assert getattr(one, key) == pytest.approx(getattr(other, key), abs=1e-5)


# --- CSV ------------------------------------------------------------------------------------------

SIDES = st.one_of(st.integers(1, 60).map(float), st.integers(1, 600).map(lambda k: k / 10),
                  st.floats(1.0, 60.0))  # fmt: skip


@st.composite
def layouts(draw, name="one"):
    """Boxes in squares beside each other, with room to be turned and moved."""
    items = []
    for sequence in range(draw(st.integers(1, 5))):
        size = tuple(draw(SIDES) for _ in range(3))
        offset = tuple(draw(st.integers(-4, 4)) / 10.0 * side for side in size)
        corner = (CELL * sequence + draw(st.integers(0, 40)), 0.0, draw(st.floats(0.0, 40.0)))
        weight = 4e-4 * math.prod(size)
        items.append(Item(sequence, corner, size, weight, offset, f"SKU {sequence}"))
    return Layout(name, Pallet(500.0, 100.0, 100.0), tuple(items))


@st.composite
def plans(draw, layout):
    """Any order and choice of the boxes, some turned, some elsewhere in their squares."""
    order = draw(st.permutations(range(len(layout))))
    order = order[: draw(st.integers(1, len(layout)))]
    moved = {}
    for step in draw(st.sets(st.sampled_from(order))):
        square = CELL * math.floor((layout.items[step].position[0] + 1.0) / CELL)
        moved[step] = (square + draw(st.floats(0.0, 40.0)), 0.0, draw(st.integers(0, 400)) / 10)
    return replan(layout, order=order, moved=moved, turn=draw(st.sets(st.sampled_from(order))))


DIALECTS = st.builds(
    Dialect,
    units=st.sampled_from(["mm", "cm", "m", "in"]),
    weight=st.sampled_from(["g", "lb"]),
    up=st.sampled_from("yz"),
    positions=st.sampled_from(["corner", "centre"]),
    columns=st.sampled_from([{}, {"length": "L", "id": "Artikel", "x": "pos x", "z": "pos z"}]),
    other_columns=st.just("ignore"),
    order=st.sampled_from(["column", "from-1", "rows"]),
)


def along(values, up):
    return [values[axis] for axis in {"y": (0, 1, 2), "z": (2, 0, 1)}[up]]


def csv_text(some, dialect, *, separator=",", mark=".", end="\n", mixed=False):
    """A CSV file with a column of its own, written from the definition of each key of a dialect."""
    length = Decimal({"mm": "0.1", "cm": "1", "m": "100", "in": "2.54"}[dialect.units])
    mass = Decimal({"g": "0.001", "kg": "1", "lb": "0.45359237"}[dialect.weight])
    sides = {"y": ("width", "height", "length"), "z": ("length", "width", "height")}[dialect.up]
    words = ["note", *([] if dialect.pallet else [f"pallet_{side}" for side in sides]), "layout",
             *([] if dialect.order == "rows" else ["sequence"]), "id", "x", "y", "z", *sides,
             "weight", "offset_x", "offset_y", "offset_z"]  # fmt: skip

    def text(value, unit=length):
        return str(DIGITS.divide(Decimal(repr(value)), unit)).replace(".", mark)

    rows = []
    for layout in some:
        for item in layout.items:
            half = 0.5 if dialect.positions == "centre" else 0.0
            at = [DIGITS.add(Decimal(repr(p)), Decimal(repr(s)) * Decimal(half))
                  for p, s in zip(item.position, item.size, strict=True)]  # fmt: skip
            at = [str(DIGITS.divide(p, length)).replace(".", mark) for p in along(at, dialect.up)]
            count = str(item.sequence + (dialect.order == "from-1"))
            rows.append([
                f'"1{separator}5 ""x""{end}{item.sequence}"',
                *([] if dialect.pallet else map(text, along(layout.pallet.size, dialect.up))),
                layout.name, *([] if dialect.order == "rows" else [count]), f'"{item.name}"', *at,
                *map(text, along(item.size, dialect.up)), text(item.weight, mass),
                *map(text, along(item.mass_offset, dialect.up)),
            ])  # fmt: skip
    if mixed:
        rows = sorted(rows[::2] + rows[1::2], key=lambda row: row[words.index("layout")])
    head = [dialect.columns.get(word, word) for word in words]
    return end.join(separator.join(row) for row in [head, *rows])


def cells(path, separator):
    text = path.read_bytes().decode("utf-8-sig")
    return list(csv.reader(io.StringIO(text, newline=""), delimiter=separator))


def with_pallet_outside(dialect):
    unit = {"mm": 0.1, "cm": 1.0, "m": 100.0, "in": 2.54}[dialect.units]
    sides = [f"{side / unit:.6f}" for side in along((500.0, 100.0, 100.0), dialect.up)]
    return replace(dialect, pallet="x".join(sides))


MARKS = st.sampled_from([(",", "."), (";", ","), ("\t", ","), (";", ".")])
STARTS = st.sampled_from(["", "\ufeff", "\ufeffsep=;\n", "\n\n"])


@settings(max_examples=100, deadline=None)
@given(st.data(), DIALECTS, MARKS, STARTS, st.sampled_from(["\n", "\r\n"]), st.booleans())
def test_a_csv_file_in_any_dialect_reads_as_the_new_plan(
    tmp_path_factory, data, dialect, marks, start, end, mixed
):
    separator, mark = marks
    if data.draw(st.booleans()):
        dialect = with_pallet_outside(dialect)
    start = start.replace(";", separator).replace("\n", end)
    some = [data.draw(layouts("one")), data.draw(layouts("two"))]
    text = csv_text(some, dialect, separator=separator, mark=mark, end=end, mixed=mixed)
    tail = data.draw(st.sampled_from(["", end, end + separator * 3 + end]))
    folder = tmp_path_factory.mktemp("any")
    source, target = folder / "in.csv", folder / "out.csv"
    source.write_bytes((start + text + tail).encode())
    read = read_layouts(source, dialect=dialect)
    changed = {"two": data.draw(plans(read[1]))}
    rewrite(Content.of(source), target, changed, dialect=dialect)
    assert_reads_as(target, changed, read, dialect=dialect)
    assert target.read_bytes().startswith((start + text.split(end)[0] + end).encode())
    assert_only_what_changed_is_written(source, target, read[1], changed["two"], dialect, marks)
    rewrite(
        Content.of(source),
        target,
        {layout.name: replan(layout) for layout in read},
        dialect=dialect,
    )
    assert target.read_bytes() == source.read_bytes()


def assert_only_what_changed_is_written(source, target, layout, plan, dialect, marks):
    separator, mark = marks
    old, new = cells(source, separator), cells(target, separator)
    [head] = [row for row in old if "weight" in row]
    at = {name: head.index(dialect.columns.get(name, name)) for name in
          ("layout", "id", "x", "y", "z", "offset_x", "offset_y", "offset_z")}  # fmt: skip
    sides = {"y": ("width", "height", "length"), "z": ("length", "width", "height")}[dialect.up]
    for axis, side in zip("xyz", sides, strict=True):
        at[f"size_{axis}"] = head.index(dialect.columns.get(side, side))
    kept = {layout.items[step].name: step for step in plan.origins}
    rows = {row[at["id"]]: row for row in new if row[at["layout"] :][:1] == ["two"]}
    assert rows.keys() == kept.keys()
    others = [row for row in old if row[at["layout"] :][:1] != ["two"]]
    assert [row for row in new if row[at["layout"] :][:1] != ["two"]] == others
    ids = [row[at["id"]] for row in old if row[at["layout"] :][:1] == ["two"]]
    ids = [name for name in ids if name in kept]
    if dialect.order == "rows":
        ids = [item.name for item in plan.layout.items]
    assert list(rows) == ids
    axes = {"y": "xyz", "z": "yzx"}[dialect.up]
    for row in old:
        if row[at["layout"] :][:1] != ["two"] or row[at["id"]] not in kept:
            continue
        written, step = rows[row[at["id"]]], kept[row[at["id"]]]
        before, after = layout.items[step], plan.layout.items[plan.origins.index(step)]
        may = set()
        for ours, axis in enumerate(axes):
            point = "centre" if dialect.positions == "centre" else "corner"
            for key, (one, other) in {
                axis: (at_point(before, point)[ours], at_point(after, point)[ours]),
                f"size_{axis}": (before.size[ours], after.size[ours]),
                f"offset_{axis}": (before.mass_offset[ours], after.mass_offset[ours]),
            }.items():
                if abs(one - other) > 5e-7:
                    may.add(at[key])
        if "sequence" in head:
            place = head.index("sequence")
            assert written[place] == str(after.sequence + (dialect.order == "from-1"))
            may.add(place)
        for place, (one, other) in enumerate(zip(row, written, strict=True)):
            if place not in may:
                assert one == other
            else:
                assert other in row or len(other.partition(mark)[2]) <= 8


def at_point(item, point):
    half = 0.5 if point == "centre" else 0.0
    return [p + half * s for p, s in zip(item.position, item.size, strict=True)]


SHIPPED = """\
layout;pallet_length;pallet_width;pallet_height;sequence;id;x;y;z;length;width;height;weight;Lage
P;1200;800;1500;0;a;"0";0;0;400;300;200;5;unten
P;1200;800;1500;1;b;400; 0 ;0;400;300;200;5;unten
Q;1200;800;1500;0;a;0;0;0;400;300;200;5;unten
"""
MILLIMETRES = Dialect(units="mm", up="z", other_columns="ignore")


def test_cells_keep_quotes_and_spaces_and_new_decimals_have_the_mark_of_the_file(tmp_path):
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    source.write_text(SHIPPED)
    plan, _ = read_layouts(source, dialect=MILLIMETRES)
    # The file's x, y, z are our z, x, y; 12.3 + 1e-12 is no text of a length.
    changed = {"P": replan(plan, moved={0: (12.3 + 1e-12, 0.0, 1.05), 1: (3.0, 0.0, 45.0)})}
    rewrite(Content.of(source), target, changed, dialect=MILLIMETRES)
    expected = SHIPPED.replace('"0";0;', '"10,5";123;').replace("400; 0 ;0", "450; 30 ;0")
    assert target.read_text() == expected
    pointed = SHIPPED.replace("400;300;200;5;", "400;300.0;200;5.00;")
    source.write_text(pointed)
    rewrite(Content.of(source), target, changed, dialect=MILLIMETRES)
    expected = pointed.replace('"0";0;', '"10.5";123;').replace("400; 0 ;0", "450; 30 ;0")
    assert target.read_text() == expected


def test_a_file_of_windows_is_written_back_as_one(tmp_path):
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    text = SHIPPED.replace("P;", "Käfig;")
    source.write_bytes(text.encode("cp1252"))
    (plan, *_) = read_layouts(source, dialect=MILLIMETRES)
    assert plan.name == "Käfig"
    moved = {1: (plan.items[1].position[0], 0.0, 45.0)}
    rewrite(Content.of(source), target, {plan.name: replan(plan, moved=moved)}, dialect=MILLIMETRES)
    assert target.read_bytes().decode("cp1252").count("Käfig") == text.count("Käfig")
    assert read_layouts(target, dialect=MILLIMETRES)[0].items[1].position == moved[1]


def test_new_numbers_have_no_fewer_decimals_than_those_before(tmp_path):
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    text = SHIPPED.replace("400; 0 ;0", "400.000;0.00;0.0")
    source.write_text(text)
    plan, _ = read_layouts(source, dialect=MILLIMETRES)
    rewrite(
        Content.of(source),
        target,
        {"P": replan(plan, moved={1: (2.5, 0.0, 50.0)})},
        dialect=MILLIMETRES,
    )
    assert target.read_text() == text.replace("400.000;0.00;0.0", "500.000;25.00;0.0")


def test_a_number_that_rounds_to_zero_has_no_sign(tmp_path):
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    source.write_text(SHIPPED)
    plan, _ = read_layouts(source, dialect=MILLIMETRES)
    rewrite(
        Content.of(source),
        target,
        {"P": replan(plan, moved={1: (30.0, 0.0, -1e-9)})},
        dialect=MILLIMETRES,
    )
    assert target.read_text() == SHIPPED.replace("400; 0 ;0", "0; 300 ;0")


def test_a_turned_box_beside_a_column_that_says_how_it_is_turned_is_refused(tmp_path):
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    source.write_text(SHIPPED.replace("Lage", "Drehung").replace("unten", "0"))
    plan, _ = read_layouts(source, dialect=MILLIMETRES)
    with pytest.raises(
        LayoutError, match=r'in.csv: layout "P": box b .*column \'Drehung\'.*allowed: .*native'
    ):
        rewrite(Content.of(source), target, {"P": replan(plan, turn={1})}, dialect=MILLIMETRES)
    assert not target.exists()
    rewrite(Content.of(source), target, {"P": replan(plan, order=(1, 0))}, dialect=MILLIMETRES)
    rows = cells(target, ";")
    assert [row[4:6] for row in rows[1:]] == [["1", "a"], ["0", "b"], ["0", "a"]]


# --- JSON -----------------------------------------------------------------------------------------


def texts(path):
    """A JSON file with all numbers as the texts that they are."""
    return json.loads(path.read_text("utf-8-sig"), parse_float=str, parse_int=str)


def pairs(text):
    """JSON as pairs in the order of the text, with all numbers as the texts that they are."""
    return json.loads(text, parse_float=str, parse_int=str, object_pairs_hook=list)


NATIVE = """{"format": "steadyload-layouts", "version": 1,
  "layouts": [
    {"name": "A\u00e9", "pallet": {"width": 120.00, "height": 160, "depth": 80, "overhang": 5},
     "items": [
       {"sequence": 2, "id": 7, "position": [80.0, 0, 0], "size": [4e1, 30, 20.50], "weight": 12.0,
        "mass_offset": [2, 0, -1.0], "max_load_per_m2": 100},
       {"id": "b", "position": [0, 0, 0], "sequence": 0, "size": [40, 30, 40], "weight": 9},
       {"sequence": 1, "position": [40.0, 0.00, 0], "size": [40, 30, 40], "weight": 8}
     ]},
    {"name": "B", "pallet": {"width": 120, "height": 160, "depth": 80},
     "items": [{"sequence": 0, "position": [1.50, 0, 0], "size": [40, 30, 40], "weight": 12}]}
  ]}
"""


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("start", ["", "\ufeff"])
def test_a_native_file_keeps_all_but_white_space_and_the_numbers_that_changed(tmp_path, start, end):
    source, target = tmp_path / "in.json", tmp_path / "out.json"
    text = start + NATIVE.replace("\n", end)
    source.write_bytes(text.encode())
    some = read_layouts(source)
    rewrite(Content.of(source), target, {layout.name: replan(layout) for layout in some})
    assert target.read_bytes() == text.encode()
    changed = {"Aé": replan(some[0], order=(2, 0, 1), moved={2: (81.25, 0.0, 7.0)}, turn={2})}
    rewrite(Content.of(source), target, changed)
    assert_reads_as(target, changed, some)
    expected = (
        NATIVE.replace('"sequence": 2, "id"', '"sequence": 0, "id"')
        .replace("[80.0, 0, 0]", "[81.25, 0, 7]").replace("[4e1, 30, 20.50]", "[20.50, 30, 4e1]")
        .replace("[2, 0, -1.0]", "[1, 0, 2.0]")
        .replace('"sequence": 0, "size"', '"sequence": 1, "size"')
        .replace('{"sequence": 1, "position": [40.0', '{"sequence": 2, "position": [40.0')
    )  # fmt: skip
    written = target.read_bytes().decode()
    assert written.startswith(start + '{\n  "format"')
    # White space alone differs: numbers keep their digits, and keys their order.
    assert pairs(written.removeprefix(start)) == pairs(expected)


@pytest.mark.parametrize("left", [{0}, {1}, {2}, {0, 1}, {0, 2}, {1, 2}])
def test_a_box_left_out_of_a_native_file_goes_and_the_others_are_renumbered(tmp_path, left):
    source, target = tmp_path / "in.json", tmp_path / "out.json"
    source.write_text(NATIVE)
    some = read_layouts(source)
    kept = [step for step in (2, 0, 1) if step not in left]
    changed = {"Aé": replan(some[0], order=sorted(kept))}
    rewrite(Content.of(source), target, changed)
    assert_reads_as(target, changed, some)
    before, after = texts(source), texts(target)
    items = before["layouts"][0]["items"]
    items[:] = [item for item in items if int(item["sequence"]) not in left]
    for item in items:
        item["sequence"] = str(sorted(kept).index(int(item["sequence"])))
    assert after == before


JOB = {
    "label": "job", "assessmentCriteria": ["LoadingStability"],
    "ulds": [
        {"id": number, "properties": {"width": 200, "depth": 100, "maxHeight": 100, "uldType": "p"},
         "placedItems": [
            {"itemLabel": f"item-{k}", "weight": 0.05, "x": 50 * k, "y": 0, "z": 0.5, "sequence": k,
             "shape": {"shapeType": "Box", "width": 9, "height": 4, "depth": 3, "volume": 108},
             "rotationAxes": [0, 1, 2],
             "centerOfMass": {"x": 0.5, "y": -0.25, "z": 0} if k else None}
            for k in (1, 0, 2)]}
        for number in (1, "two")
    ],
}  # fmt: skip


@pytest.mark.parametrize("count", [1, 2])
def test_a_job_keeps_its_other_fields_and_the_order_of_its_items(tmp_path, count):
    source, target = tmp_path / "in.json", tmp_path / "out.json"
    content = JOB | {"ulds": JOB["ulds"][:count]}
    source.write_text(json.dumps(content, indent=3))
    some = read_layouts(source)
    rewrite(Content.of(source), target, {some[-1].name: replan(some[-1])})
    assert target.read_bytes() == source.read_bytes()
    plan = replan(some[-1], order=(2, 1), moved={1: (55.125, 1.0, 0.5)}, turn={1})
    rewrite(Content.of(source), target, {some[-1].name: plan})
    assert_reads_as(target, {some[-1].name: plan}, some)
    expected = texts(source)
    one, _, two = expected["ulds"][-1]["placedItems"]
    expected["ulds"][-1]["placedItems"] = [one, two]
    one |= {"x": "55.125", "y": "1", "sequence": "1"}
    one["shape"] |= {"width": "3", "depth": "9"}
    one["centerOfMass"] = {"x": "0.0", "y": "-0.25", "z": "0.5"}
    two |= {"sequence": "0"}
    assert texts(target) == expected


# --- ACLPP ----------------------------------------------------------------------------------------

BLOCK = """\
# Built by hand

segments:
  X1:
    built_ulds:
      pmc_F_ld-14:
        finish: 1
        loaded:
        - height: 91  # first
          lat: 100
          lng: 150
          piece: p0
          shipment: s0
          start_height: 0
          start_lat: 44
          start_lng: 10
        - height: 20.0
          lat: 100
          lng: 50
          piece: p1
          shipment: s0
          start_height: 93
          start_lat: 44
          start_lng: 10
        # of another kind
        - {height: 20, lat: 50, lng: 60, piece: p1, shipment: s0,
           start_height: 0, start_lat: 160, start_lng: 10}
        total_weight: 183.5
        uld_type: pmc_F_ld
      ake-1:
        loaded: [{height: 91, lat: 100, lng: 90, piece: p0, shipment: s0, start_height: 0,
          start_lat: 4, start_lng: 10}]
        uld_type: ake
    offloads:
      p9: 4
    shipments:
      s0:
        pieces:
          p0: {weight: 39.5}
          p1: {weight: 7}
"""


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_schedule_lists_pieces_in_the_new_order(tmp_path, end):
    source, target = tmp_path / "in.yaml", tmp_path / "out.yaml"
    text = BLOCK.replace("\n", end)
    source.write_bytes(text.encode())
    some = read_layouts(source)
    rewrite(Content.of(source), target, {layout.name: replan(layout) for layout in some})
    assert target.read_bytes() == text.encode()
    plan = replan(some[0], order=(2, 0, 1), moved={2: (162.5, 0.0, 10.0)}, turn={2})
    changed = {"X1/pmc_F_ld-14": plan}
    rewrite(Content.of(source), target, changed)
    assert_reads_as(target, changed, some)
    expected = yaml.safe_load(text)
    loaded = expected["segments"]["X1"]["built_ulds"]["pmc_F_ld-14"]["loaded"]
    loaded[:] = [loaded[2] | {"start_lat": 162.5, "lat": 60, "lng": 50}, loaded[0], loaded[1]]
    assert yaml.safe_load(target.read_bytes()) == expected
    for line in ("# Built by hand" + end, "        finish: 1" + end, "height: 20.0" + end):
        assert line.encode() in target.read_bytes()


@pytest.mark.parametrize("offloads", ["\n      p9: 4", "\n      p1: 4", " {}", " {p9: 1}"])
@pytest.mark.parametrize("left", [(0,), (1,), (2,), (1, 2)])
def test_a_piece_left_out_is_an_offload(tmp_path, offloads, left):
    source, target = tmp_path / "in.yaml", tmp_path / "out.yaml"
    source.write_text(BLOCK.replace("\n      p9: 4", offloads))
    some = read_layouts(source)
    changed = {some[0].name: replan(some[0], order=[k for k in range(3) if k not in left])}
    rewrite(Content.of(source), target, changed)
    assert_reads_as(target, changed, some)
    expected = yaml.safe_load(source.read_text())
    segment = expected["segments"]["X1"]
    device = segment["built_ulds"]["pmc_F_ld-14"]
    for place in left:
        piece = device["loaded"][place]["piece"]
        segment["offloads"][piece] = segment["offloads"].get(piece, 0) + 1
        device["total_weight"] -= {"p0": 39.5, "p1": 7}[piece]
    device["loaded"] = [e for k, e in enumerate(device["loaded"]) if k not in left]
    assert yaml.safe_load(target.read_text()) == expected


# --- PackingSolver --------------------------------------------------------------------------------

CERTIFICATE = """\
TYPE,ID,COPIES,BIN,X,Y,Z,LX,LY,LZ,ROTATION
BIN,0,2,0,0,0,0,120,80,100,
ITEM,1,1,0,0,0,0,20,30,40,YZX
ITEM,0,1,0,40,0,0,20,30,40,XYZ
ITEM,0,1,0,0,0,40,20,30,40,
BIN,0,1,1,0,0,0,120,80,100,
ITEM,0,1,1,0,0,0,20,30,40,ZXY
"""


def both(plan):
    """The same changed plan of both copies of a bin."""
    copy = plan.layout.renamed("bin 0 copy 1")
    return {"bin 0": plan, "bin 0 copy 1": Replanned(copy, plan.origins)}


@pytest.mark.parametrize("units", ["mm", "cm", "in"])
def test_a_certificate_states_moved_turned_and_missing_boxes(tmp_path, units):
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    source.write_text(CERTIFICATE)
    dialect = Dialect(units=units)
    cm = {"mm": 0.1, "cm": 1.0, "in": 2.54}[units]
    some = read_layouts(source, dialect=dialect)
    rewrite(
        Content.of(source),
        target,
        {layout.name: replan(layout) for layout in some},
        dialect=dialect,
    )
    assert target.read_bytes() == source.read_bytes()
    moved = {1: (50 * cm, 0.0, 40 * cm), 2: (1 * cm, 40 * cm, 0.0)}
    changed = both(replan(some[0], moved=moved, turn={0, 1, 2}))
    rewrite(Content.of(source), target, changed, dialect=dialect)
    assert_reads_as(target, changed, some, dialect=dialect)
    assert target.read_text() == CERTIFICATE.replace(
        "0,0,0,20,30,40,YZX", "0,0,0,30,20,40,ZYX"
    ).replace("40,0,0,20,30,40,XYZ", "40,50,0,30,20,40,YXZ").replace(
        "0,0,40,20,30,40,\n", "0,1,40,30,20,40,\n"
    )
    changed = both(replan(some[0], order=(0, 1)))
    rewrite(Content.of(source), target, changed, dialect=dialect)
    assert_reads_as(target, changed, some, dialect=dialect)
    assert target.read_text() == CERTIFICATE.replace("ITEM,0,1,0,0,0,40,20,30,40,\n", "")


def test_codes_of_rotation_are_those_of_the_solver(tmp_path):
    """A box that is turned has the code by which the solver gives a box the turned sides."""
    packer = pytest.importorskip("packingsolver3d")
    sides = {}
    for rotation in packer.Rotation:
        instance = packer.Instance(
            bin_types=[packer.BinType(60, 60, 60, copies=1)],
            item_types=[packer.ItemType(10, 20, 30, copies=1, rotations=(rotation,))],
            objective=packer.Objective.BIN_PACKING,
        )
        [placed] = packer.box.solve(instance, time_limit=1.0).placements
        sides[rotation.value] = [str(side) for side in (placed.lx, placed.ly, placed.lz)]
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    for code, (x, y, z) in sides.items():
        source.write_text(CERTIFICATE.replace("0,0,0,20,30,40,ZXY", f"0,0,0,{x},{y},{z},{code}"))
        last = read_layouts(source)[-1]
        rewrite(Content.of(source), target, {last.name: replan(last, turn={0})})
        *_, lx, ly, lz, new = cells(target, ",")[-1]
        assert [lx, ly, lz] == [y, x, z] == sides[new]


@pytest.mark.parametrize(
    ("text", "how", "message"),
    [
        (CERTIFICATE, {"moved": {1: (0.5, 0.0, 40.0)}}, r"box type 0 \(2nd\): has Y = 0.5 cm"),
        (CERTIFICATE, {"order": (1, 0, 2)}, "another order than that of height.*allowed: .*native"),
        (CERTIFICATE.replace("YZX", "3"), {"turn": {0}}, "is turned.*'3'; allowed: .*X, Y, Z"),
        (CERTIFICATE.replace("ITEM,1,", "STACK,0,1,0,0,0,0,20,30,40,\nITEM,1,"), {"turn": {0}},
         "stands in stacks.*native"),
    ],
)  # fmt: skip
def test_what_a_certificate_cannot_state_is_refused(tmp_path, text, how, message):
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    source.write_text(text)
    plan = replan(read_layouts(source)[0], **how)
    with pytest.raises(LayoutError, match=message) as caught:
        rewrite(Content.of(source), target, both(plan))
    assert str(caught.value).startswith(f"{source}: layout")
    assert not target.exists()


def test_copies_of_a_bin_change_alike(tmp_path):
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    source.write_text(CERTIFICATE)
    first, second, _ = read_layouts(source)
    plan, other = replan(first, turn={0}), replan(second, turn={1})
    for changed in ({"bin 0": plan}, {"bin 0": plan, "bin 0 copy 1": other}):
        with pytest.raises(LayoutError, match=r"2 copies.*allowed: all changed alike, or native"):
            rewrite(Content.of(source), target, changed)
    assert not target.exists()


# --- Packvium -------------------------------------------------------------------------------------


@pytest.fixture(scope="module", params=["", "big"], ids=["complete", "one too large"])
def packed(request):
    """A request of Packvium, its answer, and the items of it that are in no container."""
    packvium = pytest.importorskip("packvium")
    sides = {"flat": (600, 400, 100), "tall": (200, 250, 500)}
    if request.param:
        sides[request.param] = (3000, 100, 100)
    asked = {
        "units": {"length": "mm", "weight": "kg"},
        "items": [
            {"id": name, "weight": "6 kg", "quantity": 1,
             "dimensions": dict(zip(("length", "width", "height"), map(str, mm), strict=True))}
            for name, mm in sides.items()
        ],
        "containers": [{"id": "pallet", "inner_dimensions":
                        {"length": "1000", "width": "800", "height": "600"}}],
    }  # fmt: skip
    items = [packvium.Item.create(name, packvium.Dimensions.mm(*map(str, mm)), "6 kg")
             for name, mm in sides.items()]  # fmt: skip
    pallet = packvium.Container.create("pallet", packvium.Dimensions.mm("1000", "800", "600"))
    answer = packvium.Packer(packvium.PackingConfig.balanced()).pack(items, [pallet])
    return asked, answer, [f"{request.param}#1"] * bool(request.param)


def faults(request, path):
    import packvium

    content = json.loads(path.read_text())
    for placement in content["containers"][0]["placements"]:
        for measure in (*placement["position"].values(), *placement["dimensions"].values()):
            read = packvium.Length.of(measure["value"], measure["unit"]).ticks
            assert measure["ticks"] == pytest.approx(read, abs=1)
    return {issue.code for issue in packvium.validate(request, content)}


@pytest.mark.parametrize("unit", ["mm", "in"])
def test_a_result_of_packvium_stays_one(tmp_path, packed, unit):
    request, result, _ = packed
    source, target = tmp_path / "in.json", tmp_path / "out.json"
    source.write_text(json.dumps(result.to_dict(unit), indent=2))
    assert not faults(request, source)
    [plan] = read_layouts(source)
    rewrite(Content.of(source), target, {plan.name: replan(plan)})
    assert target.read_bytes() == source.read_bytes()
    second = plan.items[1]
    away = (80.0 - second.size[2], 0.0, 100.0 - second.size[0])
    changed = {plan.name: replan(plan, moved={1: away}, turn={1})}
    rewrite(Content.of(source), target, changed)
    assert_reads_as(target, changed)
    # Weights and forces are Packvium's to measure again; the plan itself is right.
    assert faults(request, target) == {"centre_of_mass_mismatch"}
    before, after = (json.loads(path.read_text()) for path in (source, target))
    placed = [content["containers"][0]["placements"] for content in (before, after)]
    place = next(k for k, box in enumerate(placed[0]) if box["item_id"] == second.name)
    [old, new] = [boxes.pop(place) for boxes in placed]
    assert before == after
    assert old.keys() == new.keys()
    assert new["dimensions"] == old["dimensions"] | {
        "length": old["dimensions"]["width"], "width": old["dimensions"]["length"]
    }  # fmt: skip


def test_a_box_left_out_of_a_result_of_packvium_is_unpacked(tmp_path, packed):
    request, result, unpacked = packed
    source, target = tmp_path / "in.json", tmp_path / "out.json"
    source.write_text(json.dumps(result.to_dict("in", "lb"), indent=2))
    [plan] = read_layouts(source)
    changed = {plan.name: replan(plan, order=(0,))}
    rewrite(Content.of(source), target, changed)
    assert_reads_as(target, changed)
    after = json.loads(target.read_text())
    unpacked = [*unpacked, plan.items[1].name]
    assert [box["item_id"] for box in after["unpacked_items"]] == unpacked
    assert after["summary"]["packed_item_count"] == 1
    assert sl.from_packvium(target).unplaced == tuple(unpacked)
    # Weights of items are not in a result, and what Packvium found of its own plan stays.
    assert faults(request, target) <= {
        "payload_weight_mismatch", "used_volume_mismatch", "centre_of_mass_mismatch",
        "score_mismatch", "result_fact_mismatch",
    }  # fmt: skip


# --- every format ---------------------------------------------------------------------------------


def test_a_name_or_an_origin_that_there_is_not_is_refused(tmp_path):
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    source.write_text(SHIPPED)
    plan, _ = read_layouts(source, dialect=MILLIMETRES)
    with pytest.raises(LayoutError, match="has no layout 'R' to change; allowed: P, Q"):
        rewrite(Content.of(source), target, {"R": replan(plan)}, dialect=MILLIMETRES)
    with pytest.raises(LayoutError, match="has the origin 7; allowed: 0 to 1"):
        rewrite(Content.of(source), target, {"P": Replanned(plan, (0, 7))}, dialect=MILLIMETRES)
    with pytest.raises(LayoutError, match=r"has the origins \(0, 0\); allowed: for each of its 2"):
        Replanned(plan, (0, 0))
    with pytest.raises(LayoutError, match=r"box a .*: would be read back with another id; "):
        rewrite(Content.of(source), target, {"P": Replanned(plan, (1, 0))}, dialect=MILLIMETRES)
    assert not target.exists()


def test_what_the_judge_saw_beside_places_is_compared_too(tmp_path):
    """A load that a box may bear, or a pallet, that the file does not state."""
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    source.write_text(SHIPPED)
    plan, _ = read_layouts(source, dialect=MILLIMETRES)
    higher = replace(plan.pallet, height=plan.pallet.height + 1.0)
    for other, told in (
        (plan.bearing((None, 7.5)), r"box b \(2nd\): .*another max_load; allowed: "),
        (plan.on("deck"), "another pallet; allowed: "),
        (Layout("P", higher, plan.items), "another pallet; allowed: "),
    ):
        with pytest.raises(LayoutError, match=told):
            rewrite(Content.of(source), target, {"P": replan(other)}, dialect=MILLIMETRES)
    changed = {"P": replan(plan.on("deck"))}
    rewrite(Content.of(source), target, changed, dialect=MILLIMETRES, floor="deck")
    assert target.read_text() == SHIPPED


def test_a_plan_that_is_changed_by_mistake_is_refused(tmp_path, monkeypatch):
    def one_more(*given):
        return written(*given).replace(b"Q;1200;800;1500;0;a;0;", b"Q;1200;800;1500;0;a;5;")

    written = plans_module._written
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    source.write_text(SHIPPED)
    plan, _ = read_layouts(source, dialect=MILLIMETRES)
    monkeypatch.setattr(plans_module, "_written", one_more)
    with pytest.raises(LayoutError, match=r'layout "Q": box a \(1st\): .* another place'):
        rewrite(Content.of(source), target, {"P": replan(plan, order=(1, 0))}, dialect=MILLIMETRES)
    assert not target.exists()


def test_a_text_of_half_a_character_is_refused(tmp_path):
    source, target = tmp_path / "in.json", tmp_path / "out.json"
    source.write_text(json.dumps(JOB | {"note": "\ud800"}))
    some = read_layouts(source)
    plan = replan(some[0], order=(0, 1))
    with pytest.raises(LayoutError, match=r"half a character .*: whole characters"):
        rewrite(Content.of(source), target, {some[0].name: plan})
    assert not target.exists()


def test_bytes_are_copied_where_no_plan_changed(tmp_path):
    """Also those that are no text, and that no reader takes."""
    source, target = tmp_path / "in", tmp_path / "out"
    for content in (b"PAR1 and so on", b"\0", b"", b"layout,x\n"):
        source.write_bytes(content)
        rewrite(Content.of(source), target, {})
        assert target.read_bytes() == content


def test_another_centre_of_mass_or_weight_is_refused(tmp_path):
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    source.write_text(SHIPPED)
    plan, _ = read_layouts(source, dialect=MILLIMETRES)
    heavy = replan(plan.with_mass_offsets([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    with pytest.raises(LayoutError, match=r"box a \(1st\): .*another centre of mass; allowed: "):
        rewrite(Content.of(source), target, {"P": heavy}, dialect=MILLIMETRES)
    first, second = plan.items
    lighter = Layout("P", plan.pallet, (first, replace(second, weight=4.0)))
    with pytest.raises(LayoutError, match=r"box b \(2nd\): .*another weight; allowed: "):
        rewrite(Content.of(source), target, {"P": Replanned(lighter, (0, 1))}, dialect=MILLIMETRES)
    assert not target.exists()


def test_a_layout_that_is_not_valid_stays_as_it_is(tmp_path):
    source, target = tmp_path / "in.csv", tmp_path / "out.csv"
    text = SHIPPED.replace("Q;1200;800;1500;0;a;0;0;0;400", "Q;1200;800;1500;0;a;0;0;0;-400")
    source.write_text(text)
    whole = tmp_path / "whole.csv"
    whole.write_text(SHIPPED)
    plan, _ = read_layouts(whole, dialect=MILLIMETRES)
    rewrite(Content.of(source), target, {"P": replan(plan, order=(1, 0))}, dialect=MILLIMETRES)
    assert target.read_text() == text.replace('1500;0;a;"0"', '1500;1;a;"0"').replace(
        "1500;1;b", "1500;0;b"
    )


@pytest.mark.parametrize("kind", [Format.NATIVE, Format.CSV, Format.JOB])
def test_a_real_pallet_is_changed_in_every_format(tmp_path, kind, customers_pallets):
    real = read_layouts(customers_pallets)[:3]
    source, target = tmp_path / "in", tmp_path / "out"
    write_layouts(source, real, kind)
    count = len(real[1])
    plan = replan(real[1], order=[*range(count - 1, -1, -1)][: count - 2])
    rewrite(Content.of(source), target, {real[1].name: plan})
    assert_reads_as(target, {real[1].name: plan}, real)
    other = tmp_path / "other"
    write_layouts(other, [real[0], plan.layout, real[2]], kind)
    if kind is Format.CSV:
        assert sorted(target.read_text()) == sorted(other.read_text())
    else:
        lengths = [len(orjson.dumps(orjson.loads(path.read_bytes()))) for path in (target, other)]
        assert lengths[0] == lengths[1]


def test_a_real_schedule_is_changed(tmp_path, aclpp_files):
    [schedule] = [file for file in aclpp_files if file.name.startswith("LH8368-25NOV15-FRA-BOM")]
    some = read_layouts(schedule)
    target = tmp_path / "out.yaml"
    rewrite(Content.of(schedule), target, {layout.name: replan(layout) for layout in some})
    assert target.read_bytes() == schedule.read_bytes()
    largest = max(some, key=len)
    changed = {largest.name: replan(largest, order=range(len(largest) - 1, 0, -1))}
    rewrite(Content.of(schedule), target, changed)
    assert_reads_as(target, changed, some)
    lines = [sorted(path.read_bytes().split(b"\r\n")) for path in (schedule, target)]
    assert len(lines[0]) - len(lines[1]) in (7, 8)
