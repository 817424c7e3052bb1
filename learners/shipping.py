"""Shipping of weights with the package: only of those that anybody can make again."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from steadyload.learners import LearnerError
from steadyload.learners.weights import (
    SHIPPED,
    load_arrays,
    load_weights,
    save_weights,
)
from steadyload.runs.provenance import provenance


def method_for(members: int) -> str:
    """Name of the method that judges by so many networks, and of its shipped weights."""
    return "lstm_1" if members == 1 else "lstm_e"


def check_before(name: str, *, leaky: bool) -> None:
    """Check, before hours are spent, that weights trained now may be shipped.

    Args:
        name: of the weights in the package.
        leaky: the training learns from what is held out.

    Raises:
        LearnerError: it may not.
    """
    _check_name(name)
    if leaky:
        raise LearnerError("what learns from what is held out is not shipped; leave out --leaky")
    check_shippable(provenance())


def ship(weights: Path, name: str) -> Path:
    """Make weights part of the package, in the place of what had the name.

    Raises:
        LearnerError: they, or those that they started from, were trained the leaky way, or by code
            that is in no commit: nobody could make them again. Or the name is no plain one.
    """
    _check_name(name)
    found = load_weights(weights)
    part: Mapping[str, Any] = found.manifest
    while part:
        for made_by in (part["made_by"], *part.get("gone_on_by", ())):
            check_shippable(made_by)
        part = part.get("started_from", {})
    if found.manifest["leaky"]:
        raise LearnerError(f"{weights}: learnt from what is held out, and is not shipped")
    arrays = [load_arrays(weights, k) for k in range(len(found.networks))]
    own = {k: v for k, v in found.manifest.items() if k not in ("version", "hashes")}
    return save_weights(SHIPPED / name, arrays, own)


def check_shippable(made_by: Mapping[str, Any]) -> None:
    """Check that the weights of a training may be shipped.

    Raises:
        LearnerError: its code is in no commit.
    """
    if made_by["git"] is None or "dirty" in str(made_by["git"]):
        raise LearnerError(
            f"the weights are made by {made_by['git'] or 'an installed package'}, which is in no "
            "commit: nobody could make them again; commit, then train in another folder"
        )


def _check_name(name: str) -> None:
    if not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_.\-]*", name):
        raise LearnerError(
            f"name of weights is {name!r}; allowed: letters, digits, '_', '-' and '.'"
        )
