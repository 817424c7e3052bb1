"""Evaluation of tuned presets on cases on which nothing was tuned, for the page of tuning."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.engines.registry import capabilities
from steadyload.layouts.benchmark import PLANAR, Part
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.methods.tuned import TUNED, tuned
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import Evaluation, evaluate
from steadyload.runs.runner import run_study
from steadyload.studies.tuning.summary import (
    PricePoint,
    SeedRow,
    TransferCell,
    TransferTable,
    TunedTable,
    Tuning,
    Variant,
    VariantTable,
    tuning_of,
)
from steadyload.studies.tuning.variants import (
    Change,
    carried_over,
    physical,
    tuned_values,
    without_gains,
)
from steadyload.tuning import TuningError
from steadyload.tuning.cost import GOAL
from steadyload.tuning.ledger import Entry
from steadyload.tuning.presets import by_worth, preset
from steadyload.tuning.search import Search, pareto_front
from steadyload.tuning.trial import fitness

BUDGETS = (1.0, 3.0, 10.0, 30.0)
"""Budgets in the table of prices [ms a layout]."""

PART = Part.TEST
"""Part of the labelled set that is judged once and never used for tuning."""

_SHARD_SIZE = 60

_STOPPED = GOAL.partition(":")[2]
"""Parameters of samples and of a stop at rest, which PS_3 and PS_5 are given like all methods."""

Progress = Callable[[int, int], None]


@dataclass
class _Engine:
    """One engine's part of the study: the specs that are to be judged, by their purpose."""

    name: str
    tuned: str
    others: dict[str, MethodKey]
    left_out: list[Change]
    physical: list[Change]
    carried: dict[str, tuple[str, tuple[str, ...]]]
    seeds: list[tuple[Search, str]]
    prices: list[tuple[float, Entry | None, str]]

    def specs(self) -> list[str]:
        """All specs."""
        changed = [change.spec for change in (*self.left_out, *self.physical)]
        elsewhere = [spec for spec, _ in self.carried.values()]
        priced = [spec for _, _, spec in self.prices if spec]
        seeded = [spec for _, spec in self.seeds]
        return [self.tuned, *self.others, *changed, *elsewhere, *seeded, *priced]


def tuning_study(
    searches: Iterable[Search],
    work: Path,
    *,
    workers: int,
    limit: int | None = None,
    progress: Progress = lambda done, total: None,
) -> Tuning:
    """Compare the tuned presets with others on the test part, and measure the gain of each part.

    2-D engines are judged on the planar set, on which the others are judged, too, where parameters
    are transferred.

    Args:
        searches: finished searches, which gave the presets, fronts and seeds.
        work: folder of the run folders; an interrupted study is resumed.
        workers: processes beside this one.
        limit: largest number of cases a scenario; None for all.
        progress: called with rows done and rows in all, for each labelled set.

    Raises:
        TuningError: none of the searched engines has a preset, or none of its searches found it.
        as :func:`steadyload.runs.runner.run_study`.
    """
    searches = [search for own in by_worth(searches).values() for search in own]
    names = [e for e in dict.fromkeys(s.options.engine for s in searches) if e in tuned()[TUNED]]
    if not names:
        raise TuningError("none of these engines has a preset; steadyload tune --write-preset")
    sets: dict[str | None, list[str]] = {}
    for name in names:
        sets.setdefault(_set_of(name), []).append(name)
    tables = []
    for benchmark, on_it in sets.items():
        others = names if benchmark == PLANAR else on_it
        engines = [_engine(name, searches, others) for name in on_it]
        # 3-D engines take part on the planar set with their own parameters.
        guests = [n for n in others if n not in on_it]
        specs = [spec for engine in engines for spec in engine.specs()]
        specs += [_carried(a, b)[0] for b in guests for a in others]
        evaluation = _evaluated(
            specs,
            work / (benchmark or "shipped"),
            benchmark=benchmark,
            workers=workers,
            limit=limit,
            progress=progress,
        )
        tables.append((benchmark, engines, others, evaluation))
    return _assembled(searches, tables)


