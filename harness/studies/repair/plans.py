"""Plans of packers that fail by their labels, changed in every way and judged by others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from steadyload.app.check_defaults import default_method
from steadyload.layouts.benchmark.dataset import Benchmark
from steadyload.layouts.benchmark.tables import BenchmarkError
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.scenarios import Scenario
from steadyload.layouts.packers.packed import PackerNotInstalledError
from steadyload.layouts.sizes import MOST_SMALL
from steadyload.studies.kit import Lab
from steadyload.studies.packed_plans import plans_of
from steadyload.studies.repair.confirming import (
    ENGINES,
    Labelled,
    Stands,
    engine_units,
    label_units,
)
from steadyload.studies.repair.ways import Changed, ChangeUnit, Way, rests_on

OF_LARGE = 3.0
"""Times the CPU time that a search on a plan of more than :data:`.MOST_SMALL` boxes may take."""


@dataclass(frozen=True)
class Failing:
    """A plan that fails by the label of at least one question.

    Attributes:
        layout: the plan, centres of mass in the middle of its boxes.
        instance: published instance of its item list.
        packers: titles of those that found it.
    """

    layout: Layout
    instance: str
    packers: tuple[str, ...]


@dataclass(frozen=True)
class Tried:
    """A plan, changed in a way, and what others say of that.

    Attributes:
        plan: as it was.
        way: of changing it.
        changed: the outcome.
        engines: verdicts by title of the engine; empty where the judge confirms none.
        label: None where the judge confirms none, or the reference has not come to it.
    """

    plan: Failing
    way: Way
    changed: Changed
    engines: Mapping[str, Stands] = field(default_factory=dict)
    label: Labelled | None = None


@dataclass(frozen=True)
class AllTried:
    """All plans in all ways.

    Attributes:
        labelled: plans with a label, of which some fail.
        tried: plan by plan, from the smallest one on.
        not_installed: why a packer does not pack again; empty where it does.
        made_with: provenance of the changed plans.
    """

    labelled: int
    tried: Sequence[Tried]
    not_installed: str
    made_with: Mapping[str, str]


def failing_plans(benchmark: Benchmark) -> tuple[list[Failing], int]:
    """Plans of scenario S1 that fail, the smallest first, and how many have a label.

    Raises:
        BenchmarkError: none fails.
    """
    plans = plans_of(benchmark)
    main = plans[(plans["scenario"] == str(Scenario.S1)) & plans["is_known"]]
    fails = (main["settled"] & ~main["stands"]) | (main["labelled"] & ~main["within"])
    failing = main[fails].sort_values(["items", "layout"], kind="stable")
    if failing.empty:
        raise BenchmarkError(
            "no plan of a packer in this set fails by its label; allowed: a set of benchmark "
            "build-real that is labelled, at least in part"
        )
    found = [
        Failing(
            benchmark.layout(str(name), str(Scenario.S1)),
            str(own["instance"].iloc[0]),
            tuple(own["packer"]),
        )
        for name, own in failing.groupby("layout", sort=False)
    ]
    return found, main["layout"].nunique()


def try_all(
    lab: Lab, benchmark: Benchmark, *, seconds: float, limit: int | None, reference: bool
) -> AllTried:
    """Change all failing plans in all ways, as far as that is missing, and judge what comes of it.

    Args:
        lab: what was measured in its folder is not measured again.
        benchmark: a labelled set of real size.
        seconds: CPU time that a search may take; :data:`OF_LARGE` times it for a large plan.
        limit: plans at most, the smallest ones; None for all.
        reference: label the changed plans that have no label yet; else only those count that have.

    Raises:
        BenchmarkError: no plan fails.
        ResultsError: another run is at work in the folder.
    """
    failing, labelled = failing_plans(benchmark)
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
        for limit_ in [seconds * (OF_LARGE if len(plan.layout) > MOST_SMALL else 1.0)]
        for way in ways
    ]
    changed, made_with = lab.measure([unit for *_, unit in asked], Changed, folder="changed")
    tried = [Tried(plan, way, row) for (plan, way, _), row in zip(asked, changed, strict=True)]
    return AllTried(labelled, list(_confirmed(lab, tried, reference)), not_installed, made_with)


def _confirmed(lab: Lab, tried: Sequence[Tried], reference: bool) -> Iterator[Tried]:
    """Each of these, with the verdicts of others."""
    layouts = {
        place: one.changed.layout(one.plan.layout.pallet)
        for place, one in enumerate(tried)
        if one.changed.stands
    }
    engines = engine_units(list(layouts.values()))
    said = lab.measure(engines, Stands, folder="engines", parallel=True).rows if engines else []
    titles = {spec: title for title, spec in ENGINES.items()}
    verdicts: dict[int, dict[str, Stands]] = {}
    for place, unit, verdict in zip([*layouts] * len(ENGINES), engines, said, strict=True):
        verdicts.setdefault(place, {})[titles[unit.method]] = verdict
    labels = _labels(lab, layouts, [one.way for one in tried], reference)
    for place, one in enumerate(tried):
        yield Tried(one.plan, one.way, one.changed, verdicts.get(place, {}), labels.get(place))


def _labels(
    lab: Lab, layouts: Mapping[int, Layout], ways: Sequence[Way], reference: bool
) -> dict[int, Labelled]:
    """Labels of changed plans by their places, those that are there or are made now, by way."""
    units = dict(zip(layouts, label_units(list(layouts.values())), strict=True))
    if reference and units:
        ordered = [units[place] for way in Way for place in units if ways[place] is way]
        lab.measure(ordered, Labelled, folder="labels", parallel=True)
    found = lab.so_far(list(units.values()), Labelled, folder="labels")
    return {place: one for place, one in zip(units, found, strict=True) if one is not None}
