"""Units that were probably read wrong are told once a file; layouts of real size never are."""

import logging

import numpy as np
import pytest

from steadyload.app.viewing import pick_layouts
from steadyload.cli import main
from steadyload.layouts.batch_files import plain_batch, read_batch
from steadyload.layouts.benchmark.dataset import load_benchmark
from steadyload.layouts.benchmark.parts import SETS
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.formats import Format, read_layouts, scan_layouts, write_layouts
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.layouts.model.plausibility import implausible

HEADER = "layout,pallet_width,pallet_height,pallet_depth,sequence,x,y,z,width,height,depth,weight"
ROWS = [f"PAL-{k},1200,1800,800,0,0,0,0,400,300,300,6500" for k in range(3)]


def pallet(scale=1.0, weight=6.5):
    sides = [scale * side for side in (120, 180, 80)]
    item = Item(0, (0, 0, 0), (40 * scale, 30 * scale, 30 * scale), weight)
    return Layout("PAL-1", Pallet(*sides), (item,))


def test_a_plausible_pallet_is_not_spoken_of():
    assert implausible(pallet()) == ""


@pytest.mark.parametrize(
    ("layout", "units"),
    [
        (pallet(weight=6500), "--weight g"),
        (pallet(scale=10), "--units mm"),
        (pallet(scale=10, weight=6500), "--units mm and --weight g"),
        (pallet(scale=0.01), "--units m"),
        (pallet(scale=0.01, weight=1e-5), "--units m and another --weight"),
        (pallet(weight=0.0065), "another --units or --weight"),
    ],
)
def test_wrong_units_are_named_with_the_flags(layout, units):
    told = implausible(layout)
    assert told.endswith(f"did you mean {units}?")


def test_the_figures_are_told():
    assert implausible(pallet(scale=10, weight=6500)) == (
        'layout "PAL-1": a pallet of 1,200 cm x 800 cm and boxes of 400 cm and 6,500 kg (medians), '
        "0.18 kg a litre: did you mean --units mm and --weight g?"
    )


def test_the_figures_are_in_plain_digits():
    assert "boxes of 40 cm and 12,000 kg (medians), 330 kg a litre:" in implausible(
        pallet(weight=12_000)
    )


@pytest.mark.parametrize("name", ["", *SETS])
def test_no_shipped_set_is_spoken_of(name):
    labelled = load_benchmark(name) if name else load_benchmark()
    batch = labelled.batch(labelled.select())
    assert [told for k in range(0, len(batch), 7) if (told := implausible(batch[k]))] == []


@pytest.mark.parametrize("data", ["customers_pallets", "aclpp_files"])
def test_no_real_file_is_spoken_of(data, caplog, request):
    files = request.getfixturevalue(data)
    for file in files[:6] if data == "aclpp_files" else [files]:
        assert any(isinstance(entry, Layout) for entry in scan_layouts(file))
    assert caplog.messages == []


@pytest.mark.parametrize("kind", [Format.CSV, Format.NATIVE])
@pytest.mark.parametrize(
    "layouts",
    [
        [pallet()],
        [pallet(), pallet(weight=6500), pallet(scale=10)],
        [pallet(), pallet(scale=10), pallet(weight=6500)],
        [pallet(scale=0.01), pallet()],
        [pallet(scale=0.01, weight=1e-5)],
        [pallet(), pallet(weight=0.0065)],
        [pallet(weight=weight) for weight in np.linspace(0.0541, 0.0539, 20)],
        [pallet(weight=weight) for weight in np.linspace(432.1, 431.9, 20)],
    ],
)
def test_a_batch_warns_as_layouts_do(layouts, kind, tmp_path, caplog):
    named = [layout.renamed(f"PAL-{k}") for k, layout in enumerate(layouts)]
    write_layouts(tmp_path / "file", named, kind)
    assert plain_batch(tmp_path / "file", {}) is not None
    read_batch(tmp_path / "file")
    found = list(caplog.messages)
    caplog.clear()
    read_layouts(tmp_path / "file")
    assert found == caplog.messages
    assert len(found) == (len(layouts) > 1 or layouts[0].pallet.width < 10)


@pytest.fixture
def grams(tmp_path):
    file = tmp_path / "grams.csv"
    file.write_text("\n".join([HEADER, *ROWS]))
    return file


@pytest.mark.parametrize(
    "words", [["check", "-m", "fbs"], ["score", "-m", "fbs"], ["view", "-m", "fbs"]]
)
def test_check_score_and_view_warn_once(
    grams, words, capsys, tmp_path, monkeypatch, in_this_process
):
    monkeypatch.chdir(tmp_path)
    main([words[0], str(grams), *words[1:]])
    told = capsys.readouterr().err
    assert told.count("did you mean --units mm and --weight g?") == 1
    assert "grams.csv" in told
    main([words[0], str(grams), *words[1:], "--units", "mm", "--weight", "g"])
    assert "did you mean" not in capsys.readouterr().err


@pytest.mark.parametrize(
    "name",
    [
        "Rotation",
        "Drehung",
        "item_orientation",
        "ROT",
        "isTurned",
        "flipped",
        "upside_down",
        "theta",
    ],
)
@pytest.mark.parametrize("read", [pick_layouts, read_batch])
def test_an_ignored_column_that_turns_boxes_is_named_with_its_file(name, read, tmp_path, caplog):
    file = tmp_path / "turned.csv"
    file.write_text(f"{HEADER},{name}\nA,120,180,80,0,0,0,0,40,30,30,6.5,90\n")
    (layout,) = read(file, dialect=Dialect(other_columns="ignore"))
    assert layout.name == "A"
    assert [r.levelno for r in caplog.records] == [logging.WARNING]
    assert f"{file}: the CSV column {name!r} is left out" in caplog.text


@pytest.mark.parametrize("cell", ["", "0", "0.0", "no", "False", "nein"])
@pytest.mark.parametrize("read", [pick_layouts, read_batch])
def test_a_column_that_turns_no_box_is_not_named(cell, read, tmp_path, caplog):
    file = tmp_path / "unturned.csv"
    file.write_text(f"{HEADER},Rotation\nA,120,180,80,0,0,0,0,40,30,30,6.5,{cell}\n")
    read(file, dialect=Dialect(other_columns="ignore"))
    assert caplog.messages == []


@pytest.mark.parametrize(
    "name",
    ["colour", "rotterdam_stop", "return", "rectangle", "protocol", "produktrotation"],
)
def test_another_ignored_column_is_not(name, tmp_path, caplog):
    file = tmp_path / "other.csv"
    file.write_text(f"{HEADER},{name}\nA,120,180,80,0,0,0,0,40,30,30,6.5,90\n")
    pick_layouts(file, dialect=Dialect(other_columns="ignore"))
    assert caplog.messages == []
