"""Every reader on real-shaped files, and every kind of bad file."""

import csv
import io
import json
import math
from pathlib import Path

import jsonschema
import pytest

from steadyload.layouts import Item, Layout, LayoutError, Pallet
from steadyload.layouts.files.csv_reader import CSV_COLUMNS
from steadyload.layouts.files.record import FormatError, Refused
from steadyload.layouts.formats import (
    Format,
    read_layouts,
    read_written,
    scan_layouts,
    write_layouts,
)
from steadyload.layouts.model.floor import FloorError, FloorKind
from steadyload.layouts.model.snapping import snap

SCHEMA = Path(__file__).resolve().parents[2] / "docs" / "layouts.schema.json"


@pytest.fixture
def layouts():
    pallet = Pallet(120.0, 100.5, 80.0)
    first = Layout(
        "first, with a comma",
        pallet,
        (
            Item(0, (0.0, 0.0, 0.0), (10.0, 20.0, 30.0), 1.25, (0.1, -0.2, 1 / 3), 'a "box"'),
            Item(1, (0.0, 20.0, 0.0), (10.0, 5.0, 30.0), 2.0),
        ),
    )
    return [first, Layout("second", pallet, (Item(0, (1.0, 0.0, 2.0), (3.0, 4.0, 5.0), 6.0),))]


def native(**changes):
    entry = {
        "sequence": 0,
        "name": "box",
        "position": [0, 0, 0],
        "size": [10, 10, 10],
        "weight": 1,
    }
    layout = {
        "name": "A",
        "pallet": {"width": 100, "height": 100, "depth": 100},
        "items": [entry | changes],
    }
    return {"format": "steadyload-layouts", "version": 1, "layouts": [layout]}


# The published benchmark's form, written down from its description, fields that do not matter too.
JOB = {
    "ulds": [
        {
            "placedItems": [
                {
                    "itemLabel": "item-7",
                    "shipmentLabel": "s1",
                    "loadCapacity": 100000,
                    "rotationAxes": [0, 1, 2],
                    "priority": 0,
                    "weight": 30,
                    "x": 5,
                    "y": 12,
                    "z": 0,
                    "sequence": 1,
                    "shape": {
                        "shapeType": "Box", "width": 9, "height": 4, "depth": 3, "volume": 108
                    },
                    "centerOfMass": {"x": 0.5, "y": -0.25, "z": 0},
                },
                {
                    "itemLabel": "item-3",
                    "weight": 40,
                    "x": 5,
                    "y": 0,
                    "z": 0,
                    "sequence": 0,
                    "shape": {
                        "shapeType": "Box", "width": 9, "height": 12, "depth": 3, "volume": 324
                    },
                    "centerOfMass": {"x": 0, "y": 0, "z": 0},
                },
            ],
            "id": 1,
            "properties": {"width": 30, "depth": 20, "maxHeight": 40, "uldType": "pallet"},
        }
    ],
    "assessmentCriteria": ["LoadingStability"],
    "label": "Data_2_Ulds_scenario_2a_H1_Class_1_Instance_0_ULD_1",
}  # fmt: skip

ACLPP = """\
flights:
  X1:
    aircraft_type: md11f
segments:
  X1-FRA:
    built_ulds:
      pmc_F_ld-14:
        finish: 1
        loaded:
        - {height: 91, lat: 173, lng: 151, piece: p0, shipment: s0, start_height: 0,
           start_lat: 44, start_lng: 10}
        - {height: 20, lat: 100, lng: 50, piece: p1, shipment: s0, start_height: 93,
           start_lat: 44, start_lng: 10}
        uld_type: pmc_F_ld
    shipments:
      s0:
        pieces:
          p0: {weight: 39.5}
          p1: {weight: 7}
"""


def write(path, content):
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


@pytest.mark.parametrize("kind", [Format.NATIVE, Format.CSV, Format.JOB, Format.PARQUET])
def test_a_round_trip_is_exact(tmp_path, layouts, kind):
    if kind is Format.JOB:
        layouts = layouts[:1]
    write_layouts(tmp_path / "file", layouts, kind)
    back = read_layouts(tmp_path / "file")
    assert [lay.name for lay in back] == [lay.name for lay in layouts]
    assert [lay.items for lay in back] == [lay.items for lay in layouts]
    assert [lay.pallet for lay in back] == [lay.pallet for lay in layouts]


