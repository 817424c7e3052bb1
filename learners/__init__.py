"""Learned methods: methods trained on labelled layouts, and their training.

What judges (:mod:`steadyload.learners.methods` and below it) needs NumPy and the C library alone;
what trains imports torch, which comes with ``pip install 'steadyload[learners]'``.
"""

from __future__ import annotations

import importlib.util

if __name__ != "steadyload.learners":
    raise ImportError("learners is installed as steadyload.learners: import it under that name")

from steadyload.errors import UserError


class LearnerError(UserError):
    """Impossible training, data or weights: says what was requested and what is allowed."""


class LeakError(LearnerError):
    """Training data hold an item list or a geometry that is held out for validation or test."""


def require_training() -> None:
    """Check that the packages for training are installed.

    Raises:
        LearnerError: it is not; says which extra installs it.
    """
    for name in ("torch", "safetensors", "optuna"):
        if importlib.util.find_spec(name) is None:
            raise LearnerError(f"training needs {name}: pip install 'steadyload[learners]'")
