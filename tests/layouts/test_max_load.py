"""The load that a box may bear, from files and back."""

import json
from dataclasses import replace

import pytest

from steadyload.layouts.batch_files import read_batch
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.files.record import FormatError
from steadyload.layouts.formats import Format, read_layouts, write_layouts
from steadyload.layouts.model.layout import Item, Layout, LayoutError, Pallet, replace_items
from steadyload.layouts.model.snapping import snap

BOXES = tuple(
    Item(k, (0.0, 10.0 * k, 0.0), (20.0, 10.0, 50.0), 8.0, max_load=most)
    for k, most in enumerate((40.0, 0.0, None))
)
LAYOUT = Layout("limited", Pallet(100, 60, 80), BOXES)


def limits(layout):
    return [item.max_load for item in layout.items]


@pytest.mark.parametrize("kind", [Format.NATIVE, Format.CSV, Format.PARQUET])
def test_limits_are_written_and_read(kind, tmp_path):
    file = tmp_path / "file"
    write_layouts(file, [LAYOUT], kind)
    [again] = read_layouts(file)
    assert limits(again) == [40.0, 0.0, None]
    assert again.content_hash() == LAYOUT.content_hash()  # no verdict of a method depends on it
    assert len(read_batch(file)) == 1


def test_a_layout_without_limits_is_written_as_before(tmp_path):
    file = tmp_path / "plain.csv"
    plain = replace_items(LAYOUT, tuple(replace(item, max_load=None) for item in BOXES))
    write_layouts(file, [plain], Format.CSV)
    assert "max_load" not in file.read_text()
    write_layouts(file, [plain], Format.NATIVE)
    assert "max_load" not in file.read_text()


def test_a_format_without_a_place_for_limits_is_refused(tmp_path):
    with pytest.raises(FormatError, match="max_load, for which job has no place; allowed: native"):
        write_layouts(tmp_path / "job.json", [LAYOUT], Format.JOB)
    assert not (tmp_path / "job.json").exists()


def test_a_limit_a_square_metre_counts_the_whole_top(tmp_path):
    file = tmp_path / "file.json"
    write_layouts(file, [LAYOUT], Format.NATIVE)
    content = json.loads(file.read_text())
    item = content["layouts"][0]["items"][0]
    del item["max_load"]
    item["max_load_per_m2"] = 300.0
    file.write_text(json.dumps(content))
    assert limits(read_layouts(file)[0])[0] == pytest.approx(30.0)  # 0.2 m x 0.5 m
    item["max_load"] = 30.0
    file.write_text(json.dumps(content))
    with pytest.raises(LayoutError, match="states max_load and max_load_per_m2; allowed: one"):
        read_layouts(file)


def test_columns_follow_the_dialect(tmp_path):
    file = tmp_path / "wms.csv"
    file.write_text(
        "layout,sequence,x,y,z,length,width,height,weight,Tragkraft\n"
        "A,0,0,0,0,500,200,100,8000,40000\n"
        "A,1,0,0,100,500,200,100,8000,\n"
    )
    dialect = Dialect(
        units="mm", weight="g", up="z", pallet="800x1000x600", columns={"max_load": "Tragkraft"}
    )
    assert limits(read_layouts(file, dialect=dialect)[0]) == [40.0, None]


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (-1.0, "max_load is -1 kg; allowed: 0 to 1000000000 kg"),
        (float("nan"), "max_load is nan kg; allowed: 0 to 1000000000 kg"),
        ("many", "max_load is 'many'; allowed: a number"),
    ],
)
def test_what_is_no_limit_is_refused(value, message, tmp_path):
    with pytest.raises(LayoutError) as refused:
        replace(BOXES[0], max_load=value)
    assert message in str(refused.value)
    file = tmp_path / "file.json"
    write_layouts(file, [LAYOUT], Format.NATIVE)
    content = json.loads(file.read_text())
    content["layouts"][0]["items"][1]["max_load"] = value
    if value == value:
        file.write_text(json.dumps(content))
        with pytest.raises(LayoutError) as refused:
            read_layouts(file)
        assert "item 1: max_load is" in str(refused.value)


def test_limits_stay_with_boxes_that_are_moved():
    assert limits(snap(LAYOUT)) == limits(LAYOUT.first(3)) == limits(LAYOUT)
    assert limits(LAYOUT.with_mass_offsets(LAYOUT.mass_offsets)) == limits(LAYOUT)
