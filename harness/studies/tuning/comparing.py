"""Tuned presets compared with other methods, on cases on which nothing was tuned."""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import pandas as pd

from steadyload.engines.registry import capabilities
from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import LISTS, PLANAR, Part
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.spec import as_plain, bind
from steadyload.methods.naming import MethodKey
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.simulation_parameters import parameters_on
from steadyload.methods.tuned import TUNED, tuned
from steadyload.reports import frames
from steadyload.reports.columns import general, names
from steadyload.runs import frames as v
from steadyload.runs.costs import CostKind, CostSource
from steadyload.runs.judged import JudgedCases
from steadyload.runs.labels import Cases
from steadyload.runs.provenance import provenance_lines
from steadyload.studies.kit import Lab
from steadyload.studies.tuning.gains import search_gains
from steadyload.studies.tuning.presets import BUDGETS, DEAR, START, Found
from steadyload.studies.tuning.searching import Point, of_searches, spread
from steadyload.tuning import TuningError
from steadyload.tuning.cost import GOAL
from steadyload.tuning.ledger import Entry
from steadyload.tuning.presets import by_worth, preset
from steadyload.tuning.search import Search, pareto_front
from steadyload.tuning.space import PAPERS, Space, gene_groups, space_on, spec_of
from steadyload.tuning.trial import fitness

LIMIT, GAINS = 150, 300
"""Cases a scenario, and those on which presets of both questions are compared with the starts of
their searches."""

EVERYTHING = "everything"
"""The change of all groups of parameters at once."""

_SHARD_SIZE = 60

_STOPPED = GOAL.partition(":")[2]
"""Parameters of samples and of a stop at rest, which PS_3 and PS_5 are given like all methods."""


Values = Mapping[str, Any]

_PHYSICAL = {
    "friction": ("friction",),
    "restitution": ("restitution",),
    "friction and restitution": ("friction", "restitution"),
    "damping": ("linear_damping", "angular_damping"),
    "margin": ("margin",),
    "thresholds and time": ("eps_t", "eps_r", "t_max"),
}
"""Parameters that get the values of the simulation that makes the labels, by name of the change."""

_BY_HAND = {"eps_t": 10, "eps_r": 10, "frequency": 100, "linear_damping": 0.01}
"""A point of the paper's own space near the label's thresholds, which short searches miss."""


