"""The labelled set: layouts, labels with their confidence, and splits."""

from steadyload.layouts.benchmark.dataset import (
    CHOOSING,
    PLANAR,
    REAL,
    UNLEARNT,
    Benchmark,
    BenchmarkError,
    Part,
    load_benchmark,
)

__all__ = [
    "CHOOSING",
    "PLANAR",
    "REAL",
    "UNLEARNT",
    "Benchmark",
    "BenchmarkError",
    "Part",
    "load_benchmark",
]
