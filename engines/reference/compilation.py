"""Compilation by numba, kept on disk."""

from __future__ import annotations

import importlib
import logging
import uuid
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

# Without it functions stay those of Python; the registry of engines says that it is missing.
try:
    from numba import config, njit
except ModuleNotFoundError:
    njit = None

_LOG = logging.getLogger(__name__)
"""Tells that something is compiled, at level INFO: commands print it, see
:func:`steadyload.cli.terminal.say_warnings`; workers and users of the library do not."""


@dataclass(eq=False)
class Part:
    """The compiled functions of a package.

    Attributes:
        title: for sentences.
        seconds: time that compiling all of them takes, about; a method may need a few of them.
        warming: "module:function" that calls them with the types that judging calls them with.
        compiled: number of functions that this process found no compiled code of, callees too.
        folder: where compiled code is kept; None where it cannot be kept.
    """

    title: str
    seconds: int
    warming: str
    compiled: int = field(default=0, init=False)
    folder: Path | None = field(default=None, init=False)

    def warm_up(self) -> None:
        """Compile what is not compiled yet, and load all of it."""
        module, _, name = self.warming.partition(":")
        getattr(importlib.import_module(module), name)()

    def notice(self, kept: Any) -> None:
        """Count and tell what numba compiles because a function's cache has no code for it."""
        cache, load = kept._cache, kept._cache.load_overload

        def loaded(signature: Any, context: Any) -> Any:
            found = load(signature, context)
            if found is None:
                self._tell(once=cache.cache_path is not None)
            return found

        cache.load_overload = loaded
        if cache.cache_path is not None:
            self.folder = Path(cache.cache_path)

    def _tell(self, once: bool) -> None:
        self.compiled += 1
        if self.compiled == 1:
            again = "once" if once else "anew in every process: there is no folder to keep it in"
            _LOG.info("compiling %s (up to about %d s, %s)", self.title, self.seconds, again)


def compile_kept(function: Callable[..., Any], digest: str, part: Part) -> Callable[..., Any]:
    """Compile a function when it is first called, or load the compiled code.

    Compiled code holds no lock of the interpreter, so that threads run it at once. Sums and
    products are rounded one by one, as the source has them: where a compiler may round them
    together, numbers depend on the processor and on the order in which functions were compiled.

    Args:
        function: to be compiled.
        digest: of all files that it depends on, this one too. Numba's own cache looks at the file
            that a function stands in, not at those of the functions that it calls; as part of the
            name, the digest makes a change anywhere a change everywhere.
        part: to which the function belongs.
    """
    if njit is None or config.DISABLE_JIT:  # Numba's own switch, for debuggers.
        return function
    function.__qualname__ += f"_{digest}"
    how = {"error_model": "numpy", "nogil": True}
    try:
        kept = njit(cache=True, **how)(function)
    except RuntimeError:  # nowhere to keep it: neither beside the sources nor in a home folder
        kept = njit(**how)(function)
        part.notice(kept)
        return kept
    part.notice(kept)
    # Numba numbers the files of a function's signatures by the index that it reads. Processes that
    # compile at once overwrite each other's index, so that a number may be taken twice, and one
    # signature is then loaded with the code of another: every file has a number of its own.
    files = kept._cache._cache_file
    pattern = files._data_name_pattern
    files._data_name = lambda _: pattern.format(number=uuid.uuid4().int)
    return kept
