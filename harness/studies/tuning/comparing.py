"""Tuned presets compared with other methods, on cases on which nothing was tuned.

Shares are 0 to 1, times in ms a layout.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from steadyload.engines.registry import capabilities
from steadyload.layouts.benchmark import PLANAR, Part, load_benchmark
from steadyload.layouts.model.question import Question
from steadyload.methods.naming import MethodKey
from steadyload.methods.registry import make_method
from steadyload.methods.tuned import TUNED, tuned
from steadyload.runs.evaluation import Evaluation
from steadyload.runs.labels import Cases
from steadyload.runs.provenance import provenance_lines
from steadyload.studies.kit import Lab
from steadyload.studies.tuning.presets import (
    BUDGETS,
    START,
    Bought,
    Carried,
    Cell,
    Found,
    Luck,
    OnPart,
    Seed,
    Step,
    Tested,
    Transfer,
    Variant,
)
from steadyload.studies.tuning.searching import of_searches, points, spread
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

_SHARD_SIZE = 60

_STOPPED = GOAL.partition(":")[2]
"""Parameters of samples and of a stop at rest, which PS_3 and PS_5 are given like all methods."""


def compare(lab: Lab, searches: Iterable[Search], limit: int | None = None) -> Found:
    """Compare the tuned presets with others on the test part, and measure the gain of each part.

    2-D engines are judged on the planar set, on which the others are judged, too, where parameters
    are transferred.

    Args:
        lab: where it runs; an interrupted study is resumed.
        searches: finished ones, which gave the presets, fronts and seeds; those for another
            question than that of the label are left out.
        limit: largest number of cases a scenario; None for all.

    Raises:
        TuningError: all searches are for another question than that of the label, none of the
            searched engines has a preset, or none of its searches found it.
        as :meth:`steadyload.studies.kit.Lab.judge`.
    """
    asked = [s for s in searches if s.options.source.question == Question.WITHIN]
    if not asked:
        raise TuningError(
            f"none of the searches is for the question {Question.WITHIN}, by whose labels the page "
            "compares presets; those for another question are left out"
        )
    by_engine = {
        engine: own for (engine, _), own in by_worth(asked).items() if engine in tuned()[TUNED]
    }
    if not by_engine:
        raise TuningError("none of these engines has a preset; steadyload tune --write-preset")
    plans = {engine: _plan(engine, own) for engine, own in by_engine.items()}
    sets: dict[str | None, list[str]] = {}
    for engine in plans:
        planar = capabilities(engine).dimensions == 2
        sets.setdefault(PLANAR if planar else None, []).append(engine)
    parts, costs = [], ""
    for benchmark, engines in sets.items():
        # 3-D engines take part on the planar set with their own parameters.
        pairs = list(plans) if benchmark == PLANAR else engines
        specs = [spec for engine in engines for spec in plans[engine].specs]
        specs += [_carried(here, there)[0] for there in pairs for here in pairs]
        found = lab.judge(
            list(dict.fromkeys(specs)),
            Cases(load_benchmark(benchmark), Part.TEST, limit=limit),
            folder=benchmark or "shipped",
            name="tuning",
            shard_size=_SHARD_SIZE,
        )
        part = f"{Part.TEST}, {benchmark}" if benchmark else str(Part.TEST)
        tested = [_tested(plans[engine], found) for engine in engines]
        transfer = Transfer(part, _transferred(pairs, found)) if len(pairs) > 1 else None
        parts.append(OnPart(part, tested, transfer))
        costs = costs or found.cost_source.explained()
    # Of each engine the one that found its preset first.
    ordered = [s for engine, plan in plans.items() for s in (plan.finder, *by_engine[engine])]
    return Found(
        **of_searches(list(dict.fromkeys(ordered))),
        parts=parts,
        costs_explained=costs,
        made_with=provenance_lines(),
    )


class _Plan(NamedTuple):
    """The specs that are to be judged on one engine, by their purpose."""

    engine: str
    finder: Search
    tuned: str
    others: Mapping[str, MethodKey]
    steps: Mapping[str, str]
    left_out: Sequence[Change]
    physical: Sequence[Change]
    seeds: Sequence[tuple[Search, str]]
    front: Sequence[Entry]
    bought: Mapping[float, tuple[Entry, str] | None]

    @property
    def specs(self) -> list[str]:
        """All of them."""
        changed = [change.spec for change in (*self.left_out, *self.physical)]
        seeded = [spec for _, spec in self.seeds]
        bought = [found[1] for found in self.bought.values() if found]
        return [self.tuned, *self.others, *self.steps.values(), *changed, *seeded, *bought]


def _plan(engine: str, searches: Sequence[Search]) -> _Plan:
    stored, values = tuned()[TUNED][engine].parameters, tuned_values(engine)
    finder = next((s for s in searches if preset(s).parameters == stored), None)
    if finder is None:
        raise TuningError(
            f"none of these searches found {TUNED}@{engine}; name the folder of the one"
        )
    space, front = finder.space, pareto_front([e for s in searches for e in s.whole()])
    return _Plan(
        engine,
        finder,
        _spec(f"{TUNED}@{engine}"),
        _others(engine, values, space.spec(space.start)),
        _steps(engine, searches, finder),
        without_gains(space, values),
        physical(engine, values),
        apart_by_seeds(searches),
        front,
        _within_budgets(searches, front),
    )


def _spec(spec: str) -> str:
    """The spec as the rows of a study name it."""
    return str(make_method(spec).spec)


def _others(engine: str, values: Mapping[str, Any], start: str) -> dict[str, MethodKey]:
    """The methods with which the tuned one is compared, by spec."""
    known = (
        (f"ps3@{engine}:{_STOPPED}", "PS_3, stopped at rest", "ps3"),
        (f"ps5@{engine}:{_STOPPED}", "PS_5, stopped at rest", "ps5"),
        (f"ps3@{engine}:{_STOPPED},scope=widening", "PS_3, widening scope", "simulation"),
        (f"ps3@{engine}", "PS_3, never stopped", "simulation"),
        (f"ps_opt-paper@{engine}:rest_speed={values['rest_speed']}", "PS_opt, paper",
         "ps_opt-paper"),
        (start, "start of the search", START),
    )  # fmt: skip
    return {
        (own := _spec(spec)): MethodKey(f"{title} @ {engine}", own, family, engine)
        for spec, title, family in known
    }


def _steps(engine: str, searches: Sequence[Search], finder: Search) -> dict[str, str]:
    """Specs from the paper's values to the tuned ones, by title."""
    papers = space_on(engine, PAPERS)
    steps = {"the paper's protocol and values": papers.spec(papers.start)}
    best = next((search for search in searches if search.options.space == PAPERS), None)
    if best is not None:
        steps[f"its protocol, {_effort(best)}"] = papers.spec(best.fittest().genotype)
    steps["the label's protocol, nothing searched"] = finder.space.spec(finder.space.start)
    steps[f"that protocol and how the engine is used, {_effort(finder)}"] = f"{TUNED}@{engine}"
    return {title: _spec(spec) for title, spec in steps.items()}


