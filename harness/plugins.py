"""Objects that other distributions register by entry points: a faulty one breaks only itself."""

from __future__ import annotations

import importlib
import importlib.metadata
from typing import Any

from steadyload.errors import UserError

OWN = "steadyload."
"""Beginning of what this distribution registers."""


class PluginError(UserError):
    """Something of another distribution that cannot be used; says whose it is, and why."""


def loaded(target: str, group: str, name: str) -> Any:
    """An object of a registry.

    Args:
        target: ``"module:attribute"``.
        group: entry-point group.
        name: under which it is registered.

    Raises:
        PluginError: it is of another distribution and cannot be imported.
    """
    module, _, attribute = target.partition(":")
    if target.startswith(OWN):
        return getattr(importlib.import_module(module), attribute)
    try:
        return getattr(importlib.import_module(module), attribute)
    except (Exception, SystemExit) as error:  # one that ends the process ends no command
        raise faulty(group, name, f"{type(error).__name__}: {error}") from error


def faulty(group: str, name: str, why: str) -> PluginError:
    """The error of a faulty entry of a group.

    Args:
        group: entry-point group, such as ``steadyload.methods``.
        name: of the entry.
        why: it cannot be used.
    """
    found = importlib.metadata.entry_points(group=group, name=name)
    owners = [f"{one.dist.name} {one.dist.version}" for one in found if one.dist is not None]
    kind = group.rpartition(".")[2].removesuffix("s").replace("studie", "study")
    return PluginError(
        f"{kind} {name!r} of {', '.join(owners) or 'another distribution'} cannot be used: {why}"
    )