def compare(lab: Lab, searches: Iterable[Search], limit: int | None = None) -> Found:
    """Compare the tuned presets with others on the test part, and measure the gain of each part.

    The cases are those of many item lists; 2-D engines are judged on the planar set, on which the
    others are judged, too, where parameters are transferred.

    Raises:
        TuningError: all searches are for another question than that of the label, none of the
            searched engines has a preset, or none of its searches found it.
    """
    asked = [s for s in searches if s.options.source.question == Question.WITHIN]
    if not asked:
        raise TuningError(
            f"none of the searches is for the question {Question.WITHIN}, by whose labels the page "
            "compares presets; those for another question are left out"
        )
    by_engine = {engine: own for (engine, _), own in by_worth(asked).items() if engine in tuned()}
    if not by_engine:
        raise TuningError("none of these engines has a preset; steadyload tune --write-preset")
    plans = {engine: _Plan(engine, own) for engine, own in by_engine.items()}
    sets: dict[str, list[str]] = {}
    for engine in plans:
        sets.setdefault(PLANAR if capabilities(engine).dimensions == 2 else LISTS, []).append(
            engine
        )
    rows: dict[str, list[Any]] = defaultdict(list)
    parts, fronts, luck, made_with = [], [], [], dict[str, str]()
    for name, engines in sorted(sets.items()):
        # 3-D engines take part on the planar set with their own parameters.
        together = list(plans) if name == PLANAR else engines
        carried = {(a, b): _carried(a, b) for b in together for a in together}
        specs = [spec for engine in engines for spec in plans[engine].specs]
        judged = lab.judge(
            list(dict.fromkeys([*specs, *(spec for spec, _ in carried.values())])),
            Cases(load_benchmark(name), Part.TEST, limit=limit or LIMIT),
            folder=name,
            name="tuning",
            shard_size=_SHARD_SIZE,
        ).judged
        pairs = [pair for engine in engines for pair in plans[engine].pairs]
        pairs += [(carried[b, b][0], spec) for (_, b), (spec, _) in carried.items()]
        found = _Judged.of(judged, pairs)
        tested = pd.concat([plans[engine].tested(found) for engine in engines])
        parts.append(
            {"part": f"{Part.TEST}, {name}", "rows": tested, **_transferred(found, carried)}
        )
        for engine in engines:
            plan = plans[engine]
            for field, own in plan.rows(found).items():
                rows[field].append(own.assign(engine=engine))
            fronts += [Point(engine, e.trial.mean_cost, e.trial.accuracy) for e in plan.front]
            luck += [plan.luck(found)] if plan.seeds else []
        made_with |= provenance_lines(judged.manifest, of=f"set {name}")
    # Of each engine the one that found its preset first.
    ordered = [s for engine, plan in plans.items() for s in (plan.finder, *by_engine[engine])]
    whole = {field: pd.concat(own) for field, own in rows.items()}
    changes = whole["left_out"]["change"]
    groups = whole["left_out"][changes != EVERYTHING]
    shown = pd.concat([part["rows"] for part in parts])
    family = shown["key"].map(lambda key: key.family)
    return Found(
        **of_searches(list(dict.fromkeys(ordered))),
        **whole,
        groups=groups,
        everything=whole["left_out"][changes == EVERYTHING],
        most=groups.iloc[int(v.values(groups["accuracy_change"]).argmin())],
        parts=parts,
        shown=frames.records(shown[family.isin((TUNED, DEAR, START))]),
        fronts=fronts,
        luck=luck,
        gains=search_gains(lab, sets.get(LISTS, ()), limit or GAINS),
        costs_explained=CostSource(CostKind.JUDGING).explained(),
        made_with=made_with,
    )


class _Judged(NamedTuple):
    """Verdicts of methods on some cases, rows by spec, and differences by pair of specs."""

    frame: pd.DataFrame
    rows: pd.DataFrame
    differences: pd.Series

    @classmethod
    def of(cls, judged: JudgedCases, pairs: Iterable[tuple[str, str]]) -> _Judged:
        """Of all methods of a run, and some pairs of them."""
        frame = v.costed(judged)
        rows = v.by_method(frame, ("right", "over", "under", "right_robust"))
        rows["cpu"] = v.mean(frame, "cpu", ["method"])
        return cls(frame, rows, v.pairs(frame, chosen=dict.fromkeys(pairs))["difference"])

    def against(self, own: str, specs: Sequence[str]) -> pd.Series:
        """CPU time of one method over that of each of others."""
        beside = self.frame.assign(own=v.beside(self.frame, "cpu", own))
        return v.ratio(beside[beside["method"].isin(specs)], "own", "cpu", ["method"])


