"""How sure verdicts are on labelled cases: what is sampled for the page of uncertain verdicts.

A run folder holds ``cases/*.json``, a file for some cases of one question, named by a hash of all
that they depend on. Every file is whole or not there, so an interrupted run goes on where it was.
"""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from engines.registry import installed_versions
from harness.atomic import write_atomically
from harness.layouts.benchmark import Benchmark, Part, load_benchmark
from harness.layouts.model import Layout
from harness.methods.method import Status
from harness.methods.registry import make_method
from harness.methods.uncertainty import dimensions, judge_deviated, parse_uncertainty
from harness.studies import outlook as looking
from harness.studies.executors import IN_THIS_PROCESS, run_units
from harness.studies.outlook import Sampling, outlook, variance_by_scramblings
from harness.studies.results import ResultsError, judged_by
from harness.studies.runner import locked

CHECK = "equilibrium"
"""The method whose probabilities are held against those of many random samples."""

_SHARD = 10
_MEASURING = (looking.__file__, __file__)

Row = dict[str, Any]
Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True)
class Questions:
    """What is asked of which cases.

    Attributes:
        part: of the labelled set that comes with the package.
        uncertainty: what deviates, as :func:`parse_uncertainty` reads it.
        methods: spec strings.
        cases: a scenario, for methods without an engine.
        engine_cases: a scenario, for methods with one, and for ``alone``.
        alone: what deviates by itself, to tell what matters.
        alone_method: which method is asked that.
        checked: layouts on which :data:`CHECK` is held against random samples; 0 for none.
        check_cases: a scenario, among which they are the first that neither stand nor fall at
            every sample.
        random: samples a checked layout.
        sampling: how long to sample.
    """

    part: Part = Part.TEST
    uncertainty: str = "com=5mm,position=3mm"
    methods: tuple[str, ...] = (
        "sme", "equilibrium:time=0.3", "lstm_1:outside=accept", "ps_opt@mujoco"
    )  # fmt: skip
    cases: int = 100
    engine_cases: int = 20
    alone: tuple[str, ...] = ("com=5mm", "position=3mm", "weight=5%", "friction=0.1")
    alone_method: str = "equilibrium:time=0.3"
    checked: int = 50
    check_cases: int = 300
    random: int = 4096
    sampling: Sampling = field(default_factory=Sampling)


@dataclass(frozen=True, slots=True)
class Sampled:
    """What a run found, tables with a row a case in the order of :meth:`Benchmark.select`.

    Columns: ``layout, scenario, item_count``; ``nominal``, items placed safely by the plan (all: it
    stands), missing without a verdict; ``safe``, the same of samples, with how many; ``samples,
    lost``; ``low, high, ending``; ``variance`` of the share that stands; ``cpu, nominal_cpu`` [s];
    ``random``, the share of random samples that stand, missing where there were none.
    """

    methods: dict[str, pd.DataFrame]
    alone: dict[str, pd.DataFrame]
    check: pd.DataFrame


@dataclass(frozen=True, slots=True)
class Unit:
    """A unit of work: one question to some cases, and the file that the answers go to."""

    method: str
    uncertainty: str
    cases: tuple[tuple[str, Layout], ...]
    sampling: Sampling
    random: int
    path: Path

    def __len__(self) -> int:
        return len(self.cases)

    def without(self, done: int) -> Unit:
        """The unit without its first cases."""
        return replace(self, cases=self.cases[done:])

    def describe(self, part: int) -> str:
        """A case for people."""
        scenario, layout = self.cases[part]
        return f"{self.method} on layout {layout.name!r} ({scenario}), {self.uncertainty}"


def sample_unit(unit: Unit) -> Iterator[Row]:
    """Prepare a unit's method, then sample: a row a case."""
    make_method(unit.method).prepare(max(len(layout) for _, layout in unit.cases))
    return (_row(unit, part) for part in range(len(unit)))


