"""The set of real size: item lists, plans of real packers, pallets, and its folder."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import steadyload as sl
from steadyload.atomic import write_atomically
from steadyload.cli import main
from steadyload.labelling.building.item_lists import (
    CONTAINER,
    ItemListError,
    PalletRule,
    container_files,
    container_lists,
    pallet_lists,
    product_files,
    read_items,
    read_products,
)
from steadyload.labelling.building.real import (
    PALLET_SOFTWARE,
    RealInputs,
    RealOptions,
    build_real,
    real_manifest,
)
from steadyload.labelling.building.splits import splits_of_manifest
from steadyload.labelling.labelling import build_real_set, extend_real_set
from steadyload.layouts.benchmark import tables
from steadyload.layouts.benchmark.tables import CASES, BenchmarkError, read_tables, write_tables
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.floor import FloorKind
from steadyload.layouts.packers.packed import PACKERS
from steadyload.layouts.sizes import MOST_SMALL

ITEMS = "ID,X,Y,Z,ROTATION_XYZ,COPIES\n0,110,100,90,1,5\n1,120,80,100,1,4\n"
PRODUCTS = """#products 4
1 0 52 400.00 600.00 500.00 24.5 1 1 1 1 0 0 1
2 1 78 400.00 600.00 500.00 24.5 1 1 1 1 0 0 2
3 2 78 300.40 700.00 400.00 12 1 1 1 1 0 0 3
4 0 26 1300.00 900.00 1250.00 99 1 1 1 1 0 0 4
#layers 1
1 997.00 1270.00 171.40 120.30 0 26 8
"""
RULE = PalletRule(
    load_heights=(100, 130), fewest_types=2, most_types=12, fewest_boxes=4, most_boxes=20
)
OPTIONS = RealOptions(
    containers=2, pallets=2, fewest_items=2, most_items=9, most_in_all_scenarios=4, rule=RULE
)


def pallet(name, count, *, at=0.0, height=10.0):
    boxes = tuple(
        sl.Item(k, position=(at, height * k, 0.0), size=(30.0, height, 40.0), weight=1.0 + k)
        for k in range(count)
    )
    return sl.Layout(name, sl.Pallet(80.0, 200.0, 120.0), boxes)


def written_inputs(tmp_path):
    containers, products = tmp_path / "containers", tmp_path / "products"
    containers.mkdir()
    products.mkdir()
    for name in ("B.txt_1", "A.txt_10", "A.txt_2"):
        (containers / f"{name}_items.csv").write_text(ITEMS)
        (containers / f"{name}_bins.csv").write_text("ID,X,Y,Z\n0,587,233,220\n")
    (products / "inst1.csv").write_text(PRODUCTS)
    (products / "readme.txt").write_text("no instance")
    pallets = [pallet("7.order-0", 3), pallet("7.order-1", 5, at=-2.0), pallet("8.order-0", 1)]
    pallets += [pallet("8.order-1", 3), pallet("8.order-2", 10)]
    write_layouts(tmp_path / "pallets.json", pallets, Format.NATIVE)
    return RealInputs(containers, products, tmp_path / "pallets.json")


@pytest.fixture
def inputs(tmp_path):
    return written_inputs(tmp_path)


@pytest.fixture(scope="module")
def packers():
    for package in ("packingsolver3d", "packvium", "py3dbp"):
        pytest.importorskip(package)


@pytest.fixture(scope="module")
def built(packers, tmp_path_factory):
    """A set, its inputs, what its making returned, and the progress it told."""
    folder, seen = tmp_path_factory.mktemp("real"), []
    inputs = written_inputs(folder)
    count = build_real_set(OPTIONS, inputs, folder / "set", lambda *done: seen.append(done))
    return SimpleNamespace(folder=folder / "set", inputs=inputs, count=count, seen=seen)


# --- item lists -----------------------------------------------------------------------------------


def test_containers_take_the_lowest_numbers_first_and_half_of_the_copies(inputs):
    assert list(container_files(inputs.containers)) == ["B-1", "A-2", "A-10"]
    lists = container_lists(inputs.containers, 2, 3)
    assert [each.name for each in lists] == ["B-1", "A-2"]
    assert [each.name for each in container_lists(inputs.containers, 3, 3)][2:] == ["A-10"]
    assert [each.name for each in container_lists(inputs.containers, 1, 3, skip=2)] == ["A-10"]
    for each in lists:
        assert (each.bin, each.units) == (CONTAINER, "cm")
        assert [(t.sides, t.copies) for t in each.types] == [
            ((110, 100, 90), 3),
            ((120, 80, 100), 2),
        ]
        for kind in each.types:
            density = kind.weight / math.prod(kind.sides) * 1e6
            assert 100.0 <= density <= 500.0
            assert kind.weight == round(kind.weight, 3)


def test_densities_depend_on_the_seed_and_the_name_of_the_list_alone(inputs):
    (first, second) = container_lists(inputs.containers, 2, 3)
    assert first.types != second.types
    (inputs.containers / "B.txt_1_items.csv").unlink()
    assert container_lists(inputs.containers, 1, 3) == [second]
    assert container_lists(inputs.containers, 1, 4) != [second]


def test_densities_are_log_uniform(inputs):
    path = inputs.containers / "B.txt_1_items.csv"
    path.write_text("X,Y,Z,COPIES\n" + "100,100,100,1\n" * 4000)
    (only,) = container_lists(inputs.containers, 1, 0)
    shares = np.log([kind.weight / 100.0 for kind in only.types]) / math.log(5.0)
    assert np.quantile(shares, [0.25, 0.5, 0.75]) == pytest.approx([0.25, 0.5, 0.75], abs=0.03)


def test_pallets_draw_products_that_fit_and_as_many_boxes_as_are_allowed(inputs):
    lists = pallet_lists(inputs.products, 20, 5, RULE)
    assert lists[:3] == pallet_lists(inputs.products, 3, 5, RULE)
    assert {each.bin for each in lists} == {(1200, 800, 1000), (1200, 800, 1300)}
    for number, each in enumerate(lists):
        assert each.name == f"inst1-{each.bin[2] // 10}-{number}"
        assert each.units == "mm"
        assert 4 <= each.count <= 20
        # Equal products count once, and one is too large.
        kinds = {(400, 600, 500): 24.5, (300, 700, 400): 12.0}
        assert {kind.sides: kind.weight for kind in each.types} == kinds
        filled = sum(kind.copies * math.prod(kind.sides) for kind in each.types)
        assert filled / math.prod(each.bin) == pytest.approx(1.1, abs=0.15)


DAMAGED_ITEMS = [
    ("X,Y,Z\n1,2,3\n", "line 1 has no column COPIES; allowed: X, Y, Z, COPIES, ..."),
    ("X,Y,Z,COPIES\n1,2,3,4\n1,2.5,3,4\n", "line 3 has Y '2.5'; allowed: a whole number, 1 to"),
    ("X,Y,Z,COPIES\n1,2,3\n", "line 2 has COPIES missing; allowed: a whole number, 1 to 999999"),
    ("X,Y,Z,COPIES\n1,2,3,0\n", "line 2 has COPIES '0'; allowed: a whole number, 1 to 999999"),
    ('X,Y,Z,COPIES\n1,"2"3,3,4\n', "line 2 is not CSV"),
    ("X,Y,Z,COPIES\n", "holds no item types; allowed: one or more"),
    ("", "line 1 has no column X"),
]  # fmt: skip


DAMAGED_PRODUCTS = [
    ("", "line 1 is empty; allowed: #products NUMBER"),
    ("#layers 4\n", "line 1 is '#layers 4'; allowed: #products NUMBER"),
    ("#products 2\n1 0 5 10 10 10 1\n", "ends at line 2; allowed: 2 products, as line 1 says"),
    ("#products 1\n1 0 5 10 10 10\n", "line 2 has 6 columns; allowed: 7 or more"),
    ("#products 1\n1 0 5 10 0 10 1\n", "line 2 has length '0'; allowed: a number, 1 or more"),
    ("#products 1\n1 0 5 10 9 10 x\n", "line 2 has weight 'x'; allowed: a number, 0.001 or more"),
]


@pytest.mark.parametrize(
    ("read", "text", "message"),
    [
        *((read_items, *damaged) for damaged in DAMAGED_ITEMS),
        *((read_products, *damaged) for damaged in DAMAGED_PRODUCTS),
    ],
)
def test_damaged_lists_are_refused_with_file_and_line(read, text, message, tmp_path):
    path = tmp_path / "A_1_items.csv"
    path.write_text(text)
    with pytest.raises(ItemListError) as error:
        read(path)
    said = str(error.value).removeprefix(f"{path}: ")
    assert said == message if read is read_products else said.startswith(message)


def test_folders_that_do_not_do_are_refused(inputs, tmp_path):
    missing = tmp_path / "missing"
    for ask in (container_lists, pallet_lists):
        with pytest.raises(ItemListError, match="missing: is no folder; allowed: one that holds"):
            ask(missing, 1, 0)
    with pytest.raises(
        ItemListError, match=r"holds 3 files NAME.txt_NUMBER_items.csv; allowed: 4 or"
    ):
        container_lists(inputs.containers, 4, 0)
    with pytest.raises(ItemListError, match=r"no instance of 4 or more products that fit a Euro"):
        pallet_lists(inputs.products, 1, 0)
    few = PalletRule(fewest_types=2, fewest_boxes=1, most_boxes=2)
    with pytest.raises(
        ItemListError, match=r"10,000 draws gave no list of 1 to 2 boxes for a load"
    ):
        pallet_lists(inputs.products, 1, 0, few)
    (product_files(inputs.products)[0]).write_bytes(b"\xff\xfe\xff")
    with pytest.raises(ItemListError, match=r"inst1.csv: is no text in UTF-8"):
        pallet_lists(inputs.products, 1, 0, RULE)


# --- layouts --------------------------------------------------------------------------------------


def test_a_set_holds_pallets_and_one_plan_a_list_and_packer(built):
    assert built.seen == [(1, 4), (2, 4), (3, 4), (4, 4)]
    found = sl.load_benchmark(built.folder)
    assert len(found.cases) == built.count
    assert set(found.cases["status"]) == {"unlabelled"}
    assert set(found.layouts["item_class"]) == {0}
    layouts = found.layouts[found.layouts["weights"].map(len).between(2, 9)]
    assert len(layouts) == len(found.layouts)
    # Pallets of 1 and 10 boxes are left out, and one geometry is there twice.
    pallets = layouts[[s[0] == PALLET_SOFTWARE for s in layouts["sources"]]]
    assert pallets["instance"].to_dict() == {"7.order-0": "7", "7.order-1": "7"}
    plans = layouts.drop(index=pallets.index)
    for name, row in plans.iterrows():
        items, packer, number = name.split(" ")
        assert row["instance"] == (items if items[0] == "B" else items.split("-")[0])
        assert row["sources"][0] == packer
        assert int(number) >= 1
    sources = [(name.split(" ")[0], s) for name, row in plans.iterrows() for s in row["sources"]]
    assert len(sources) == len(set(sources))
    assert {packer for _, packer in sources} == set(PACKERS)
    geometries = {found.layout(name, "S1").geometry_hash() for name in layouts.index}
    assert len(geometries) == len(layouts)


def test_large_layouts_are_cases_in_one_scenario(built):
    found = sl.load_benchmark(built.folder)
    scenarios = {name: [] for name in found.layouts.index}
    for name, scenario in zip(found.cases["layout"], found.cases["scenario"], strict=True):
        scenarios[name].append(scenario)
        assert found.layout(name, scenario).mass_offsets.any() == (scenario != "S1")
    for name, weights in found.layouts["weights"].items():
        assert scenarios[name] == (["S1", "S2a", "S2b"] if len(weights) <= 4 else ["S1"])


def test_pallets_keep_their_order_their_weights_and_their_floor(built):
    found = sl.load_benchmark(built.folder)
    for layout in sl.read(built.inputs.pallets):
        if layout.name.startswith("7"):
            stored = found.layout(layout.name, "S1")
            assert stored.content_hash() == layout.content_hash()
            assert stored.floor == layout.floor
    # One overhangs its deck.
    kinds = [found.layout(f"7.order-{k}", "S1").floor.kind for k in (0, 1)]
    assert kinds == [FloorKind.INFINITE, FloorKind.DECK]


def test_the_manifest_says_what_the_set_is_made_from(built):
    manifest = json.loads((built.folder / "manifest.json").read_text())
    assert (manifest["origin"], manifest["seed"]) == ("real", OPTIONS.seed)
    assert list(manifest["packers"]["names"]) == list(PACKERS)
    assert set(manifest["packers"]["versions"]) == {"packingsolver3d", "packvium", "py3dbp"}
    assert "log-uniform by item type, 100 to 500 kg/m3" in manifest["densities"]
    assert manifest["loading_order"].startswith("pallets: that of the file; plans: height")
    assert (manifest["test"], manifest["validation"]) == (OPTIONS.test, OPTIONS.validation)
    assert manifest["built_with"]["versions"]["python"]
    # A licence is stated of the known files alone.
    assert {source["title"] for source in manifest["sources"].values()} == {"other files"}


def test_a_checksum_of_the_sources_changes_with_their_files(inputs, packers):
    before = real_manifest(OPTIONS, inputs)["sources"]
    (inputs.products / "inst1.csv").write_text(PRODUCTS + "\n")
    (inputs.products / "readme.txt").write_text("is not read")
    after = real_manifest(OPTIONS, inputs)["sources"]
    assert [name for name in before if before[name] != after[name]] == ["products"]


def test_what_no_set_can_hold_is_refused(inputs, packers, tmp_path):
    none = RealOptions(containers=0, pallets=0, fewest_items=11)
    with pytest.raises(BenchmarkError, match="nothing has 11 to 150 items; allowed: pallets or"):
        build_real(none, inputs)
    few = RealOptions(containers=1, pallets=0, fewest_items=2)
    write_layouts(inputs.pallets, [pallet("B-1 py3dbp 1", 2)], Format.NATIVE)
    with pytest.raises(BenchmarkError, match="layout 'B-1 py3dbp 1' is there twice; allowed: once"):
        build_real(few, inputs)
    low = sl.Pallet(80.0, 200.0, 120.0, deck_height=10.0)
    boxes = pallet("a", 3).items
    write_layouts(inputs.pallets, [sl.Layout("a", low, boxes)], Format.NATIVE)
    with pytest.raises(BenchmarkError, match="layout 'a' states more than its pallet's sides"):
        build_real(few, inputs)


# --- further draws --------------------------------------------------------------------------------


def list_inputs(tmp_path):
    """Files of a set, of which the first draw takes the first list for containers."""
    inputs = written_inputs(tmp_path)
    (inputs.containers / "A.txt_2_items.csv").write_text(ITEMS.replace(",5\n", ",16\n"))
    other = PRODUCTS.replace("400.00", "390.00").replace("300.40", "310").replace("1300", "1290")
    (inputs.products / "inst2.csv").write_text(other)
    # Shares a product with the first, so nothing of it is in the further draw.
    (inputs.products / "inst3.csv").write_text(PRODUCTS.replace("300.40 ", "320 "))
    return inputs


FIRST = RealOptions(
    seed=1, containers=1, pallets=0, fewest_items=2, most_items=9, most_in_all_scenarios=4
)
MORE = RealOptions(
    seed=2, containers=1, pallets=2, fewest_items=2, most_items=30, most_in_all_scenarios=0,
    rule=RULE, test=0.5, validation=0.5,
)  # fmt: skip


@pytest.fixture
def extended(packers, tmp_path):
    """A set as it was, its folder after a further draw, and its inputs."""
    inputs = list_inputs(tmp_path)
    build_real_set(FIRST, inputs, tmp_path / "set")
    layouts, cases, opinions, manifest = read_tables(tmp_path / "set")
    # One instance of Alonso et al. is in the set, and everything is labelled.
    layouts.loc[layouts["instance"] == "7", "instance"] = "inst1"
    cases["status"], cases.loc[::2, "failing_step"] = "done", 1
    instance = cases["layout"].map(layouts.set_index("layout")["instance"])
    cases = splits_of_manifest(cases.assign(instance=instance), manifest)[CASES.names]
    write_tables(tmp_path / "set", layouts, cases, opinions, manifest)
    before = sl.load_benchmark(tmp_path / "set")
    count = extend_real_set(MORE, inputs, tmp_path / "set")
    return SimpleNamespace(before=before, folder=tmp_path / "set", inputs=inputs, count=count)


def test_a_further_draw_follows_the_first_and_leaves_it_as_it_is(extended):
    before, found = extended.before, sl.load_benchmark(extended.folder)
    assert found.layouts.head(len(before.layouts)).equals(before.layouts)
    assert found.cases.head(len(before.cases)).equals(before.cases)
    new, cases = found.layouts.iloc[len(before.layouts) :], found.cases.iloc[len(before.cases) :]
    assert len(cases) == extended.count == len(new)
    assert set(cases["status"]) == {"unlabelled"}
    assert set(cases["scenario"]) == {"S1"}
    # A-2 follows B-1; inst1 is there already, and inst3 shares a product with it.
    assert set(new["instance"]) == {"A-2", "inst2"}
    assert {*new["instance"]}.isdisjoint(before.layouts["instance"])
    geometries = {found.layout(n, "S1").geometry_hash() for n in found.layouts.index}
    assert len(geometries) == len(found.layouts)
    # Whole containers and all copies.
    (container, *_) = new[new["instance"] == "A-2"].index
    assert found.layout(container, "S1").pallet.size == (233.0, 220.0, 587.0)
    assert len(found.layout(container, "S1")) == 20
    assert (cases.groupby("instance")["split"].nunique() == 1).all()
    assert set(cases["split"]) == {"test", "validation"}


def test_the_manifest_states_a_further_draw_beside_the_first(extended):
    before, manifest = extended.before.manifest, sl.load_benchmark(extended.folder).manifest
    (draw,) = manifest.pop("further_draws")
    counts = {"layouts", "cases", "checksum"}
    assert {k: v for k, v in manifest.items() if k not in counts} == {
        k: v for k, v in before.items() if k not in counts
    }
    assert (draw["seed"], draw["instances"]) == (2, ["A-2", "inst2"])
    assert draw["layouts"] == manifest["layouts"] - before["layouts"]
    assert draw["container"] == [587, 233, 220]
    assert draw["sources"] == {k: before["sources"][k] for k in ("containers", "products")}


def test_a_set_is_extended_once_and_from_the_files_that_it_was_made_from(extended, tmp_path):
    with pytest.raises(BenchmarkError, match="has a further draw already; allowed: a set without"):
        extend_real_set(MORE, extended.inputs, extended.folder)
    build_real_set(FIRST, extended.inputs, tmp_path / "other")
    (extended.inputs.containers / "C.txt_1_items.csv").write_text(ITEMS)
    with pytest.raises(BenchmarkError, match=r"containers: are other files than those"):
        extend_real_set(MORE, extended.inputs, tmp_path / "other")
    layouts, cases, opinions, manifest = read_tables(tmp_path / "other")
    write_tables(tmp_path / "other", layouts, cases, opinions, manifest | {"origin": "generated"})
    with pytest.raises(BenchmarkError, match="was not made by `benchmark build-real`; allowed"):
        extend_real_set(MORE, extended.inputs, tmp_path / "other")


def test_an_extension_that_was_interrupted_while_writing_can_be_repeated(extended, monkeypatch):
    whole = read_tables(extended.folder)
    layouts, cases, opinions, manifest = whole
    first = {k: v for k, v in manifest.items() if k != "further_draws"}
    count = len(extended.before.layouts)
    left = layouts.head(count), cases.head(len(extended.before.cases)), opinions, first
    write_tables(extended.folder, *left)
    written = []

    def interrupted(path, content):
        if path.name == "cases.parquet":
            raise KeyboardInterrupt
        written.append(path.name)
        write_atomically(path, content)

    with monkeypatch.context() as patched:
        patched.setattr(tables, "write_atomically", interrupted)
        with pytest.raises(KeyboardInterrupt):
            extend_real_set(MORE, extended.inputs, extended.folder)
    assert written == ["manifest.json", "layouts.parquet"]
    assert len(read_tables(extended.folder)[0]) == len(layouts)
    extend_real_set(MORE, extended.inputs, extended.folder)
    for found, expected in zip(read_tables(extended.folder)[:3], whole[:3], strict=True):
        pd.testing.assert_frame_equal(found, expected)


@pytest.mark.parametrize("share", [0.0, 0.1, 1.0])
def test_labels_of_large_cases_of_the_package_move_no_other_case(share):
    """These labels are made up: a share of them fails."""
    benchmark = sl.load_benchmark("real")
    cases = benchmark.cases
    large = cases["item_count"] > MOST_SMALL
    labelled = cases.assign(status="done")
    fails = large & (np.random.default_rng(7).random(len(cases)) < share)
    labelled["failing_step"] = labelled["failing_step"].mask(large).mask(fails, 3)
    found = splits_of_manifest(labelled, benchmark.manifest)
    others = ~large | (cases["split"] == "train")
    for name in ("split", "rank"):
        before, after = (table.loc[others, name].tolist() for table in (cases, found))
        assert after == before, name


# --- the command ----------------------------------------------------------------------------------


def test_the_command_builds_the_set_and_refuses_to_replace_it(inputs, packers, tmp_path, capsys):
    command = [
        "benchmark", "build-real", "--pallets", str(inputs.pallets),
        "--containers", str(inputs.containers), "--products", str(inputs.products),
        "-o", str(tmp_path / "set"), "--container-lists", "0", "--pallet-lists", "0",
    ]  # fmt: skip
    write_layouts(inputs.pallets, [pallet("9.order-0", 18)], Format.NATIVE)
    assert main(command) == 2
    assert "nothing has 25 to 150 items" in capsys.readouterr().err
    write_layouts(inputs.pallets, [pallet("9.order-0", 30, height=5.0)], Format.NATIVE)
    assert main(command) == 0
    assert "3 cases" in capsys.readouterr().out
    assert list(sl.load_benchmark(tmp_path / "set").layouts.index) == ["9.order-0"]
    assert main(command) == 2
    assert "already holds something" in capsys.readouterr().err
    command[5] = str(tmp_path / "nowhere")
    command[9] = str(tmp_path / "other")
    assert main(command) == 2
    assert "nowhere: is no folder; allowed: one that holds instances" in capsys.readouterr().err


def test_the_command_extends_a_set_by_large_layouts_alone(inputs, packers, tmp_path, capsys):
    files = ["--containers", str(inputs.containers), "--products", str(inputs.products)]
    lists = ["--container-lists", "1", "--pallet-lists", "0"]
    write_layouts(inputs.pallets, [pallet("9.order-0", 30, height=5.0)], Format.NATIVE)
    build_real_set(RealOptions(containers=0, pallets=0), inputs, tmp_path / "set")
    command = ["benchmark", "extend-real", str(tmp_path / "set"), *files, *lists]
    assert main(command) == 2
    assert "nothing has 62 to 150 items" in capsys.readouterr().err
    (inputs.containers / "B.txt_1_items.csv").write_text(ITEMS.replace("100,90,1,5", "50,60,1,90"))
    assert main(command) == 2
    assert "containers: are other files" in capsys.readouterr().err
    build_real_set(RealOptions(containers=0, pallets=0), inputs, tmp_path / "new")
    command[2] = str(tmp_path / "new")
    assert main(command) == 0
    count = int(capsys.readouterr().out.split()[0])
    found = sl.load_benchmark(tmp_path / "new")
    assert found.cases["item_count"].iloc[-count:].between(62, 150).all()
    assert set(found.cases["scenario"].iloc[-count:]) == {"S1"}
