"""Plans of packers that fail by their labels, changed in every way and judged by others."""

from __future__ import annotations

import zlib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import pandas as pd

from steadyload.app.check_defaults import default_method
from steadyload.labelling.close_steps import StepVerdicts
from steadyload.labelling.label_rows import LABEL
from steadyload.layouts.benchmark.dataset import Benchmark
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.scenarios import Scenario
from steadyload.layouts.packers.packed import PackerNotInstalledError
from steadyload.layouts.sizes import MOST_SMALL
from steadyload.methods.registry import make_method
from steadyload.studies.kit import Lab
from steadyload.studies.packed_plans import plans_of
from steadyload.studies.repair.confirming import (
    ENGINES,
    REFERENCES,
    Firmness,
    Judged,
    engine_units,
    firmness_units,
    judged,
    reference_units,
)
from steadyload.studies.repair.ways import Changed, ChangeUnit, Way, rests_on

SEARCH_SECONDS = 10.0
"""CPU time that a search may take."""

OF_LARGE = 3.0
"""Times the CPU time that a search on a plan of more than :data:`.MOST_SMALL` boxes may take."""

ONE_IN = 3
"""Of so many failing plans one has a control."""


@dataclass(frozen=True)
class Plan:
    """A plan with a label, its published instance, and titles of the packers that found it."""

    layout: Layout
    instance: str
    packers: tuple[str, ...]


@dataclass(frozen=True)
class Tried:
    """A plan as it was, and the outcome of a way of changing it."""

    plan: Plan
    way: Way
    changed: Changed


@dataclass(frozen=True)
class Answers:
    """Answers of independent judges, by title, on a plan that was repaired, or is a control.

    ``references`` has those that have come.
    """

    plan: Plan
    repaired: bool
    firmness: Firmness
    engines: Mapping[str, Judged]
    references: Mapping[str, Judged]


@dataclass(frozen=True)
class AllTried:
    """All plans in all ways.

    ``labelled``: plans with a label. ``tried``: from the smallest plan on. ``answers``: on plans
    repaired with boxes left out where that helps, and on controls. ``not_installed``: why a packer
    does not pack again; empty where it does.
    """

    labelled: int
    tried: Sequence[Tried]
    answers: Sequence[Answers]
    not_installed: str
    made_with: Mapping[str, str]


def plans_by_label(benchmark: Benchmark) -> tuple[list[Plan], list[Plan], int]:
    """Plans of S1 that fail, those that stand, the smallest first, and how many have a label."""
    plans = plans_of(benchmark)
    main = plans[(plans["scenario"] == str(Scenario.S1)) & plans["is_known"]]
    fails = (main["settled"] & ~main["stands"]) | (main["labelled"] & ~main["within"])
    stands = main["settled"] & main["stands"] & main["labelled"] & main["within"]
    failing, standing = (_plans(benchmark, main[chosen]) for chosen in (fails, stands))
    return failing, standing, main["layout"].nunique()


def _plans(benchmark: Benchmark, rows: pd.DataFrame) -> list[Plan]:
    rows = rows.sort_values(["items", "layout"], kind="stable")
    return [
        Plan(
            benchmark.layout(str(name), str(Scenario.S1)),
            str(own["instance"].iloc[0]),
            tuple(own["packer"]),
        )
        for name, own in rows.groupby("layout", sort=False)
    ]


def controls(failing: Sequence[Plan], standing: Sequence[Plan]) -> list[Plan]:
    """Plans that stand, of the packers and about the sizes of those that fail, each once.

    Args:
        failing: the smallest first; of these every :data:`ONE_IN` has a control.
        standing: to choose from.
    """
    packers = {packer for plan in failing for packer in plan.packers}
    left = [plan for plan in standing if packers.intersection(plan.packers)]
    left.sort(key=lambda plan: zlib.crc32(plan.layout.name.encode()))
    chosen = []
    for plan in failing[::ONE_IN]:
        if left:
            nearest = min(left, key=lambda one: abs(len(one.layout) - len(plan.layout)))
            left.remove(nearest)
            chosen.append(nearest)
    return chosen


def try_all(
    lab: Lab, benchmark: Benchmark, *, limit: int | None = None, reference: bool = False
) -> AllTried:
    """Change all failing plans in all ways, as far as that is missing, and judge what comes of it.

    Args:
        lab: what was measured in its folder is not measured again.
        benchmark: a labelled set of real size.
        limit: plans at most, the smallest ones; None for all.
        reference: have the references judge what they have not come to; else only what they have
            judged counts.
    """
    if reference:
        make_method(LABEL).prepare()
    failing, standing, labelled = plans_by_label(benchmark)
    failing = failing[:limit]
    ways, not_installed = list(Way), ""
    try:
        rests_on(Way.AGAIN, default_method(1))
    except PackerNotInstalledError as error:
        ways.remove(Way.AGAIN)
        not_installed = str(error)
    judges = [default_method(len(plan.layout)) for plan in failing]
    made = {(way, judge): rests_on(way, judge) for way in ways for judge in dict.fromkeys(judges)}
    asked = [
        (plan, way, ChangeUnit(plan.layout, str(way), judge, limit_, made[way, judge]))
        for plan, judge in zip(failing, judges, strict=True)
        for limit_ in [SEARCH_SECONDS * (OF_LARGE if len(plan.layout) > MOST_SMALL else 1.0)]
        for way in ways
    ]
    changed, made_with = lab.measure([unit for *_, unit in asked], Changed, folder="changed")
    tried = [Tried(plan, way, row) for (plan, way, _), row in zip(asked, changed, strict=True)]
    repaired = [
        replace(one.plan, layout=one.changed.layout(one.plan.layout.pallet))
        for one in tried
        if one.way is Way.LEAVE and one.changed.stands
    ]
    answers = [
        *_answers(lab, repaired, True, reference),
        *_answers(lab, controls(failing, standing), False, reference),
    ]
    return AllTried(labelled, tried, answers, not_installed, made_with)


def _answers(lab: Lab, plans: Sequence[Plan], repaired: bool, reference: bool) -> list[Answers]:
    """Of all judges on plans."""
    if not plans:
        return []
    layouts = [plan.layout for plan in plans]
    firmness = lab.measure(
        firmness_units(layouts), Firmness, folder="firmness", parallel=True
    ).rows  # fmt: skip
    said = lab.measure(engine_units(layouts), Judged, folder="engines", parallel=True).rows
    units = reference_units(layouts, firmness)
    if reference:
        lab.measure(units, StepVerdicts, folder="references", parallel=True)
    so_far = lab.so_far(units, StepVerdicts, folder="references")
    known = [None if steps is None else judged(steps) for steps in so_far]
    return [
        Answers(
            plan, repaired, firmness[place], _by_title(ENGINES, said, place),
            _by_title(REFERENCES, known, place),
        )
        for place, plan in enumerate(plans)
    ]  # fmt: skip


def _by_title(
    titles: Collection[str], said: Sequence[Judged | None], place: int
) -> dict[str, Judged]:
    """Answers of all judges on the plan at a place, without those that have not come to it."""
    own = said[place * len(titles) : (place + 1) * len(titles)]
    return {title: one for title, one in zip(titles, own, strict=True) if one is not None}
