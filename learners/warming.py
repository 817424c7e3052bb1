"""The learners' part of ``steadyload warm-up``."""

from __future__ import annotations

from steadyload.methods.registry import make_method


def warm_up() -> None:
    """Compile what learned methods judge with, or load the compiled code."""
    for name in ("lstm_1", "lstm_e"):
        make_method(name).prepare()
