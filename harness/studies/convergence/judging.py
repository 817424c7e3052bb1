"""Convergence study: the reference under other numerics and models, and other methods, judged."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.layouts.benchmark.parts import LISTS, Part
from steadyload.layouts.model.question import Question
from steadyload.methods.registry import make_method
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.labels import item_lists, load_labels
from steadyload.runs.provenance import provenance_lines
from steadyload.runs.results import load_manifest, load_results
from steadyload.runs.runner import run_study
from steadyload.studies.kit import Lab

BASE = "label@reference"
CASES = {Question.WITHIN: 100, Question.STANDS: 67}
"""Cases a scenario by question, for the reference, its decisive variants and other engines."""

SAMPLE = 17
"""Cases a scenario for slow methods."""

SECONDS = 30.0
"""CPU time in which a slow method has to judge a case; one that rattles may take it hours."""

SWEPT = 67
"""Cases a scenario for the variants that are not :attr:`Variant.decisive`."""

ITEM_LIST = "item_list"
"""Column of results: the item list of the case, within its class of items."""

_STIFFNESSES = (1e5, 1e6, 1e7, 3e7, 1e8, 3e8, 3e9, 1e10)
_STIFFNESS, _MOST_RATE = 1e9, 3e4
"""Of the default contacts [N/m, rad/s]. Both change together: one limits heavy items, one light."""


@dataclass(frozen=True, slots=True)
class Variant:
    """One change of the reference.

    ``value``: position on the axis of a plot, where it is a number. A ``decisive`` change is tried
    on all cases, any other on the first :data:`SWEPT` of a scenario.
    """

    group: str
    title: str
    changes: str
    value: float | None = None
    decisive: bool = False

    @property
    def spec(self) -> str:
        """The changed method."""
        return canonical(f"{BASE}:{self.changes}")


def canonical(text: str, question: Question = Question.WITHIN) -> str:
    """The spec of a method as rows name it, with the question unless it is that of the label."""
    spec = make_method(text).spec
    if question != Question.WITHIN:
        spec = make_method(str(spec.stating("question", question))).spec
    return str(spec)


def _sweep(
    group: str, parameter: str, values: Sequence[float], decisive: Sequence[float] = ()
) -> list[Variant]:
    return [
        Variant(group, f"{parameter} {v:g}", f"{parameter}={v!r}", v, v in decisive) for v in values
    ]


VARIANTS: tuple[Variant, ...] = (
    *_sweep("tolerance [m]", "tolerance", (1e-5, 1e-6, 1e-8), (1e-6, 1e-8)),
    *(
        Variant(
            "stiffness [N/m]",
            f"stiffness {k:g}",
            f"stiffness={k!r},most_rate={_MOST_RATE * math.sqrt(k / _STIFFNESS)!r}",
            k,
            k == 1e8,
        )
        for k in _STIFFNESSES
    ),
    *_sweep("damping time [s]", "damping_time", (3e-4, 1e-3, 1e-2)),
    *_sweep("depth of full damping [m]", "damping_depth", (1e-9, 1e-7, 1e-6)),
    *_sweep("stiction speed [m/s]", "stiction_speed", (1e-5, 1e-3)),
    *_sweep("longest step [s]", "most_time", (1e-3,)),
    *_sweep("position jitter [m]", "jitter", (1e-6, 1e-5, 1e-4)),
    *_sweep("lateral shrink [m]", "shrink", (1e-5, 1e-4)),
    *_sweep("friction", "friction", (0.4, 0.6)),
    Variant("friction", "dynamic friction 0.375", "dynamic_share=0.75"),
    *_sweep("time [s]", "t_max", (0.2, 0.27, 0.33, 0.6)),
    Variant("thresholds", "9 cm and 9 degrees", "eps_t=9,eps_r=9"),
    Variant("thresholds", "11 cm and 11 degrees", "eps_t=11,eps_r=11"),
    Variant("loading", "carry instead of reseat", "between_steps=carry"),
    Variant("loading", "criterion of the paper", "criterion=paper,early_exit=0"),
)
"""Every change of the reference in the study; groups are tables and plots."""

OF_STANDS = frozenset(
    {
        "tolerance 1e-06", "tolerance 1e-08", "stiffness 100000", "stiffness 1e+06",
        "stiffness 1e+07", "stiffness 1e+08", "damping_depth 1e-07", "stiction_speed 0.001",
        "most_time 0.001",
    }
)  # fmt: skip
"""Titles of the changes that are tried for the question ``stands``, too, of which a case takes the
reference two to three times as long."""

ENGINES: tuple[str, ...] = tuple(
    f"label@{engine}:frequency={frequency}"
    for engine, frequencies in (
        ("mujoco", (90, 240, 480, 1000)),
        ("bullet", (90, 240, 480, 1000)),
        ("dart", (90, 240, 480)),
    )
    for frequency in frequencies
)
"""Other methods under the label's criterion, on all cases."""

