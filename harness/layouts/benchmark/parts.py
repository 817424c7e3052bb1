"""Names of the labelled sets that come with the package, and of their parts."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path

from steadyload.reading import own_file

_PACKAGE = own_file("steadyload.layouts.benchmark")

SHIPPED = _PACKAGE / "data"
"""The folder of the set that comes with the package."""

PLANAR = "planar"
"""Name of the small set of planar layouts that comes with the package, too."""

REAL = "real"
"""Name of the set of layouts of real size, 25 to 150 boxes."""

LISTS = "lists"
"""Name of the set that is a test alone: few layouts of each of many item lists."""

CHOOSING = "choosing"
"""Name of the set of further item lists, half of them for searches of parameters, half for fitting
cascades, so that neither sees what stopped the training of a learned method."""

SETS: Mapping[str, Path] = {
    PLANAR: _PACKAGE / "data_planar",
    REAL: _PACKAGE / "data_real",
    LISTS: _PACKAGE / "data_lists",
    CHOOSING: _PACKAGE / "data_choosing",
}
"""Names of further sets of the package, and their folders."""

LABELLED_ITEM_COUNTS: Mapping[int, int] = {3: 32}
"""Items of an instance in labelled sets, where they are not the class's own. Splits and intervals
are by item list, and fewer items a list give more of them."""

NO_CLASS = 0
"""Item class of layouts that are of none of the paper's."""

PALLET_SOFTWARE = "palletising software"
"""Source of the customers' pallets in the set of layouts of real size."""


def set_named(directory: str | None, beside: Path = Path()) -> str | Path | None:
    """A labelled set as a study names it: a word of :data:`SETS`, or a folder.

    Args:
        directory: the word or the folder; empty or None for the large set of the package.
        beside: what the folder is relative to.
    """
    if not directory:
        return None
    return directory if directory in SETS else (beside / directory).resolve()


class Part(StrEnum):
    """A part of the labelled set.

    ``train``: everything of the training instances. ``validation``, ``search``, ``fitting`` and
    ``test``: half stable, half unstable by scenario. ``test-300``: 300 cases a scenario of
    ``test``, the paper's size. ``all``: every labelled case, also those in no split.
    """

    TRAIN = "train"
    VALIDATION = "validation"
    SEARCH = "search"
    FITTING = "fitting"
    TEST = "test"
    TEST_300 = "test-300"
    ALL = "all"


HELD_OUT = (Part.VALIDATION, Part.SEARCH, Part.FITTING, Part.TEST)
"""Splits that nothing is trained on."""

SPLITS = (Part.TRAIN, *HELD_OUT)
"""Splits that a case may be in; every other part is made of one or of all of these."""

UNLEARNT = (*HELD_OUT, Part.TEST_300)
"""Held-out parts: nothing is trained on their item lists."""
