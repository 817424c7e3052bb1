"""Layouts of all families, judged by methods and by the simulation that gives the labels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from steadyload.atomic import without_link
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.packing.families import FAMILIES, family_layouts
from steadyload.methods.registry import make_method
from steadyload.methods.tuned import TUNED, tuned_engines
from steadyload.runs.able import able_methods
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.judged import JudgedCases, load_judged
from steadyload.runs.runner import run_study
from steadyload.studies.kit import Lab

LABEL = "label@reference"
"""The method whose verdicts are the labels."""

AGAINST = "equilibrium:time=0.3"
"""The method that all others are compared with: the most accurate one that simulates nothing."""

_RULES = ("fbs", "sme", "equilibrium", AGAINST)
_LEARNED = ("lstm_e", "lstm_e:outside=accept")
_CASCADES = ("cascade@rapier", "cascade@mujoco")

LAYOUTS, SEED = 120, 2
"""Layouts of every family, and their seed."""

_TURN = 10
"""Layouts a unit of work."""


class FamilyCases(NamedTuple):
    """Cases that every method has judged.

    Attributes:
        judged: verdicts of the methods and of :data:`LABEL`.
        families: name of the family of every layout.
        left_out: usual methods that cannot judge here, with the reasons.
        layouts: of every family.
    """

    judged: JudgedCases
    families: Mapping[str, str]
    left_out: Mapping[str, str]
    layouts: int


def usual_methods() -> tuple[str, ...]:
    """Specs of rules, networks, cascades and tuned simulations, which the page compares."""
    return (*_RULES, *_LEARNED, *_CASCADES, *(f"{TUNED}@{name}" for name in tuned_engines()))


def judge_families(lab: Lab, limit: int | None, methods: Sequence[str]) -> FamilyCases:
    """Judge layouts of all families, as far as that is missing.

    Families take turns, so that a run of more layouts goes on where one of fewer ended.
    """
    able, left_out = able_methods(tuple(methods), usual_methods)
    fixed = [make_method(spec) for spec in (LABEL, AGAINST)]
    for method in fixed:
        method.prepare()
    label, against = (str(method.spec) for method in fixed)
    layouts = limit or LAYOUTS
    made = {name: family_layouts(name, layouts, SEED) for name in FAMILIES}
    turns = [own for of_all in zip(*made.values(), strict=True) for own in of_all]
    lab.work.mkdir(parents=True, exist_ok=True)
    file = lab.work / "families.layouts"
    write_layouts(without_link(file), turns, Format.NATIVE)
    definition = StudyDefinition(
        "families",
        tuple(dict.fromkeys((label, against, *able))),
        files=(file.resolve(),),
        shard_size=_TURN,
    )
    run = lab.work / "run"
    run_study(
        definition, run, workers=lab.workers, progress=lambda *of: lab.progress("judging", *of)
    )
    families = {own.name: name for name, of_family in made.items() for own in of_family}
    return FamilyCases(load_judged(run), families, left_out, layouts)
