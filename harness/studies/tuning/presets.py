"""Results of tuned presets, as their page shows them. Shares are 0 to 1, times in ms a layout."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import pandas as pd

from steadyload.studies.tuning.searching import Algorithm, Gene, Point, Searching

BUDGETS = (1.0, 3.0, 10.0, 30.0)
"""Budgets in the table of prices [ms a layout]."""

DEAR = "ps3"
"""The family of which a page compares the cost with that of tuned methods."""

START = "label"
"""The family of the genotype with which a search begins."""


class Found(SimpleNamespace):
    """Results of searches, and of presets on other cases; without these a page of searches alone.

    Frames of results have a row a parameter set, with ``engine``, ``right`` and ``cpu``. ``parts``:
    of a labelled set, with ``rows``, tuned parameters before what is compared with them, and
    ``carried``, also those of other engines. ``left_out``, ``physical``: tuned parameters with some
    changed; ``everything``: all of one kind. ``steps``: from the paper's values to the tuned ones.
    ``bought``: the most accurate of all judged parameter sets within a budget. ``luck``: a search
    with several seeds. ``fronts``: of all searches of an engine, where they judged.
    """

    made_with: Mapping[str, str]
    genes: Sequence[Gene]
    searches: Sequence[Searching]
    algorithms: Sequence[Algorithm]
    fronts: Sequence[Point] = ()
    parts: Sequence[Mapping[str, Any]] = ()
    luck: Sequence[Mapping[str, Any]] = ()
    gains = steps = left_out = everything = physical = bought = pd.DataFrame()
    costs_explained = ""

    @property
    def finders(self) -> list[Searching]:
        """The first search on every engine, which found its preset."""
        first = {one.engine: one for one in reversed(self.searches)}
        return [first[engine] for engine in sorted(first)]

    @property
    def largest(self) -> list[Searching]:
        """The search on every engine that judged most."""
        by_size = sorted(self.searches, key=lambda one: one.genotypes)
        return list({one.engine: one for one in by_size}.values())
