"""CPU time as a sum over a simulation's counted work, so that a search can be repeated.

The terms are counted (:class:`steadyload.methods.contract.method.Effort`) and equal on every
machine; what each takes is measured once an engine, as the non-negative weights that fit the CPU
times of random genotypes best.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.stats import spearmanr

from steadyload.atomic import ChecksumError, manifest_text, verified_manifest, write_atomically
from steadyload.config import bind, stated
from steadyload.engines.world import BroadPhase
from steadyload.escaping import shown
from steadyload.layouts.model.question import with_question
from steadyload.methods.contract.method import Effort
from steadyload.methods.contract.spec import SpecError
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.simulation_parameters import SimulationParameters
from steadyload.methods.tuned import TUNED, tuned
from steadyload.reading import MAX_STORED_BYTES, content_of, json_of
from steadyload.runs.pool import PartLimit, SinglePart, run_units
from steadyload.runs.provenance import made_by
from steadyload.tuning import TuningError
from steadyload.tuning.cases import CaseSource, load_cases
from steadyload.tuning.space import Space, question_of

FloatArray = NDArray[np.float64]

VERSION = 1
"""Of the terms that costs are sums of, and of the goal: raised when they change."""

GOAL = "ps3@{engine}:samples=10,rest_speed=0.01"
"""The method that defines the goal: PS_3, stopped at rest and sampled as others are."""

TERMS = (
    "layout",
    "world",
    "world with the simple broad phase",
    "box placed",
    "look",
    "substep",
    "body and substep",
    "body and substep, neighbours close",
    "body, substep and iteration",
)
"""What is counted. Bodies and iterations count as requested: an engine may use fewer.
Neighbours touch, or begin to touch, the more often the less their side faces are drawn in."""

_CLOSE = 1e-4
"""[m]; neighbours drawn in by this are half as close."""

_REDRAWN = 0.3
"""Share of the genes in which a genotype near the start of a space differs from it."""

_ANCHOR_WEIGHT = 16.0
"""Of the goal, the start of a space and what was found in it before, among parameter sets: every
cost of a search is compared with the first, and searches spend their time near the others."""

CASES = 90
"""Each parameter set is measured on so many."""

CASES_OF_SEVERAL = 24
"""The same where there are further labelled sets: large layouts take a hundred times as long, and
are less easily disturbed."""

_SECONDS_A_CASE = 20.0
"""Hard limit on the CPU time of a measurement, by judged case."""

_USUAL_ITERATIONS = 50
"""Of an engine that was not told."""


@dataclass(frozen=True)
class CostModel:
    """Model of the CPU time of a judgement on one engine.

    Attributes:
        microseconds: by term of :data:`TERMS`.
        parameter_sets: how many it was fitted to.
        correlation: Spearman's, of modelled and measured times.
        error: median relative error.
    """

    microseconds: Mapping[str, float] = field(default_factory=dict)
    parameter_sets: int = 0
    correlation: float = np.nan
    error: float = np.nan

    def milliseconds(self, effort: Effort, parameters: SimulationParameters) -> float:
        """The modelled CPU time of one layout."""
        weights = np.array([self.microseconds[term] for term in TERMS])
        return 1e-3 * float(weights @ counts(effort, parameters))


def counts(effort: Effort, parameters: SimulationParameters) -> FloatArray:
    """Count of each of :data:`TERMS` in the judgement of one layout."""
    iterations = parameters.solver_iterations or _USUAL_ITERATIONS
    closeness = 1.0 / (1.0 + parameters.shrink / _CLOSE)
    simple = effort.worlds if parameters.broad_phase is BroadPhase.SIMPLE else 0
    return np.array(
        [
            1.0, effort.worlds, simple, effort.boxes, effort.looks, effort.substeps,
            effort.body_substeps, effort.body_substeps * closeness,
            effort.body_substeps * iterations,
        ]
    )  # fmt: skip


def calibrate(
    space: Space,
    source: CaseSource,
    *,
    workers: int,
    seed: int = 0,
    parameter_sets: int = 32,
    cases: int | None = None,
    repeats: int | None = None,
    with_goal: bool = True,
) -> CostModel:
    """Measure genotypes of a space and what its goal is a share of, and fit the model to them.

    Half of the genotypes are random ones, half are near the start of the space, where searches
    spend their time. What was found in the space before, and is the preset, is measured too.

    Args:
        space: of the engine.
        source: where the layouts are from.
        workers: processes beside this one; 0 measures here.
        seed: of the genotypes.
        parameter_sets: how many, the goal and the start among them, a preset beside them; those
            that cannot be are left out.
        cases: each is measured on so many, spread evenly; None for :data:`CASES`, of several sets
            :data:`CASES_OF_SEVERAL`.
        repeats: each case is judged so often; the median counts. None for 2, of several sets 1.
        with_goal: whether what the goal is a share of is measured, too; a stated goal needs none.

    Raises:
        TuningError: not one of them could be measured.
    """
    random = np.random.default_rng(seed)
    sizes = [len(gene.values) for gene in space.genes]
    genotypes = []
    for number in range(parameter_sets - 2):
        drawn = random.integers(sizes)
        kept = random.random(len(sizes)) >= (_REDRAWN if number % 2 else 1.0)
        genotypes.append(tuple(np.where(kept, space.start, drawn).tolist()))
    anchors = [space.spec(space.start)]
    if with_goal:
        anchors.insert(0, GOAL.format(engine=space.engine))
    question = question_of(space.name)
    before = tuned(question).get(space.engine)
    if before is not None and before.made_by["space"] == space.name:
        anchors.append(with_question(f"{TUNED}@{space.engine}", question))
    specs = list(anchors)
    for genotype in genotypes:
        with suppress(SpecError):
            specs.append(space.spec(genotype))
    if cases is None:
        cases = CASES_OF_SEVERAL if source.data else CASES
    if repeats is None:
        repeats = 1 if source.data else 2
    units = [_Measurement(spec, source, cases, repeats) for spec in specs]
    limit = PartLimit(_SECONDS_A_CASE * cases * repeats, _NO_COST)
    measured = run_units(_measure, units, workers=workers, crashed=_NO_COST, limit=limit)
    found = [answer for _, answers in measured for answer in answers if answer is not None]
    if not found:
        raise TuningError(f"engine {space.engine!r}: no genotype could be measured")
    found.sort(key=lambda answer: answer[1:])  # in which order they were measured means nothing
    rows, times = np.array([row for row, _, _ in found]), np.array([time for _, time, _ in found])
    sure = np.sqrt([_ANCHOR_WEIGHT if spec in anchors else 1.0 for _, _, spec in found])
    # Relative errors count: a genotype of 1 ms matters as much as one of 50.
    weights, _ = nnls(rows * (sure / times)[:, None], sure)
    modelled = rows @ weights
    return CostModel(
        {term: float(f"{1e3 * w:.4g}") for term, w in zip(TERMS, weights, strict=True)},
        len(times),
        float(spearmanr(modelled, times).statistic),
        float(np.median(np.abs(modelled / times - 1.0))),
    )


def kept_model(
    path: Path,
    space: Space,
    source: CaseSource,
    *,
    workers: int,
    with_goal: bool = True,
    report: Callable[[str], None] = lambda sentence: None,
) -> CostModel:
    """The cost model of an engine on a space, measured once and kept in a file.

    Measured again when the engine's version has changed since. Measure it while nothing else runs.

    Args:
        path: of the file.
        space: of the engine.
        source: where the layouts are from.
        workers: processes beside this one.
        with_goal: see :func:`calibrate`.
        report: told when it is measured.

    Raises:
        TuningError: the file holds something else.
    """
    about = {
        "engine": space.engine,
        "space": space.name,
        "version": VERSION,
        "made_by": made_by(make_method(f"simulation@{space.engine}")),
        **stated(**{n: source.stored().get(n) for n in ("directory", "limit", "data")}),
    }
    if path.exists() and (stored := stored_model(path, about)) is not None:
        return stored
    report(f"measuring what judging costs on {space.engine}; kept in {path}")
    model = calibrate(space, source, workers=workers, with_goal=with_goal)
    path.parent.mkdir(parents=True, exist_ok=True)
    kept = {"about": about, "model": dataclasses.asdict(model)}
    write_atomically(path, manifest_text(kept))
    return model


def stored_model(path: Path, about: Mapping[str, Any]) -> CostModel | None:
    """The cost model of a file; None where it is of other versions.

    Args:
        path: of the file.
        about: what the model has to be of.

    Raises:
        TuningError: the file holds something else, or is damaged.
    """
    content = content_of(path, MAX_STORED_BYTES)
    try:
        kept = json_of(content)
        of = kept["about"]["engine"], kept["about"]["space"]
        model = _model(kept["model"]) if kept["about"] == about else None
    except (ValueError, KeyError, TypeError, RecursionError):
        raise TuningError(f"{path}: holds no cost model; name another file") from None
    if of != (about["engine"], about["space"]):
        raise TuningError(
            f"{path}: is of engine {shown(of[0])}, space {shown(of[1])}; name another file"
        )
    try:
        verified_manifest(kept)
    except ChecksumError:
        raise TuningError(f"{path}: is damaged; remove it to measure anew") from None
    return model


def _model(kept: Mapping[str, Any]) -> CostModel:
    """A stored model; an error of any of the kinds of malformed JSON where it is none."""
    model = bind(CostModel, kept, "model")
    if not {*TERMS} <= model.microseconds.keys():
        raise KeyError
    return model


@dataclass(frozen=True, slots=True)
class _Measurement(SinglePart):
    """A unit of work: one parameter set on some cases."""

    spec: str
    source: CaseSource
    cases: int
    repeats: int

    def describe(self, part: int) -> str:
        return f"{self.spec} on {self.cases} cases"


_Counted = tuple[Sequence[float], float, str]


def _measure(unit: _Measurement) -> Iterator[_Counted | None]:
    """Mean counts and mean CPU time [ms] a layout, and the spec."""
    method = make_method(unit.spec)
    cases = load_cases(unit.source)
    # The first cases are not like all: fragile labels come first.
    chosen = np.linspace(0, len(cases) - 1, min(unit.cases, len(cases)), dtype=int)
    layouts = [cases[k].layout for k in chosen]
    method.prepare(max(map(len, layouts)))
    method.judge(layouts[0])
    verdicts = [[method.judge(layout) for layout in layouts] for _ in range(unit.repeats)]
    row = np.mean([counts(v.effort, method.parameters) for v in verdicts[0]], axis=0)
    cpu = np.median([[v.cpu.total for v in repeat] for repeat in verdicts], axis=0)
    yield row.tolist(), 1e3 * float(cpu.mean()), unit.spec


_NO_COST: Callable[[_Measurement, int, str], _Counted | None] = lambda unit, part, reason: None  # noqa: E731
"""A parameter set that ends its process, or takes too long, gives no cost."""
