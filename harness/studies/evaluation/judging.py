"""Methods of the study, judged and timed; an interrupted run is resumed."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pandas as pd

from steadyload.app.recommend.kept import SPATIAL
from steadyload.engines.registry import EngineNotInstalledError, capabilities, engines_here
from steadyload.layouts.benchmark.dataset import KEYS, PLANAR, set_named
from steadyload.layouts.model.question import Question, with_question
from steadyload.methods.contract.method import Status
from steadyload.methods.contract.spec import parse_spec
from steadyload.methods.registry import METHODS, each_question, method_class
from steadyload.runs.able import able_methods, asked_question
from steadyload.runs.definition import StudyDefinition, StudyError
from steadyload.runs.labels import labelled_material
from steadyload.runs.results import ResultsError, load_manifest, load_results
from steadyload.runs.runner import run_study
from steadyload.runs.timing import BLOCK, Times, timed
from steadyload.studies.kit import Lab

RULES = ("fbs", "pbs0.9", "pbs0.7", "pbs0.5", "sme", "equilibrium", "equilibrium:time=0.3")
TUNINGS = ("ps5-literal", "ps3-literal", "ps5", "ps3", "ps_opt-paper", "ps_opt")
NETWORKS = ("lstm_1-paper", "lstm_e-paper", "lstm_1", "lstm_e")
OTHERS = ("settling", "cascade@mujoco", "label@mujoco")
"""Methods of our own; ``simulation`` is included by its tunings."""


def standard_methods() -> tuple[str, ...]:
    """Specs of the methods compared by default: the paper's on every engine, our own, and more.

    Every registered engine with fixed steps takes part; a method of this package that none of these
    specs names takes part with its own defaults, on every such engine where it needs one. Those of
    other distributions join where they are named. Methods
    that were made for both questions stand in the list once a question, those on planar engines
    once.
    """
    engines = tuple(name for name in engines_here() if _takes_steps(name))
    tunings = (f"{name}@{engine}" for name in TUNINGS for engine in engines)
    listed = (*RULES, *tunings, *NETWORKS, *OTHERS)
    named = {method_class(parse_spec(spec).name) for spec in listed}
    more = [name for name in METHODS if method_class(name) not in named]
    stands = [
        with_question(spec, Question.STANDS)
        for spec in listed
        if each_question(parse_spec(spec).name) and not _is_planar(spec)
    ]
    return (*listed, *stands, *(spec for name in more for spec in _everywhere(name, engines)))


def _takes_steps(engine: str) -> bool:
    try:
        return not capabilities(engine).error_controlled
    except EngineNotInstalledError:
        return True  # it is left out for that reason, not for this


def _is_planar(spec: str) -> bool:
    """Whether a method is on an engine of two dimensions; not so where that cannot be told."""
    engine = parse_spec(spec).engine
    try:
        return engine is not None and capabilities(engine).dimensions == 2
    except EngineNotInstalledError:
        return False


def _everywhere(name: str, engines: tuple[str, ...]) -> tuple[str, ...]:
    method = method_class(name)
    return tuple(f"{name}@{e}" for e in engines) if method and method.needs_engine else (name,)


PART = "test"
"""Part of the labelled set; nothing was tuned, trained or fitted on it."""


_SHARD_SIZE = 60

_FEW = 0.1
"""Largest share of the timed cases that a method may refuse and still be timed on the others."""

_NO_PLANAR_LABELS = "judges planar layouts alone, which have no labels of this question"


@dataclass(frozen=True)
class Options:
    """Cases and methods that are judged and timed; other fields are options of the study.

    Attributes:
        question: whose labels and methods the page shows. What is judged and timed does not depend
            on it, but that planar layouts have no labels of the question ``stands``.
        spatial: specs of the methods that judge 3-D layouts.
        planar: specs of those on 2-D engines.
        left_out: by spec, the reason why one of :func:`standard_methods` cannot judge.

    Raises:
        StudyError: a number out of range, or no method judges 3-D layouts.
        SpecError, EngineNotInstalledError: a named method cannot judge.
        LearnerError: its weights cannot be read.
    """

    methods: tuple[str, ...] = ()
    directory: str = ""
    question: Question = Question.WITHIN
    limit: int | None = None
    timed: int = 100
    repeats: int = 3
    spatial: tuple[str, ...] = field(init=False)
    planar: tuple[str, ...] = field(init=False)
    left_out: Mapping[str, str] = field(init=False)

    def __post_init__(self) -> None:
        for name in ("limit", "timed", "repeats"):
            value = getattr(self, name)
            if value is not None and value < 1:
                raise StudyError(f"{name} is {value}; allowed: 1 or more")
        able, left_out = able_methods(self.methods, standard_methods)
        planar = tuple(spec for spec in able if _is_planar(spec))
        spatial = tuple(spec for spec in able if spec not in planar)
        if not spatial:
            raise StudyError(
                f"methods {', '.join(able)}: none judges layouts in space; name one more, such as "
                "sme"
            )
        if self.question is Question.STANDS and planar:
            left_out |= dict.fromkeys(planar, _NO_PLANAR_LABELS)
            planar = ()
        vars(self).update(spatial=spatial, planar=planar, left_out=left_out)

    @property
    def shown(self) -> tuple[str, ...]:
        """Specs of the 3-D methods that the page shows.

        Of a method that stands in the list once a question only the one that is asked this one;
        named methods all.
        """
        if self.methods:
            return self.spatial
        stands = {spec for spec in self.spatial if asked_question(spec) is Question.STANDS}
        if self.question is Question.WITHIN:
            return tuple(spec for spec in self.spatial if spec not in stands)
        return tuple(s for s in self.spatial if with_question(s, Question.STANDS) not in stands)

    def definition(self, *, planar: bool) -> StudyDefinition:
        """Of all 3-D methods on their set, or of those shown and 2-D ones on planar layouts."""
        return StudyDefinition(
            name=f"table5 {PLANAR}" if planar else "table5",
            methods=(*self.shown, *self.planar) if planar else self.spatial,
            benchmark=PART,
            benchmark_directory=PLANAR if planar else set_named(self.directory),
            limit=self.limit,
            shard_size=_SHARD_SIZE,
        )


@dataclass(frozen=True)
class Ran:
    """A set whose cases were judged, and some of them timed.

    Attributes:
        definition: what was judged.
        folder: of the run.
        cases: those that were timed, (layout, scenario) in the order of the times.
        times: of the methods that were timed.
        untimed: by spec, the reason why a method was not timed.
        refused: by spec, number of cases that no method was timed on because this one refuses them.
    """

    definition: StudyDefinition
    folder: Path
    cases: tuple[tuple[str, str], ...]
    times: Times
    untimed: Mapping[str, str]
    refused: Mapping[str, int]

    @property
    def is_planar(self) -> bool:
        """Whether its layouts are planar."""
        return self.definition.benchmark_directory == PLANAR

    def timed_among(self, cases: pd.Index) -> Ran:
        """The same with the times of those cases alone that are among some."""
        kept = pd.MultiIndex.from_tuples(self.cases, names=KEYS).isin(cases)
        cpu, wall = (
            {spec: taken[:, kept] for spec, taken in clock.items()}
            for clock in (self.times.cpu, self.times.wall)
        )
        chosen = tuple(case for case, is_kept in zip(self.cases, kept, strict=True) if is_kept)
        times = dataclasses.replace(self.times, cpu=cpu, wall=wall)
        return dataclasses.replace(self, cases=chosen, times=times)


def judged_and_timed(lab: Lab, asked: Options) -> tuple[Ran, Ran | None]:
    """Judge all cases, then time some of them; an interrupted run is resumed.

    Args:
        lab: where they are judged; with 0 workers also the timing is in this process, else in one
            beside it.
        asked: the options.

    Returns:
        The 3-D part, and the planar one; None without a 2-D method.

    Raises:
        ResultsError: the folder holds another study.
        as :func:`steadyload.runs.runner.run_study`, :func:`steadyload.runs.timing.timed`.
    """
    if (lab.work / "manifest.json").exists():  # its page would be overwritten
        name = load_manifest(lab.work)["study"]["name"]
        raise ResultsError(f"{lab.work}: holds the study {name!r}; choose another folder")
    folders = {SPATIAL: asked.definition(planar=False)}
    if asked.planar:
        folders[PLANAR] = asked.definition(planar=True)
    for name, definition in folders.items():
        run_study(
            definition, lab.work / name, workers=lab.workers,
            progress=lambda *of: lab.progress("judging", *of),
        )  # fmt: skip
    found = [_timed(lab, asked, own, lab.work / name) for name, own in folders.items()]
    return found[0], found[1] if len(found) > 1 else None


def _timed(lab: Lab, asked: Options, definition: StudyDefinition, folder: Path) -> Ran:
    fewer = dataclasses.replace(definition, limit=min(asked.timed, asked.limit or asked.timed))
    cases = {
        (layout.name, str(scenario)): layout for scenario, layout in labelled_material(fewer).cases
    }
    untimed, refused = _not_judged(folder, list(cases))
    for case in set().union(*refused.values()):
        del cases[case]
    times = timed(
        [spec for spec in definition.methods if spec not in untimed],
        list(cases.values()),
        folder / "times",
        repeats=asked.repeats,
        block=BLOCK,
        workers=lab.workers,
        progress=lambda *of: lab.progress("timing", *of),
    )
    counts = {spec: len(own) for spec, own in refused.items()}
    return Ran(definition, folder, tuple(cases), times, untimed, counts)


def _not_judged(
    folder: Path, chosen: Sequence[tuple[str, str]]
) -> tuple[dict[str, str], dict[str, set[tuple[str, str]]]]:
    """Reasons by spec for methods that are not timed; of the others, the cases that they refuse.

    A method that ended its process would end that of the timing, and the time of a refusal is not
    that of a judgement. A few refused cases are left out for all methods, so that times are
    compared on the same ones.
    """
    rows = load_results(folder, ["layout", "scenario", "method", "repetition", "status"])
    there = pd.MultiIndex.from_frame(rows[["layout", "scenario"]]).isin(list(chosen))
    lost = rows[there & rows["status"].isin([str(Status.CRASHED), str(Status.REFUSED)])]
    untimed, refused = {}, {}
    for method, own in lost.groupby("method", sort=False):
        counts = own["status"].value_counts().sort_index()
        if str(Status.CRASHED) in counts or len(own) > _FEW * len(chosen):
            untimed[str(method)] = f"of {len(chosen)} cases to be timed " + ", ".join(
                f"{n} {status}" for status, n in counts.items()
            )
        else:
            refused[str(method)] = set(zip(own["layout"], own["scenario"], strict=True))
    return untimed, refused
