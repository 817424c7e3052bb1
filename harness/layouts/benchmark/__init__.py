"""The labelled benchmark: layouts, labels, how sure they are, and which split each belongs to."""

from steadyload.layouts.benchmark.dataset import (
    PLANAR,
    UNLEARNT,
    Benchmark,
    BenchmarkError,
    Part,
    load_benchmark,
)

__all__ = ["PLANAR", "UNLEARNT", "Benchmark", "BenchmarkError", "Part", "load_benchmark"]
