"""The labelled set: layouts, labels with their confidence, and splits."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from steadyload.layouts.benchmark.dataset import Benchmark as Benchmark
    from steadyload.layouts.benchmark.dataset import BenchmarkError as BenchmarkError
    from steadyload.layouts.benchmark.dataset import load_benchmark as load_benchmark

__all__ = ["Benchmark", "BenchmarkError", "load_benchmark"]

if not TYPE_CHECKING:  # for which a name that is not declared above is a mistake

    def __getattr__(name: str) -> Any:
        """The readers of tables, imported when asked for: pandas takes half a second."""
        if name not in __all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(importlib.import_module("steadyload.layouts.benchmark.dataset"), name)
