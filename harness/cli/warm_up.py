"""``steadyload warm-up``: compile before the first judgement what it would wait for."""

from __future__ import annotations

import importlib
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from steadyload.cli.terminal import print_table, say, study_progress

if TYPE_CHECKING:
    from steadyload.compilation import Part

PARTS = (
    "steadyload.statics.kernels.compiled:PART",
    "steadyload.engines.reference.compiled:PART",
)
"""Import paths of the compiled parts of packages, the quickest first."""


@dataclass(frozen=True)
class WarmUp:
    """All parts; those that are compiled already are loaded."""

    def run(self) -> int:
        """Compile, then print a table of the parts; 1 if compiled code cannot be kept."""
        from steadyload.engines.registry import EngineNotInstalledError, world_class

        try:
            world_class("reference")
        except EngineNotInstalledError as error:
            print(f"nothing is compiled: {error}")
            return 0
        from numba import config

        rows, kept = [], True
        with study_progress() as show:
            for part in _parts():
                show(f"loading or compiling {part.title} (about {part.seconds} s if compiled)")
                start, before = time.perf_counter(), part.compiled
                part.warm_up()
                state = "compiled" if part.compiled > before else "ready"
                if config.DISABLE_JIT:
                    state = "not compiled"
                seconds = f"{time.perf_counter() - start:.1f}"
                rows.append((part.title, state, seconds, str(part.folder or "nowhere")))
                kept = kept and part.folder is not None
        print_table(("part", "state", "s", "kept in"), rows)
        if not kept:
            say(
                "steadyload: what is kept nowhere is compiled in every process; set "
                "NUMBA_CACHE_DIR to a folder that can be written, and unset NUMBA_DISABLE_JIT"
            )
        return 0 if kept else 1


def _parts() -> Iterator[Part]:
    for path in PARTS:
        module, _, name = path.partition(":")
        yield getattr(importlib.import_module(module), name)
