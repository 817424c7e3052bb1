"""Tuned presets on cases that were used in no search."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.config import REQUIRED
from steadyload.studies.kit import Lab, PublishedPage, Study, operand, option
from steadyload.tuning import TuningError

if TYPE_CHECKING:
    from steadyload.studies.tuning.presets import Found


class Tuning(Study["Found"]):
    """Which searches found the presets, and on how many cases these are judged."""

    answers = "What does tuning a simulation bring, and which parameter brings it?"
    about = "compare tuned presets with other methods on test, and write the page of tuning"
    workers = 0
    verdicts = True
    pages = (PublishedPage("tuning", "reports/published/tuning/searches/*/"),)

    searches: tuple[Path, ...] = operand(REQUIRED, "folders of searches", metavar="DIR")
    limit: int | None = option(
        None, "cases a scenario (default: 150; 300 for what searches add)", least=2
    )
    write_presets: bool = option(
        False, "first make the fittest genotype of all searches on an engine its preset"
    )

    def __post_init__(self) -> None:
        names = [folder.resolve().name for folder in self.searches]
        if len(set(names)) < len(names):
            listed = ", ".join(names)
            raise TuningError(f"folders of searches: {listed}; allowed: names that differ")

    def run(self, lab: Lab) -> Found:
        """The presets, judged beside other methods, and what the searches found."""
        from steadyload.studies.tuning.comparing import compare
        from steadyload.tuning.presets import by_worth, write_preset
        from steadyload.tuning.search import Search

        searches = [Search.of(folder) for folder in self.searches]
        if self.write_presets:
            for best, *_ in by_worth(searches).values():
                write_preset(best)
        return compare(lab, searches, self.limit)

    def remarks(self, found: Found) -> list[str]:
        """The file of presets, where they were written."""
        from steadyload.methods.tuned import FILE

        return [f"presets written to {FILE}"] if self.write_presets else []

    def beside(self, found: Found, folder: Path) -> None:
        """Keep the searches in ``searches``, from which the page can be made again."""
        from steadyload.tuning.ledger import Ledger

        for search in self.searches:
            _, ledger = Ledger.of(search)
            ledger.keep(folder / "searches" / search.resolve().name)
