"""Plans of packers, made by the packers themselves, as layouts."""

import json

import pytest

import steadyload as sl
from steadyload.layouts import LayoutError
from steadyload.layouts.files.record import FormatError
from steadyload.layouts.packers.plan import Bin, Placed, Plan, PlanError, plan

SIDES = {"flat": (60, 40, 10), "tall": (20, 20, 50), "long": (80, 15, 15), "big": (300, 10, 10)}
"""Boxes as length, width and height, for a bin of 100 x 80 x 60."""
WEIGHTS = {"flat": 12.0, "tall": 5.0, "long": 4.0, "big": 1.0}


def same(one, two):
    """Whether layouts are equal by value."""
    stated = [[(each.name, each.pallet, each.items) for each in layouts] for layouts in (one, two)]
    return stated[0] == stated[1]


# --- what holds of every plan ---------------------------------------------------------------------


def placed(*corners, size=(10.0, 10.0, 10.0)):
    return [Placed(str(k), corner, size, 1.0) for k, corner in enumerate(corners)]


def test_boxes_are_loaded_by_height_then_from_the_back_then_from_the_left():
    boxes = placed((10, 0, 0), (0, 0, 10), (0, 10, 0), (10, 10, 0), (0, 0, 0))
    (layout,) = plan([Bin("a", (50, 50, 50), boxes)], (), "height").layouts
    # x, the length, is our depth; y, the width, our x; z, the height, our y.
    assert [item.name for item in layout.items] == ["4", "2", "0", "3", "1"]
    assert layout.items[-1].position == (0.0, 10.0, 0.0)
    (given,) = plan([Bin("a", (50, 50, 50), boxes)], (), "given").layouts
    assert [item.name for item in given.items] == ["0", "1", "2", "3", "4"]
    with pytest.raises(PlanError, match="order is 'random'; allowed: 'height', 'given'"):
        plan([], (), "random")


def test_axes_are_turned_and_not_mirrored():
    box = Placed("box", (1.0, 2.0, 3.0), (10.0, 20.0, 30.0), 1.0)
    (along,) = plan([Bin("a", (100.0, 80.0, 60.0), [box])], (), "height").layouts
    assert (along.pallet.width, along.pallet.height, along.pallet.depth) == (80.0, 60.0, 100.0)
    assert along.items[0].position == (2.0, 3.0, 1.0)
    assert along.items[0].size == (20.0, 30.0, 10.0)
    (upright,) = plan([Bin("a", (100.0, 80.0, 60.0), [box], "y")], (), "height").layouts
    assert upright.items[0].position == (1.0, 2.0, 3.0)


def test_equal_bins_get_numbers_and_empty_ones_are_left_out():
    bins = [Bin("a", (50, 50, 50), placed((0, 0, 0))), Bin("b", (50, 50, 50), [])]
    found = plan([*bins, bins[0]], ["left"], "height")
    assert [layout.name for layout in found.layouts] == ["a", "a (2)"]
    assert found.unplaced == ("left",)


def test_a_box_without_a_weight_weighs_200_kg_a_cubic_metre():
    box = Placed("box", (0.0, 0.0, 0.0), (100.0, 50.0, 20.0))
    (layout,) = plan([Bin("a", (100, 100, 100), [box])], (), "height").layouts
    assert layout.items[0].weight == pytest.approx(20.0)


def test_a_plan_that_is_no_layout_names_bin_and_item():
    boxes = placed((0, 0, 0), (5, 0, 0))
    with pytest.raises(LayoutError, match=r'layout "a": box 1 \(2nd\): overlaps box 0 \(1st\)'):
        plan([Bin("a", (50, 50, 50), boxes)], (), "height")


# --- py3dbp ---------------------------------------------------------------------------------------


@pytest.fixture
def py3dbp_packer():
    py3dbp = pytest.importorskip("py3dbp")
    packer = py3dbp.Packer()
    packer.add_bin(py3dbp.Bin("pallet", 100, 60, 80, 1000))
    for name, (length, width, height) in SIDES.items():
        packer.add_item(py3dbp.Item(name, length, height, width, WEIGHTS[name]))
    packer.pack(bigger_first=True)
    return packer