@pytest.fixture
def decked():
    pallet = Pallet(120.0, 100.5, 80.0, overhang=3.5, deck_height=12.0, floor=FloorKind.DECK)
    return Layout("decked", pallet, (Item(0, (-3.25, 0.0, 2.0), (30.0, 4.0, 5.0), 6.0),))


def test_a_native_file_holds_what_a_pallet_has_beside_its_size(tmp_path, decked, layouts):
    write_layouts(tmp_path / "file", [decked, *layouts], Format.NATIVE)
    found = read_layouts(tmp_path / "file")
    assert [layout.pallet for layout in found] == [
        decked.pallet,
        *(each.pallet for each in layouts),
    ]
    [again] = read_written(tmp_path / "file", ["decked"])
    assert again.content_hash() == decked.content_hash()
    content = json.loads((tmp_path / "file").read_text())
    jsonschema.validate(content, json.loads(SCHEMA.read_text()))
    # A pallet with a size alone is written as it always was.
    assert set(content["layouts"][1]["pallet"]) == {"width", "height", "depth"}


@pytest.mark.parametrize("kind", [Format.CSV, Format.JOB])
def test_a_format_without_a_place_for_a_deck_is_not_written(tmp_path, decked, kind):
    with pytest.raises(FormatError) as caught:
        write_layouts(tmp_path / "file", [decked], kind)
    assert f'"decked": has a pallet with overhang 3.5, for which {kind} has no place' in str(
        caught.value
    )
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", [Format.NATIVE, Format.CSV, Format.JOB, Format.PARQUET])
def test_an_overhanging_layout_is_read_as_it_was_written(tmp_path, kind):
    over = Layout("A", Pallet(50.0, 50.0, 50.0), (Item(0, (-9.0, 0, 0), (20.0, 9.0, 9.0), 1.0),))
    write_layouts(tmp_path / "file", [over], kind)
    [found] = read_layouts(tmp_path / "file")
    assert (found.content_hash(), found.floor) == (over.content_hash(), over.floor)
    # An option of the reader comes before what the file states.
    [found] = read_layouts(tmp_path / "file", overhang=20.0, floor="infinite")
    assert (found.pallet.overhang, found.floor.has_edges) == (20.0, False)
    with pytest.raises(LayoutError, match=r"allowed: inside the pallet's contour, -5 to 55 cm"):
        read_layouts(tmp_path / "file", overhang=5.0)
    with pytest.raises(FloorError, match="floor is 'desk'; did you mean 'deck'"):
        read_layouts(tmp_path / "file", floor="desk")


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        ({"overhang": -1}, "pallet overhang is -1 cm"),
        ({"overhang": "wide"}, "pallet overhang is 'wide'; allowed: a number"),
        ({"deck_height": 0}, "pallet deck_height is 0 cm"),
        ({"deck_height": True}, "pallet deck_height is True; allowed: a number"),
        ({"floor": "desk"}, "pallet floor is 'desk'; allowed: auto, deck, infinite"),
        ({"floor": ["deck"]}, "pallet floor is ['deck']; allowed: auto, deck, infinite"),
        ({"flor": "deck"}, "unknown key 'flor'; did you mean 'floor'?"),
    ],
)
def test_a_deck_that_cannot_be_is_refused(tmp_path, stated, message):
    content = native()
    content["layouts"][0]["pallet"] |= stated
    with pytest.raises(LayoutError) as caught:
        read_layouts(write(tmp_path / "bad.json", content))
    assert message in str(caught.value)
    assert 'layout "A"' in str(caught.value)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(content, json.loads(SCHEMA.read_text()))


