"""Item lists packed by the packers themselves."""

import math
import sys
from types import SimpleNamespace

import pytest

from steadyload.layouts.packers.packed import (
    PACKERS,
    ItemList,
    ItemType,
    PackerNotInstalledError,
    packer_versions,
    with_packingsolver,
)

PACKAGES = ("packingsolver3d", "packvium", "py3dbp")
LIST = ItemList(
    "small", (100, 80, 60), (ItemType((60, 40, 20), 3, 4.5), ItemType((20, 30, 50), 4, 2.25))
)
"""Seven boxes for one bin, in cm."""


@pytest.fixture(autouse=True)
def packers():
    for package in PACKAGES:
        pytest.importorskip(package)


@pytest.mark.parametrize("packer", PACKERS)
def test_every_packer_packs_all_boxes_in_cm_with_their_weights(packer):
    plan = PACKERS[packer](LIST)
    assert plan.unplaced == ()
    boxes = [item for layout in plan.layouts for item in layout.items]
    assert len(boxes) == LIST.count == 7
    for name, each in (("type 0", LIST.types[0]), ("type 1", LIST.types[1])):
        mine = [item for item in boxes if item.name.startswith(name)]
        assert len(mine) == each.copies
        assert all(sorted(item.size) == pytest.approx(sorted(each.sides)) for item in mine)
        assert all(item.weight == each.weight for item in mine)
    for layout in plan.layouts:
        # The length is our depth.
        assert layout.pallet.size == pytest.approx((80.0, 60.0, 100.0))
        bases = [item.position[1] for item in layout.items]
        assert bases == sorted(bases)


@pytest.mark.parametrize("packer", PACKERS)
@pytest.mark.parametrize(("units", "centimetres"), [("mm", 0.1), ("in", 2.54)])
def test_lengths_are_in_the_unit_of_the_list(packer, units, centimetres):
    (layout,) = PACKERS[packer](ItemList("one", (30, 20, 10), LIST_OF_ONE, units)).layouts
    (item,) = layout.items
    sides = [side * centimetres for side in (3, 4, 5)]
    assert sorted(item.size) == pytest.approx(sides)
    assert layout.pallet.size == pytest.approx([side * centimetres for side in (20, 10, 30)])
    # Without a weight a box weighs 200 kg/m3.
    assert item.weight == pytest.approx(2e-4 * math.prod(sides))


LIST_OF_ONE = (ItemType((3, 4, 5), 1),)


def test_what_fits_no_bin_is_unplaced():
    types = (*LIST.types, ItemType((300, 10, 10), 2))
    for name in ("packvium", "packvium-support-75", "py3dbp"):
        plan = PACKERS[name](ItemList("long", LIST.bin, types))
        assert [each[:6] for each in plan.unplaced] == ["type 2", "type 2"], name


def test_a_further_time_limit_is_used_where_the_first_gave_no_plan(monkeypatch):
    package = pytest.importorskip("packingsolver3d")
    limits, solve = [], package.box.solve

    def solved(instance, *, time_limit, optimization_mode):
        limits.append(time_limit)
        found = solve(instance, time_limit=10.0, optimization_mode=optimization_mode)
        return SimpleNamespace(bins=()) if len(limits) == 1 else found

    monkeypatch.setattr(package.box, "solve", solved)
    plan = with_packingsolver(LIST, time_limits=(1.0, 2.0, 3.0))
    assert limits == [1.0, 2.0]
    assert plan.layouts


@pytest.mark.parametrize("package", PACKAGES)
def test_a_missing_packer_is_named_with_what_installs_it(package, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    first = next(name for name in PACKERS if name.startswith(package))
    for ask in (lambda: PACKERS[first](LIST), packer_versions):
        with pytest.raises(PackerNotInstalledError) as error:
            ask()
        assert str(error.value) == (
            f"packing with {package} needs its package: pip install 'steadyload[packers]'"
        )


def test_versions_are_those_of_the_packages():
    assert set(packer_versions()) == set(PACKAGES)