def _effort(search: Search) -> str:
    return f"best of {len(search.judged())} searched"


def apart_by_seeds(searches: Sequence[Search]) -> list[tuple[Search, str]]:
    """Searches that differ in their seed alone, with the spec of the best; empty without any.

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
    return [(s, _spec(s.space.spec(s.fittest().genotype))) for s in alike]


def _within_budgets(
    searches: Sequence[Search], front: Sequence[Entry]
) -> dict[float, tuple[Entry, str] | None]:
    """By budget the most accurate genotype of all searches that costs no more, and its spec."""
    spaces = {id(entry): search.space for search in searches for entry in search.whole()}
    found: dict[float, tuple[Entry, str] | None] = dict.fromkeys(BUDGETS)
    for budget in BUDGETS:
        cheap = [entry for entry in front if entry.trial.mean_cost <= budget]
        best = cheap[-1] if cheap else None
        if best is not None:
            found[budget] = best, _spec(spaces[id(best)].spec(best.genotype))
    return found


def _tested(plan: _Plan, found: Evaluation) -> Tested:
    """Results on an engine."""
    engine, own = plan.engine, plan.tuned
    steps, before = [], ""
    for title, spec in plan.steps.items():
        row = found.row(spec)
        gain = found.difference(spec, before) if before else None
        steps.append(Step(title, row.accuracy.n, row.accuracy, gain, row.cpu))
        before = spec
    bought: dict[float, Bought | None] = dict.fromkeys(plan.bought)
    for budget, best in plan.bought.items():
        if best is not None:
            entry, spec = best
            row = found.row(spec)
            bought[budget] = Bought(
                engine, budget, spec.partition(":")[2], row.accuracy.n, entry.trial.accuracy,
                row.accuracy, row.cpu,
            )  # fmt: skip
    return Tested(
        engine=engine,
        tuned=found.row(own),
        others=[found.row(spec, against=own, key=key) for spec, key in plan.others.items()],
        steps=steps,
        left_out=[_variant(engine, change, own, found) for change in plan.left_out],
        physical=[_variant(engine, change, own, found) for change in plan.physical],
        front=points(plan.front),
        bought=bought,
        luck=_luck(plan.seeds, found) if plan.seeds else None,
    )


def _variant(engine: str, change: Change, own: str, found: Evaluation) -> Variant:
    row = found.row(change.spec)
    return Variant(
        engine=engine,
        change=change.name,
        values=change.values,
        n=row.accuracy.n,
        accuracy=row.accuracy,
        accuracy_change=found.difference(change.spec, own),
        cost_ms=row.cpu.value,
        cost_change=found.cost_ratio(change.spec, own).value,
    )


def _luck(seeds: Sequence[tuple[Search, str]], found: Evaluation) -> Luck:
    values = [search.space.values(search.fittest().genotype) for search, _ in seeds]
    differing = [gene for gene in values[0] if len({own.get(gene) for own in values}) > 1]
    rows = []
    for (search, spec), own in zip(seeds, values, strict=True):
        trial, row = search.fittest().trial, found.row(spec)
        rows.append(
            Seed(
                search.options.seed, fitness(trial, search.goal), trial.accuracy, row.accuracy.n,
                row.accuracy, row.cpu, {gene: own[gene] for gene in differing},
            )
        )  # fmt: skip
    return Luck(
        rows,
        spread([row.test.value for row in rows]),
        spread([row.cpu.value for row in rows]),
        len(values[0]),
    )


def _carried(here: str, there: str) -> tuple[str, tuple[str, ...]]:
    """Spec on one engine of the parameters tuned on another, and those without effect there."""
    if here == there:
        return _spec(f"{TUNED}@{here}"), ()
    return carried_over(tuned_values(here), there)


def _transferred(engines: Sequence[str], found: Evaluation) -> list[Carried]:
    cells = []
    for there in engines:
        own, _ = _carried(there, there)
        for here in engines:
            spec, ignored = _carried(here, there)
            row = found.row(spec)
            ahead = None if here == there else found.difference(own, spec)
            cell = Cell(row.over, row.under, row.cpu)
            cells.append(Carried(here, there, row.accuracy, ahead, cell, ignored))
    return cells