def test_the_schema_refuses_what_the_reader_refuses():
    schema = json.loads(SCHEMA.read_text())
    jsonschema.validate(native(), schema)
    for changes in ({"weight": 0}, {"size": [1, 2]}, {"sequence": -1}, {"weight": "1"}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(native(**changes), schema)


def test_job_files_keep_axes_and_sequence(tmp_path):
    (layout,) = read_layouts(write(tmp_path / "any.name", JOB))
    assert layout.name == JOB["label"]
    assert layout.pallet == Pallet(width=30.0, height=40.0, depth=20.0)
    assert [i.name for i in layout.items] == ["item-3", "item-7"]
    assert layout.items[1].position == (5.0, 12.0, 0.0)
    assert layout.items[1].size == (9.0, 4.0, 3.0)
    assert layout.items[1].mass_offset == (0.5, -0.25, 0.0)
    assert layout.items[1].weight == 30.0


def test_aclpp_files_turn_their_axes_and_find_their_weights(tmp_path):
    (layout,) = read_layouts(write(tmp_path / "schedule.yaml", ACLPP))
    assert layout.name == "X1-FRA/pmc_F_ld-14"
    assert layout.pallet == Pallet(width=405.0, height=153.0, depth=243.0)
    first, second = layout.items
    assert (first.position, first.size) == ((44.0, 0.0, 10.0), (173.0, 91.0, 151.0))
    assert (first.weight, second.weight) == (39.5, 7.0)


def test_snapping_closes_small_gaps_only_when_asked(tmp_path):
    gap = ACLPP.replace("start_height: 93", "start_height: 91.3")
    path = write(tmp_path / "schedule.yaml", gap)
    assert read_layouts(path)[0].items[1].position[1] == 91.3
    assert read_layouts(path, snap_gap=0.5)[0].items[1].position[1] == 91.0
    assert read_layouts(path, snap_gap=0.2)[0].items[1].position[1] == 91.3


def test_snapping_closes_every_slit_of_a_stack():
    # Boxes of 30 cm with a slit of 0.4 cm under each: the third sinks by 1.2 cm in all.
    def stack(*bottoms):
        return Layout(
            "a",
            Pallet(50.0, 200.0, 50.0),
            tuple(Item(k, (0.0, y, 0.0), (30.0, 30.0, 30.0), 1.0) for k, y in enumerate(bottoms)),
        )

    assert [i.position[1] for i in snap(stack(0.4, 30.8, 61.2), 0.5).items] == [0.0, 30.0, 60.0]
    # A slit of 0.6 cm stays, and what stands above it stays too.
    assert [i.position[1] for i in snap(stack(0.0, 30.6, 61.0), 0.5).items] == [0.0, 30.6, 60.6]


@pytest.mark.parametrize("gap", [0.25, 0.5, 2.0])
@pytest.mark.parametrize("on", ["the floor", "a box"])
def test_a_slit_of_exactly_the_gap_is_closed_and_a_wider_one_is_not(gap, on):
    below = [] if on == "the floor" else [Item(0, (0.0, 0.0, 0.0), (30.0, 30.0, 30.0), 1.0)]
    top = 30.0 * len(below)

    def lowered_to(slit):
        box = Item(len(below), (0.0, top + slit, 0.0), (30.0, 30.0, 30.0), 1.0)
        made = snap(Layout("a", Pallet(50.0, 200.0, 50.0), (*below, box)), gap)
        return made.items[-1].position[1]

    assert lowered_to(gap) == top
    assert lowered_to(0.5 * gap) == top
    assert lowered_to(1.25 * gap) == top + 1.25 * gap


def test_snapping_never_makes_items_overlap():
    # The second item would sink into the third, which comes later in the sequence.
    items = (
        Item(0, (0.0, 0.0, 0.0), (40.0, 30.0, 40.0), 1.0),
        Item(1, (0.0, 30.4, 0.0), (80.0, 30.0, 40.0), 1.0),
        Item(2, (40.0, 0.0, 0.0), (40.0, 30.3, 40.0), 1.0),
    )
    snapped = snap(Layout("a", Pallet(100.0, 100.0, 100.0), items), 0.5)
    assert [i.position[1] for i in snapped.items] == pytest.approx([0.0, 30.3, 0.0])


def test_csv_columns_come_in_any_order_and_offsets_may_be_left_out(tmp_path):
    columns = (
        "weight,layout,sequence,x,y,z,width,height,depth,pallet_depth,pallet_height,pallet_width"
    )
    path = write(tmp_path / "a.csv", f"{columns}\n5,A,0,1,0,2,3,4,5,60,70,80\n")
    (layout,) = read_layouts(path)
    assert layout.pallet == Pallet(80.0, 70.0, 60.0)
    assert layout.items == (Item(0, (1.0, 0.0, 2.0), (3.0, 4.0, 5.0), 5.0),)


def test_an_excel_file_with_a_byte_order_mark_is_read(tmp_path, layouts):
    write_layouts(tmp_path / "a", layouts, Format.CSV)
    text = (tmp_path / "a").read_text()
    (tmp_path / "b").write_text(text.replace("\n", "\r\n"), encoding="utf-8-sig")
    assert [lay.items for lay in read_layouts(tmp_path / "b")] == [lay.items for lay in layouts]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"weight": math.nan}, 'layout "A": box box (1st): weight is nan kg'),
        ({"weight": -1}, "weight is -1 kg"),
        ({"weight": "7"}, "weight is '7'; allowed: a number"),
        ({"weight": True}, "weight is True; allowed: a number"),
        ({"weight": None}, "weight is missing"),
        ({"weight": 10**400}, "weight is inf kg"),
        ({"size": [0, 1, 1]}, "width is 0 cm"),
        ({"size": [1, 1]}, "size is [1, 1]; allowed: a list of three numbers"),
        ({"position": "origin"}, "position is 'origin'"),
        ({"position": [105, 0, 0]}, "allowed: inside the pallet's contour, -10 to 110 cm"),
        ({"sequence": 1}, "sequence 0 is missing"),
        ({"sequence": "first"}, "sequence is 'first'"),
        ({"mass_offset": [9, 0, 0]}, "centre-of-mass offset x is 9 cm"),
        ({"mass_ofset": [1, 0, 0]}, "unknown key 'mass_ofset'; did you mean 'mass_offset'?"),
        ({"name": 7}, "items[0].name is 7; allowed: a text"),
    ],
)
def test_a_bad_value_is_named_with_its_place(tmp_path, changes, message):
    path = write(tmp_path / "bad.json", native(**changes))
    with pytest.raises(LayoutError) as caught:
        read_layouts(path)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)
    assert "allowed" in str(caught.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "is empty"),
        ("hello", "is in no known format"),
        ("\0\1\2", "is in no known format"),
        ('{"format": "steadyload-layouts", "version": 1, "lay', "is not valid JSON"),
        ("{}", "is JSON of another kind"),
        ('{"format": "steadyload-layouts", "version": 2, "layouts": []}', "has version 2"),
        ('{"format": "steadyload-layouts", "version": 1, "layouts": 3}', "allowed: a list"),
        ('{"ulds": {}}', "allowed: a list"),
        ('{"ulds": [{"properties": 3}]}', "allowed: an object"),
        ("layout,sequence\nA,0\n", "lacks the CSV column"),
        ("layout,sequence,offset x\n", "has the unknown CSV column 'offset x'"),
        (",".join([*CSV_COLUMNS, "x"]) + "\n", "has the CSV column 'x' twice"),
        ('layout,"sequence\nA,0', "is not CSV"),
        ("layout,sequence" + "\r", "lacks the CSV column"),
        ('{"format": "steadyload-layouts", "version": 1, "layouts": []}', "holds no layouts"),
        ('{"format": "steadyload-layouts", "version": true, "layouts": []}', "has version True"),
        ('{"version": 1, "version": 1}', "states 'version' twice in one object"),
        ('{"a": ' + "9" * 5000 + "}", "holds a number that is none"),
        ("flights:\n a: " + "9" * 5000, "holds a YAML value that is none"),
        ("#a\n" + "\n" * 60 + "x: 1", "is in no known format"),
        ("flights:\n  a: [1, 2\n", "is not valid YAML"),
        ("flights:\n  a: 1\n", "segments is missing"),
        (ACLPP.replace("uld_type: pmc_F_ld", "uld_type: pmc"), "uld_type is 'pmc'"),
        (ACLPP[: ACLPP.index("          p1:")], "states no weight for shipment 's0', piece 'p1'"),
        ("{" + '"a":{' * 100_000, "nested too deeply"),
    ],
)
def test_a_file_that_is_not_one_is_refused_in_a_sentence(tmp_path, content, message):
    path = write(tmp_path / "file", content)
    with pytest.raises(FormatError) as caught:
        read_layouts(path)
    assert message in str(caught.value)
    assert str(path) in str(caught.value)


