"""Results of all parts, as the page shows them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.methods.tuned import tuned_engines
from steadyload.reports.columns import row
from steadyload.runs.costs import CostKind, CostSource
from steadyload.studies.engines.accuracy import Accuracy
from steadyload.studies.engines.agreeing import Agreement, OptionEffect
from steadyload.studies.engines.equal_searches import EqualSearches
from steadyload.studies.engines.sources import ANSWERS, Source, SourceTable
from steadyload.studies.engines.speed import Cost, Gain, SpeedCurve


@row
class Found:
    """Everything the page shows; a part that was not measured is empty."""

    made_with: Mapping[str, str]
    agreement: Agreement | None = None
    options: Sequence[OptionEffect] = ()
    curves: Sequence[SpeedCurve] = ()
    rates: Sequence[Gain] = ()
    tables: Sequence[SourceTable] = ()
    accuracy: Accuracy | None = None
    equal: EqualSearches | None = None

    @property
    def timed(self) -> str:
        """Explanation of the times."""
        return CostSource(CostKind.ONE_PROCESS).explained()

    @property
    def costs(self) -> list[Cost]:
        """All points of all curves."""
        return [
            Cost(curve, point, 100.0 * point.step / point.total, point.own)
            for curve in self.curves
            for point in curve.points
        ]

    @property
    def tuned(self) -> tuple[str, ...]:
        """The engines on which sources are compared."""
        return tuned_engines()

    @property
    def sources(self) -> list[SourceTable]:
        """Tables of the answer that the page speaks of, one a design."""
        return [table for table in self.tables if table.answer == next(iter(ANSWERS))]

    @property
    def shares(self) -> list[Source]:
        """Their rows."""
        return [share for table in self.sources for share in table.shares]

    @property
    def depends(self) -> bool:
        """Whether the largest source depends on the parameter sets, for one question."""
        alone = [table for table in self.sources if len(table.design.questions) == 1]
        return len({table.largest.factors for table in alone[:2]}) > 1
