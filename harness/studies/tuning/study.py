"""Evaluation of tuned presets on cases on which nothing was tuned, for the page of tuning."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.engines.registry import capabilities
from steadyload.layouts.benchmark import PLANAR, Part
from steadyload.layouts.model.question import Question
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.registry import make_method
from steadyload.methods.tuned import TUNED, tuned
from steadyload.progress import Progress, silent
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import Evaluation, evaluate
from steadyload.runs.runner import run_study
from steadyload.studies.tuning.summary import (
    KnowledgeStep,
    KnowledgeTable,
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
from steadyload.tuning.space import PAPERS, space_on
from steadyload.tuning.trial import fitness

BUDGETS = (1.0, 3.0, 10.0, 30.0)
"""Budgets in the table of prices [ms a layout]."""

PART = Part.TEST
"""Part of the labelled set that is judged once and never used for tuning."""

_SHARD_SIZE = 60

_STOPPED = GOAL.partition(":")[2]
"""Parameters of samples and of a stop at rest, which PS_3 and PS_5 are given like all methods."""


@dataclass(frozen=True)
class _Engine:
    """One engine's part of the study: the specs that are to be judged, by their purpose."""

    name: str
    tuned: str
    others: dict[str, MethodKey]
    steps: list[tuple[str, str]]
    left_out: list[Change]
    physical: list[Change]
    seeds: list[tuple[Search, str]]
    prices: list[tuple[float, Entry | None, str]]

    def specs(self) -> list[str]:
        """All specs."""
        changed = [change.spec for change in (*self.left_out, *self.physical)]
        priced = [spec for _, _, spec in self.prices if spec]
        seeded = [spec for _, spec in self.seeds]
        stepped = [spec for _, spec in self.steps]
        return [self.tuned, *self.others, *stepped, *changed, *seeded, *priced]


@dataclass(frozen=True)
class _Judged:
    """An evaluation on one labelled set: of engines with their specs, and of pairs of engines."""

    part: str
    engines: list[_Engine]
    transferred: list[str]
    found: Evaluation


def tuning_study(
    searches: Iterable[Search],
    work: Path,
    *,
    workers: int,
    limit: int | None = None,
    progress: Progress = silent,
) -> Tuning:
    """Compare the tuned presets with others on the test part, and measure the gain of each part.

    2-D engines are judged on the planar set, on which the others are judged, too, where parameters
    are transferred.

    Args:
        searches: finished searches, which gave the presets, fronts and seeds; those for another
            question than that of the label are left out.
        work: folder of the run folders; an interrupted study is resumed.
        workers: processes beside this one.
        limit: largest number of cases a scenario; None for all.
        progress: called with rows done and rows in all, for each labelled set.

    Raises:
        TuningError: all searches are for another question than that of the label, none of the
            searched engines has a preset, or none of its searches found it.
        as :func:`steadyload.runs.runner.run_study`.
    """
    asked = [s for s in searches if s.options.source.question == Question.WITHIN]
    if not asked:
        raise TuningError(
            f"none of the searches is for the question {Question.WITHIN}, by whose labels the page "
            "compares presets; those for another question are left out"
        )
    searches = [search for own in by_worth(asked).values() for search in own]
    names = [e for e in dict.fromkeys(s.options.engine for s in searches) if e in tuned()[TUNED]]
    if not names:
        raise TuningError("none of these engines has a preset; steadyload tune --write-preset")
    sets: dict[str | None, list[str]] = {}
    for name in names:
        planar = capabilities(name).dimensions == 2
        sets.setdefault(PLANAR if planar else None, []).append(name)
    judged = []
    for benchmark, on_it in sets.items():
        engines = [
            _engine(name, [s for s in searches if s.options.engine == name]) for name in on_it
        ]
        # 3-D engines take part on the planar set with their own parameters.
        pairs = names if benchmark == PLANAR else on_it
        specs = [spec for engine in engines for spec in engine.specs()]
        specs += [_carried(here, there)[0] for there in pairs for here in pairs]
        study = StudyDefinition(
            name="tuning",
            methods=tuple(dict.fromkeys(specs)),
            benchmark=PART,
            benchmark_directory=benchmark,
            limit=limit,
            shard_size=_SHARD_SIZE,
        )
        folder = work / (benchmark or "shipped")
        run_study(study, folder, workers=workers, progress=progress)
        part = f"{PART}, {benchmark}" if benchmark else PART
        judged.append(_Judged(part, engines, pairs, evaluate(folder, by_scenario=False)))
    return _assembled([*_finders_first(names, searches)], judged)


def _assembled(searches: Sequence[Search], judged: Sequence[_Judged]) -> Tuning:
    own = [(engine, each.part, each.found) for each in judged for engine in each.engines]
    return dataclasses.replace(
        tuning_of(searches),
        tests=tuple(_tested(engine, part, found) for engine, part, found in own),
        knowledge=tuple(_knowledge(engine, part, found) for engine, part, found in own),
        seeds=tuple(row for engine, _, found in own for row in _seed_rows(engine, found)),
        left_out=tuple(
            _changed(e, e.left_out, part, found) for e, part, found in own if e.left_out
        ),
        plausibility=tuple(
            _changed(e, e.physical, part, found) for e, part, found in own if e.physical
        ),
        transfer=tuple(_transfer(each) for each in judged if len(each.transferred) > 1),
        prices=tuple(row for engine, _, found in own for row in _price_rows(engine, found)),
        cost_source=judged[0].found.cost_source,
    )


