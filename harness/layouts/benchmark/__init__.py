"""The labelled set: layouts, labels with their confidence, and splits."""

from steadyload.layouts.benchmark.dataset import (
    PLANAR,
    UNLEARNT,
    Benchmark,
    BenchmarkError,
    Part,
    load_benchmark,
)

__all__ = ["PLANAR", "UNLEARNT", "Benchmark", "BenchmarkError", "Part", "load_benchmark"]
