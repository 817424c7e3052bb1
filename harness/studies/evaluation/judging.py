"""Methods of the study, judged and timed; an interrupted run is resumed."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial, reduce
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from steadyload.app.check_defaults import PREFERENCES
from steadyload.app.recommend.kept import REAL, SMALL, SPATIAL
from steadyload.engines.registry import EngineNotInstalledError, capabilities, engines_here
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.parts import PLANAR, set_named
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.question import Question, with_question
from steadyload.methods.contract.method import Status
from steadyload.methods.contract.spec import as_plain, parse_spec
from steadyload.methods.registry import METHODS, each_question, make_method, method_class
from steadyload.methods.simulation.simulation import Simulation
from steadyload.methods.simulation.simulation_parameters import tuning
from steadyload.methods.tuned import TUNED, tuned_engines
from steadyload.runs.able import able_methods, asked_question
from steadyload.runs.definition import StudyDefinition, StudyError
from steadyload.runs.judged import JudgedCases, load_judged
from steadyload.runs.labels import labelled_cases
from steadyload.runs.results import ResultsError, load_manifest, load_results
from steadyload.runs.runner import run_study
from steadyload.runs.timing import BLOCK, Times, kept_times, timed
from steadyload.studies.kept_rows import unpacked_rows
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


def limited_methods() -> tuple[str, ...]:
    """Specs of the methods compared by default where judgements have a time limit.

    Methods that were made for both questions stand in the list once a question.
    """
    specs = (
        "fbs", "sme", "equilibrium", "equilibrium:margin=0.01", "equilibrium:time=0.3", "settling",
        *(f"{TUNED}@{engine}" for engine in tuned_engines()), "lstm_e",
        *(one.method for one in PREFERENCES if one.engine and one.question == Question.WITHIN),
    )  # fmt: skip
    return tuple(
        with_question(spec, question)
        for spec in specs
        for question in each_question(parse_spec(spec).name) or (Question.WITHIN,)
    )


PART = "test"
"""Part of the labelled sets; nothing was tuned, trained or fitted on it."""

SHARD_SIZE, LIMITED_SHARD_SIZE = 60, 12
"""Cases a unit of work, without and with a time limit."""

TIMED, _PLANAR_TIMED = 100, 20
"""Largest numbers of cases a scenario that are timed, and of the planar set: its times only tell
what a 2-D engine saves."""

SMALL_CASES, PALLETS = 60, 60
"""With a time limit, cases a scenario of the large set that are judged beside the set `real`, and
customers' pallets that are judged on several floors."""

_FEW = 0.1
"""Largest share of the timed cases that a method may refuse and still be timed on the others."""

_PUBLISHED = "the published page has it"
_NO_PLANAR = "judges planar layouts alone, which this page does not show"