class _Plan:
    """The specs that are judged on an engine with a preset, and frames of their results."""

    def __init__(self, engine: str, searches: Sequence[Search]) -> None:
        stored, values = tuned()[engine].parameters, tuned_values(engine)
        finder = next((s for s in searches if preset(s).parameters == stored), None)
        if finder is None:
            raise TuningError(
                f"none of these searches found {TUNED}@{engine}; name the folder of the one"
            )
        self.engine, self.finder, self.own = engine, finder, _spec(f"{TUNED}@{engine}")
        self.others = _others(engine, values, finder.space.spec(finder.space.start))
        self.steps = _steps(engine, searches, finder)
        self.changes = {
            "left_out": without_gains(finder.space, values),
            "physical": physical(engine, values),
        }
        self.seeds = apart_by_seeds(searches)
        self.front = pareto_front([entry for search in searches for entry in search.whole()])
        self.bought = list(_within_budgets(searches, self.front))
        changed = [change.spec for changes in self.changes.values() for change in changes]
        self.specs = [
            self.own,
            *self.others,
            *self.steps.values(),
            *changed,
            *(spec for _, spec in self.seeds),
            *(spec for *_, spec in self.bought),
        ]
        self.pairs = [
            *((self.own, spec) for spec in self.others),
            *((one, last) for last, one in pairwise(self.steps.values())),
            *((spec, self.own) for spec in changed),
        ]

    def tested(self, found: _Judged) -> pd.DataFrame:
        """The tuned parameters, and other methods: accuracy of the tuned ones minus theirs."""
        specs = list(self.others)
        others = found.rows.loc[specs].assign(
            key=list(self.others.values()),
            title=[key.title for key in self.others.values()],
            ahead=[found.differences[self.own, spec] for spec in specs],
            cost_ratio=found.against(self.own, specs),
        )
        return pd.concat([found.rows.loc[[self.own]], others])

    def rows(self, found: _Judged) -> dict[str, pd.DataFrame]:
        """The other frames, by field of :class:`Found`."""
        steps = list(self.steps.values())
        gains = [found.differences.get((one, last)) for last, one in pairwise(steps)]
        return {
            "steps": found.rows.loc[steps].assign(title=list(self.steps), gain=[None, *gains]),
            **{field: self._changed(changes, found) for field, changes in self.changes.items()},
            "bought": found.rows.loc[[spec for *_, spec in self.bought]].assign(
                budget=[general(budget) for budget, *_ in self.bought],
                validation=[entry.trial.accuracy for _, entry, _ in self.bought],
                values=[spec.partition(":")[2] for *_, spec in self.bought],
            ),
        }

    def _changed(self, changes: Sequence[Change], found: _Judged) -> pd.DataFrame:
        """Tuned parameters with some of them changed; differences are to the tuned ones."""
        specs = [change.spec for change in changes]
        ratio = v.values(found.against(self.own, specs))
        return found.rows.loc[specs].assign(
            change=[change.name for change in changes],
            values=[change.to for change in changes],
            accuracy_change=[found.differences[spec, self.own] for spec in specs],
            cost_change=[1.0 / ratio[spec] for spec in specs],
        )

    def luck(self, found: _Judged) -> dict[str, Any]:
        """A search with several seeds: the best genotype of each, tested once."""
        best = [search.fittest() for search, _ in self.seeds]
        values = [s.space.values(e.genotype) for (s, _), e in zip(self.seeds, best, strict=True)]
        differing = [gene for gene in values[0] if len({own.get(gene) for own in values}) > 1]
        seeds = found.rows.loc[[spec for _, spec in self.seeds]].assign(
            seed=[search.options.seed for search, _ in self.seeds],
            fitness=[fitness(e.trial, s.goal) for (s, _), e in zip(self.seeds, best, strict=True)],
            validation=[entry.trial.accuracy for entry in best],
            **{f"gene:{gene}": [own[gene] for own in values] for gene in differing},
        )
        return {
            "engine": self.engine, "seeds": seeds, "differing": len(differing),
            "genes": len(values[0]),
            **{name: spread(list(v.values(seeds[name]))) for name in ("right", "cpu")},
        }  # fmt: skip


