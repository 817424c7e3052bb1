"""The checks that every engine must pass: written once, run for each, importable by others.

A check is a function of a world class. It raises :class:`AssertionError` when the engine does not
conform and :class:`NotApplicable` when the engine declares that it lacks what is checked. Nearly
all checks are planar (motion in the x-z plane), so that 2-D engines are checked alike.

An outside adapter runs them all with::

    if __name__ == "__main__":  # one check starts a process, which imports this module again
        for name, check in CHECKS.items():
            try:
                check(MyWorld)
            except NotApplicable as reason:
                print(name, "does not apply:", reason)

Failures that are known stand beside the adapter, in ``capabilities.known_failures``.
"""

from __future__ import annotations

import inspect

from steadyload.engines.checks import (
    changing_gravity,
    flight,
    landing,
    launching,
    mechanics,
    protocol,
    refusals,
    reseating,
)
from steadyload.engines.checks.scenes import Check, NotApplicable

__all__ = ["CHECKS", "Check", "NotApplicable"]

CHECKS: dict[str, Check] = {
    name.removeprefix("check_"): function
    for module in (
        protocol,
        reseating,
        refusals,
        mechanics,
        changing_gravity,
        launching,
        flight,
        landing,
    )
    for name, function in vars(module).items()
    if name.startswith("check_") and inspect.isfunction(function)
}
"""All checks by name, in the order in which they are written."""
