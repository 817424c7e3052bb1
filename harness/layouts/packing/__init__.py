"""Packing of boxes: item lists, heuristics, empty spaces."""

from steadyload.layouts.packing.packing import (
    WeightRule,
    generate,
    make_instance,
    pack,
    pack_instance,
    random_layouts,
)

__all__ = ["WeightRule", "generate", "make_instance", "pack", "pack_instance", "random_layouts"]