@dataclass(frozen=True)
class Options:
    """Cases and methods that are judged and timed; other fields are options of the study.

    Attributes:
        questions: whose labels and methods the page shows. What is judged and timed does not depend
            on it, but that planar layouts have no labels of the question ``stands``.
        timeout: CPU seconds a judgement may take; None for no limit. With a limit there are no
            planar layouts and no timing pass.
        published: work folder of a published page, whose verdicts and times are shown, too.
        kept: specs of the methods that these are of.
        spatial: specs of the methods that judge 3-D layouts.
        planar: specs of those on 2-D engines.
        left_out: by spec, the reason why a method that nobody named cannot judge.

    Raises:
        StudyError: a number out of range, or no method judges 3-D layouts.
    """

    methods: tuple[str, ...] = ()
    directory: str = ""
    questions: tuple[Question, ...] = (Question.WITHIN,)
    limit: int | None = None
    timeout: float | None = None
    published: Path | None = None
    kept: tuple[str, ...] = ()
    spatial: tuple[str, ...] = field(init=False)
    planar: tuple[str, ...] = field(init=False)
    left_out: Mapping[str, str] = field(init=False)

    def __post_init__(self) -> None:
        if self.limit is not None and self.limit < 1:
            raise StudyError(f"limit is {self.limit}; allowed: 1 or more")
        usual = standard_methods if self.timeout is None else limited_methods
        able, left_out = able_methods(self.methods, usual)
        left_out |= dict.fromkeys(set(able).intersection(self.kept), _PUBLISHED)
        able = tuple(spec for spec in able if spec not in self.kept)
        if not able:
            raise StudyError(
                f"methods {', '.join(self.methods)}: the published page has them all; name another"
            )
        planar = tuple(spec for spec in able if _is_planar(spec))
        spatial = tuple(spec for spec in able if spec not in planar)
        if not spatial:
            raise StudyError(
                f"methods {', '.join(able)}: none judges layouts in space; name one more, such as "
                "sme"
            )
        without = Question.WITHIN not in self.questions or self.timeout is not None
        if planar and (without or self.published):
            left_out |= dict.fromkeys(planar, _NO_PLANAR)
            planar = ()
        vars(self).update(spatial=spatial, planar=planar, left_out=left_out)

    def shown(self, question: Question) -> tuple[str, ...]:
        """Specs of the 3-D methods that the page shows for a question.

        Of a method that stands in the list once a question only the one that judges this one;
        of named methods all, where the page is of one question.
        """
        specs = (*self.kept, *self.spatial)
        if len(self.questions) > 1:
            return tuple(s for s in specs if asked_question(s) in (None, question))
        if self.methods and not self.kept:
            return self.spatial
        stands = {spec for spec in specs if asked_question(spec) == Question.STANDS}
        if question == Question.WITHIN:
            return tuple(spec for spec in specs if spec not in stands)
        return tuple(s for s in specs if with_question(s, Question.STANDS) not in stands)

    @property
    def definitions(self) -> Mapping[str, StudyDefinition]:
        """By run folder, the runs on labelled sets: all 3-D methods on their set comes first.

        Kept rows lie in folders and studies of these names.
        """
        limited = self.timeout is not None
        define = partial(
            StudyDefinition, benchmark=PART, timeout=self.timeout,
            shard_size=LIMITED_SHARD_SIZE if limited else SHARD_SIZE,
        )  # fmt: skip
        named = set_named(self.directory)
        of_set = partial(define, methods=self.spatial, benchmark_directory=named, limit=self.limit)
        if limited:
            most = min(SMALL_CASES, self.limit or SMALL_CASES)
            small = {SMALL: define("real small", self.spatial, limit=most)}
            return {REAL: of_set("real"), **(small if self.directory == "real" else {})}
        planar = define(
            f"table5 {PLANAR}", (*self.shown(Question.WITHIN), *self.planar),
            benchmark_directory=PLANAR, limit=self.limit,
        )  # fmt: skip
        return {SPATIAL: of_set("table5"), **({PLANAR: planar} if self.planar else {})}


@dataclass(frozen=True)
class Timed:
    """The timing pass of a set.

    Attributes:
        cases: (layout, scenario) in the order of the times.
        times: of the methods that were timed.
        untimed: by spec, the reason why a method was not timed.
        refused: by spec, number of cases that no method was timed on because this one refuses them.
    """

    cases: tuple[tuple[str, str], ...]
    times: Times
    untimed: Mapping[str, str]
    refused: Mapping[str, int]

    def among(self, cases: pd.Index) -> Timed:
        """The same with the times of those cases alone that are among some."""
        kept = pd.MultiIndex.from_tuples(self.cases, names=KEYS).isin(cases)
        cpu, wall = (
            {spec: taken[:, kept] for spec, taken in clock.items()}
            for clock in (self.times.cpu, self.times.wall)
        )
        chosen = tuple(case for case, is_kept in zip(self.cases, kept, strict=True) if is_kept)
        times = dataclasses.replace(self.times, cpu=cpu, wall=wall)
        return dataclasses.replace(self, cases=chosen, times=times)


class Ran(NamedTuple):
    """A run on a labelled set: its definition and folder, its timing pass if there was one, and the
    folder of the published run beside it if there is one.
    """

    definition: StudyDefinition
    folder: Path
    timed: Timed | None
    published: Path | None = None

    @property
    def folders(self) -> tuple[Path, ...]:
        """The folders of verdicts, that of the published ones first."""
        return (self.folder,) if self.published is None else (self.published, self.folder)

    def judged(self) -> JudgedCases:
        """The cases that all methods have judged, published ones too."""
        return reduce(JudgedCases.beside, map(load_judged, self.folders))


