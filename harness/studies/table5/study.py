"""Configuration of the study of Table 5."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from steadyload.config import methods_option, option, set_option
from steadyload.progress import NamedProgress, silent
from steadyload.studies.study import PublishedPage, Study

if TYPE_CHECKING:
    from steadyload.studies.table5.judging import Table5Options


@dataclass(frozen=True)
class Table5Config:
    """Which methods, on how many cases, and how often they are timed."""

    methods: tuple[str, ...] = methods_option(
        "may be repeated (default: the paper's methods on every engine, and our own)"
    )
    directory: str = set_option()
    question: str = option(
        "within",
        "whose labels and methods the page shows, within or stands (default: within); those of "
        "both are judged",
        metavar="QUESTION",
        choices="steadyload.layouts.model.question:Question",
    )
    limit: int | None = option(None, "only the first N cases a scenario", least=2)
    timed: int = option(
        100, "cases a scenario that are timed, in one process (default: 100)", least=1
    )
    repeats: int = option(3, "how often they are timed (default: 3)", least=1)
    rules: int = option(
        0,
        "cases a scenario on which other rules are compared, too, with the question within "
        "(default: 0, none)",
        least=0,
    )

    def options(self) -> Table5Options:
        """The options of the study, with the methods that can judge and reasons for the others."""
        from steadyload.layouts.model.question import Question
        from steadyload.studies.table5.judging import Table5Options

        return Table5Options(
            self.methods, self.limit, self.timed, self.repeats, directory=self.directory,
            question=Question(self.question),
        )  # fmt: skip


_PUBLISHED = "--directory lists --limit 300 --timed 20 --repeats 2"
"""300 cases a scenario, as many as the paper has, of many item lists."""


class Table5(Study[Table5Config, Any]):
    """All methods on the labelled test split."""

    name = "table5"
    question = "How accurate is every method on every engine, and what does it cost?"
    about = "all methods on the labelled test split, as Table 5 of the paper, every engine"
    Config = Table5Config
    workers = 0
    published = (
        PublishedPage("table5", f"{_PUBLISHED} --rules 25"),
        PublishedPage(
            "table5_stands",
            f"{_PUBLISHED} --question stands",
            question="How accurate is every method where a load has to stand until it rests?",
        ),
    )

    def run(
        self,
        config: Table5Config,
        work: Path,
        *,
        workers: int = 1,
        progress: NamedProgress = silent,
    ) -> Any:
        """The summary of the run, judged over processes and timed in one; also writes the front."""
        from steadyload.studies.kit import Lab
        from steadyload.studies.rankings import ranked
        from steadyload.studies.table5.judging import judge_table5, time_table5
        from steadyload.studies.table5.summary import summarise, write_timed_front

        asked = config.options()
        judge_table5(asked, work, workers=workers, progress=lambda *of: progress("judging", *of))
        spatial, planar = time_table5(asked, work, progress=lambda *of: progress("timing", *of))
        found = summarise(asked, spatial, planar)
        write_timed_front(found, work)
        if config.rules and config.question == "within":
            lab = Lab(work / "rules", workers, progress)
            rules = ranked(lab, config.methods, config.rules, config.directory)
            found = dataclasses.replace(found, rules=rules)
        return found

    def page(self, result: Any) -> Any:
        """The page of the table, its tests, and the errors of methods."""
        from steadyload.studies.table5.page import table5_page

        return table5_page(result)


STUDY = Table5()