def _evaluated(
    specs: Iterable[str],
    directory: Path,
    *,
    benchmark: str | None,
    workers: int,
    limit: int | None,
    progress: Progress,
) -> Evaluation:
    """Evaluation of methods on the test part of a labelled set; an interrupted run is resumed."""
    study = StudyDefinition(
        name="tuning",
        methods=tuple(dict.fromkeys(specs)),
        benchmark=PART,
        benchmark_directory=benchmark,
        limit=limit,
        shard_size=_SHARD_SIZE,
    )
    run_study(study, directory, workers=workers, progress=progress)
    return evaluate(directory, by_scenario=False)


_Judged = tuple[str | None, list[_Engine], list[str], Evaluation]


def _assembled(searches: Sequence[Search], tables: Iterable[_Judged]) -> Tuning:
    tables = list(tables)
    parts = [(engine, found, _part(benchmark)) for benchmark, engines, _, found in tables
             for engine in engines]  # fmt: skip
    return dataclasses.replace(
        tuning_of(searches),
        tests=tuple(_held_against(engine, part, found) for engine, found, part in parts),
        seeds=tuple(row for engine, found, _ in parts for row in _seed_rows(engine, found)),
        left_out=tuple(
            _changed(e, part, found, e.left_out) for e, found, part in parts if e.left_out
        ),
        plausibility=tuple(
            _changed(e, part, found, e.physical) for e, found, part in parts if e.physical
        ),
        transfer=tuple(
            _transfer(_part(benchmark), names, found)
            for benchmark, _, names, found in tables
            if len(names) > 1
        ),
        prices=tuple(row for engine, found, _ in parts for row in _price_rows(engine, found)),
        cost_source=tables[0][3].cost_source,
    )


def _set_of(engine: str) -> str | None:
    return PLANAR if capabilities(engine).dimensions == 2 else None


def canonical_spec(spec: str) -> str:
    """The spec as the rows of a study name it."""
    return str(make_method(spec).spec)


def _part(benchmark: str | None) -> str:
    return f"{PART}, {benchmark}" if benchmark else PART


def _engine(name: str, searches: Sequence[Search], others: Sequence[str]) -> _Engine:
    own = [search for search in searches if search.options.engine == name]
    values = tuned_values(name)
    spec = canonical_spec(f"{TUNED}@{name}")
    main = _finder(name, own)
    rivals = {
        canonical_spec(rival): (title, family)
        for rival, title, family in (
            (f"ps3@{name}:{_STOPPED}", "PS_3, stopped at rest", "ps3"),
            (f"ps5@{name}:{_STOPPED}", "PS_5, stopped at rest", "ps5"),
            (f"ps3@{name}:{_STOPPED},scope=widening", "PS_3, widening scope", "simulation"),
            (f"ps3@{name}", "PS_3, never stopped", "simulation"),
            (
                f"ps_opt-paper@{name}:rest_speed={values['rest_speed']}",
                "PS_opt, paper",
                "ps_opt-paper",
            ),
            (main.space.spec(main.space.start), "start of the search", "label"),
        )
    }
    return _Engine(
        name=name,
        tuned=spec,
        others={
            rival: MethodKey(f"{title} @ {name}", rival, family, name)
            for rival, (title, family) in rivals.items()
        },
        left_out=without_gains(main.space, values),
        physical=physical(name, values),
        carried={other: _carried(other, name) for other in others},
        seeds=apart_by_seeds(own),
        prices=_prices(own),
    )


def _finder(engine: str, searches: Sequence[Search]) -> Search:
    """The search that found the preset of an engine."""
    values = tuned()[TUNED][engine].parameters
    for search in searches:
        if preset(search).parameters == values:
            return search
    raise TuningError(f"none of these searches found {TUNED}@{engine}; name the folder of the one")


def _carried(here: str, there: str) -> tuple[str, tuple[str, ...]]:
    """Spec on one engine of the parameters tuned on another, and those without effect there."""
    if here == there:
        return canonical_spec(f"{TUNED}@{here}"), ()
    return carried_over(tuned_values(here), there)


