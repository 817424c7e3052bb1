"""Item lists of real size: containers of published instances, pallets of a retailer's products."""

from __future__ import annotations

import csv
import hashlib
import io
import math
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from steadyload.errors import UserError
from steadyload.layouts.files.limits import MAX_FILE_BYTES
from steadyload.layouts.files.record import shown
from steadyload.layouts.packers.packed import ItemList, ItemType, Sides
from steadyload.reading import content_of

CONTAINER: Sides = (280, 233, 220)
"""Inner length, width and height of a 10-foot container [cm]."""

WHOLE_CONTAINER: Sides = (587, 233, 220)
"""Likewise of a 20-foot container, which the published instances are for."""

EURO_PALLET = (120, 80)
"""Length and width of the deck of a Euro pallet [cm]."""

DENSITIES = (100.0, 500.0)
"""Densities [kg/m3] between which that of an item type without a weight is drawn."""

_CONTAINER_FILE = re.compile(r"(.+)\.txt_(0|[1-9][0-9]{0,5})_items\.csv", re.ASCII)
_COLUMNS = ("X", "Y", "Z", "COPIES")
_WHOLE = re.compile(r"[0-9]{1,6}", re.ASCII)
_NUMBER = re.compile(r"[0-9]{1,6}(\.[0-9]{1,6})?", re.ASCII)
_PRODUCTS = re.compile(r"#products\s+([0-9]{1,6})\s*", re.ASCII)
_LEAST_OF_PRODUCT = 7
"""Columns of a product up to its weight."""

_DRAWS = 10_000
"""Draws of product types before a list is given up."""


class ItemListError(UserError):
    """A folder of instances that cannot be read: says file, line, and what is allowed."""


@dataclass(frozen=True, slots=True)
class PalletRule:
    """Rule by which lists for Euro pallets are drawn.

    Args:
        load_heights: heights of the bin [cm], one of which is drawn.
        fewest_types, most_types: product types of a list.
        fill: volume of the boxes as a multiple of the bin's.
        fewest_boxes, most_boxes: boxes of a list; others are drawn again.
    """

    load_heights: tuple[int, ...] = (100, 130, 160, 190)
    fewest_types: int = 4
    most_types: int = 12
    fill: float = 1.1
    fewest_boxes: int = 35
    most_boxes: int = 75


PALLET_RULE = PalletRule()


@dataclass(frozen=True, slots=True)
class Product:
    """A product: sides in mm, weight in kg."""

    sides: Sides
    weight: float


def container_lists(
    folder: Path, count: int, seed: int, *, skip: int = 0, whole: bool = False
) -> list[ItemList]:
    """Lists of instances for containers, of half the length or whole.

    The bin is :data:`CONTAINER`, and each type has half of its copies, rounded up, unless the
    containers are whole. The density of a type is drawn log-uniformly from :data:`DENSITIES`; the
    draw depends on the seed and the name of the list alone. Weights are whole grams.

    Args:
        folder: holds ``NAME.txt_NUMBER_items.csv`` of PackingSolver, lengths in cm: first those of
            the lowest number of every name are taken, then those of the next.
        count: how many lists, 0 or more.
        seed: root of the draws, 0 or more.
        skip: lists in this order that are left out first, 0 or more.
        whole: the bin is :data:`WHOLE_CONTAINER`, and each type has all of its copies.

    Raises:
        ItemListError: the folder or a file cannot be read, or there are too few.
    """
    found = container_files(folder)
    if len(found) < skip + count:
        raise ItemListError(
            f"{folder}: holds {len(found)} files NAME.txt_NUMBER_items.csv; "
            f"allowed: {skip + count} or more"
        )
    taken = islice(found.items(), skip, skip + count)
    return [_container_list(path, name, seed, whole=whole) for name, path in taken]


