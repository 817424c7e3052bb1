"""Compilation by numba for this package, kept on disk until a file of it changes."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from steadyload import compilation
from steadyload.core import constants

PART = compilation.Part("the kernels", 75, "steadyload.statics.kernels.warming:warm_up")

_SOURCES = hashlib.sha256(
    b"".join(path.read_bytes() for path in sorted(Path(__file__).parent.glob("*.py")))
    + b"".join(Path(str(of.__file__)).read_bytes() for of in (compilation, constants))
).hexdigest()[:12]


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """See :func:`steadyload.compilation.compile_kept`."""
    return compilation.compile_kept(function, _SOURCES, PART)
