"""Compilation by numba for this package, kept on disk until a file of it changes."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import njit

_SOURCES = hashlib.sha256(
    b"".join((Path(__file__).parent / f"{name}.py").read_bytes()
             for name in ("features", "inference", "plane", "ranges", "support"))
).hexdigest()[:12]  # fmt: skip
"""Of the files that hold compiled functions. Numba's own cache looks at the file that a function
stands in, not at those of the functions that it calls."""


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function when it is first called, or load what was compiled before."""
    function.__qualname__ += f"_{_SOURCES}"
    how = {"error_model": "numpy", "fastmath": {"contract"}}
    try:
        return njit(cache=True, **how)(function)
    except RuntimeError:  # nowhere to keep it: neither beside the sources nor in a home folder
        return njit(**how)(function)