def _row(unit: Unit, part: int) -> Row:
    scenario, layout = unit.cases[part]
    method, uncertainty = make_method(unit.method), parse_uncertainty(unit.uncertainty)
    found = outlook(method, layout, uncertainty, unit.sampling)
    stands = [safe == len(layout) for safe in found.said]
    return {
        "layout": layout.name,
        "scenario": scenario,
        "item_count": len(layout),
        "nominal": _safe(found.nominal.status, found.nominal.failing_step, len(layout)),
        "safe": sorted(Counter(s for s in found.said if s is not None).items()),
        "samples": found.samples,
        "lost": sum(found.without_verdict.values()),
        "low": found.low,
        "high": found.high,
        "ending": str(found.ending),
        "variance": variance_by_scramblings(stands) if stands else None,
        "cpu": found.cpu,
        "nominal_cpu": found.nominal.cpu.total,
        "random": _random_share(unit, part) if unit.random else None,
    }


def _safe(status: Status, failing_step: int | None, item_count: int) -> int | None:
    if status is not Status.DONE:
        return None
    return item_count if failing_step is None else failing_step


def _random_share(unit: Unit, part: int) -> float:
    """How many of random samples stand, drawn apart from the quasi-random ones."""
    _, layout = unit.cases[part]
    digest = int(layout.content_hash()[:8], 16)
    random = np.random.default_rng([unit.sampling.seed, digest])
    uniforms = random.random((unit.random, dimensions(len(layout))))
    verdicts = judge_deviated(
        make_method(unit.method), layout, parse_uncertainty(unit.uncertainty), uniforms
    )
    return float(np.mean([verdict.stable for verdict in verdicts]))


def _crashed(unit: Unit, part: int, reason: str) -> Row:
    """The row of a case that ends the process it is judged in."""
    scenario, layout = unit.cases[part]
    return {
        "layout": layout.name, "scenario": scenario, "item_count": len(layout), "nominal": None,
        "safe": [], "samples": 0, "lost": 0, "low": 0.0, "high": 1.0, "variance": None,
        "ending": f"crashed: {reason}", "cpu": 0.0, "nominal_cpu": 0.0, "random": None,
    }  # fmt: skip


def run_uncertain(
    asked: Questions,
    directory: Path,
    *,
    workers: int = IN_THIS_PROCESS,
    progress: Progress = lambda done, total: None,
) -> Sampled:
    """Sample what is missing in ``directory``; an interrupted run is taken up again.

    Args:
        asked: what to ask.
        directory: made when it does not exist.
        workers: see :func:`harness.studies.runner.run_study`.
        progress: called with cases done and cases in all, first of all but the random samples.

    Raises:
        SpecError: no such method, or nothing that can be uncertain.
        BenchmarkError: no such part.
        ResultsError: the folder is none, or another run is at work in it.
        EngineNotInstalledError: a method's engine is missing.
        WorkerDiedError: see :func:`harness.studies.executors.run_units`.
    """
    for text in (asked.uncertainty, *asked.alone):
        parse_uncertainty(text)
    for spec in (*asked.methods, asked.alone_method):
        make_method(spec).prepare()
    if directory.exists() and not directory.is_dir():
        raise ResultsError(f"{directory}: is not a folder")
    (directory / "cases").mkdir(parents=True, exist_ok=True)
    with locked(directory):
        run = _Run(asked, load_benchmark(), directory / "cases")
        run.sample(run.first(), workers, progress)
        check = run.unsure()
        run.sample(run.units(CHECK, asked.uncertainty, check, asked.random), workers, progress)
        return Sampled(
            {m: run.table(m, asked.uncertainty, run.cases(_many(asked, m))) for m in asked.methods},
            {
                text: run.table(asked.alone_method, text, run.cases(asked.engine_cases))
                for text in asked.alone
            },
            run.table(CHECK, asked.uncertainty, check, asked.random),
        )


def _many(asked: Questions, spec: str) -> int:
    return asked.cases if make_method(spec).spec.engine is None else asked.engine_cases


