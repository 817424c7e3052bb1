"""``steadyload warm-up``: compile before the first simulation what it would wait for."""

from __future__ import annotations

import time
from dataclasses import dataclass

from steadyload.cli.terminal import print_table, say, study_progress


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
        from steadyload.engines.reference import compilation, warming

        compiled = compilation.compiled
        with study_progress() as show:
            show(f"loading or compiling {compiled.title} (about {compiled.seconds} s if compiled)")
            start = time.perf_counter()
            warming.warm_up()
            seconds = f"{time.perf_counter() - start:.1f}"
        state = "not compiled" if compiled.is_off else "compiled" if compiled.count else "ready"
        row = (compiled.title, state, seconds, str(compiled.folder or "nowhere"))
        print_table(("part", "state", "s", "kept in"), [row])
        if compiled.folder is None:
            say(
                "steadyload: what is kept nowhere is compiled in every process; set "
                "NUMBA_CACHE_DIR to a folder that can be written, and unset NUMBA_DISABLE_JIT"
            )
            return 1
        return 0