OPINIONS: tuple[str, ...] = (
    "label@reference:integrator=radau,tolerance=1e-6",  # the engine's own are a hundredth of these
    "label@reference:contact=adams",
)
"""Slow methods, on a sample of the cases."""

SECOND_MODEL = "label@drake"
"""Another slow method, with a contact model of its own; optional."""

LOOKED_AT = ("label@mujoco:frequency=480", "label@bullet:frequency=480")
"""Methods whose every disagreement with the reference the page lists."""


def convergence_studies(
    opinions: Sequence[str] = OPINIONS,
    question: Question = Question.WITHIN,
    limit: int | None = None,
) -> dict[str, StudyDefinition]:
    """Definitions of the runs, by the name of their folder; all on the first of the same cases.

    Args:
        opinions: the slow methods.
        question: asked of all; for ``stands`` there are no other engines and no slow methods.
        limit: most cases a scenario of a run; None for all.
    """
    within = question == Question.WITHIN
    tried = [v for v in VARIANTS if within or v.title in OF_STANDS]
    decisive = [v.spec for v in tried if v.decisive]
    other = [v.spec for v in tried if not v.decisive]
    engines = ENGINES if within else ()
    parts: dict[str, tuple[list[str], int, int, float | None]] = {
        "all": ([BASE, *decisive, *engines], CASES[question], 30, None),
        "sweep": ([BASE, *other], SWEPT, 30, None),
    }
    if within:
        parts["opinions"] = ([BASE, *opinions], SAMPLE, 5, SECONDS)
    of = "" if within else f"{question}-"
    return {
        of + name: StudyDefinition(
            of + name, tuple(canonical(method, question) for method in methods),
            benchmark=Part.TEST, benchmark_directory=LISTS, limit=min(count, limit or count),
            shard_size=size, timeout=seconds,
        )
        for name, (methods, count, size, seconds) in parts.items()
    }  # fmt: skip


def judged(
    lab: Lab, opinions: Sequence[str], question: Question, limit: int | None
) -> dict[str, pd.DataFrame]:
    """The results of each run of :func:`convergence_studies`, with the column :data:`ITEM_LIST`;
    missing rows are judged. Methods have their names without the question.
    """
    for spec in opinions:  # so that a missing library is reported at once, not after an hour
        make_method(spec).prepare()
    every = (BASE, *(variant.spec for variant in VARIANTS), *ENGINES, *opinions)
    names = {canonical(spec, question): canonical(spec) for spec in every}
    frames = {}
    for name, study in convergence_studies(opinions, question, limit).items():
        lab.work.mkdir(parents=True, exist_ok=True)
        run_study(
            study, lab.work / name, workers=lab.workers,
            progress=lambda *of: lab.progress("judging", *of),
        )  # fmt: skip
        labels = load_labels(lab.work / name)
        lists = pd.Series(item_lists(labels), labels.index, name=ITEM_LIST)
        rows = load_results(lab.work / name)
        rows["method"] = rows["method"].map(names)
        frames[name] = rows.join(lists, on=KEYS)
    return frames


def made_with(folders: Iterable[Path]) -> dict[str, str]:
    """Provenance of the results in some folders, as a page shows it, separately by part."""
    lines: dict[str, str] = {}
    for folder in sorted(folders):
        manifest = load_manifest(folder)
        study, about = manifest["study"], manifest["labels"]
        lines[f"{study['name']}: cases"] = (
            f"{about['cases']} of part {about['part']} of {about['set']}"
        )
        lines |= provenance_lines(manifest, of=study["name"])
    return lines