def beside_published(lab: Lab, asked: Options) -> Options:
    """Options by which methods are judged on the cases of the published page of their question."""
    page = "evaluation_real" if len(asked.questions) > 1 else {
        Question.WITHIN: "evaluation", Question.STANDS: "evaluation_stands"
    }[asked.questions[0]]  # fmt: skip
    work = unpacked_rows(page, lab.work / "published")
    manifest = load_manifest(work / (REAL if len(asked.questions) > 1 else SPATIAL))
    kept = manifest["study"]
    limit = min((n for n in (asked.limit, kept["limit"]) if n is not None), default=None)
    return dataclasses.replace(
        asked, directory=manifest["labels"]["set"], limit=limit, timeout=kept["timeout"],
        published=work, kept=tuple(kept["methods"]),
    )  # fmt: skip


def judged_and_timed(lab: Lab, asked: Options) -> Mapping[str, Ran]:
    """Judge all cases, then time some; an interrupted run is resumed. By folder, as
    :attr:`Options.definitions`; with 0 workers the timing is in this process, else in one beside.
    """
    if (lab.work / "manifest.json").exists():  # its page would be overwritten
        name = load_manifest(lab.work)["study"]["name"]
        raise ResultsError(f"{lab.work}: holds the study {name!r}; choose another folder")
    for name, definition in asked.definitions.items():
        run(lab, definition, name)
    return {
        name: Ran(
            definition, lab.work / name,
            _timed(lab, asked, definition, name) if asked.timeout is None else None,
            None if asked.published is None else asked.published / name,
        )
        for name, definition in asked.definitions.items()
    }  # fmt: skip


def run(lab: Lab, definition: StudyDefinition, name: str) -> None:
    """Judge what is missing of a run in a folder of the lab."""
    run_study(
        definition, lab.work / name, workers=lab.workers,
        progress=lambda *of: lab.progress("judging", *of),
    )  # fmt: skip


def _timed(lab: Lab, asked: Options, definition: StudyDefinition, name: str) -> Timed:
    folder, is_planar = lab.work / name, definition.benchmark_directory == PLANAR
    most = _PLANAR_TIMED if is_planar else TIMED
    fewer = dataclasses.replace(definition, limit=min(most, asked.limit or most))
    cases = {(layout.name, str(scenario)): layout for scenario, layout in labelled_cases(fewer)}
    untimed, refused = _not_judged(folder, list(cases))
    for case in set().union(*refused.values()):
        del cases[case]
    times = timed(
        [spec for spec in definition.methods if spec not in untimed],
        list(cases.values()),
        folder / "times",
        repeats=1,
        block=BLOCK,
        workers=lab.workers,
        progress=lambda *of: lab.progress("timing", *of),
    )
    own = Timed(tuple(cases), times, untimed, {spec: len(own) for spec, own in refused.items()})
    return own if asked.published is None else _beside_kept(own, cases, asked.published / name)


def _beside_kept(own: Timed, layouts: Mapping[tuple[str, str], Layout], published: Path) -> Timed:
    """A timing pass with the kept times of published methods, on the cases that both have."""
    kept = kept_times(published / "times").set_index(["method", "layout_hash"])
    clocks = [1e-6 * kept[f"timed_{clock}_ns"].unstack("method") for clock in ("cpu", "wall")]
    timed = [layouts[case].content_hash() in clocks[0].index for case in own.cases]
    found = own.among(pd.MultiIndex.from_tuples(own.cases)[timed])
    places = [layouts[case].content_hash() for case in found.cases]
    cpu, wall = (
        {spec: clock.loc[places, spec].to_numpy()[np.newaxis] for spec in clock} for clock in clocks
    )
    times = dataclasses.replace(
        found.times, cpu=cpu | found.times.cpu, wall=wall | found.times.wall
    )
    untimed, _ = _not_judged(published, own.cases)
    return dataclasses.replace(found, times=times, untimed={**untimed, **own.untimed})


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


def tunings(specs: Iterable[str]) -> dict[str, str]:
    """By spec of a simulation, a text of its parameters, equal for equal parameters.

    A tuned preset has different ones on every engine; parameters of a single engine are left out.
    """
    methods = [make_method(spec) for spec in specs]
    return {
        str(m.spec): tuning(as_plain(m.parameters)) for m in methods if isinstance(m, Simulation)
    }
