"""The file of a plan: TOML, validated when it is read."""

from __future__ import annotations

from pathlib import Path

from steadyload.config import bind
from steadyload.errors import nearest
from steadyload.escaping import shown
from steadyload.layouts.benchmark.parts import SETS
from steadyload.learners import LearnerError
from steadyload.learners.jobs import BENCHMARK
from steadyload.learners.plans.plan import Plan, Section
from steadyload.methods.contract.spec import SpecError
from steadyload.methods.registry import make_method
from steadyload.reading import own_file, toml_of


def load_plan(path: Path | None = None) -> Plan:
    """Read a plan; None reads the one that comes with the package.

    Raises:
        LearnerError: not valid TOML, an unknown key or name, or a value that is not allowed.
        TooLargeError: it has too many bytes.
        OSError: the file cannot be read.
    """
    path = path or own_file("steadyload.learners.plans", "plan.toml")
    content = toml_of(path, LearnerError)
    if isinstance(tables := content.get("trainings"), dict):
        content["trainings"] = {name: _named(name, table) for name, table in tables.items()}
    plan = bind(Plan, content, str(path), LearnerError)
    try:
        _check_names(plan)
    except (LearnerError, SpecError) as error:
        raise LearnerError(f"{path}: {error}") from None
    return plan


def _named(name: str, table: object) -> object:
    """The table of a training, which has its name for a title unless it states one."""
    return {"title": name, "name": name, **table} if isinstance(table, dict) else table


def _check_names(plan: Plan) -> None:
    """Check that all names of the plan are defined."""
    for name in plan.named(plan.sections()):
        if name not in plan.trainings:
            raise LearnerError(f"training {shown(name)}; {nearest(name, plan.trainings)}")
    for key, training in plan.trainings.items():
        if training.name != key:
            raise LearnerError(
                f"trainings[{key}]: name is {shown(training.name)}; allowed: {shown(key)}"
            )
        where = f"trainings.{training.name}"
        for name in training.data:
            if name not in (*plan.sets, BENCHMARK):
                raise LearnerError(f"{where}: data {shown(name)}; {nearest(name, plan.sets)}")
        seen = training
        for _ in plan.trainings:
            if not seen.start:
                break
            if seen.start not in plan.trainings:
                raise LearnerError(f"{where}: start {shown(seen.start)}; none of that name")
            if not set(seen.seeds) <= set(plan.trainings[seen.start].seeds):
                raise LearnerError(
                    f"{where}: {shown(seen.start)} is not trained with all its seeds"
                )
            seen = plan.trainings[seen.start]
        else:
            raise LearnerError(f"{where}: starts from itself in the end")
    for spec in plan.method_names([Section.TABLE, Section.FOREIGN]):
        make_method(spec)
    if (table := plan.table) is not None:
        known = (*table.methods, *table.trainings)
        if table.held not in known:
            raise LearnerError(f"table: held is {shown(table.held)}; {nearest(table.held, known)}")
    at = plan.directory
    if at and at not in SETS and not Path(at).is_dir():
        raise LearnerError(f"directory {shown(at)} is no folder; {nearest(at, SETS)}")