def test_a_plan_of_py3dbp_is_judged(py3dbp_packer):
    found = sl.from_py3dbp(py3dbp_packer)
    (layout,) = found.layouts
    assert found.unplaced == ("big",)
    assert (layout.name, layout.pallet.size) == ("pallet", (100.0, 60.0, 80.0))
    assert {item.name: item.weight for item in layout.items} == {
        name: weight for name, weight in WEIGHTS.items() if name != "big"
    }
    for item, packed in (
        (item, packed)
        for item in layout.items
        for packed in py3dbp_packer.bins[0].items
        if packed.name == item.name
    ):
        assert item.position == tuple(map(float, packed.position))
        assert item.size == tuple(map(float, packed.get_dimension()))
    assert sl.make_method("equilibrium").judge(layout).status == "done"
    assert same(sl.from_py3dbp(py3dbp_packer.bins[0]).layouts, found.layouts)


def test_units_and_axes_of_py3dbp_are_told(py3dbp_packer):
    (layout,) = sl.from_py3dbp(py3dbp_packer, units="in", weights="lb", up="z").layouts
    assert layout.pallet.size == pytest.approx((152.4, 203.2, 254.0))
    assert layout.items[0].weight in [w * 0.45359237 for w in WEIGHTS.values()]
    for wrong in ({"units": "ft"}, {"weights": "t"}, {"up": "x"}):
        with pytest.raises(PlanError, match="allowed: "):
            sl.from_py3dbp(py3dbp_packer, **wrong)


def test_what_py3dbp_has_not_packed_yet_is_unplaced():
    py3dbp = pytest.importorskip("py3dbp")
    packer = py3dbp.Packer()
    packer.add_bin(py3dbp.Bin("pallet", 100, 60, 80, 1000))
    packer.add_item(py3dbp.Item("late", 10, 10, 10, 1))
    assert sl.from_py3dbp(packer) == Plan((), ("late",))
    packer.pack()
    packer.add_item(py3dbp.Item("later", 10, 10, 10, 1))
    found = sl.from_py3dbp(packer)
    assert [item.name for item in found.layouts[0].items] == ["late"]
    assert found.unplaced == ("later",)


def test_boxes_that_py3dbp_has_turned_keep_their_volume():
    py3dbp = pytest.importorskip("py3dbp")
    packer = py3dbp.Packer()
    packer.add_bin(py3dbp.Bin("narrow", 15, 90, 20, 100))
    packer.add_item(py3dbp.Item("long", 80, 15, 15, 0))
    packer.pack()
    (layout,) = sl.from_py3dbp(packer).layouts
    assert layout.items[0].size == (15.0, 80.0, 15.0)
    assert layout.items[0].weight == pytest.approx(2e-4 * 80 * 15 * 15)


def test_an_item_that_py3dbp_has_put_into_two_bins_is_refused():
    py3dbp = pytest.importorskip("py3dbp")

    def packed(**how):
        packer = py3dbp.Packer()
        for name in ("a", "b"):
            packer.add_bin(py3dbp.Bin(name, 10, 10, 10, 100))
        for name in ("one", "two"):
            packer.add_item(py3dbp.Item(name, 10, 10, 10, 1))
        packer.pack(**how)
        return packer

    with pytest.raises(PlanError, match='item "one" is in bin "a" and in bin "b"; allowed: each'):
        sl.from_py3dbp(packed())
    found = sl.from_py3dbp(packed(distribute_items=True))
    assert [layout.name for layout in found.layouts] == ["a", "b"]
    assert found.unplaced == ()


# --- PackingSolver --------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def solved():
    """A result of packingsolver3d and its instance: boxes in millimetres, weights in grams."""
    packer = pytest.importorskip("packingsolver3d")
    items = [
        packer.ItemType(
            *(10 * side for side in SIDES[name]), weight=1000 * WEIGHTS[name], copies=3,
            rotations=packer.ALL_ROTATIONS,
        )
        for name in ("flat", "tall", "long")
    ]  # fmt: skip
    instance = packer.Instance(
        bin_types=[packer.BinType(1000, 800, 250, copies=9)],
        item_types=items,
        objective=packer.Objective.BIN_PACKING,
    )
    return packer.box.solve(instance, time_limit=1.0), instance


