"""Layouts of files that are checked as a whole and then judged one by one."""

import dataclasses
import errno
import gc
import tempfile

import numpy as np
import pytest

from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.files.record import FormatError, Refused
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.layout import ARRAYS
from steadyload.layouts.packing.packing import random_layouts
from steadyload.methods.registry import make_method
from steadyload.runs import entries as kept
from steadyload.runs.entries import Entries, scan_entries
from steadyload.runs.scoring import score_entries

BAD = (
    "layout,pallet_width,pallet_height,pallet_depth,sequence,x,y,z,width,height,depth,weight\n"
    "good,120,160,80,0,0,0,0,40,30,40,5\n"
    "bad,120,160,80,0,0,0,0,40,30,40,0\n"
)


def one_box(number):
    return Layout(f"L{number}", Pallet(9.0, 9.0, 9.0), (Item(0, (0, 0, 0), (1, 1, 1), 1.0),))


@pytest.fixture
def files(tmp_path):
    """One whose boxes have ids, one with a layout that is not valid, one of loads on boxes."""
    many = random_layouts(6, seed=2)
    named = [
        dataclasses.replace(item, name=f"SKU-{item.sequence}", max_load=None)
        for item in many[0].items
    ]
    many[0] = Layout(many[0].name, many[0].pallet, tuple(named))
    write_layouts(tmp_path / "many.json", many, Format.NATIVE)
    (tmp_path / "bad.csv").write_text(BAD)
    bearing = one_box(7)
    bearing = Layout(
        "bearing", bearing.pallet, (dataclasses.replace(bearing.items[0], max_load=3.0),)
    )
    write_layouts(tmp_path / "bearing.json", [bearing], Format.NATIVE)
    return [tmp_path / name for name in ("many.json", "bad.csv", "bearing.json")]


@pytest.mark.parametrize(("items", "memory"), [(500, 8 * 2**20), (1, 1), (40, 1)])
def test_what_is_handed_out_is_what_was_read(files, monkeypatch, items, memory):
    monkeypatch.setattr(kept, "_ITEMS", items)
    monkeypatch.setattr(kept, "_IN_MEMORY", memory)
    read = list(scan_entries(files))
    with Entries(scan_entries(files)) as entries:
        assert (len(entries), entries.valid, entries.refused.count) == (9, 8, 1)
        assert "weight is 0 kg" in entries.refused.first[0]
        for _ in range(2):
            for (file, found), (name, expected) in zip(entries, read, strict=True):
                assert (file, found.name) == (name, expected.name)
                if isinstance(expected, Refused):
                    assert str(found.error) == str(expected.error)
                    assert type(found.error) is type(expected.error)
                    continue
                assert (found.items, found.pallet, found.floor) == (
                    expected.items, expected.pallet, expected.floor,
                )  # fmt: skip
                for key in ARRAYS:
                    assert np.array_equal(getattr(found, key), getattr(expected, key))
                    assert not getattr(found, key).flags.writeable


def test_no_more_layouts_are_in_memory_than_are_read_at_a_time(monkeypatch):
    monkeypatch.setattr(kept, "_ITEMS", 20)

    def in_memory():
        return sum(type(thing) is Layout for thing in gc.get_objects())

    before = in_memory()
    most = 0
    with Entries(("a.json", one_box(k)) for k in range(300)) as entries:
        for place, record in enumerate(score_entries(entries, [make_method("fbs")])):
            assert record["layout"] == f"L{place}"
            if place % 50 == 0:
                most = max(most, in_memory())
    assert most - before <= 2 * 20


def test_a_record_comes_before_the_next_layout_is_taken():
    class Counted(Entries):
        taken = 0

        def __iter__(self):
            for entry in super().__iter__():
                self.taken += 1
                yield entry

    with Counted(("a.json", one_box(k)) for k in range(5)) as entries:
        records = score_entries(entries, [make_method("fbs")])
        assert entries.taken == 0
        assert [(record["layout"], entries.taken) for record in records] == [
            (f"L{k}", k + 1) for k in range(5)
        ]


def test_what_is_wrong_is_raised_before_there_is_an_entry(tmp_path):
    (tmp_path / "cut.csv").write_text(BAD + "cut,120,160\n")
    with pytest.raises(FormatError, match="line 4 has 3 values"):
        Entries(scan_entries([tmp_path / "cut.csv"]))


def test_a_full_disk_is_told_by_its_place(monkeypatch):
    def full(*content):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(tempfile.SpooledTemporaryFile, "write", full)
    with pytest.raises(OSError, match="No space left") as raised:
        Entries([("a.json", one_box(0))])
    assert raised.value.filename == tempfile.gettempdir()
