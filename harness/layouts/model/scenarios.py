"""Scenarios for the centres of mass: S1, S2a and S2b of Section 5.1 of the paper."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum

import numpy as np

from steadyload.layouts.model.layout import Layout

_OFFSET_DECIMALS = 2
"""Centres of mass lie on tenths of a millimetre: the stored values are those judged."""

_REACH = 0.8
"""The centre of mass stays within this share of every side."""


class Scenario(StrEnum):
    """Complexity scenario of the paper.

    ``S1``: at the geometric centre. ``S2a``: normally distributed about it with standard deviation
    0.8 side / 6, clipped at 0.4 side. ``S2b``: uniform on +-0.4 side.
    """

    S1 = "S1"
    S2A = "S2a"
    S2B = "S2b"


def in_usual_order(names: Iterable[str]) -> tuple[str, ...]:
    """Names of scenarios, each once: those that are none of the paper's first."""
    order = {str(s): k for k, s in enumerate(Scenario)}
    return tuple(sorted(set(names), key=lambda name: (order.get(name, -1), name)))


_ALONG_DEPTH = 2


def apply_scenario(
    layout: Layout, scenario: Scenario, seed: int, *, planar: bool = False
) -> Layout:
    """The layout with its centres of mass drawn anew.

    The draw depends on the seed, the scenario and the layout's geometry alone: not on names,
    weights, the centres of mass it came with, or other layouts. To judge the first items of a
    layout, draw first and cut then.

    Args:
        layout: any layout.
        scenario: which distribution.
        seed: 0 or more; the same seed gives the same centres of mass.
        planar: leave every centre of mass in the middle of the depth, out of the plane of width
            and height; in the plane it lies where it would without this. A layout whose items share
            one extent along the depth is then a planar scene in every scenario.
    """
    sides = layout.upper - layout.lower
    centred = layout.with_mass_offsets(np.zeros_like(sides))
    if scenario is Scenario.S1:
        return centred
    geometry = int(layout.geometry_hash()[:16], 16)
    which = list(Scenario).index(scenario)
    random = np.random.default_rng(np.random.SeedSequence([seed, which, geometry]))
    limit = 0.5 * _REACH
    if scenario is Scenario.S2A:
        shares = np.clip(random.normal(0.0, _REACH / 6.0, sides.shape), -limit, limit)
    else:
        shares = random.uniform(-limit, limit, sides.shape)
    if planar:
        shares[:, _ALONG_DEPTH] = 0.0
    return centred.with_mass_offsets(shares * sides)


def draw_case(layout: Layout, scenario: Scenario, seed: int, *, planar: bool = False) -> Layout:
    """A layout in a scenario, its centres of mass rounded as they are stored."""
    drawn = apply_scenario(layout, scenario, seed, planar=planar)
    return drawn.with_mass_offsets(np.round(drawn.mass_offsets, _OFFSET_DECIMALS) + 0.0)
