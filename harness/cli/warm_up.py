"""``steadyload warm-up``: compile before the first simulation what it would wait for."""

from __future__ import annotations

import importlib
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

from steadyload.cli.terminal import print_table, say, study_progress

if TYPE_CHECKING:
    from steadyload.engines.reference.compilation import Part

PART = "steadyload.engines.reference.compiled:PART"
"""Import path of what numba compiles."""


@dataclass(frozen=True)
class WarmUp:
    """Compilation of the reference simulator; what is compiled already is loaded."""

    def run(self) -> int:
        """Compile, then print how long that took; 1 if compiled code cannot be kept."""
        from steadyload.engines.registry import EngineNotInstalledError, world_class

        try:
            world_class("reference")
        except EngineNotInstalledError as error:
            print(f"nothing is compiled: {error}")
            return 0
        from numba import config

        module, _, name = PART.partition(":")
        part: Part = getattr(importlib.import_module(module), name)
        with study_progress() as show:
            show(f"loading or compiling {part.title} (about {part.seconds} s if compiled)")
            start = time.perf_counter()
            part.warm_up()
            seconds = f"{time.perf_counter() - start:.1f}"
        state = "compiled" if part.compiled else "ready"
        if config.DISABLE_JIT:
            state = "not compiled"
        row = (part.title, state, seconds, str(part.folder or "nowhere"))
        print_table(("part", "state", "s", "kept in"), [row])
        if part.folder is None:
            say(
                "steadyload: what is kept nowhere is compiled in every process; set "
                "NUMBA_CACHE_DIR to a folder that can be written, and unset NUMBA_DISABLE_JIT"
            )
            return 1
        return 0
