"""Plain steadyload JSON as a batch: blocks of layouts become arrays, and no item an object.

A block is parsed by orjson. Only what is read here exactly as
:mod:`steadyload.layouts.readers` reads it is read here. Where a file may be wrong, or has what is
rare, there is no batch: that reader then says what is wrong.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import chain
from operator import itemgetter
from typing import Any

import numpy as np
import orjson

from steadyload.layouts.files.limits import (
    MAX_ITEMS,
    MAX_LAYOUTS,
    MAX_STREAM_BYTES,
    MAX_TEXT_LENGTH,
    MAX_VALUE_LENGTH,
)
from steadyload.layouts.files.record import DECK_KEYS, to_pallet
from steadyload.layouts.model.batch import LayoutBatch, checked_batch
from steadyload.layouts.model.batch_checks import Pallets
from steadyload.layouts.model.layout import FloatArray, LayoutError, Pallet
from steadyload.layouts.readers import NATIVE_FORMAT, NATIVE_VERSION

_SPACE = rb"[ \t\n\r]*"
_HEAD = re.compile(
    _SPACE.join(
        [
            rb"(?:\xef\xbb\xbf)?", rb"\{", rb'"format"', rb":", rb'"%b"' % NATIVE_FORMAT.encode(),
            rb",", rb'"version"', rb":", rb"%d" % NATIVE_VERSION, rb",", rb'"layouts"', rb":",
            rb"\[",
        ]
    )
)  # fmt: skip
"""What stands before the layouts of a file, as it is written here."""

_NEXT = re.compile(_SPACE.join([rb"", rb",", rb"\{", rb'"[^"\\]*"']))
"""What stands between two layouts, and the first key of the latter."""

_CLOSING = b"]} \t\n\r"

_PALLET_KEYS = {"width", "height", "depth", *DECK_KEYS}
_ITEM_KEYS = {"sequence", "position", "size", "weight"}
_OPTIONAL_KEYS = ({"mass_offset"}, {"id"}, {"name"}, {"mass_offset", "id"}, {"mass_offset", "name"})


class _NotPlainError(ValueError):
    """A text that the other reader has to look at."""


def batch_of_json(chunks: Iterable[bytes], deck: dict[str, Any]) -> LayoutBatch | None:
    """The batch of a file of steadyload JSON; None where the other reader has to look at it.

    Args:
        chunks: the bytes of the file, in turn. Not more of them are held than a layout may have.
        deck: what is stated of all pallets beside their sizes, as fields of a pallet.
    """
    read = _Layouts(deck)
    try:
        for block in _blocks(iter(chunks)):
            read.add(block)
        return read.batch()
    except (LayoutError, ValueError, LookupError, TypeError, OverflowError):
        return None


def _blocks(chunks: Iterator[bytes]) -> Iterator[bytes]:
    """Texts of some layouts with commas between them, which together are those of a file.

    A text ends where one layout ends and another begins if these look as the first two do. That it
    does has to be seen by parsing it: what is JSON between brackets has no part of a layout.

    Raises:
        _NotPlainError: the file is none of layouts alone, or layouts are not found in it.
    """
    text = next(chunks, b"")
    head = _HEAD.match(text)
    if head is None:
        raise _NotPlainError
    held, size, between, wanted = text[head.end() :], len(text), b"", 0
    for chunk in chunks:
        held += chunk
        size += len(chunk)
        if size > MAX_STREAM_BYTES or len(held) > MAX_VALUE_LENGTH:
            raise _NotPlainError
        if len(held) < wanted:
            continue
        between = between or _between(held)
        end = held.rfind(between) if between else -1
        if end < 0:
            wanted = 2 * len(held)  # so that all looks at a layout cost twice the last one
        else:
            comma = held.index(b",", end)
            yield held[:comma]
            held, wanted = held[comma + 1 :], 0
    for mark in (b"}", b"]"):
        held = held.rstrip(b" \t\n\r")
        if not held.endswith(mark):
            raise _NotPlainError
        held = held[:-1]
    yield held


def _between(text: bytes) -> bytes:
    """The text from the last value of the first layout to the first key of the second.

    Empty where there are no two layouts.
    """
    # As Latin-1, a text has a character a byte, and the same structure.
    start = len(text) - len(text.lstrip(b" \t\n\r"))
    try:
        end = _DECODER.raw_decode(text.decode("latin-1"), start)[1]
    except (ValueError, RecursionError):
        return b""
    after = _NEXT.match(text, end)
    first = text[:end]
    return first[len(first.rstrip(_CLOSING)) :] + after[0] if after else b""


_DECODER = json.JSONDecoder()


class _Layouts:
    """Layouts of the blocks of a file.

    Args:
        deck: see :func:`batch_of_json`.
    """

    def __init__(self, deck: dict[str, Any]) -> None:
        self._deck = deck
        self._names: list[str] = []
        self._ids: list[str] = []
        self._counts: list[int] = []
        self._kinds: dict[bytes, int] = {}
        self._pallets: list[Pallet] = []
        self._which: list[int] = []
        self._arrays: dict[str, list[FloatArray]] = {
            "lower": [], "sizes": [], "weights": [], "mass_offsets": []
        }  # fmt: skip

    def add(self, block: bytes) -> None:
        """Take over the layouts of a block.

        Raises:
            _NotPlainError: the block may not be plain, or one of them not valid; likewise
                ValueError, LookupError, TypeError, OverflowError and LayoutError.
        """
        layouts = _all_of(dict, orjson.loads(b"[%b]" % block))
        names, pallets, lists = (_values(layouts, key) for key in ("name", "pallet", "items"))
        counts = list(map(len, _all_of(list, lists)))
        items = _all_of(dict, list(chain.from_iterable(lists)))
        keys = items[0].keys()
        if keys - _ITEM_KEYS and keys - _ITEM_KEYS not in _OPTIONAL_KEYS:
            raise _NotPlainError
        label = "id" if "id" in keys else "name"
        ids = _values(items, label) if label in keys else [""] * len(items)
        stated = 3 * len(layouts) + sum(map(len, pallets)) + len(keys) * len(items)
        _refuse_other_keys(block, stated, [*names, *ids])
        self._count(names, counts)
        self._names += _texts(names)
        self._which += map(self._kind, pallets)
        made = {
            "lower": _vectors(_values(items, "position")),
            "sizes": _vectors(_values(items, "size")),
            "weights": _numbers(_values(items, "weight")),
            "mass_offsets": _vectors(_values(items, "mass_offset"))
            if "mass_offset" in keys
            else np.zeros((len(items), 3)),
        }
        order = _order(_all_of(int, _values(items, "sequence")), counts)
        for key, array in made.items():
            self._arrays[key].append(array if order is None else array[order])
        texts = _texts(ids)
        self._ids += texts if order is None else map(texts.__getitem__, order)

    def _count(self, names: Sequence[Any], counts: list[int]) -> None:
        if len(self._names) + len(names) > MAX_LAYOUTS or max(counts) > MAX_ITEMS:
            raise _NotPlainError
        self._counts += counts

    def _kind(self, pallet: Any) -> int:
        """The number of a pallet among the different ones."""
        text = orjson.dumps(pallet)
        if text not in self._kinds:
            if type(pallet) is not dict or pallet.keys() - _PALLET_KEYS:
                raise _NotPlainError
            self._kinds[text] = len(self._pallets)
            self._pallets.append(to_pallet(pallet, **self._deck))
        return self._kinds[text]

    def batch(self) -> LayoutBatch:
        """All of them.

        Raises:
            _NotPlainError: two have the same name.
            LayoutError: one is not valid.
        """
        if len({*self._names}) < len(self._names):
            raise _NotPlainError
        arrays: dict[str, Any] = {key: np.concatenate(parts) for key, parts in self._arrays.items()}
        return checked_batch(
            np.cumsum([0, *self._counts], dtype=np.int64),
            **arrays,
            pallets=Pallets(tuple(self._pallets), np.array(self._which, dtype=np.int64)),
            names=tuple(self._names),
            ids=tuple(self._ids) if any(self._ids) else (),
        )


def _refuse_other_keys(block: bytes, keys: int, texts: list[Any]) -> None:
    """Raise _NotPlainError where a block has keys beside those that are known, or one twice.

    Args:
        block: some layouts. Each colon in it follows a key or is one of a text.
        keys: number of the known keys of all objects.
        texts: all texts that are no keys.
    """
    # An escape may state a colon that does not stand in the block.
    if b"\\u003" in block or block.count(b":") != keys + "".join(texts).count(":"):
        raise _NotPlainError


def _values(objects: Iterable[Mapping[str, Any]], key: str) -> list[Any]:
    return list(map(itemgetter(key), objects))


def _all_of(kind: type, values: list[Any]) -> list[Any]:
    """The same values, of which there are some and each is of this type and no other."""
    if {*map(type, values)} != {kind}:
        raise _NotPlainError
    return values


def _texts(values: list[Any]) -> list[str]:
    """The same texts, of which none is too long."""
    if max(map(len, _all_of(str, values))) > MAX_TEXT_LENGTH:
        raise _NotPlainError
    return values


def _vectors(values: list[Any]) -> FloatArray:
    """Lists of three numbers each, shape (N, 3)."""
    if {*map(len, _all_of(list, values))} != {3}:
        raise _NotPlainError
    return _numbers(list(chain.from_iterable(values))).reshape(-1, 3)


def _numbers(values: list[Any]) -> FloatArray:
    """Numbers, none of which is True or False."""
    if {*map(type, values)} - {float, int}:
        raise _NotPlainError
    return np.array(values, dtype=float)


def _order(sequence: list[int], counts: list[int]) -> list[int] | None:
    """Places of items in the order of loading; None where they stand in it.

    Args:
        sequence: numbers of all items, layout by layout.
        counts: how many items a layout has.
    """
    loaded = list(chain.from_iterable(map(range, counts)))
    if sequence == loaded:
        return None
    layouts = chain.from_iterable([k] * count for k, count in enumerate(counts))
    keys = list(zip(layouts, sequence, strict=True))
    order = sorted(range(len(keys)), key=keys.__getitem__)
    if [sequence[k] for k in order] != loaded:
        raise _NotPlainError
    return order
