"""Compilation by numba, kept on disk and made anew whenever any file of this package changes."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import njit

# Numba's own cache looks at the file that a function stands in, not at those of the functions that
# it calls. The digest, as part of the name, makes a change anywhere a change everywhere.
_SOURCES = hashlib.sha256(
    b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py")))
).hexdigest()[:12]


_STALE = Path(__file__).parent / "__pycache__"
with contextlib.suppress(OSError):
    for _file in _STALE.glob("*.nb[ci]"):
        if _SOURCES not in _file.name:
            _file.unlink(missing_ok=True)


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function when it is first called, or load what was compiled before."""
    function.__qualname__ += f"_{_SOURCES}"
    how = {"error_model": "numpy", "fastmath": {"contract"}}
    try:
        return njit(cache=True, **how)(function)
    except RuntimeError:  # nowhere to keep it: neither beside the sources nor in a home folder
        return njit(**how)(function)
