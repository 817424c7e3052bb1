"""Compilation by numba, kept on disk and made anew whenever any file of this package changes."""

from __future__ import annotations

import contextlib
import hashlib
import logging
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import Any

# Without it functions stay those of Python; the registry of engines says that it is missing.
try:
    from numba import config, njit
except ModuleNotFoundError:
    njit = None

_LOG = logging.getLogger(__name__)
"""Logs that something is compiled, at level INFO: commands print it, see
:func:`steadyload.cli.terminal.say_warnings`; workers and users of the library do not."""

_HERE = Path(__file__).parent

_SOURCES = hashlib.sha256(
    b"".join(path.read_bytes() for path in sorted(_HERE.glob("*.py")))
).hexdigest()[:12]

with contextlib.suppress(OSError):
    for _file in (_HERE / "__pycache__").glob("*.nb[ci]"):
        if _SOURCES not in _file.name:
            _file.unlink(missing_ok=True)


class Compilation:
    """Functions that are compiled when they are first called, or whose compiled code is loaded.

    Compiled code holds no lock of the interpreter, so that threads run it at once. Sums and
    products are rounded one by one, as the source has them: where a compiler may round them
    together, numbers depend on the processor and on the order in which functions were compiled.

    Args:
        title: of the functions, for sentences.
        seconds: time that compiling all of them takes, about; a method may need a few of them.
        digest: of all files that they depend on. Numba's own cache looks at the file that a
            function stands in, not at those of the functions that it calls; as part of the name,
            the digest makes a change anywhere a change everywhere.

    Attributes:
        count: number of functions that this process found no compiled code of, callees too.
        folder: where compiled code is kept; None where it cannot be kept.
    """

    def __init__(self, title: str, seconds: int, digest: str) -> None:
        self.title, self.seconds, self._digest = title, seconds, digest
        self.count = 0
        self.folder: Path | None = None

    @property
    def is_off(self) -> bool:
        """Whether functions stay those of Python."""
        return njit is None or bool(config.DISABLE_JIT)  # Numba's own switch, for debuggers.

    def __call__(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """The compiled function."""
        if self.is_off:
            return function
        function.__qualname__ += f"_{self._digest}"
        how = {"error_model": "numpy", "nogil": True}
        try:
            kept = njit(cache=True, **how)(function)
        except RuntimeError:  # nowhere to keep it: neither beside the sources nor in a home folder
            kept = njit(**how)(function)
            self._notice(kept)
            return kept
        self._notice(kept)
        # Numba numbers the files of a function's signatures by the index that it reads. Processes
        # that compile at once overwrite each other's index, so that a number may be taken twice,
        # and one signature is then loaded with the code of another: every file has its own number.
        files = kept._cache._cache_file
        pattern = files._data_name_pattern
        files._data_name = lambda _: pattern.format(number=uuid.uuid4().int)
        return kept

    def _notice(self, kept: Any) -> None:
        """Count and log what numba compiles because a function's cache has no code for it."""
        cache, load = kept._cache, kept._cache.load_overload

        def loaded(signature: Any, context: Any) -> Any:
            found = load(signature, context)
            if found is None:
                self._log(once=cache.cache_path is not None)
            return found

        cache.load_overload = loaded
        if cache.cache_path is not None:
            self.folder = Path(cache.cache_path)

    def _log(self, once: bool) -> None:
        self.count += 1
        if self.count == 1:
            again = "once" if once else "anew in every process: there is no folder to keep it in"
            _LOG.info("compiling %s (up to about %d s, %s)", self.title, self.seconds, again)


compiled = Compilation("the reference simulator", 70, _SOURCES)
"""Those of this package: a decorator."""
