"""Parameters found by searches that differ in their engine alone, on cases that none of them saw.

The presets ``ps_opt`` are the best that is known on each engine: they come of searches on different
cases and of different lengths. Engines are compared by ``ps_opt-equal``.
"""

from __future__ import annotations

from collections.abc import Sequence

from steadyload.methods.tuned import EQUAL, TUNED, tuned, tuned_engines
from steadyload.reports.columns import column, percent, plain_percent, row
from steadyload.runs.evaluation import Evaluation
from steadyload.statistics.estimate import Estimate


@row
class EquallySearched:
    """An engine with the parameters that its search found."""

    engine: str = column()
    genotypes: int = column("parameter sets searched")
    searched_on: int = column("cases searched on")
    found: float = column("accuracy there %", plain_percent)
    accuracy: Estimate = column("accuracy here %", percent)
    behind: Estimate | None = column("less than the best engine, points", percent)
    ahead: Estimate = column("more than ps_opt, points", percent)


@row
class EqualSearches:
    """Results of all engines, and the cases that they were judged on, which no search saw."""

    engines: Sequence[EquallySearched]
    cases: int
    item_lists: int

    @property
    def worse(self) -> list[EquallySearched]:
        """Engines that are significantly less accurate than the best one."""
        return [own for own in self.engines if own.behind and own.behind.low > 0.0]


def equal_searches(found: Evaluation) -> EqualSearches:
    """Accuracy of the presets of equal searches.

    Args:
        found: of both tuned presets on every engine of :func:`.tuned_engines`, and of others.
    """
    entries = tuned(preset=EQUAL)
    own = {engine: found.row(f"{EQUAL}@{engine}").accuracy for engine in tuned_engines()}
    best = max(own, key=lambda engine: own[engine].value)

    def behind(engine: str) -> Estimate:
        return found.difference(f"{EQUAL}@{best}", f"{EQUAL}@{engine}")

    return EqualSearches(
        [
            EquallySearched(
                engine,
                entries[engine].made_by["found"]["genotypes"],
                entries[engine].made_by["found"]["cases"],
                entries[engine].made_by["found"]["accuracy"],
                accuracy,
                None if engine == best else behind(engine),
                found.difference(f"{EQUAL}@{engine}", f"{TUNED}@{engine}"),
            )
            for engine, accuracy in own.items()
        ],
        len(found.judged.said),
        found.judged.clusters.nunique(),
    )