def certificate(result):
    """As PackingSolver writes it; see its ``Solution::write``."""
    lines = ["TYPE,ID,COPIES,BIN,X,Y,Z,LX,LY,LZ,ROTATION"]
    for each in result.bins:
        number = f"{each.copies},{each.bin_id}"
        lines.append(f"BIN,{each.bin_type_id},{number},0,0,0,{each.x},{each.y},{each.z},")
        lines += [
            f"ITEM,{p.item_type_id},1,{p.bin_id},{p.x},{p.y},{p.z},{p.lx},{p.ly},{p.lz},"
            f"{p.rotation.value}"
            for p in each.placements
        ]
    return "\n".join(lines) + "\n"


def test_a_plan_of_packingsolver_is_judged(solved):
    result, instance = solved
    found = sl.from_packingsolver(result, instance=instance, units="mm", weights="g")
    assert len(found.layouts) == result.number_of_bins > 1
    assert sum(map(len, found.layouts)) == 9
    assert found.unplaced == ()
    assert all(layout.pallet.size == (80.0, 25.0, 100.0) for layout in found.layouts)
    weights = sorted(item.weight for layout in found.layouts for item in layout.items)
    assert weights == pytest.approx([4.0] * 3 + [5.0] * 3 + [12.0] * 3)
    assert all(sl.make_method("fbs").judge(layout).status == "done" for layout in found.layouts)


def test_a_certificate_is_the_result_it_was_written_of(solved, tmp_path):
    result, instance = solved
    path = tmp_path / "solution.csv"
    path.write_text(certificate(result))
    told = {"instance": instance, "units": "mm", "weights": "g"}
    found = sl.from_packingsolver(result, **told)
    assert same(sl.from_packingsolver(path, **told).layouts, found.layouts)
    read = sl.read(path)
    assert [len(layout) for layout in read] == [
        len(layout) for layout in sl.from_packingsolver(path).layouts
    ]
    kilograms = sl.from_packingsolver(path, units="mm", weights={0: 12.0, 1: 5.0, 2: 4.0})
    assert same(kilograms.layouts, found.layouts)


STACKS = """TYPE,ID,COPIES,BIN,STACK,X,Y,Z,LX,LY,LZ,GROUP_ID,ROTATION
BIN,0,2,0,-1,0,0,0,100,100,100,,
STACK,0,1,0,0,0,0,0,20,30,80,,
ITEM,1,1,0,0,0,0,40,20,30,40,0,XYZ
ITEM,0,1,0,0,0,0,0,20,30,40,0,XYZ
"""


def test_a_certificate_of_stacks_is_read_and_copies_of_a_bin_are_layouts(tmp_path):
    path = tmp_path / "stacks.csv"
    path.write_text(STACKS)
    first, second = sl.read(path)
    assert (first.name, second.name) == ("bin 0", "bin 0 copy 1")
    assert first.items == second.items
    assert [(item.name, item.position[1]) for item in first.items] == [
        ("type 0", 0.0), ("type 1", 40.0)
    ]  # fmt: skip


def test_a_box_out_of_its_bin_is_refused_and_other_bins_are_read(tmp_path):
    """A bin has no deck that a box may overhang."""
    path = tmp_path / "out.csv"
    path.write_text(STACKS + "BIN,0,1,1,-1,0,0,0,100,100,100,,\nITEM,0,1,1,0,95,0,0,20,30,40,0,\n")
    with pytest.raises(LayoutError, match=r"bin 1.*type 0.*spans z = 95 to 115 cm.*0 to 100 cm"):
        sl.read(path)
    records = sl.score([path], ["fbs"])
    assert [record["status"] for record in records] == ["done", "done", "refused"]


