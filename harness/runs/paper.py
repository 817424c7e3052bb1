"""The paper's Table 5, as it is printed."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

from steadyload.methods.naming import MethodKey
from steadyload.runs.evaluation import ALL


@dataclass(frozen=True, slots=True)
class PaperRow:
    """A column of the paper's Table 5, by group: accuracy, runtime [ms of wall time].

    ``families``: families of methods that judge in the same way here, see
    :attr:`MethodKey.family`, or specs. ``namesakes``: those that go by the same name and judge in
    another.
    """

    title: str
    families: tuple[str, ...]
    namesakes: tuple[str, ...]
    accuracy: Mapping[str, float]
    runtime: Mapping[str, float]

    @property
    def runtime_mean(self) -> float:
        """Mean of the runtimes of the scenarios; the printed average may differ."""
        single = [value for group, value in self.runtime.items() if group != ALL]
        return sum(single) / len(single)


@dataclass(frozen=True, slots=True)
class Paper:
    """The paper's Table 5: ``cases`` a scenario, and the ``machine`` that times are of."""

    source: str
    cases: int
    machine: str
    rows: tuple[PaperRow, ...]

    def row_of(self, method: MethodKey) -> PaperRow | None:
        """The column of a method or of its namesake; None where the paper has none."""
        return self.like(method) or next(
            (row for row in self.rows if method.family in row.namesakes), None
        )

    def like(self, method: MethodKey) -> PaperRow | None:
        """The column of a method that judges in the same way; None where the paper has none."""
        named = {method.family, method.spec}
        return next((row for row in self.rows if not named.isdisjoint(row.families)), None)

    def among(self, groups: Iterable[str]) -> list[str]:
        """The groups that the paper has, too."""
        return [group for group in groups if group in self.rows[0].accuracy]


@cache
def paper() -> Paper:
    """The paper's own numbers, from ``paper.toml``; accuracies as shares."""
    content = tomllib.loads(
        (resources.files(__package__) / "paper.toml").read_text(encoding="utf-8")
    )
    return Paper(
        source=content["source"],
        cases=content["cases"],
        machine=content["machine"],
        rows=tuple(
            PaperRow(
                title=entry["title"],
                families=tuple(entry["families"]),
                namesakes=tuple(entry.get("namesakes", ())),
                accuracy={group: value / 100.0 for group, value in entry["accuracy"].items()},
                runtime=entry["runtime"],
            )
            for entry in content["method"]
        ),
    )