def test_every_truncation_of_every_format_is_refused_or_whole(tmp_path, layouts):
    """A cut-off file never yields a shorter layout without a word."""
    texts = [json.dumps(JOB), ACLPP]
    for kind in (Format.NATIVE, Format.CSV):
        write_layouts(tmp_path / "whole", layouts, kind)
        texts.append((tmp_path / "whole").read_text())
    silent = 0
    for text in texts[:3]:
        for length in range(1, len(text.rstrip()) - 1, 7):
            path = write(tmp_path / "cut", text[:length])
            try:
                read = read_layouts(path)
            except LayoutError:
                continue
            silent += len(read)
    assert silent == 0
    # CSV has no end mark: a cut inside a row is seen, a cut after a row cannot be.
    rows = list(csv.reader(io.StringIO(texts[3])))
    path = write(tmp_path / "cut", texts[3][: texts[3].rindex(",")])
    with pytest.raises(FormatError, match=f"allowed: {len(rows[0])}"):
        read_layouts(path)


def test_a_bad_shape_type_is_refused(tmp_path):
    job = json.loads(json.dumps(JOB))
    job["ulds"][0]["placedItems"][0]["shape"]["shapeType"] = "Cylinder"
    with pytest.raises(LayoutError, match="shape is 'Cylinder'; allowed: 'Box'"):
        read_layouts(write(tmp_path / "job.json", job))


