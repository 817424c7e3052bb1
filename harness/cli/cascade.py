"""``steadyload cascade fit``: the thresholds of the stages of a cascade."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from steadyload.cli.terminal import print_table, progress_bar
from steadyload.config import option, output_option
from steadyload.tuning.cascade.defaults import (
    BUDGETS,
    CANDIDATES,
    CONFIDENCE,
    ENGINE,
    LAST,
)


@dataclass(frozen=True)
class Fit:
    """Engines, candidate stages, and the error budget."""

    engines: tuple[str, ...] = option(
        (), f"engine of the last stage; may be repeated (default: {ENGINE})",
        names=("--engine",),
    )  # fmt: skip
    error_budget: tuple[float, ...] = option(
        (), "accuracy that the stages before the last may cost, in percentage points; of several "
        f"the first is the default (default: {' '.join(f'{b:g}' for b in BUDGETS)})",
        metavar="POINTS", fewest=1,
    )  # fmt: skip
    confidence: float = option(
        CONFIDENCE, f"that lost accuracy keeps within the budget (default: {CONFIDENCE:g})",
        metavar="C",
    )  # fmt: skip
    candidates: tuple[str, ...] = option(
        (), "a method that may become a stage, in order; may be repeated (default: "
        f"{', '.join(CANDIDATES['within'])}; for stands {', '.join(CANDIDATES['stands'])})",
        names=("--candidate",), metavar="SPEC",
    )  # fmt: skip
    last: str = option(
        "", "the method that decides the steps that no stage decides, on the engine; {engine} "
        f"stands for its name (default: {LAST})", metavar="SPEC",
    )  # fmt: skip
    benchmark: str | None = option(
        None, "labelled set to fit on, its part fitting or else validation (default: choosing; "
        "for a 2-D engine planar)", metavar="SET",
    )  # fmt: skip
    data: tuple[str, ...] = option(
        (), "further labelled set, such as real, likewise, or one of steadyload generate that no "
        "judge has learnt from; may be repeated", metavar="SET",
    )  # fmt: skip
    limit: int | None = option(None, "only the first N cases a scenario", least=2)
    question: str = option(
        "within", "whose labels count (default: within)",
        choices="steadyload.layouts.model.question:Question",
    )  # fmt: skip
    falls: str | None = option(
        None, "labelled set of whose customers' pallets no fall may be lost that the last method "
        "finds: stages only pass steps then; none for no such set (default: real for stands, else "
        "none)", metavar="SET",
    )  # fmt: skip
    output: Path | None = output_option(
        None, "file of thresholds (default: the one of the package)"
    )

    def run(self) -> None:
        """Fit, write the thresholds, and print them."""
        from steadyload.layouts.model.question import Question
        from steadyload.methods.cascade.thresholds import FILE, write_thresholds
        from steadyload.runs.provenance import provenance
        from steadyload.tuning.cascade.fitted import FitOptions, check_remakable, fit_cascade

        question = Question(self.question)
        if self.output is None:  # reported before minutes of work
            check_remakable(provenance())
        common = (
            self.error_budget or BUDGETS, self.confidence, self.candidates, self.benchmark,
            self.data, self.limit, question, self.last, "" if self.falls == "none" else self.falls,
        )  # fmt: skip
        asked = [FitOptions(engine, *common) for engine in self.engines or (ENGINE,)]
        fitted = {}
        for one in asked:
            with progress_bar(f"asking for {one.engine}") as advance:
                fitted[one.engine] = fit_cascade(one, progress=advance)
        for engine, thresholds in fitted.items():
            file = write_thresholds(engine, thresholds, self.output or FILE, question)
            print_table(
                ("cascade", "budget", "stages", "lost", "of", "left out", "falls", "of", "alone",
                 "accuracy %", "alone %", "ms", "alone"),
                [
                    (
                        f"cascade@{engine}",
                        f"{budget:g}",
                        ", ".join(map(str, ladder.stages)) or "-",
                        str(ladder.found["lost"]),
                        str(ladder.found["cases"]),
                        "{lost} of {cases}".format(**ladder.found["left_out"]),
                        *(
                            str(ladder.found.get("falls", {}).get(name, "-"))
                            for name in ("found", "cases", "found_alone")
                        ),
                        f"{100 * ladder.found['accuracy']:.2f}",
                        f"{100 * ladder.found['alone']:.2f}",
                        f"{ladder.found['milliseconds']:.2f}",
                        f"{ladder.found['milliseconds_alone']:.2f}",
                    )
                    for budget, ladder in thresholds.ladders.items()
                ],
            )  # fmt: skip
        print(file)