def canonical_spec(spec: str) -> str:
    """The spec as the rows of a study name it."""
    return str(make_method(spec).spec)


def _engine(name: str, searches: Sequence[Search]) -> _Engine:
    """The specs of an engine, from its own searches."""
    values, main = tuned_values(name), _finder(name, searches)
    return _Engine(
        name=name,
        tuned=canonical_spec(f"{TUNED}@{name}"),
        others=_others(name, values, main),
        steps=_steps(name, searches, main),
        left_out=without_gains(main.space, values),
        physical=physical(name, values),
        seeds=apart_by_seeds(searches),
        prices=_prices(searches),
    )


def _others(name: str, values: Mapping[str, Any], main: Search) -> dict[str, MethodKey]:
    """The methods with which the tuned one is compared, by spec."""
    others = {}
    for spec, title, family in (
        (f"ps3@{name}:{_STOPPED}", "PS_3, stopped at rest", "ps3"),
        (f"ps5@{name}:{_STOPPED}", "PS_5, stopped at rest", "ps5"),
        (f"ps3@{name}:{_STOPPED},scope=widening", "PS_3, widening scope", "simulation"),
        (f"ps3@{name}", "PS_3, never stopped", "simulation"),
        (f"ps_opt-paper@{name}:rest_speed={values['rest_speed']}", "PS_opt, paper", "ps_opt-paper"),
        (main.space.spec(main.space.start), "start of the search", "label"),
    ):
        known = canonical_spec(spec)
        others[known] = MethodKey(f"{title} @ {name}", known, family, name)
    return others


def _steps(name: str, searches: Sequence[Search], main: Search) -> list[tuple[str, str]]:
    """Titles and specs from the paper's values to the tuned ones."""
    papers = space_on(name, PAPERS)
    over_them = [search for search in searches if search.options.space == PAPERS]
    steps = [
        ("the paper's protocol and values", papers.spec(papers.start)),
        *(
            (f"its protocol, {_effort(best)}", papers.spec(best.fittest().genotype))
            for best in over_them[:1]
        ),
        ("the label's protocol, nothing searched", main.space.spec(main.space.start)),
        (f"that protocol and how the engine is used, {_effort(main)}", f"{TUNED}@{name}"),
    ]
    return [(title, canonical_spec(spec)) for title, spec in steps]


def _effort(search: Search) -> str:
    return f"best of {len(search.judged())} searched"


def _finder(engine: str, searches: Sequence[Search]) -> Search:
    """The search that found the preset of an engine."""
    values = tuned()[TUNED][engine].parameters
    for search in searches:
        if preset(search).parameters == values:
            return search
    raise TuningError(f"none of these searches found {TUNED}@{engine}; name the folder of the one")


def _finders_first(names: Sequence[str], searches: Sequence[Search]) -> Iterator[Search]:
    """Searches by engine, of each first the one that found its preset."""
    for name in names:
        own = [search for search in searches if search.options.engine == name]
        finder = _finder(name, own)
        yield finder
        yield from (search for search in own if search is not finder)


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


def _tested(engine: _Engine, part: str, found: Evaluation) -> TunedTable:
    others = (found.row(s, against=engine.tuned, key=key) for s, key in engine.others.items())
    return TunedTable(engine.name, part, found.row(engine.tuned), tuple(others))


def _knowledge(engine: _Engine, part: str, found: Evaluation) -> KnowledgeTable:
    before = [None, *(spec for _, spec in engine.steps)]
    return KnowledgeTable(
        engine.name,
        part,
        tuple(
            KnowledgeStep(
                title, found.row(spec), None if last is None else found.difference(spec, last)
            )
            for (title, spec), last in zip(engine.steps, before, strict=False)
        ),
    )


def _changed(
    engine: _Engine, changes: Sequence[Change], part: str, found: Evaluation
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


def _transfer(judged: _Judged) -> TransferTable:
    names, cells, ignored = judged.transferred, [], {}
    for there in names:
        own, _ = _carried(there, there)
        for here in names:
            spec, ignored[here, there] = _carried(here, there)
            key = dataclasses.replace(
                method_key(make_method(f"{TUNED}@{here}")), title=f"PS_opt of {here} @ {there}"
            )
            row = judged.found.row(spec, against=None if here == there else own, key=key)
            cells.append(TransferCell(here, there, row))
    return TransferTable(judged.part, tuple(names), tuple(cells), ignored)


def _seed_rows(engine: _Engine, found: Evaluation) -> Iterator[SeedRow]:
    for search, spec in engine.seeds:
        best = search.fittest()
        yield SeedRow(
            engine=engine.name,
            seed=search.options.seed,
            fitness=fitness(best.trial, search.goal),
            validation=best.trial.accuracy,
            test=found.row(spec),
            values={name: f"{v}" for name, v in search.space.values(best.genotype).items()},
        )


def _price_rows(engine: _Engine, found: Evaluation) -> Iterator[PricePoint]:
    for budget, entry, spec in engine.prices:
        if entry is None:
            yield PricePoint(engine.name, budget, "", 0.0, None)
            continue
        key = MethodKey(f"{budget:g} ms @ {engine.name}", spec, "simulation", engine.name)
        test = found.row(spec, key=key)
        yield PricePoint(engine.name, budget, spec.partition(":")[2], entry.trial.accuracy, test)