@pytest.mark.parametrize("changes", [{"weight": -1}, {"size": [1, 2]}, {"colour": "red"}])
def test_an_invalid_layout_among_others_can_be_skipped(tmp_path, changes):
    content = native()
    content["layouts"] += native(**changes)["layouts"]
    content["layouts"][1]["name"] = "B"
    good, bad = scan_layouts(write(tmp_path / "two.json", content))
    assert isinstance(good, Layout)
    assert isinstance(bad, Refused)
    assert bad.name == "B"


def test_a_name_that_stands_twice_is_refused(tmp_path):
    content = native()
    content["layouts"] *= 2
    with pytest.raises(LayoutError, match="name stands there twice"):
        read_layouts(write(tmp_path / "two.json", content))


def test_a_name_of_too_many_characters_is_refused_and_no_layout_beside_it(tmp_path):
    """Names that begin alike are others, and so is one that a cut name would have been."""
    names = ["n" * 1001, "n" * 1000 + "B", "n" * 40 + "...", "n" * 1000]
    content = native()
    content["layouts"] = [native()["layouts"][0] | {"name": name} for name in names]
    found = list(scan_layouts(write(tmp_path / "long.json", content)))
    assert [type(entry) for entry in found] == [Refused, Refused, Layout, Layout]
    assert len({entry.name for entry in found}) == 4
    for entry in found[:2]:
        assert str(entry.error).endswith('n...": name has 1,001 characters; allowed: at most 1,000')


@pytest.mark.parametrize("harm", [b"\xff", b"[" * 100_000])
def test_a_kept_file_that_was_harmed_is_refused(tmp_path, layouts, harm):
    path = tmp_path / "kept.json"
    write_layouts(path, layouts, Format.NATIVE)
    path.write_bytes(path.read_bytes().replace(b'"position": [', b'"position": [' + harm, 1))
    with pytest.raises(FormatError, match=r"kept\.json: is not"):
        list(read_written(path))


def test_a_name_that_a_label_makes_too_long_is_refused(tmp_path):
    job = json.loads(json.dumps(JOB))
    job["ulds"] = [job["ulds"][0] | {"id": number} for number in (1, 22, "n" * 1001)]
    job["label"] = "n" * 998
    good, *bad = scan_layouts(write(tmp_path / "job.json", job))
    assert good.name == "n" * 998 + "#1"
    assert [str(entry.error).rpartition('": ')[2] for entry in bad] == [
        "name has 1,001 characters; allowed: at most 1,000"
    ] * 2


def test_an_id_of_too_many_digits_is_refused(tmp_path):
    content = native(id=10**1000)
    del content["layouts"][0]["items"][0]["name"]
    with pytest.raises(FormatError, match=r"items\[0\].id has 1,001 characters"):
        read_layouts(write(tmp_path / "long.json", content))


@pytest.mark.parametrize("kind", [Format.NATIVE, Format.PARQUET])
def test_equal_names_are_not_written(tmp_path, layouts, kind):
    with pytest.raises(FormatError, match="two of the layouts to write have this name"):
        write_layouts(tmp_path / "x", [layouts[0], layouts[0]], kind)
    assert not list(tmp_path.iterdir())


def test_a_centre_of_mass_of_a_job_is_whole_or_absent(tmp_path):
    for value in ({"a": 1}, "", 0, [], False, {"x": 1, "y": 0}):
        job = json.loads(json.dumps(JOB))
        job["ulds"][0]["placedItems"][0]["centerOfMass"] = value
        with pytest.raises(LayoutError, match="allowed"):
            read_layouts(write(tmp_path / "job.json", job))
    job["ulds"][0]["placedItems"][0]["centerOfMass"] = None
    assert read_layouts(write(tmp_path / "job.json", job))[0].items[1].mass_offset == (0, 0, 0)


def test_aclpp_cannot_be_written(tmp_path, layouts):
    with pytest.raises(FormatError, match="cannot be written as aclpp"):
        write_layouts(tmp_path / "x", layouts, Format.ACLPP)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("given", [17, io.StringIO("text"), None])
def test_what_is_no_file_is_refused_by_what_is_allowed(given):
    with pytest.raises(TypeError, match=r"the file to read is .*; allowed: a path, bytes, a file"):
        list(read_layouts(given))
