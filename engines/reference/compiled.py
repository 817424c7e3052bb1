"""Compilation by numba, kept on disk and made anew whenever any file of this package changes."""

from __future__ import annotations

import contextlib
import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from steadyload.engines.reference import compilation

PART = compilation.Part(
    "the reference simulator", 70, "steadyload.engines.reference.warming:warm_up"
)

_SOURCES = hashlib.sha256(
    b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py")))
).hexdigest()[:12]


_STALE = Path(__file__).parent / "__pycache__"
with contextlib.suppress(OSError):
    for _file in _STALE.glob("*.nb[ci]"):
        if _SOURCES not in _file.name:
            _file.unlink(missing_ok=True)


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """See :func:`steadyload.engines.reference.compilation.compile_kept`."""
    return compilation.compile_kept(function, _SOURCES, PART)
