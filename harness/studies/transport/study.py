"""The acceleration that a complete load holds, by every method beside the reference."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, option

if TYPE_CHECKING:
    from steadyload.studies.transport.comparing import Found


class Transport(Study["Found"]):
    """Limits of loads by statics, rule of thumb and simulation, beside the reference's."""

    question = "What acceleration does a complete load withstand, and which method finds it?"
    about = "compare limits of acceleration by equilibrium, engines and the reference, and why"

    loads: int = option(200, "loads of real size (default: 200)", least=1)
    most_boxes: int | None = option(
        None, "boxes of a load of real size at most (default: 61, those of a small one)", least=1
    )
    small: int = option(60, "loads of at most 20 boxes (default: 60)", least=1)
    referenced: int = option(
        100, "loads of real size, those of fewest boxes, that the reference judges as well "
        "(default: 100; a load takes it a minute or several)", least=0,
    )  # fmt: skip
    directions: int = option(8, "directions around a load (default: 8)", least=1, most=360)
    engines: tuple[str, ...] = option(
        (), "engine for the loads of real size; may be repeated (default: those whose tuned "
        "simulation no cheaper one beats on the largest loads that recommend has; small loads are "
        "judged by all)", names=("--engine",), metavar="NAME",
    )  # fmt: skip

    def run(self, lab: Lab) -> Found:
        """Missing limits are found, and all are compared."""
        from steadyload.layouts.sizes import MOST_SMALL
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.transport.comparing import compare
        from steadyload.studies.transport.limits_of_loads import limits_of_loads

        made_with, asked = provenance_lines(), vars(self)
        most = MOST_SMALL if self.most_boxes is None else self.most_boxes
        return compare(limits_of_loads(lab, **{**asked, "most_boxes": most}), made_with)
