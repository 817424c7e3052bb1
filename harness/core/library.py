"""The C library: found and loaded, with the types of its public functions.

All that the headers beside this file declare with ``SL_API`` can be called: on :data:`LIBRARY`,
which lets other threads run, and on :data:`HELD`, which does not. Short calls are on :data:`HELD`.
A state (a session, a loading, the forces of a growing load) is for one thread at a time.
"""

from __future__ import annotations

import ctypes as ct
import re
import threading
import weakref
from collections.abc import Callable, Iterator
from pathlib import Path
from struct import Struct
from typing import Any, NamedTuple, NoReturn

import numpy as np

from steadyload.core import building, constants
from steadyload.core.constants import MEMORY, REFUSED
from steadyload.errors import FailedError, SentenceError

FINDING = np.dtype([("ended", "i4"), ("step", "i4"), ("item", "i4"), ("", "i4"), ("number", "f8")])
"""``sl_finding``."""

_UNPACKED = Struct("iii4xd")

_TYPES = {"int32_t": ct.c_int32, "uint64_t": ct.c_uint64, "double": ct.c_double, "void": None}
_DECLARED = re.compile(r"^SL_API\s+((?:const\s+)?\w+\s*\**)\s*(\w+)\s*\(([^)]*)\)\s*;", re.M)


class NotBuiltError(FailedError):
    """There is no library that was built from these sources."""


class WrongArrayError(SentenceError, ValueError):
    """An array of another shape, type or order in memory than a function takes."""


class RefusedError(SentenceError, ValueError):
    """Numbers that a function has no answer to."""


class Finding(NamedTuple):
    """The first failure of a layout: ``sl_finding`` of steadyload.h.

    Attributes:
        ended: see :data:`steadyload.core.constants.STANDS`.
        step: that fails; the number of boxes where all stand.
        item: the box that fails, -1 for none.
        number: the share of its base that is supported (:data:`.SUPPORTED`), 1 where something is
            below it (:data:`.CARRIED`), or a margin [cm].
    """

    ended: int
    step: int
    item: int
    number: float


def declared(folder: Path = building.HERE) -> Iterator[tuple[str, Any, list[Any]]]:
    """Name, type of the answer and types of the arguments of all public functions."""
    for header in sorted(folder.glob("*.h")):
        text = re.sub(r"/\*.*?\*/", "", header.read_text(encoding="utf-8"), flags=re.S)
        for answer, name, given in _DECLARED.findall(text):
            taken = [] if given.strip() == "void" else [_type(one) for one in given.split(",")]
            yield name, _type(answer), taken


def _type(words: str) -> Any:
    if "*" in words:
        return ct.c_void_p
    return _TYPES[next(word for word in words.split() if word != "const")]


def _loaded() -> tuple[ct.CDLL, ct.PyDLL]:
    path = building.HERE / "lib" / building.name()
    if not path.exists():
        raise NotBuiltError(
            "the C library of this installation is not built from its present sources; "
            "`make build` builds it"
        )
    library, held = ct.CDLL(str(path)), ct.PyDLL(str(path))
    for name, answer, taken in declared():
        for function in (getattr(library, name), getattr(held, name)):
            function.restype, function.argtypes = answer, taken
    for name, stated in vars(constants).items():
        if name.isupper() and ct.c_double.in_dll(library, f"sl_constant_{name}").value != stated:
            raise NotBuiltError(
                f"{name} is {stated} in Python, and another number in the C library"
            )
    return library, held


LIBRARY, HELD = _loaded()


class Kept:
    """Something that C made, and that C frees once no reference to it is left.

    It cannot be copied or pickled: two would free the same memory.

    Args:
        made: its address; None where there was no memory, or where it would be too large.
        free: the function that frees it.
    """

    def __init__(self, made: int | None, free: Callable[[int], None]) -> None:
        if not made:
            raise MemoryError("the C library found no memory, or more than a million boxes")
        self.address = int(made)
        # At the end of the process others may still use it, and all memory goes with that.
        weakref.finalize(self, free, made).atexit = False

    def __reduce__(self) -> NoReturn:
        raise TypeError("what the C library made cannot be copied or pickled")


