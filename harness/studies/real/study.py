"""All methods on labelled layouts of real size, asked both questions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.config import positive_number
from steadyload.studies.kit import Lab, PublishedPage, Study, methods_option, option, set_option

if TYPE_CHECKING:
    from steadyload.studies.real.comparing import Found


class Real(Study["Found"]):
    """Which methods, on which cases, and how long a judgement may take."""

    question = "Which method judges a pallet of real size, how right is it, and at what cost?"
    about = "all methods on labelled layouts of real size, by number of boxes"
    pages = (PublishedPage("real", "--workers 1"),)

    methods: tuple[str, ...] = methods_option(
        "may be repeated (default: rules, equilibrium, settling, tuned simulations, "
        "networks, the cascade)"
    )
    directory: str = set_option("real")
    timeout: float = option(
        20.0, "CPU seconds a judgement may take (default: 20)", metavar="S", read=positive_number
    )
    limit: int | None = option(None, "only the first N cases a scenario", least=1)
    small: int = option(
        60, "cases a scenario of the small layouts of the package, for comparison (default: 60)",
        least=0,
    )  # fmt: skip
    sizes: tuple[int, ...] = option(
        (), "largest numbers of boxes of the bins (default: 37 62 87 125 150)", fewest=1, least=1
    )
    pallets: int = option(
        60, "customers' pallets that are judged on several floors, too (default: 60)", least=0
    )

    def run(self, lab: Lab) -> Found:
        """Accuracy and cost of every method, by question and number of boxes."""
        from steadyload.studies.real.comparing import compare

        return compare(lab, **vars(self))
