"""Contents of a labelled set, and how far its labels can be trusted."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from steadyload.studies.kit import Lab, Study, operand

if TYPE_CHECKING:
    from steadyload.studies.benchmark.counting import Found


def labelled_set() -> Any:
    """The operand of a labelled set."""
    return operand(
        None,
        "folder of a labelled set, or planar for that of the package (default: its large one)",
        metavar="DIR",
    )


class Benchmark(Study["Found"]):
    """Which labelled set."""

    answers = "What does the labelled set contain, and how robust are its labels?"
    about = "write the page of a set"
    resumable = False
    workers = None

    directory: str | None = labelled_set()

    def run(self, lab: Lab) -> Found:
        """Counted from the set; nothing is judged."""
        from steadyload.layouts.benchmark import load_benchmark
        from steadyload.studies.benchmark.counting import summarise

        return summarise(load_benchmark(self.directory))
