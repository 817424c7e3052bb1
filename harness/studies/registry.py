"""Names of studies. Listing them imports none.

A study is one folder and one line in :data:`STUDIES`. Other distributions register studies through
the entry-point group ``steadyload.studies``, with values of the form ``module:Class``.
"""

from __future__ import annotations

import importlib.metadata
from functools import cache
from typing import Any

from steadyload.errors import UserError, nearest
from steadyload.plugins import faulty, loaded
from steadyload.studies import kit

AnyStudy = type[kit.Study[Any]]
"""A study: the class that is its configuration."""

GROUP = "steadyload.studies"
"""Group of entry points of studies."""

STUDIES: dict[str, str] = {
    "report": "steadyload.studies.report.study:RunReport",
    "evaluation": "steadyload.studies.evaluation.study:Evaluation",
    "sensitivity": "steadyload.studies.sensitivity.study:Sensitivity",
    "cascade": "steadyload.studies.cascade.study:Cascade",
    "tuning": "steadyload.studies.tuning.study:Tuning",
    "learned": "steadyload.studies.learned.study:LearnedStudy",
    "replication": "steadyload.studies.replication.study:Replication",
    "uncertain": "steadyload.studies.uncertain.study:Uncertain",
    "session": "steadyload.studies.session.study:Session",
    "speed": "steadyload.studies.speed.study:Speed",
    "engines": "steadyload.studies.engines.study:EngineStudy",
    "scope": "steadyload.studies.scope.study:Scope",
    "families": "steadyload.studies.families.study:Families",
    "closed_forms": "steadyload.studies.closed_forms.study:ClosedForms",
    "convergence": "steadyload.studies.convergence.study:Convergence",
    "determinism": "steadyload.studies.determinism.study:Determinism",
    "extremes": "steadyload.studies.extremes.study:Extremes",
    "properties": "steadyload.studies.properties.study:Properties",
    "benchmark": "steadyload.studies.benchmark.study:Benchmark",
    "transport": "steadyload.studies.transport.study:Transport",
    "packers": "steadyload.studies.packers.study:Packers",
    "repair": "steadyload.studies.repair.study:RepairStudy",
    "reality": "steadyload.studies.reality.study:Reality",
    "scale": "steadyload.studies.scale.study:Scale",
}
"""Study -> import path of its declaration, in the order of the index of pages."""


class UnknownStudyError(UserError):
    """No study is registered under a name."""


def studies() -> dict[str, str]:
    """All studies: ours, and then those of other distributions."""
    return STUDIES | {k: v for k, v in _from_other_distributions().items() if k not in STUDIES}


@cache
def _from_other_distributions() -> dict[str, str]:
    found = importlib.metadata.entry_points(group=GROUP)
    return {entry.name: entry.value for entry in found}


def study(name: str) -> AnyStudy:
    """The study with a name.

    Raises:
        UnknownStudyError: no study has this name.
    """
    known = studies()
    if name not in known:
        raise UnknownStudyError(f"unknown study {name!r}; {nearest(name, known)}")
    found = loaded(known[name], GROUP, name)
    if not (isinstance(found, type) and issubclass(found, kit.Study)):
        raise faulty(GROUP, name, f"{known[name]} is no Study")
    return found
