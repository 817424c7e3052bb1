"""Cost of a judgement: one by one, in batches, in sessions, and by number of items."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, PublishedPage, Study, option

if TYPE_CHECKING:
    from steadyload.studies.speed.records import Found

METHODS = ("fbs", "pbs0.7", "sme", "equilibrium", "equilibrium:time=0.3")
"""Methods that are measured."""

FILE = "times.json"
"""File of the figures, in the folder of the page."""


class Speed(Study["Found"]):
    """Times of judgements on labelled cases, and on the layouts of files."""

    answers = "What does a judgement cost, and how does that grow with the number of items?"
    about = "measure what judgements cost"
    resumable = False
    workers = None
    pages = (PublishedPage("speed", "--last --layouts ../shared/data/pallets/pallets.json"),)

    layouts: tuple[Path, ...] = option(
        (), "measure on the layouts of this file, too; may be repeated", metavar="FILE"
    )
    last: bool = option(
        False, "make the page of the last run once more; measures where there is none"
    )
    limit: int | None = option(
        None, "only N cases a scenario and N layouts of a file, few repeats, up to 50 items: "
        "seconds (default: all)", least=1, metavar="N",
    )  # fmt: skip
    json: bool = option(False, "print the figures as one JSON object, in place of the page's path")

    def run(self, lab: Lab) -> Found:
        """Times that are measured, or those of the last run, which are kept beside its page."""
        from steadyload.config import bind
        from steadyload.stored import stored_object
        from steadyload.studies.speed.records import Found
        from steadyload.studies.speed.running import run_speed
        from steadyload.studies.speed.scenes import FULL, QUICK, case_sets

        file = lab.work / FILE
        if self.last and file.exists():
            return bind(Found, stored_object(file, "remove it, and measure anew"), str(file))
        extent = FULL if self.limit is None else QUICK._replace(limit=self.limit)
        sets = case_sets(self.layouts, extent.limit)
        return run_speed(METHODS, sets, extent, lab.progress)

    def beside(self, found: Found, folder: Path) -> None:
        """The figures, of which the page can be made once more."""
        from steadyload.atomic import manifest_text, write_atomically

        folder.mkdir(parents=True, exist_ok=True)
        write_atomically(folder / FILE, manifest_text(asdict(found)))

    def printed(self, found: Found, page: Path) -> str:
        """The path of the page, or the figures as JSON."""
        import json

        return json.dumps(asdict(found), indent=1) if self.json else str(page)
