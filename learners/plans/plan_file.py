"""The file of a plan: TOML, validated when it is read."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import MISSING, fields
from importlib import resources
from pathlib import Path
from typing import Any, TypeVar

from steadyload.errors import nearest
from steadyload.layouts.benchmark import UNLEARNT, Part
from steadyload.layouts.files.record import shown
from steadyload.learners import LearnerError
from steadyload.learners.generation import GenerationOptions
from steadyload.learners.jobs import BENCHMARK
from steadyload.learners.options import options_from, training_preset
from steadyload.learners.plans.plan import (
    CalibrationPlan,
    Contrast,
    Curve,
    ForeignPlan,
    Plan,
    PlannedTraining,
    Section,
    TablePlan,
)
from steadyload.methods.contract.spec import SpecError
from steadyload.methods.registry import make_method
from steadyload.reading import toml_of

Named = TypeVar("Named")


def load_plan(path: Path | None = None) -> Plan:
    """Read a plan; None reads the one that comes with the package.

    Raises:
        LearnerError: not valid TOML, an unknown key or name, or a value that is not allowed.
        TooLargeError: it has too many bytes.
        OSError: the file cannot be read.
    """
    path = path or Path(str(resources.files("steadyload.learners.plans") / "plan.toml"))
    content = toml_of(path, LearnerError)
    try:
        return _plan(content)
    except (LearnerError, SpecError) as error:
        raise LearnerError(f"{path}: {error}") from None


def check_part(part: Any) -> None:
    """Check that a part of the labelled set is one on which nothing is trained.

    Raises:
        LearnerError: it is not.
    """
    if part not in UNLEARNT:
        raise LearnerError(f"part is {shown(part)}; {nearest(str(part), UNLEARNT)}")


def _plan(content: Mapping[str, Any]) -> Plan:
    _check_keys(content, [f.name for f in fields(Plan)], "the plan")
    part = content.get("part", str(Part.TEST))
    check_part(part)
    sets = {
        name: _made(GenerationOptions, table, f"sets.{name}")
        for name, table in _table(content, "sets").items()
    }
    trainings = {
        name: _training(name, table) for name, table in _table(content, "trainings").items()
    }
    kinds: dict[str, tuple[type[Any], bool]] = {
        Section.TABLE: (TablePlan, False),
        Section.SIZE: (Curve, True),
        Section.SOURCES: (Contrast, False),
        Section.REMEDIES: (Contrast, False),
        Section.CALIBRATION: (CalibrationPlan, False),
        Section.LEAK: (Contrast, True),
        Section.FOREIGN: (ForeignPlan, False),
    }
    found: dict[str, Any] = {
        str(section): tuple(_made(kind, table, section) for table in content[section])
        if many
        else _made(kind, content[section], section)
        for section, (kind, many) in kinds.items()
        if section in content
    }
    plan = Plan(Part(part), sets, trainings, **found)
    _check_names(plan)
    return plan


def _training(name: str, table: Mapping[str, Any]) -> PlannedTraining:
    where = f"trainings.{name}"
    made = _made(PlannedTraining, {"title": name, **table, "name": name}, where)
    training_preset(made.preset)
    options_from(made.options, where=where)
    if "seed" in made.options or not made.seeds or len(set(made.seeds)) < len(made.seeds):
        raise LearnerError(f"{where}: seeds are a list of their own, each once, one or more")
    return made


def _check_names(plan: Plan) -> None:
    """Check that all names of the plan are defined."""
    for name in plan.named(plan.sections()):
        if name not in plan.trainings:
            raise LearnerError(f"training {shown(name)}; {nearest(name, plan.trainings)}")
    for training in plan.trainings.values():
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
    table = plan.table
    if table is not None and table.held not in (*table.methods, *table.trainings):
        raise LearnerError(
            f"table: held is {shown(table.held)}; "
            f"{nearest(table.held, (*table.methods, *table.trainings))}"
        )


def _table(content: Mapping[str, Any], key: str) -> dict[str, Any]:
    table = content.get(key, {})
    if not isinstance(table, dict):
        raise LearnerError(f"{key} is {shown(table)}; allowed: a table of tables")
    return table


def _made(kind: Callable[..., Named], table: Any, where: str) -> Named:
    """A dataclass from a table; lists become tuples.

    Raises:
        LearnerError: an unknown or missing key, or a value of another type.
    """
    if not isinstance(table, dict):
        raise LearnerError(f"{where} is {shown(table)}; allowed: a table")
    known = {f.name: f for f in fields(kind)}  # type: ignore[arg-type]
    _check_keys(table, list(known), where)
    for name, each in known.items():
        if name not in table and each.default is MISSING and each.default_factory is MISSING:
            raise LearnerError(f"{where}: {name} is missing")
    values = {name: _value(table[name], str(known[name].type), where, name) for name in table}
    return kind(**values)


_TYPES: Mapping[str, tuple[tuple[type, ...], str]] = {
    "str": ((str,), "a text"),
    "int": ((int,), "a whole number, 0 or more"),
    "int | None": ((int,), "a whole number, 0 or more"),
    "float": ((float, int), "a number, 0 or more"),
    "bool": ((bool,), "true or false"),
    "tuple[str, ...]": ((str,), "a list of texts"),
    "tuple[int, ...]": ((int,), "a list of whole numbers, 0 or more"),
    "Mapping[str, Any]": ((dict,), "a table"),
}


def _value(value: Any, hint: str, where: str, name: str) -> Any:
    kinds, allowed = _TYPES[hint]
    many = hint.startswith("tuple")
    if many != isinstance(value, list) or not all(
        type(each) in kinds and not (type(each) in (int, float) and each < 0)
        for each in (value if many else [value])
    ):
        raise LearnerError(f"{where}: {name} is {shown(value)}; allowed: {allowed}")
    return tuple(value) if many else value


def _check_keys(table: Mapping[str, Any], known: Collection[str], where: str) -> None:
    for key in table:
        if key not in known:
            raise LearnerError(f"{where}: unknown key {shown(key)}; {nearest(key, known)}")
