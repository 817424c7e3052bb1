"""The paper's Table 5, as it is printed."""

from __future__ import annotations

import tomllib
from importlib import resources

from steadyload.studies.table5.records import Paper, PaperRow


def paper() -> Paper:
    """The paper's own numbers, from ``paper.toml``; accuracies as shares."""
    content = tomllib.loads((resources.files(__package__) / "paper.toml").read_text())
    return Paper(
        source=content["source"],
        cases=content["cases"],
        machine=content["machine"],
        rows=tuple(
            PaperRow(
                title=entry["title"],
                families=tuple(entry["families"]),
                accuracy={group: value / 100.0 for group, value in entry["accuracy"].items()},
                runtime=entry["runtime"],
            )
            for entry in content["method"]
        ),
    )
