"""The acceleration that a complete load holds, by every method beside the reference."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, option

if TYPE_CHECKING:
    from steadyload.studies.transport.comparing import Found


class Transport(Study["Found"]):
    """Limits of loads by statics, rule of thumb and simulation, beside the reference's."""

    answers = "What acceleration does a complete load withstand, and which method finds it?"
    about = "compare limits of acceleration by equilibrium, engines and the reference, and why"

    limit: int | None = option(
        None, "only N loads of each set (default: 60 small ones, 200 of real size, of which the "
        "reference judges 100, for a minute or several each)", least=5, metavar="N",
    )  # fmt: skip

    def run(self, lab: Lab) -> Found:
        """Missing limits are found, and all are compared."""
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.transport.comparing import compare
        from steadyload.studies.transport.limits_of_loads import limits_of_loads

        made_with = provenance_lines()
        return compare(limits_of_loads(lab, self.limit), made_with)
