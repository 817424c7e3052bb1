"""The learners' part of ``steadyload warm-up``."""

from __future__ import annotations

import logging
from functools import partial

from steadyload.methods.contract.declared import Trait
from steadyload.methods.registry import methods_with
from steadyload.runs.able import able_methods

_log = logging.getLogger("steadyload")


def warm_up() -> None:
    """Compile what learned methods judge with, or load the compiled code.

    Of each that cannot judge here, a warning.
    """
    _, left_out = able_methods((), partial(methods_with, Trait.LEARNED))
    for spec, why in left_out.items():
        _log.warning("method %s is not ready: %s", spec, why)
