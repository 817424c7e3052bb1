"""The paper's Table 5, as it is printed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache

from steadyload.config import ConfigError, bind
from steadyload.methods.naming import MethodKey
from steadyload.reading import own_file, toml_of
from steadyload.reports.columns import column, plain_percent, row
from steadyload.runs.evaluation import ALL


@row
class PaperRow:
    """A column of the paper's Table 5, by group: accuracy, runtime [ms of wall time].

    ``families``: families of methods that judge in the same way here, see
    :attr:`MethodKey.family`, or specs. ``namesakes``: those that go by the same name and judge in
    another.
    """

    title: str = column("the paper")
    families: tuple[str, ...]
    accuracy: Mapping[str, float] = column("{} %", plain_percent)
    runtime: Mapping[str, float]
    namesakes: tuple[str, ...] = ()

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
    file = own_file("steadyload.runs", "paper.toml")
    content = toml_of(file, ConfigError)
    for one in content["rows"]:
        one["accuracy"] = {group: value / 100.0 for group, value in one["accuracy"].items()}
    return bind(Paper, content, str(file))
