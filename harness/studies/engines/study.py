"""One loading algorithm, equal values, every engine: agreement, options and speed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, PublishedPage, Study, option

if TYPE_CHECKING:
    from steadyload.studies.engines.showing import Found

PARTS = ("sources", "accuracy", "agreement", "options", "speed", "throughput")
_SEED = 7


class EngineStudy(Study["Found"]):
    """Parts of the comparison, and how much is measured; what is timed is in one process."""

    name = "engines"
    question = "Do engines agree, what does each option change, and what does a simulation cost?"
    about = "compare engines: agreement, options, speed"
    pages = (
        PublishedPage(
            "engines",
            "--part sources --real-cases 20 --part accuracy --part agreement --part options "
            "--part speed --part throughput",
        ),
    )

    parts: tuple[str, ...] = option(
        (), "measure only this; may be repeated (default: speed and throughput)",
        names=("--part",), choices=PARTS,
    )  # fmt: skip
    layouts: int = option(
        300, "generated layouts for agreement and options (default: 300)", least=1
    )
    cases: int = option(
        100, "cases a scenario of part test for sources and accuracy, on the set of many lists "
        "(default: 100)",
        least=2,
    )  # fmt: skip
    real_cases: int = option(
        0, "the same of the set of real size, where DART takes 20 s a case (default: 0, none)",
        least=0,
    )  # fmt: skip
    most_items: int = option(
        200, "largest layout of the speed part (default: 200)", least=20, metavar="J"
    )

    def run(self, lab: Lab) -> Found:
        """Parts that are not asked for are empty."""
        from steadyload.layouts.benchmark.parts import LISTS, REAL
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.engines.accuracy import accuracy_by_load
        from steadyload.studies.engines.agreeing import Drawn, engine_agreement, option_effects
        from steadyload.studies.engines.equal_searches import equal_searches
        from steadyload.studies.engines.showing import Found
        from steadyload.studies.engines.sources import judged_by_designs, sources_of_differences
        from steadyload.studies.engines.speed import ITEM_COUNTS, speed_curves, throughput

        parts = self.parts or ("speed", "throughput")
        made_with = provenance_lines()  # of the code that measures
        drawn = Drawn(self.layouts, _SEED)
        counts = [n for n in ITEM_COUNTS if n <= self.most_items]
        limits = {LISTS: self.cases, REAL: self.real_cases} if "sources" in parts else {}
        evaluated = {n: judged_by_designs(lab, n, limit) for n, limit in limits.items() if limit}
        return Found(
            {"generated layouts": f"{self.layouts}, seed {_SEED}"} | made_with,
            engine_agreement(lab, drawn) if "agreement" in parts else None,
            option_effects(lab, drawn) if "options" in parts else [],
            speed_curves(lab, counts) if "speed" in parts else [],
            throughput(lab) if "throughput" in parts else [],
            sources_of_differences(evaluated),
            accuracy_by_load(lab, self.cases) if "accuracy" in parts else None,
            equal_searches(evaluated[LISTS]) if evaluated else None,
        )