def container_files(folder: Path) -> dict[str, Path]:
    """Files of :func:`container_lists` by the name of their list, in the order in which it takes
    them.

    Raises:
        ItemListError: it is no folder.
    """
    named = [(path, _CONTAINER_FILE.fullmatch(path.name)) for path in _files(folder)]
    found = sorted((int(name[2]), name[1], path) for path, name in named if name)
    return {f"{name}-{number}": path for number, name, path in found}


def _container_list(path: Path, name: str, seed: int, *, whole: bool) -> ItemList:
    random = np.random.default_rng([seed, int(hashlib.sha256(name.encode()).hexdigest()[:16], 16)])
    low, high = map(math.log, DENSITIES)
    types = []
    for sides, copies in read_items(path):
        kilograms = math.exp(random.uniform(low, high)) * math.prod(sides) * 1e-6
        kept = copies if whole else (copies + 1) // 2
        types.append(ItemType(sides, kept, round(kilograms, 3)))
    return ItemList(name, WHOLE_CONTAINER if whole else CONTAINER, tuple(types))


def read_items(path: Path) -> list[tuple[Sides, int]]:
    """Sides and copies of the item types of a file ``*_items.csv`` of PackingSolver.

    Raises:
        ItemListError: it cannot be read: says at which line.
    """
    reader = csv.DictReader(io.StringIO(_text(path), newline=""), strict=True)
    found = []
    try:
        missing = [name for name in _COLUMNS if name not in (reader.fieldnames or ())]
        if missing:
            raise ItemListError(
                f"{path}: line 1 has no column {missing[0]}; allowed: {', '.join(_COLUMNS)}, ..."
            )
        for row in reader:
            x, y, z, copies = (
                _whole(row[name], f"{path}: line {reader.line_num} has {name}") for name in _COLUMNS
            )
            found.append(((x, y, z), copies))
    except csv.Error as error:
        raise ItemListError(f"{path}: line {reader.reader.line_num} is not CSV ({error})") from None
    if not found:
        raise ItemListError(f"{path}: holds no item types; allowed: one or more")
    return found


def pallet_lists(
    folder: Path,
    count: int,
    seed: int,
    rule: PalletRule = PALLET_RULE,
    *,
    apart_from: Collection[str] = (),
) -> list[ItemList]:
    """Lists of products for Euro pallets.

    For each a load height is drawn, then an instance, some of its product types, and a share of the
    volume for each of these, until the number of boxes is allowed. Types of equal size and weight
    count once; sides are rounded to millimetres.

    Args:
        folder: holds files ``*.csv`` of Alonso et al. (2019); those with too few types that fit the
            pallet are left out.
        count: how many lists, 0 or more; list k depends on the seed, k, the rule, the files and
            ``apart_from`` alone.
        seed: root of the draws, 0 or more.
        rule: how lists are drawn.
        apart_from: names of instances that lists share no product with.

    Raises:
        ItemListError: the folder or a file cannot be read, or no list is allowed.
    """
    products = {path.stem: read_products(path) for path in product_files(folder)}
    known = {each for name, own in products.items() if name in apart_from for each in own}
    instances = {k: _fitting(own, rule) for k, own in products.items() if known.isdisjoint(own)}
    usable = {k: types for k, types in instances.items() if len(types) >= rule.fewest_types}
    if count and not usable:
        raise ItemListError(
            f"{folder}: holds no instance of {rule.fewest_types} or more products that fit a Euro "
            "pallet; allowed: one or more files *.csv with so many"
        )
    return [_pallet_list(usable, folder, k, seed, rule) for k in range(count)]


def product_files(folder: Path) -> list[Path]:
    """Files of :func:`pallet_lists`.

    Raises:
        ItemListError: it is no folder.
    """
    return [path for path in _files(folder) if path.suffix == ".csv"]