def apart_by_seeds(searches: Sequence[Search]) -> list[tuple[Search, str]]:
    """Searches that differ in their seed alone; empty where there are none.

    Of several such groups, the one that begins with the fewest known genotypes, since these would
    be found again with any seed.
    """
    kinds: dict[tuple[Any, ...], list[Search]] = {}
    for search in searches:
        o = search.options
        kinds.setdefault((o.algorithm, o.space, o.population, o.begin_with), []).append(search)
    several = [kind for kind in kinds.values() if len(kind) > 1]
    alike = min(several, key=lambda kind: len(kind[0].options.begin_with), default=[])
    alike.sort(key=lambda s: s.options.seed)
    return [(s, canonical_spec(s.space.spec(s.fittest().genotype))) for s in alike]


def _prices(searches: Sequence[Search]) -> list[tuple[float, Entry | None, str]]:
    """By budget the most accurate genotype of all searches that costs no more, and its spec."""
    finders = {id(entry): search for search in searches for entry in search.whole()}
    front = pareto_front([entry for search in searches for entry in search.whole()])
    found: list[tuple[float, Entry | None, str]] = []
    for budget in BUDGETS:
        best = max(
            (e for e in front if e.trial.mean_cost <= budget),
            key=lambda e: e.trial.mean_cost,
            default=None,
        )
        spec = canonical_spec(finders[id(best)].space.spec(best.genotype)) if best else ""
        found.append((budget, best, spec))
    return found


def _held_against(engine: _Engine, part: str, found: Evaluation) -> TunedTable:
    return TunedTable(
        engine=engine.name,
        part=part,
        tuned=found.row(engine.tuned),
        others=tuple(
            found.row(spec, against=engine.tuned, key=key) for spec, key in engine.others.items()
        ),
    )


def _changed(
    engine: _Engine, part: str, found: Evaluation, changes: Sequence[Change]
) -> VariantTable:
    return VariantTable(
        engine.name,
        part,
        tuple(
            Variant(
                change=change.name,
                values=change.values,
                found=found.row(change.spec),
                accuracy_change=found.difference(change.spec, engine.tuned),
                cost_change=found.cost_ratio(change.spec, engine.tuned).value,
            )
            for change in changes
        ),
    )


def _transfer(part: str, names: Sequence[str], found: Evaluation) -> TransferTable:
    cells, ignored = [], {}
    for there in names:
        own, _ = _carried(there, there)
        for here in names:
            spec, lost = _carried(here, there)
            ignored[here, there] = lost
            against = None if here == there else own
            key = dataclasses.replace(
                method_key(make_method(f"{TUNED}@{here}")), title=f"PS_opt of {here} @ {there}"
            )
            cells.append(TransferCell(here, there, found.row(spec, against=against, key=key)))
    return TransferTable(part, tuple(names), tuple(cells), ignored)


def _seed_rows(engine: _Engine, found: Evaluation) -> list[SeedRow]:
    rows = []
    for search, spec in engine.seeds:
        best = search.fittest()
        values: Mapping[str, object] = search.space.values(best.genotype)
        rows.append(
            SeedRow(
                engine.name,
                search.options.seed,
                fitness(best.trial, search.goal),
                best.trial.accuracy,
                found.row(spec),
                {name: f"{value}" for name, value in values.items()},
            )
        )
    return rows


def _price_rows(engine: _Engine, found: Evaluation) -> list[PricePoint]:
    rows = []
    for budget, entry, spec in engine.prices:
        if entry is None:
            rows.append(PricePoint(engine.name, budget, "", 0.0, None))
            continue
        values = spec.partition(":")[2]
        key = MethodKey(f"{budget:g} ms @ {engine.name}", spec, "simulation", engine.name)
        rows.append(
            PricePoint(engine.name, budget, values, entry.trial.accuracy, found.row(spec, key=key))
        )
    return rows