class _Run:
    def __init__(self, asked: Questions, benchmark: Benchmark, folder: Path) -> None:
        self._asked, self._benchmark, self._folder = asked, benchmark, folder
        specs = dict.fromkeys((*asked.methods, asked.alone_method, CHECK))
        # Of the code that samples, not of what it has become meanwhile.
        self._made_by = {spec: _made_by(spec) for spec in specs}

    def cases(self, limit: int) -> list[tuple[str, Layout]]:
        """The first so many cases a scenario."""
        chosen = self._benchmark.select(self._asked.part, limit=limit)
        return [
            (scenario, self._benchmark.layout(name, scenario))
            for name, scenario in zip(chosen["layout"], chosen["scenario"], strict=True)
        ]

    def units(
        self,
        spec: str,
        uncertainty: str,
        cases: Sequence[tuple[str, Layout]],
        random: int = 0,
    ) -> list[Unit]:
        """One question in parts."""
        question = [spec, str(parse_uncertainty(uncertainty)), repr(self._asked.sampling), random]
        units = []
        for start in range(0, len(cases), _SHARD):
            part = tuple(cases[start : start + _SHARD])
            identity = [*question, *self._made_by[spec]]
            identity += [[scenario, lay.name, lay.content_hash()] for scenario, lay in part]
            digest = hashlib.sha256(json.dumps(identity).encode()).hexdigest()[:20]
            path = self._folder / f"{digest}.json"
            units.append(Unit(spec, uncertainty, part, self._asked.sampling, random, path))
        return units

    def first(self) -> list[Unit]:
        """All that is asked without knowing any answer."""
        asked = self._asked
        units = [
            unit
            for spec in asked.methods
            for unit in self.units(spec, asked.uncertainty, self.cases(_many(asked, spec)))
        ]
        for text in asked.alone:
            units += self.units(asked.alone_method, text, self.cases(asked.engine_cases))
        if asked.checked:
            units += self.units(CHECK, asked.uncertainty, self.cases(asked.check_cases))
        return list({unit.path: unit for unit in units}.values())

    def unsure(self) -> list[tuple[str, Layout]]:
        """The first cases of which some samples stand and some fall, scenarios in turn."""
        if not self._asked.checked:
            return []
        cases = self.cases(self._asked.check_cases)
        table = self.table(CHECK, self._asked.uncertainty, cases)
        both = [
            case
            for case, safe in zip(cases, table["safe"], strict=True)
            if 0 < dict(safe).get(len(case[1]), 0) < sum(dict(safe).values())
        ]
        turns = Counter[str]()
        rank = []
        for scenario, _ in both:
            rank.append(turns[scenario])
            turns[scenario] += 1
        order = sorted(range(len(both)), key=lambda k: rank[k])
        return [both[k] for k in order[: self._asked.checked]]

    def sample(self, units: Sequence[Unit], workers: int, progress: Progress) -> None:
        """Answer what is missing."""
        missing = [unit for unit in units if _rows(unit.path) is None]
        total, done = sum(map(len, units)), sum(map(len, units)) - sum(map(len, missing))
        progress(done, total)
        for unit, rows in run_units(sample_unit, missing, workers=workers, crashed=_crashed):
            write_atomically(unit.path, json.dumps({"cases": rows}) + "\n")
            done += len(rows)
            progress(done, total)

    def table(
        self,
        spec: str,
        uncertainty: str,
        cases: Sequence[tuple[str, Layout]],
        random: int = 0,
    ) -> pd.DataFrame:
        """The answers to a question, as they are kept."""
        rows: list[Row] = []
        for unit in self.units(spec, uncertainty, cases, random):
            found = _rows(unit.path)
            assert found is not None, "sampled before"
            rows += found
        return pd.DataFrame(rows)


def _made_by(spec: str) -> list[Any]:
    method = make_method(spec)
    code = hashlib.sha256(b"".join(Path(file).read_bytes() for file in _MEASURING))
    return [judged_by(method), installed_versions(method.spec.engine or ""), code.hexdigest()]


def _rows(path: Path) -> list[Row] | None:
    """What is there; a file that cannot be read counts as not there."""
    try:
        found: list[Row] = json.loads(path.read_bytes())["cases"]
    except (FileNotFoundError, ValueError):
        return None
    return found