def _fitting(products: Sequence[Product], rule: PalletRule) -> list[Product]:
    """Different products that fit a pallet of the least load height in some way."""
    length, width = (10 * side for side in EURO_PALLET)
    bin_ = sorted((length, width, 10 * min(rule.load_heights)))
    kinds = dict.fromkeys(products)
    return [
        each for each in kinds if all(a <= b for a, b in zip(sorted(each.sides), bin_, strict=True))
    ]


def _pallet_list(
    instances: dict[str, list[Product]], folder: Path, number: int, seed: int, rule: PalletRule
) -> ItemList:
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))
    height = int(random.choice(rule.load_heights))
    length, width = (10 * side for side in EURO_PALLET)
    volume = rule.fill * length * width * 10 * height
    names = list(instances)
    for _ in range(_DRAWS):
        name = names[int(random.integers(len(names)))]
        kinds = instances[name]
        most = min(rule.most_types, len(kinds))
        drawn = random.permutation(len(kinds))[: int(random.integers(rule.fewest_types, most + 1))]
        shares = random.dirichlet(np.ones(len(drawn)))
        types = tuple(
            ItemType(kinds[k].sides, _copies(kinds[k], share * volume), kinds[k].weight)
            for k, share in zip(drawn.tolist(), shares.tolist(), strict=True)
        )
        bin_ = length, width, 10 * height
        found = ItemList(f"{name}-{height}-{number}", bin_, types, "mm", origin=name)
        if rule.fewest_boxes <= found.count <= rule.most_boxes:
            return found
    raise ItemListError(
        f"{folder}: {_DRAWS:,} draws gave no list of {rule.fewest_boxes} to {rule.most_boxes} "
        f"boxes for a load of {height} cm; allowed: products of a size to give some"
    )


def _copies(product: Product, volume: float) -> int:
    return max(1, round(volume / math.prod(product.sides)))


def read_products(path: Path) -> list[Product]:
    """The products of an instance of Alonso et al. (2019).

    Raises:
        ItemListError: it cannot be read: says at which line.
    """
    lines = _text(path).splitlines()
    head = _PRODUCTS.fullmatch(lines[0]) if lines else None
    if head is None:
        told = shown(lines[0]) if lines else "empty"
        raise ItemListError(f"{path}: line 1 is {told}; allowed: #products NUMBER")
    count = int(head[1])
    if len(lines) <= count:
        raise ItemListError(
            f"{path}: ends at line {len(lines)}; allowed: {count} products, as line 1 says"
        )
    found = []
    for number, line in enumerate(lines[1 : count + 1], start=2):
        cells = line.split()
        if len(cells) < _LEAST_OF_PRODUCT:
            raise ItemListError(
                f"{path}: line {number} has {len(cells)} columns; "
                f"allowed: {_LEAST_OF_PRODUCT} or more"
            )
        where = f"{path}: line {number} has"
        x, y, z = (round(_positive(cells[k], f"{where} {n}", least=1.0))
                   for k, n in ((3, "width"), (4, "length"), (5, "height")))  # fmt: skip
        found.append(Product((x, y, z), _positive(cells[6], f"{where} weight", least=0.001)))
    return found


def _files(folder: Path) -> Iterator[Path]:
    if not folder.is_dir():
        raise ItemListError(f"{folder}: is no folder; allowed: one that holds instances")
    yield from sorted(path for path in folder.iterdir() if path.is_file())


def _text(path: Path) -> str:
    try:
        return content_of(path, MAX_FILE_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ItemListError(f"{path}: is no text in UTF-8") from None


def _whole(cell: str | None, what: str) -> int:
    if cell is None or not _WHOLE.fullmatch(cell) or int(cell) < 1:
        raise ItemListError(f"{what} {shown(cell)}; allowed: a whole number, 1 to 999999")
    return int(cell)


def _positive(cell: str, what: str, *, least: float) -> float:
    value = float(cell) if _NUMBER.fullmatch(cell) else 0.0
    if value < least:
        raise ItemListError(f"{what} {shown(cell)}; allowed: a number, {least:g} or more")
    return value
