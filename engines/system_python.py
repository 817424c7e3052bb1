"""The system's own Python, for engines that a Linux distribution packages and no index has.

An environment of ours cannot import them: they run in a child (:mod:`steadyload.engines.child`).
"""

from __future__ import annotations

import importlib.metadata

PYTHON = "/usr/bin/python3"

PACKAGES = "/usr/lib/python3/dist-packages"
"""Where Debian and what is made from it keep packages of that Python."""


def version(package: str) -> str | None:
    """Version of a package of the system's Python; None where it is not installed."""
    found = importlib.metadata.distributions(name=package, path=[PACKAGES])
    return next((one.version for one in found), None)
