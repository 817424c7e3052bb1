"""Tables that a user hands in: every wrong value is refused by a sentence of the same form."""

import dataclasses
import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, get_args, get_type_hints

import pytest

from steadyload.cli.flags import read_config
from steadyload.config import ConfigError, bind
from steadyload.layouts.files.dialect import Dialect, DialectError, load_profile
from steadyload.learners import LearnerError
from steadyload.learners.options import TrainingPreset
from steadyload.learners.plans.plan import Plan
from steadyload.learners.plans.plan_file import load_plan
from steadyload.methods.contract.spec import SpecError
from steadyload.methods.registry import Preset
from steadyload.reading import toml_of
from steadyload.runs.definition import StudyDefinition, StudyError, load_study
from steadyload.studies.scope.study import Scope
from steadyload.transport.errors import TransportError
from steadyload.transport.rules import Rule, rule_named

RULE = {"levels": {"forwards": 0.3}, "rise": 0, "hold": 1, "rest": 0, "rotation": 5}
TRAINING = {"options": {"hidden": 8}, "seeds": [0, 1], "limit": 3}
PLAN = {
    "part": "validation",
    "sets": {"few": {"lists": 1, "label": "sme"}},
    "trainings": {"one": TRAINING},
    "table": {"methods": ["sme"], "held": "sme"},
    "size": [{"title": "few", "trainings": ["one"]}],
    "sources": {"baseline": "one", "trainings": ["one"]},
    "calibration": {"judges": ["one"]},
    "foreign": {"judges": ["lstm_1"], "others": ["sme"]},
}


@dataclass(frozen=True)
class Table:
    """A kind of table: its class, a valid one, where it stands in its file, and its reader."""

    cls: type
    valid: Mapping[str, Any]
    read: Any
    error: type
    under: str = ""
    not_stated: tuple[str, ...] = ()


def preset(cls, error):
    return lambda path: bind(cls, toml_of(path, error)["mine"], f"{path}: mine", error, name="mine")


TABLES = {
    "study": Table(
        StudyDefinition, {"methods": ["sme"], "generated": 1}, load_study, StudyError,
        not_stated=("name", "files", "dialect", "made"),
    ),
    "profile": Table(Dialect, {"columns": {"length": "L"}}, load_profile, DialectError),
    "rule": Table(
        Rule, RULE | {"displacement": 2}, lambda path: rule_named(str(path)), TransportError,
        "ours", ("name", "title", "source"),
    ),
    "plan": Table(Plan, PLAN, load_plan, LearnerError),
    "configuration": Table(Scope, {}, lambda path: read_config(path, Scope), ConfigError),
    "preset": Table(
        Preset, {"method": "pbs", "title": "a", "source": "b"}, preset(Preset, SpecError),
        SpecError, "mine", ("name",),
    ),
    "training preset": Table(
        TrainingPreset,
        {"title": "a", "options": {"hidden": 8}, "members": 1, "left_out": 0, "budget": 1},
        preset(TrainingPreset, LearnerError), LearnerError, "mine", ("name",),
    ),
}  # fmt: skip


def toml(value):
    """A value as TOML; a table stands in one line."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{json.dumps(k)} = {toml(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return f"[{', '.join(map(toml, value))}]"
    return value.text if isinstance(value, Literal) else json.dumps(value)


@dataclass(frozen=True)
class Literal:
    """A value of TOML that JSON has not."""

    text: str


DATE = Literal("1979-05-27")


def classes_of(hint):
    """The dataclass that a type is, or is made of; None where there is none."""
    if dataclasses.is_dataclass(hint):
        return hint
    return next(filter(None, map(classes_of, get_args(hint))), None)


def tables_in(cls, valid, way=()):
    """Every table of a valid one: its class, its place, and itself."""
    yield cls, way, valid
    hints = get_type_hints(cls)
    for name, value in valid.items():
        inner = classes_of(hints[name])
        if inner is None:
            continue
        if isinstance(value, list):
            yield from tables_in(inner, value[0], (*way, name, 0))
        elif dataclasses.is_dataclass(hints[name]) or type(None) in get_args(hints[name]):
            yield from tables_in(inner, value, (*way, name))
        else:
            for key, each in value.items():
                yield from tables_in(inner, each, (*way, name, key))


def changed(valid, way, change):
    """A valid table of which one, at a place, is changed."""
    if not way:
        return change(valid)
    first, *rest = way
    made = list(valid) if isinstance(valid, list) else dict(valid)
    made[first] = changed(valid[first], rest, change)
    return made


def out_of_range(metadata):
    """Numbers below and above those of a field."""
    least, most = metadata.get("least", -math.inf), metadata.get("most", math.inf)
    return [number for number in (least - 1, most + 1) if math.isfinite(number)]


def cases():
    """Every wrong table: its kind, the place and name of the key, the wrong table, a pattern."""
    for kind, table in TABLES.items():
        for cls, way, valid in tables_in(table.cls, table.valid):
            hints, given = get_type_hints(cls), () if way else table.not_stated
            own = {one.name: one for one in dataclasses.fields(cls) if one.name not in given}
            nearest = max(own, key=len)

            def case(name, what, change, way=way, kind=kind, table=table):
                place = ".".join(map(str, (*way, name)))
                wrong = changed(table.valid, way, change)
                return pytest.param(table, wrong, what, id=f"{kind}-{place}")

            yield case(
                "unknown", rf"unknown key '{nearest}_'; did you mean '{nearest}'\? allowed: \S",
                lambda valid, name=f"{nearest}_": {**valid, name: 1},
            )  # fmt: skip
            for name, one in own.items():
                if hints[name] is not Any:
                    yield case(
                        name, rf"{name}\S* is \S.*; allowed: \S",
                        lambda valid, name=name: {**valid, name: DATE},
                    )  # fmt: skip
                several = get_args(hints[name])[1:] == (...,)
                for number in out_of_range(one.metadata) if "least" in one.metadata else ():
                    yield case(
                        name, rf"{name}\S* is \S+; allowed: a (whole )?number, \S",
                        lambda valid, name=name, value=[number] if several else number: {
                            **valid, name: {"forwards": value} if name == "levels" else value
                        },
                    )  # fmt: skip
                required = one.default is one.default_factory is dataclasses.MISSING
                if required and name in valid:
                    yield case(
                        name, rf"{name} is missing; allowed: \S",
                        lambda valid, name=name: {k: v for k, v in valid.items() if k != name},
                    )  # fmt: skip


def written(folder, table, content):
    path = folder / "mine.toml"
    content = {table.under: content} if table.under else content
    path.write_text("".join(f"{key} = {toml(value)}\n" for key, value in content.items()))
    return path


@pytest.mark.parametrize("table", TABLES.values(), ids=TABLES)
def test_a_valid_table_is_read(table, tmp_path):
    table.read(written(tmp_path, table, table.valid))


@pytest.mark.parametrize(("table", "content", "what"), [*cases()])
def test_a_wrong_table_is_refused_by_where_what_and_what_is_allowed(table, content, what, tmp_path):
    path = written(tmp_path, table, content)
    with pytest.raises(table.error) as caught:
        table.read(path)
    said = str(caught.value)
    assert re.match(rf"{re.escape(str(path))}: ([^;]*: )?{what}", said), said
