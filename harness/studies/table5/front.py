"""Which method to use: accuracy against CPU time, as it was measured on a labelled set.

What was measured comes from the run folder of a study on a labelled set, or of Table 5, whose times
were taken apart. What comes with the package (``front.json``) is such a run, kept by ``steadyload
recommend --from RUN --write``.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from steadyload.atomic import write_atomically
from steadyload.engines.registry import engines
from steadyload.errors import UserError, nearest
from steadyload.runs.evaluation import MethodEvaluation, evaluate
from steadyload.runs.results import load_manifest
from steadyload.statistics.estimate import Estimate
from steadyload.studies.comparison.summary import manifest_lines
from steadyload.studies.table5.records import Table5

NAME = "front.json"
"""The file in a run folder that holds its front, where times were taken apart."""

SPATIAL = "spatial"
"""The folder in a run folder of Table 5 that holds the rows of layouts in space."""

FILE = Path(str(resources.files("steadyload.studies.table5"))) / NAME
"""What was measured and comes with the package."""


class FrontError(UserError):
    """No measured method is what was asked for, or nothing was measured."""


@dataclass(frozen=True, slots=True)
class Measured:
    """A method as it was measured.

    Attributes:
        method: its spec.
        title: for people.
        engine: that it runs on; None for one without.
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
        about: what they were measured on and with, for people.
    """

    measured: tuple[Measured, ...]
    about: Mapping[str, str]


def timed_front(found: Table5) -> Front:
    """Methods in space of Table 5, with the times of its timing pass; those untimed are left out.

    Args:
        found: the page.
    """
    own = found.spatial
    measured = tuple(_measured(row) for row in own.evaluation.methods if row.cpu.n)
    on = f"{found.manifest['labelled set']}, {own.about.item_lists} item lists"
    timed = f"{own.timing.layouts} cases, {own.timing.repeats} times each, one thread"
    return Front(measured, {"measured on": on, "timed on": timed, **found.manifest})


def measured_in(run: str | Path) -> Front:
    """What a run folder holds: its :data:`NAME` where it has one.

    Raises:
        ResultsError: not a run folder, or no case in it has been judged by all methods yet.
        FrontError: its layouts have no labels, its :data:`NAME` is damaged, or it is a Table 5
            that is not whole yet.
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
    measured = tuple(_measured(row) for row in evaluation.methods)
    labels = load_manifest(run)["labels"]
    on = f"{labels['cases']} cases of part {labels['part']}"
    if "set" in labels:
        on += f" of the set {labels['set']}"
    lists = evaluation.labelled.item_lists
    return Front(
        measured, {"measured on": f"{on}, {lists} item lists", **manifest_lines(evaluation.judged)}
    )


def _measured(row: MethodEvaluation) -> Measured:
    key = row.method
    return Measured(key.spec, key.title, key.engine, row.accuracy, row.cpu)


def load_front(file: Path = FILE) -> Front:
    """What comes with the package.

    Raises:
        FrontError: the file is not there, or is damaged.
    """
    try:
        content = json.loads(file.read_text())
        measured = tuple(
            Measured(
                **{
                    **entry,
                    "accuracy": Estimate(**entry["accuracy"]),
                    "cpu": Estimate(**entry["cpu"]),
                }
            )
            for entry in content["measured"]
        )
        about = content["about"]
        if not {"measured on", "machine"} <= about.keys():  # what the command tells of any front
            raise KeyError
        return Front(measured, about)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise FrontError(
            f"{file}: holds no measured methods; name the folder of a study on a labelled set: "
            "steadyload recommend --from RUN"
        ) from None


def write_front(front: Front, file: Path = FILE) -> Path:
    """Keep what was measured in the place of what was kept before; returns the file."""
    content = {
        "about": dict(front.about),
        "measured": [dataclasses.asdict(entry) for entry in front.measured],
    }
    write_atomically(file, json.dumps(content, indent=1) + "\n")
    return file


def best(front: Front, engine: str | None = None) -> list[Measured]:
    """Methods that no other is as accurate as at a lower cost, by rising cost.

    Args:
        front: what was measured.
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
        front: what was measured.
        budget: CPU time that a layout may take [ms]; None for any.
        accuracy: share of cases that must be right; None for any. With a budget, too, the method
            is the most accurate one of those that are both.
        engine: see :func:`best`.

    Raises:
        FrontError: no method is so; says which comes closest.
    """
    asked = best(front, engine)
    cheap = [m for m in asked if budget is None or m.cpu.value <= budget]
    if not cheap:
        raise FrontError(
            f"budget is {budget:g} ms a layout; the cheapest measured: {told(asked[0])}"
        )
    fit = [m for m in cheap if accuracy is None or m.accuracy.value >= accuracy]
    if not fit:
        within = "" if budget is None else f" within {budget:g} ms"
        raise FrontError(
            f"accuracy is {100 * (accuracy or 0.0):g} %; the most accurate measured{within}: "
            f"{told(cheap[-1])}"
        )
    return fit[-1] if budget is not None or accuracy is None else fit[0]


def told(entry: Measured) -> str:
    """What a method reaches and costs, in words."""
    share = entry.accuracy
    return (
        f"{entry.method} is right in {100 * share.value:.1f} % of cases "
        f"[{100 * share.low:.1f}, {100 * share.high:.1f}] and takes {entry.cpu.value:.3g} ms"
    )