class _Own(Kept):
    """The memory in which the calls of a thread work, and arrays for what they find.

    Attributes:
        found, found_at: room for a finding, and its address.
        boxes, patches: of contacts, see ``sl_contacts``.
    """

    def __init__(self) -> None:
        super().__init__(HELD.sl_work_new(), HELD.sl_work_free)
        self.found: Any = np.zeros(1, FINDING)
        self.found_at = int(self.found.ctypes.data)
        self.boxes = Scratch((np.bool_, ()), (np.int32, ()), (np.int32, ()))
        self.patches = Scratch((np.int32, ()), (np.float64, (4,)), (np.int32, ()))


_OWNERS = threading.local()


def own() -> _Own:
    """The memory and the arrays of this thread."""
    kept: _Own | None = getattr(_OWNERS, "kept", None)
    if kept is None:
        kept = _OWNERS.kept = _Own()
    return kept


def work() -> int:
    """The memory in which the calls of this thread work."""
    return own().address


class Scratch:
    """Arrays that calls fill, kept with their addresses, for one thread at a time.

    Args:
        kinds: the type of each, and its shape behind the first axis.

    Attributes:
        size: of the first axis, 0 at first.
        arrays: themselves.
        addresses: of these.
    """

    def __init__(self, *kinds: tuple[Any, tuple[int, ...]]) -> None:
        self._kinds = kinds
        self.widen(0)

    def widen(self, size: int) -> None:
        """Make other arrays of another size."""
        self.size = size
        self.arrays = tuple(np.empty((size, *shape), kind) for kind, shape in self._kinds)
        self.addresses = tuple(int(array.ctypes.data) for array in self.arrays)

    def first(self, count: int) -> Iterator[Any]:
        """Copies of the first rows of all arrays."""
        return (array[:count].copy() for array in self.arrays)


def finding(found: Any, place: int = 0) -> Finding:
    """The finding at a place of an array of type :data:`FINDING`."""
    return Finding(*_UNPACKED.unpack_from(found, place * _UNPACKED.size))


def array(name: str, given: Any, *shape: int, kind: Any = np.float64) -> int:
    """The address of an array that has to be as C takes it.

    Args:
        name: for the error.
        given: the array.
        shape: that it must have.
        kind: of its numbers.

    Raises:
        WrongArrayError: it is not such an array.
    """
    if not isinstance(given, np.ndarray) or given.dtype != kind or given.shape != shape:
        found = getattr(given, "shape", type(given).__name__), str(getattr(given, "dtype", ""))
        raise WrongArrayError(f"{name} is {found}; required: {np.dtype(kind)} of shape {shape}")
    if not (given.flags.c_contiguous and given.flags.aligned):
        raise WrongArrayError(f"{name} has to be C-contiguous and aligned")
    return int(given.ctypes.data)


def count_of(name: str, given: Any) -> int:
    """The length of an array.

    Raises:
        WrongArrayError: it is none, or longer than the C library counts.
    """
    if not isinstance(given, np.ndarray) or not given.ndim or len(given) > 2**31 - 1:
        raise WrongArrayError(f"{name} has to be an array of at most {2**31 - 1} rows")
    return len(given)


def ended_well(ended: int, what: str) -> int:
    """How a call ended, unless it ended without an answer.

    Args:
        ended: see :data:`steadyload.core.constants.STANDS`.
        what: it was about, for the error.

    Raises:
        MemoryError: there was no memory.
        RefusedError: the library refuses what it was given.
    """
    if ended == MEMORY:
        raise MemoryError(f"the C library found no memory for {what}")
    if ended == REFUSED:
        raise RefusedError(f"the C library refuses {what}: see its header for what it takes")
    return ended


def counted(found: int, what: str) -> int:
    """How many a call found; below 0, how it ended without an answer: see :func:`ended_well`."""
    if found < 0:
        ended_well(-found, what)
    return found