def _transferred(
    found: _Judged, carried: Mapping[tuple[str, str], tuple[str, tuple[str, ...]]]
) -> dict[str, Any]:
    """Parameters tuned on one engine, judged on another, and compared with those tuned there.

    Returns:
        ``carried``: a row a pair of engines, ``ahead``: accuracy of the engine's own parameters
        minus its, missing for these, ``gain``: the same turned; ``home``, ``away``: mean accuracy
        on the engine that parameters were tuned on, and on others; ``better``, ``worse``,
        ``alike``: pairs in which the engine's own parameters are so, significantly.
    """
    own = {b: spec for (a, b), (spec, _) in carried.items() if a == b}
    ahead = [
        None if a == b else found.differences[own[b], spec] for (a, b), (spec, _) in carried.items()
    ]
    rows = found.rows.loc[[spec for spec, _ in carried.values()]].assign(
        tuned_on=[a for a, _ in carried],
        judged_on=[b for _, b in carried],
        ignored=[names(ignored) for _, ignored in carried.values()],
        ahead=ahead,
        gain=[0.0 if one is None else -one.value for one in ahead],
    )
    known = [one for one in ahead if one is not None]
    better, worse = sum(one.low > 0.0 for one in known), sum(one.high < 0.0 for one in known)
    right, home = v.values(rows["right"]), rows["ahead"].isna()
    return {
        "carried": rows, "home": right[home].mean(), "away": right[~home].mean(),
        "better": better, "worse": worse, "alike": len(known) - better - worse,
    }  # fmt: skip


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
    changes = ",".join(f"{name}={value}" for name, value in _BY_HAND.items())
    steps[f"its protocol, {changes} set by hand"] = f"ps_opt-paper@{engine}:{changes}"
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
) -> Iterator[tuple[float, Entry, str]]:
    """By budget the most accurate genotype of all searches that costs no more, and its spec."""
    spaces = {id(entry): search.space for search in searches for entry in search.whole()}
    for budget in BUDGETS:
        cheap = [entry for entry in front if entry.trial.mean_cost <= budget]
        if cheap:
            yield budget, cheap[-1], _spec(spaces[id(cheap[-1])].spec(cheap[-1].genotype))


def _carried(here: str, there: str) -> tuple[str, tuple[str, ...]]:
    """Spec on one engine of the parameters tuned on another, and those without effect there."""
    if here == there:
        return _spec(f"{TUNED}@{here}"), ()
    return carried_over(tuned_values(here), there)


class Change(NamedTuple):
    """A tuned parameter set with some values changed: its name, these as text, and the spec."""

    name: str
    to: str
    spec: str


def tuned_values(engine: str) -> dict[str, Any]:
    """All parameters of the tuned preset on its engine."""
    return as_plain(make_method(f"{TUNED}@{engine}").parameters)


def without_gains(space: Space, tuned: Values) -> list[Change]:
    """One change for every group of genes that is reset to the start of the search; and all."""
    start = space.values(space.start)
    groups = {
        name: {gene: start[gene] for gene in genes if gene in start}
        for name, genes in gene_groups().items()
    }
    return _changes(space.engine, tuned, {**groups, EVERYTHING: start})


def physical(engine: str, tuned: Values) -> list[Change]:
    """One change for every quantity that is set to the value of the reference simulation."""
    label = as_plain(make_method("label@reference").parameters)
    groups = {title: {name: label[name] for name in names} for title, names in _PHYSICAL.items()}
    everything = {name: value for values in groups.values() for name, value in values.items()}
    return _changes(engine, tuned, {**groups, "all of these": everything})


def _changes(engine: str, tuned: Values, groups: Mapping[str, Values]) -> list[Change]:
    found = []
    for name, values in groups.items():
        different = {k: v for k, v in values.items() if k in tuned and tuned[k] != v}
        if different:
            text = ", ".join(f"{key} {value}" for key, value in different.items())
            bound = bind(parameters_on(engine), {**tuned, **different}, where=engine)
            found.append(Change(name, text, spec_of(engine, bound)))
    return found


def carried_over(tuned: Values, engine: str) -> tuple[str, tuple[str, ...]]:
    """A parameter set on another engine: its spec there, and parameters without effect there."""
    known = {field.name for field in dataclasses.fields(parameters_on(engine))}
    kept = {name: value for name, value in tuned.items() if name in known}
    bound = bind(parameters_on(engine), kept, where=engine)
    ignored = capabilities(engine).ignored(bound.world_settings())
    own = tuple(name for name in tuned if name not in known)
    return spec_of(engine, bound), (*ignored, *own)
