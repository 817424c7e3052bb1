"""Compilation by numba for this package, kept on disk until a file of it changes, or a constant."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from steadyload import compilation
from steadyload.core import constants
from steadyload.statics.kernels import convex_hull

_COMPILED = ("features", "inference", "convex_hull", "ranges", "support")
"""The files that hold compiled functions."""

PART = compilation.Part("the learners", 20, "steadyload.learners.warming:warm_up")

_SOURCES = hashlib.sha256(
    b"".join((Path(__file__).parent / f"{name}.py").read_bytes() for name in _COMPILED)
    + b"".join(Path(str(of.__file__)).read_bytes() for of in (constants, convex_hull))
    + Path(compilation.__file__).read_bytes()
).hexdigest()[:12]


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """See :func:`steadyload.compilation.compile_kept`."""
    return compilation.compile_kept(function, _SOURCES, PART)
