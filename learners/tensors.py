"""Tensors of a network: checked in a file, so that a sentence names the file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from steadyload.layouts.files.record import shown
from steadyload.learners import LearnerError
from steadyload.learners.features import names
from steadyload.learners.options import NetworkKind, TrainingOptions

_TYPE = np.dtype(np.float32)


def tensor_shapes(options: TrainingOptions) -> dict[str, tuple[int, ...]]:
    """Shapes of all tensors by name, as :mod:`steadyload.learners.network` makes them."""
    columns, hidden = len(names(options.features)), options.hidden
    shapes: dict[str, tuple[int, ...]] = {"mean": (columns,), "scale": (columns,)}
    for layer in range(options.layers):
        shapes |= {
            f"lstm.weight_ih_l{layer}": (4 * hidden, hidden if layer else columns),
            f"lstm.weight_hh_l{layer}": (4 * hidden, hidden),
            f"lstm.bias_ih_l{layer}": (4 * hidden,),
            f"lstm.bias_hh_l{layer}": (4 * hidden,),
        }
    linear = {"head": (1, hidden)}
    if options.network is NetworkKind.ATTENTION:
        linear |= {"query": (hidden, hidden), "mixed": (hidden, 2 * hidden)}
        linear |= {"key": (hidden, columns), "value": (hidden, columns)}
    for name, shape in linear.items():
        shapes |= {f"{name}.weight": shape, f"{name}.bias": shape[:1]}
    return shapes


def check_tensors(
    arrays: Mapping[str, np.ndarray], options: TrainingOptions, *, where: Path
) -> None:
    """Check that tensors are those of a network with these options.

    Args:
        arrays: by name.
        options: that the network was trained with.
        where: the file, for messages.

    Raises:
        LearnerError: a tensor is missing, unknown, of another shape or type, or not finite.
    """
    shapes = tensor_shapes(options)
    for name in arrays:
        if name not in shapes:
            raise LearnerError(
                f"{where}: has the unknown tensor {shown(name)}; allowed: {', '.join(shapes)}"
            )
    for name, shape in shapes.items():
        array = arrays.get(name)
        if array is None:
            raise LearnerError(f"{where}: lacks the tensor {name}; allowed: one of shape {shape}")
        if array.shape != shape:
            raise LearnerError(f"{where}: {name} has shape {array.shape}; allowed: {shape}")
        if array.dtype != _TYPE:
            raise LearnerError(f"{where}: {name} has type {array.dtype}; allowed: {_TYPE}")
        if not np.isfinite(array).all():
            raise LearnerError(f"{where}: {name} has a value that is not finite; allowed: numbers")