def test_units_are_told_of_a_certificate_and_nothing_else_of_a_dialect(tmp_path):
    path = tmp_path / "stacks.csv"
    path.write_text(STACKS)
    first, _ = sl.read(path, dialect=sl.Dialect(units="mm"))
    assert [item.size for item in first.items] == [(3.0, 4.0, 2.0)] * 2
    assert sl.from_packingsolver(path, units="mm").layouts[0].items == first.items
    with pytest.raises(FormatError, match=r"units can be stated, and not weight and up"):
        sl.read(path, dialect=sl.Dialect(units="mm", weight="g", up="z"))


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("COPIES,", "", "has the unknown CSV columns 'TYPE', "),
        (",LZ", ",L", "has no column LZ"),
        ("BIN,0,2", "BIN,0,1000000000", "line 2 has COPIES 1000000000; allowed: 1 to 10,000"),
        ("BIN,0,2", "CUT,0,2", "line 2 has TYPE 'CUT'; allowed: BIN, STACK, ITEM"),
        (",80,,\nITEM,1,1,0", ",80,,\nITEM,1,1,7", "line 4 holds 1 of an item in bin 7"),
        ("20,30,40,0,XYZ\nITEM,0", "1e99,30,40,0,XYZ\nITEM,0", "line 4 has LX '1e99'"),
        ("0,XYZ\nITEM,0,1,0,0,0,0,0,20,30,40,0,XYZ", "\nITEM,0,1", "line 5 has 3 values"),
        ("BIN,0,2", "STACK,0,2", "line 4 holds 1 of an item in bin 0"),
        ("0,0,0,20,30,40,0", "0,0,80,20,30,40,0", "spans y = 80 to 120 cm"),
    ],
)
def test_a_certificate_that_is_none_says_where_and_why(tmp_path, before, after, message):
    path = tmp_path / "stacks.csv"
    path.write_text(STACKS.replace(before, after, 1))
    with pytest.raises(LayoutError, match=message) as caught:
        sl.read(path)
    assert str(path) in str(caught.value)


# --- Packvium -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def packvium_result():
    packvium = pytest.importorskip("packvium")
    items = [
        packvium.Item.create(
            name, packvium.Dimensions.mm(*(str(10 * side) for side in SIDES[name])),
            f"{WEIGHTS[name]} kg",
        )
        for name in SIDES
    ]  # fmt: skip
    pallet = packvium.Container.create("pallet", packvium.Dimensions.mm("1000", "800", "600"))
    return packvium.Packer(packvium.PackingConfig.balanced()).pack(items, [pallet])


def test_a_plan_of_packvium_is_judged(packvium_result):
    found = sl.from_packvium(packvium_result)
    (layout,) = found.layouts
    assert found.unplaced == ("big#1",)
    assert (layout.name, layout.pallet.size) == ("pallet#1", (80.0, 60.0, 100.0))
    assert {item.name: item.weight for item in layout.items} == {
        f"{name}#1": weight for name, weight in WEIGHTS.items() if name != "big"
    }
    assert sl.make_method("equilibrium").judge(layout).stable


def test_packviums_json_is_its_result_with_the_payload_shared_by_volume(packvium_result, tmp_path):
    path = tmp_path / "result.json"
    path.write_text(json.dumps(packvium_result.to_dict("in")))
    (shared,) = sl.from_packvium(path).layouts
    assert same(sl.read(path), [shared])
    volumes = {item.name: item.size[0] * item.size[1] * item.size[2] for item in shared.items}
    assert {item.name: item.weight for item in shared.items} == pytest.approx(
        {name: 21.0 * volume / sum(volumes.values()) for name, volume in volumes.items()}
    )
    told = sl.from_packvium(path, weights=WEIGHTS)
    assert same(told.layouts, sl.from_packvium(packvium_result).layouts)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"containers": 7}, "containers is 7; allowed: a list"),
        ({"containers": [7]}, r"containers\[0\] is 7; allowed: an object"),
        ({"containers": [{"id": "a"}]}, 'layout "a": inner_dimensions is missing'),
        ({"position": {"x": {"ticks": 1.5}}}, "position x is .*whole ticks"),
        ({"item_id": 3}, "item_id is 3; allowed: a text"),
    ],
)
def test_a_result_of_packvium_that_is_none_says_where_and_why(
    packvium_result, tmp_path, change, message
):
    content = packvium_result.to_dict()
    inner = content["containers"][0]["placements"][0]
    (content if "containers" in change else inner).update(change)
    path = tmp_path / "result.json"
    path.write_text(json.dumps(content))
    with pytest.raises(FormatError, match=message) as caught:
        sl.read(path)
    assert str(path) in str(caught.value)


def test_what_is_no_plan_is_refused_by_name():
    for function in (sl.from_py3dbp, sl.from_packingsolver, sl.from_packvium):
        with pytest.raises(PlanError, match="a int is no plan; allowed: "):
            function(7)
