"""Choice of a method: accuracy against CPU time, as measured on a labelled set.

Measurements come from the run folder of a study on a labelled set, or of Table 5, which has a
separate timing pass. Those of the package (``front.json``) are of such a run, stored by
``steadyload recommend --from RUN --write``.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from steadyload.atomic import manifest_text, verified_manifest, write_atomically
from steadyload.engines.registry import engines
from steadyload.errors import UserError, nearest
from steadyload.runs.evaluation import MethodEvaluation, evaluate
from steadyload.runs.results import load_manifest
from steadyload.statistics.estimate import Estimate
from steadyload.studies.comparison.summary import manifest_lines

NAME = "front.json"
"""The file in a run folder that holds its front, where there was a timing pass."""

SPATIAL = "spatial"
"""The folder in a run folder of Table 5 that holds the rows of 3-D methods."""

FILE = Path(str(resources.files("steadyload.studies.table5"))) / NAME
"""The measurements that come with the package."""


class FrontError(UserError):
    """No measured method meets the requirements, or nothing was measured."""


@dataclass(frozen=True, slots=True)
class Measured:
    """Measured accuracy and cost of a method.

    Attributes:
        method: its spec.
        title: shown in tables.
        engine: the engine that it runs on; None for one without.
        accuracy: share of cases with the label's failing step.
        cpu: CPU time a layout [ms].
    """

    method: str
    title: str
    engine: str | None
    accuracy: Estimate
    cpu: Estimate


@dataclass(frozen=True)
class Front:
    """Methods that were measured on the same cases.

    Attributes:
        measured: all of them, in the order of the run.
        about: description of the cases and the machine of the measurement.
    """

    measured: tuple[Measured, ...]
    about: Mapping[str, str]


def measured_in(run: str | Path) -> Front:
    """Measurements of a run folder, from its :data:`NAME` where it has one.

    Raises:
        ResultsError: not a run folder, or no case in it has been judged by all methods yet.
        FrontError: its layouts have no labels, its :data:`NAME` is damaged, or it is a Table 5
            that is not complete yet.
    """
    if (kept := Path(run) / NAME).exists():
        return load_front(kept)
    if (Path(run) / SPATIAL).exists():
        raise FrontError(
            f"{run}: Table 5 is not whole there yet; go on with steadyload table5 --work {run}"
        )
    evaluation = evaluate(run, by_scenario=False)
    if evaluation.labelled is None:
        raise FrontError(f"{run}: its layouts have no labels, so that no accuracy is known")
    labels = load_manifest(run)["labels"]
    on = f"{labels['cases']} cases of part {labels['part']}"
    if "set" in labels:
        on += f" of the set {labels['set']}"
    lists = evaluation.labelled.item_lists
    return Front(
        tuple(map(measured, evaluation.methods)),
        {"measured on": f"{on}, {lists} item lists", **manifest_lines(evaluation.judged)},
    )


def measured(row: MethodEvaluation) -> Measured:
    """Accuracy and cost of a method, as an evaluation has them."""
    key = row.method
    return Measured(key.spec, key.title, key.engine, row.accuracy, row.cpu)


def load_front(file: Path = FILE) -> Front:
    """The measurements that come with the package.

    Raises:
        FrontError: the file is missing or damaged.
    """
    try:
        content = verified_manifest(json.loads(file.read_bytes()))
        about = content["about"]
        if not {"measured on", "machine"} <= about.keys():  # the command prints them of any front
            raise KeyError
        if not all(isinstance(text, str) for text in about.values()):
            raise TypeError
        return Front(tuple(map(_read, content["measured"])), about)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise FrontError(
            f"{file}: holds no measured methods; name the folder of a study on a labelled set: "
            "steadyload recommend --from RUN"
        ) from None


def _read(entry: Mapping[str, Any]) -> Measured:
    estimates = {name: Estimate(**entry[name]) for name in ("accuracy", "cpu")}
    found = Measured(**{**entry, **estimates})
    texts = found.method, found.title, found.engine or ""
    numbers = [number for each in estimates.values() for number in dataclasses.astuple(each)]
    if not all(isinstance(text, str) for text in texts):
        raise TypeError
    if not all(isinstance(number, int | float) or number is None for number in numbers):
        raise TypeError
    return found


def write_front(front: Front, file: Path = FILE) -> Path:
    """Write measurements over those of an earlier run; returns the file."""
    content = {
        "about": dict(front.about),
        "measured": [dataclasses.asdict(entry) for entry in front.measured],
    }
    write_atomically(file, manifest_text(content))
    return file


def best(front: Front, engine: str | None = None) -> list[Measured]:
    """Methods than which no cheaper one is as accurate, by rising cost.

    Args:
        front: the measurements.
        engine: only methods on this engine, and those that need none; None for all.

    Raises:
        FrontError: no such engine, or no such method was measured.
    """
    if engine is not None and engine not in engines():
        raise FrontError(f"unknown engine {engine!r}; {nearest(engine, engines())}")
    asked = [m for m in front.measured if engine is None or m.engine in (None, engine)]
    found: list[Measured] = []
    for entry in sorted(asked, key=lambda m: (m.cpu.value, -m.accuracy.value)):
        if not found or entry.accuracy.value > found[-1].accuracy.value:
            found.append(entry)
    if not found:
        raise FrontError("no such method was measured")
    return found


def recommend(
    front: Front,
    *,
    budget: float | None = None,
    accuracy: float | None = None,
    engine: str | None = None,
) -> Measured:
    """The method to use: the most accurate one within a budget, or the cheapest accurate enough.

    Args:
        front: the measurements.
        budget: CPU time that a layout may take [ms]; None for any.
        accuracy: share of cases that must be right; None for any. With both, the result is the
            most accurate method that meets both.
        engine: see :func:`best`.

    Raises:
        FrontError: no method meets the requirements; the message names the closest one.
    """
    asked = best(front, engine)
    cheap = [m for m in asked if budget is None or m.cpu.value <= budget]
    if not cheap:
        raise FrontError(
            f"budget is {budget:g} ms a layout; the cheapest measured: {described(asked[0])}"
        )
    fit = [m for m in cheap if accuracy is None or m.accuracy.value >= accuracy]
    if not fit:
        within = "" if budget is None else f" within {budget:g} ms"
        raise FrontError(
            f"accuracy is {100 * (accuracy or 0.0):g} %; the most accurate measured{within}: "
            f"{described(cheap[-1])}"
        )
    return fit[-1] if budget is not None or accuracy is None else fit[0]


def described(entry: Measured) -> str:
    """Sentence on the accuracy and cost of a method."""
    share = entry.accuracy
    return (
        f"{entry.method} is right in {100 * share.value:.1f} % of cases "
        f"[{100 * share.low:.1f}, {100 * share.high:.1f}] and takes {entry.cpu.value:.3g} ms"
    )
