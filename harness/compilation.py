"""Compilation by numba, kept on disk: one way for all packages that have compiled functions."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from typing import Any

from numba import config, njit


def compile_kept(
    function: Callable[..., Any], digest: str, *, contract: bool = True
) -> Callable[..., Any]:
    """Compile a function when it is first called, or load the compiled code.

    Compiled code holds no lock of the interpreter, so that threads run it at once.

    Args:
        function: to be compiled.
        digest: of all files that it depends on, this one too. Numba's own cache looks at the file
            that a function stands in, not at those of the functions that it calls; as part of the
            name, the digest makes a change anywhere a change everywhere.
        contract: a product and a sum may be rounded once, together, where the processor can.
    """
    if config.DISABLE_JIT:  # Numba's own switch, for debuggers.
        return function
    function.__qualname__ += f"_{digest}"
    how = {"error_model": "numpy", "fastmath": {"contract"} if contract else False, "nogil": True}
    try:
        kept = njit(cache=True, **how)(function)
    except RuntimeError:  # nowhere to keep it: neither beside the sources nor in a home folder
        return njit(**how)(function)
    # Numba numbers the files of a function's signatures by the index that it reads. Processes that
    # compile at once overwrite each other's index, so that a number may be taken twice, and one
    # signature is then loaded with the code of another: every file has a number of its own.
    files = kept._cache._cache_file
    pattern = files._data_name_pattern
    files._data_name = lambda _: pattern.format(number=uuid.uuid4().int)
    return kept
