"""Units of work that differ have other keys: no field of any unit is left out of its key.

A key that lacks a field finds the rows of another question, and says nothing. So every unit is
varied here, one field at a time, and a new class of units fails until it is varied, too.
"""

import dataclasses
import importlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import Enum
from functools import cache, partial
from pathlib import Path
from types import NoneType, SimpleNamespace, UnionType
from typing import Union, get_args, get_origin, get_type_hints

import numpy as np
import pandas as pd
import pytest

from steadyload.labelling import label_rows, screening
from steadyload.labelling.label_rows import TraceUnit
from steadyload.labelling.screened_loading import SCREEN, SCREENS
from steadyload.labelling.screening import ScreenedUnit
from steadyload.layouts.benchmark.parts import Part
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.packing.packing import random_layouts
from steadyload.learners import tested
from steadyload.learners.generation import GenerationOptions, ListUnit
from steadyload.learners.options import training_preset
from steadyload.learners.plans import verdicts
from steadyload.learners.plans.plan import Plan, PlannedTraining
from steadyload.learners.plans.trainings import Workshop
from steadyload.learners.plans.verdicts import JudgedPart
from steadyload.learners.sequences import sequences_of
from steadyload.measured.releases import Noise
from steadyload.properties.property import MethodUnderTest
from steadyload.properties.registry import PROPERTIES
from steadyload.runs import units
from steadyload.runs.asked import Asked, AskedCases
from steadyload.runs.blocks import block_unit, blocks_of
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.timing import BatchUnit, Turn
from steadyload.runs.units import study_units
from steadyload.runs.verdict_reliability import Sampling
from steadyload.studies.closed_forms.measuring import ClosedFormUnit
from steadyload.studies.engines.speed import SpeedUnit, ThroughputUnit
from steadyload.studies.extremes.running import CellUnit
from steadyload.studies.extremes.sizes import SizeUnit
from steadyload.studies.properties import testing as properties
from steadyload.studies.reality.fitting import FitUnit
from steadyload.studies.reality.record import Record, RecordUnit
from steadyload.studies.reality.releasing import JitterUnit, ReleasedUnit, Taken
from steadyload.studies.repair.confirming import EngineUnit, FirmnessUnit
from steadyload.studies.repair.ways import ChangeUnit
from steadyload.studies.scale.judging import InThreads, Many, OneByOne
from steadyload.studies.scale.measuring import Size
from steadyload.studies.session.packing_gains import PackingUnit
from steadyload.studies.session.placing import CurvesUnit
from steadyload.studies.transport import limits_of_loads as transport
from steadyload.studies.transport.limits_of_loads import LimitUnit
from steadyload.studies.uncertain import cases as uncertain_cases
from steadyload.studies.uncertain import sampling as uncertain
from steadyload.studies.uncertain.cases import SampledMethod
from steadyload.studies.uncertain.cases import Unit as CertaintyUnit

ROOT = Path(__file__).parents[2]
ROWS = ROOT / "reports" / "rows"
FOLDERS = {"harness": "", "engines": "engines.", "learners": "learners."}
ONE, OTHER = random_layouts(2, seed=5)
MADE = {"version of method": "1"}

WITHOUT_KEY = {
    "checking._Entry": "an answer to a person, which is not kept",
    "checked_page._Unit": "a card of a page, which is not kept",
    "repairs._Unit": "a repair for a person, which is not kept",
    "cost._Measurement": "the ledger of a search keeps the cost model, and states what it is of",
    "trial.TrialUnit": "the ledger of a search keeps trials, and states what they are of",
    "trainings.Run": "the name of its folder is its key",
}
"""Units whose results are in no shard, and why."""

NOT_IN_KEY = {
    "ListUnit.options": "the folder of the set states them",
    "GenerationOptions.lists": "a longer set begins with the same lists",
    "BlockUnit.layouts": "where they lie; their content is in the key",
    "BlockUnit.group": "where they lie; their content is in the key",
    "BlockUnit.count": "of the layouts in the key",
    "Load.of": "for people; the content of the layout is in the key",
    "Load.name": "for people; the content of the layout is in the key",
    "Load.item_list": "for statistics; the content of the layout is in the key",
    "NetworkTraining.name": "for messages and its checkpoint",
    "NetworkTraining.folder": "where its checkpoint lies",
    "PlannedTraining.title": "for people",
    "PlannedTraining.seeds": "a training each, and the seed is in the name of its folder",
}
"""Fields that change nothing in the results, and why."""

CASES_SAY = dict.fromkeys(
    (
        "name", "files", "generated", "scenarios", "seed", "max_items", "limit", "snap_gap",
        "overhang", "floor", "shard_size", "benchmark", "benchmark_directory", "dialect", "strict",
    ),
    "says which cases there are, and how they are cut; the cases of a unit are in its key",
)  # fmt: skip
"""Fields of a study that do not say how a case is judged, and why they need not be in a key."""


def altered(value):
    """Another value of the same kind."""
    if isinstance(value, Layout):
        return OTHER
    if isinstance(value, Enum):
        return next(each for each in type(value) if each is not value)
    if isinstance(value, bool):
        return not value
    if isinstance(value, int | float):
        return 2 * value + 1
    if isinstance(value, str):
        return f"{value}x"
    if isinstance(value, tuple):
        return (altered(value[0]), *value[1:])
    if isinstance(value, Mapping):
        return {**value, "numpy": "0"}
    if isinstance(value, Path):
        return value / "x"
    raise TypeError(f"{value!r}: say in a test what another one is")


def varied(thing, **others):
    """By name of a field of a dataclass, a copy with another value of that field.

    Args:
        thing: a dataclass; fields that are dataclasses are varied in turn.
        others: by field, another value where the usual one is none.
    """
    kind = type(thing).__name__
    for field in dataclasses.fields(thing):
        name, value = field.name, getattr(thing, field.name)
        if f"{kind}.{name}" in NOT_IN_KEY:
            continue
        if name in others:
            yield f"{kind}.{name}", replace(thing, **{name: others[name]})
        elif dataclasses.is_dataclass(value) and not isinstance(value, Layout):
            for inner, changed in varied(value, **others):
                yield inner, replace(thing, **{name: changed})
        else:
            yield f"{kind}.{name}", replace(thing, **{name: altered(value)})


def of_a_study(study, case=("as given", ONE), made=MADE):
    [unit, *_] = study_units(study, [case], dict.fromkeys(study.methods, made), size=12)
    return unit


def study_cases():
    study = StudyDefinition("one", ("sme",), repetitions=1, timeout=60.0)
    yield "", of_a_study(study)
    fields = {field.name for field in dataclasses.fields(study)} - CASES_SAY.keys()
    fields -= {"made"}  # of the methods
    others = {"methods": ("fbs",), "repetitions": 2, "timeout": 30.0}
    assert fields == others.keys(), "a new field of a study enters keys, or says why it does not"
    for name, value in others.items():
        yield name, of_a_study(replace(study, **{name: value}))
    yield "no timeout", of_a_study(replace(study, timeout=None))
    for name, case in cases_varied().items():
        yield name, of_a_study(study, case)
    yield "versions", of_a_study(study, made={"version of method": "2"})


def of_a_block(study, layout=ONE, made=MADE, method="sme"):
    [block] = blocks_of([layout])
    return block_unit(study, method, made, Path("x"), 0, block)


def block_units():
    study = StudyDefinition("one", ("sme",), timeout=60.0)
    yield "", of_a_block(study)
    yield "repetitions", of_a_block(replace(study, repetitions=2))
    yield "timeout", of_a_block(replace(study, timeout=None))
    yield "method", of_a_block(study, method="fbs")
    yield "versions", of_a_block(study, made={"version of method": "2"})
    yield "layout", of_a_block(study, replace(OTHER, name=ONE.name))
    yield "name of the layout", of_a_block(study, replace(ONE, name="x"))


def cases_varied():
    return {
        "scenario": ("s2", ONE),
        "layout": ("as given", replace(OTHER, name=ONE.name)),
        "name of the layout": ("as given", replace(ONE, name="x")),
    }


def property_units():
    asked = next(iter(PROPERTIES.values()))
    also = next(each for each in PROPERTIES.values() if each is not asked)
    always = [replace(each, applies=lambda subject: True) for each in (asked, also)]
    cases = dict.fromkeys((asked.name, also.name), 20)
    one = MethodUnderTest("sme")
    first, other = properties.units_of(one, always, cases, 0)
    yield "", first
    yield "properties", other
    yield "method", properties.units_of(MethodUnderTest("fbs"), always, cases, 0)[0]
    yield from varied(first)


def item_lists():
    one = ListUnit(1, 0, GenerationOptions(1))
    return [("", one), *varied(one)]


def network_trainings():
    layouts = random_layouts(6, seed=3)
    cases = pd.DataFrame(
        {
            "scenario": ["s2"] * 6, "instance": [*"abcdef"], "geometry": [*"abcdef"],
            "item_count": list(map(len, layouts)),
            "failing_step": pd.array([None] * 6, dtype="Int16"),
        }
    )  # fmt: skip
    options = replace(training_preset("paper").options, hidden=128)
    every = sequences_of(cases, layouts, options.features, "files")
    parts = [every.chosen(np.isin(np.arange(6), places)) for places in ((0, 1), (2, 3), (4, 5))]
    one = tested.NetworkTraining("file-0", options, *parts, Path("work"), 60.0)
    yield "", one
    for name in ("learnt", "stopping", "asked"):
        yield name, replace(one, **{name: every})
    yield "budget", replace(one, budget=30.0)
    for name, other in varied(options, dropout=0.5, learning_rate=0.1):
        yield name, replace(one, options=other)


CASES = (("as given", ONE),)
RECORD = Record("8f14e45fceea167a5a36")
LOAD = transport.Load("set", "name", ONE, "list")

ASKED = {
    Many: (
        Many(4000, "processes", 2),
        {"question": "layouts in blocks", "methods": ("sme", "equilibrium"), "each": 1000},
        "83e9f52bfd3e9a9d2a43",
    ),
    InThreads: (
        InThreads(4000, "sme", 2),
        {"question": "layouts in threads", "each": 1000},
        "59a718bcc97bf337c92a",
    ),
    OneByOne: (
        OneByOne(400, "ps_opt@mujoco"),
        {"question": "layouts one by one", "ahead": 100},
        "1538ff4c44a10d0e4359",
    ),
    Size: (
        Size(4000, 2),
        {"question": "scale", "methods": ("fbs", "pbs0.9", "pbs0.7", "pbs0.5"), "repetitions": 10},
        "51a4a7a6acebac05bfa8",
    ),
    Turn: (
        Turn({"sme": MADE, "fbs": MADE}, (ONE,), 50, 0),
        {"question": "times in turns", "version": 1},
        "times-aa297b096969c87518f3",
    ),
    SizeUnit: (
        SizeUnit("tipping offset", "mujoco", 0.1, MADE),
        {"question": "closed form at a size", "frequency": 480, "version": 1},
        "86b8ef882286cbe66546",
    ),
    SpeedUnit: (
        SpeedUnit("mujoco", "pile", "all", (10, 20), MADE),
        {"question": "cost by number of items"},
        "b5d3d5d96b0f46a5cf10",
    ),
    ThroughputUnit: (
        ThroughputUnit("mujoco", 60, MADE), {"question": "throughput"}, "6c6004549ef5c706df38"
    ),
    CellUnit: (
        CellUnit("weight", "mujoco", 240, 1.0, 60.0, MADE),
        {"question": "extremes"},
        "9c60d68819afce178946",
    ),
    ClosedFormUnit: (
        ClosedFormUnit("overhang of 5", "mujoco", 240, MADE),
        {"question": "closed form", "version": 1, "sampling": 240},
        "925afda2e56f4b389bdf",
    ),
    CurvesUnit: (
        CurvesUnit(("sme",), 200, {"sme": MADE}),
        {"question": "cost of a placement"},
        "38b23c82852433102f02",
    ),
    PackingUnit: (
        PackingUnit(1, "sme", "ps_opt", 5, (3, 4), {"sme": MADE}),
        {"question": "gain for packing", "version": 1, "seed": 21, "item count": 20},
        "870657016b9802708fa8",
    ),
    LimitUnit: (
        LimitUnit(LOAD, "label", (0.0, 90.0), 0.5, MADE),
        {"question": "limits of acceleration", "version": 1},
        "a8a05e502f32eb49429c",
    ),
    BatchUnit: (
        BatchUnit({"lstm_1": MADE}, (ONE,), 5, (8, 32)),
        {"question": "times in batches", "version": 1},
        "times-a95413f6385f5e46fffe",
    ),
    ChangeUnit: (
        ChangeUnit(ONE, "one pass without a search", "sme", 10.0, MADE),
        {"question": "repair of a plan", "version": 5, "seed": 0},
        "38677c1b5d103b0ed325",
    ),
    EngineUnit: (
        EngineUnit(ONE, "sme", 60.0, MADE),
        {"question": "does a plan stand"},
        "a8df90cadc7f4545a8bc",
    ),
    FirmnessUnit: (
        FirmnessUnit(ONE, MADE),
        {"question": "margin of a plan and its chance to stand", "gaps_cm": 2.0},
        "c4f6c3d419372408a232",
    ),
    RecordUnit: (
        RecordUnit(RECORD, 0, MADE),
        {"question": "recorded motion", "version": 1},
        "697d0f896d4c9b3d4de0",
    ),
    ReleasedUnit: (
        ReleasedUnit(RECORD, "simulation@mujoco", Taken(offset=(0.0, 0.0, 0.005)), MADE),
        {"question": "released bodies", "version": 1},
        "b262949500ab86b9a2b9",
    ),
    JitterUnit: (
        JitterUnit(RECORD, "fit", 0, "simulation@mujoco", Taken(), Noise(), 0.5, 24, MADE),
        {"question": "jittered releases", "version": 1},
        "d9f02fd3f06c2f77c5ff",
    ),
    FitUnit: (
        FitUnit(RECORD, 0, "mujoco", {"friction": (0.1, 0.2)}, {"friction": 0.18}, Taken(), MADE),
        {
            "question": "fitted contacts", "version": 1, "proposals": 1, "space": "motion",
            "algorithm": "genetic", "seeds": (0, 1), "population": 8, "generations": 6,
            "scales": (2.0, 10.0),
        },
        "1b84b89da3c46ae11e6f",
    ),
    TraceUnit: (TraceUnit(CASES, MADE), {"question": "traces"}, "0b41f648a8bc8eb0fdac"),
    ScreenedUnit: (ScreenedUnit(CASES, MADE), {"question": "both"}, "3c48a2d7be6f18709104"),
    CertaintyUnit: (
        CertaintyUnit(CASES, SampledMethod("sme", "com=5mm", Sampling(decide=0.5)), MADE),
        {"question": "certainty"},
        "fc7c1a59ce17c088e1db",
    ),
}  # fmt: skip
"""Of what is asked once and kept: one of each class, what the class states, and the key of that
one, under which rows are kept: it never changes. Other classes are made by their types."""

OTHERS = {
    "record": Record("c9f0f895fb98ab9159f5"),
    "uncertainty": "position=3mm",
    "half_width": 0.1,
    "decide": 0.25,
    "most": 512,
}
"""By field, another value where the usual one is none."""


MADE_WITH_KEY = {
    "units.Unit": study_cases,
    "blocks.BlockUnit": block_units,
    "generation.ListUnit": item_lists,
    "testing.PropertyUnit": property_units,
    "tested.NetworkTraining": network_trainings,
}
"""Units that are made with their key: a first one, and others with one thing changed."""


ASKED_BASES = {"runs.asked.Asked", "runs.asked.AskedCases"}


def modules():
    """Texts of all modules, by name."""
    return {
        package + ".".join(path.relative_to(ROOT / folder).with_suffix("").parts): path.read_text()
        for folder, package in FOLDERS.items()
        for path in sorted((ROOT / folder).rglob("*.py"))
    }


@cache
def unit_classes():
    """Names of all classes of units that have a key of their own, or none: module and class."""
    heads, texts = {}, {}
    for module, text in modules().items():
        for found in re.finditer(r"^class (\w+)(?:\((.*)\))?:\n(?:[ \n].*\n|\n)*", text, re.M):
            name = f"{module}.{found[1]}"
            bases = re.sub(r"\[.*?\]", "", found[2] or "")
            heads[name], texts[name] = bases.split(", "), found[0]
    roots = {"SinglePart"}
    found = {name for name, text in texts.items() if "def without(self, done" in text} - ASKED_BASES
    while True:
        known = roots | {name.rpartition(".")[2] for name in found}
        more = {name for name, bases in heads.items() if known & {*bases}} - found
        if not more:
            break
        found |= more
    protocols = {name for name in found if "Protocol" in heads[name]}
    return sorted(found - protocols - {"runs.pool.SinglePart"})


def short(name):
    """The module and class of a unit, without the packages."""
    return ".".join(name.split(".")[-2:])


def test_every_class_of_units_is_varied():
    found = {short(name) for name in unit_classes()}
    assert len(found) + len(asked_classes()) >= 22
    assert found == {*MADE_WITH_KEY, *WITHOUT_KEY}, "vary all units, or say why one has no key"


def test_units_without_a_key_have_none():
    for name in unit_classes():
        if short(name) in WITHOUT_KEY:
            module, _, kind = name.rpartition(".")
            assert not hasattr(
                getattr(importlib.import_module(f"steadyload.{module}"), kind), "key"
            )


@cache
def asked_classes():
    """All classes of what is asked once, of whose modules each is imported; by name."""
    for module, text in modules().items():
        if re.search(r"\bAsked(\[|Cases\b)", text):
            importlib.import_module(f"steadyload.{module}")
    found, ahead = {}, [Asked, AskedCases]
    while ahead:
        own = ahead.pop().__subclasses__()
        ahead += own
        found |= {short(f"{each.__module__}.{each.__name__}"): each for each in own}
    return {name: kind for name, kind in found.items() if kind.__module__.startswith("steadyload.")}


def made_of(kind):
    """A value of a type; of a dataclass, one whose fields are made of their types."""
    if dataclasses.is_dataclass(kind) and kind is not Layout:
        hints = get_type_hints(kind)
        return kind(*[made_of(hints[one.name]) for one in dataclasses.fields(kind)])
    if isinstance(kind, type) and issubclass(kind, Enum):
        return next(iter(kind))
    origin, inner = get_origin(kind), [each for each in get_args(kind) if each is not NoneType]
    if origin in (Union, UnionType):
        return made_of(inner[0])
    if origin in (tuple, list, Sequence):
        return (made_of(inner[0]),)
    if origin in (dict, Mapping):
        return {made_of(inner[0]): made_of(inner[1])}
    known = {Layout: ONE, bool: True, int: 3, float: 0.5, str: "sme", Path: Path("one")}
    assert kind in known, f"{kind}: list a value of the class in ASKED"
    return known[kind]


def test_what_is_published_is_listed():
    published = {
        each
        for each in asked_classes().values()
        if [*ROWS.glob(f"{each.__module__.split('.')[2].replace('_', '-')}.*")]
    }
    assert published <= ASKED.keys(), "list one of each, and its key"


@pytest.mark.parametrize("name", asked_classes())
def test_every_field_and_constant_of_what_is_asked_is_in_its_key(name, monkeypatch):
    kind = asked_classes()[name]
    asked, stated, key = ASKED.get(kind) or (made_of(kind), kind.stated, made_of(kind).key)
    assert kind.stated == stated
    assert stated["question"]
    assert replace(asked).key == asked.key == key
    others = {name: other.key for name, other in varied(asked, **OTHERS)}
    if issubclass(kind, AskedCases):
        more = {name: (case,) for name, case in cases_varied().items()}
        more["a further one"] = (*CASES, ("as given", OTHER))
        others |= {name: replace(asked, cases=cases).key for name, cases in more.items()}
    left_out = {name for name in NOT_IN_KEY if name.startswith(f"{kind.__name__}.")}
    assert not left_out, "every field of what is asked is in its key"
    for name, value in stated.items():
        monkeypatch.setattr(kind, "stated", {**stated, name: altered(value)})
        others[name] = replace(asked).key
    assert len({key, *others.values()}) == len(others) + 1


AS_STATED = {"value": "the constants of a sweep, which nobody states in another way"}
"""Fields in keys as they are, and why."""


def respelled(value):
    """The same value with whole numbers as floats, and floats that are whole as whole numbers."""
    if isinstance(value, bool) or hasattr(value, "content_hash"):
        return value
    if isinstance(value, int):
        return float(value)
    if isinstance(value, float) and value.is_integer():
        return int(value)
    if isinstance(value, tuple):
        return tuple(map(respelled, value))
    if isinstance(value, Mapping):
        return {key: respelled(inner) for key, inner in value.items()}
    if dataclasses.is_dataclass(value):
        names = [f.name for f in dataclasses.fields(value) if f.name not in AS_STATED]
        return replace(value, **{name: respelled(getattr(value, name)) for name in names})
    return value


@pytest.mark.parametrize("name", asked_classes())
def test_a_number_has_the_same_key_as_a_float_and_as_a_whole_number(name):
    asked, *_ = ASKED.get(asked_classes()[name]) or (made_of(asked_classes()[name]),)
    assert respelled(asked).key == asked.key


def test_a_whole_number_of_a_sweep_is_in_the_key_of_a_kept_row_as_it_was():
    assert CellUnit("tower", "mujoco", 240, 1, 60.0, MADE).key == "bd7bb764fb246df2b537"


def test_a_time_limit_has_the_same_key_as_a_float_and_as_a_whole_number():
    study = StudyDefinition("one", ("sme",), timeout=20.0)
    whole = replace(study, timeout=20)
    assert of_a_study(whole).key == of_a_study(study).key
    assert of_a_block(whole).key == of_a_block(study).key


@pytest.mark.parametrize("name", MADE_WITH_KEY)
def test_a_unit_that_differs_has_another_key(name):
    (_, first), *others = MADE_WITH_KEY[name]()
    (_, again), *_ = MADE_WITH_KEY[name]()
    assert again.key == first.key
    changed = set()
    for what, other in others:
        assert other.key != first.key, f"{what} is not in the key"
        changed |= {f.name for f in dataclasses.fields(first) if differs(first, other, f.name)}
    kind = type(first).__name__
    fields = {f.name for f in dataclasses.fields(first) if f"{kind}.{f.name}" not in NOT_IN_KEY}
    assert changed >= fields, f"{fields - changed}: vary these, too"


def differs(one, other, field):
    values = [getattr(each, field) for each in (one, other)]
    first, second = (v.fingerprint() if hasattr(v, "fingerprint") else v for v in values)
    return first != second


CONSTANTS = {
    "units.Unit": [(units, "SCHEMA_VERSION")],
    "testing.PropertyUnit": [(properties, "VERSION")],
    "tested.NetworkTraining": [(tested, "VERSION")],
}
"""What a key holds besides the fields of its unit."""


@pytest.mark.parametrize(
    ("name", "module", "constant"),
    [(name, *constant) for name, constants in CONSTANTS.items() for constant in constants],
)
def test_a_version_that_is_raised_changes_the_key(name, module, constant, monkeypatch):
    def key():
        return next(iter(MADE_WITH_KEY[name]()))[1].key

    before = key()
    monkeypatch.setattr(module, constant, altered(getattr(module, constant)))
    assert key() != before


@pytest.mark.parametrize(
    ("made_by", "module", "constant"),
    [
        (label_rows.traced_by, label_rows, "TRACE"),
        (label_rows.traced_by, label_rows, "VERSION"),
        (partial(screening.screened_by, SCREENS), screening.step_answers, "VERSION"),
        (partial(screening.screened_by, (SCREEN,)), screening, "VERSION"),
        (partial(screening.screened_by, SCREENS), screening, "VERSION_BY_TWO"),
        (partial(uncertain._made_by, "sme"), uncertain.verdict_reliability, "VERSION"),
        (partial(uncertain._made_by, "sme"), uncertain_cases, "VERSION"),
    ],
)
def test_a_version_that_is_raised_changes_what_rows_are_made_by(
    made_by, module, constant, monkeypatch
):
    before = made_by()
    monkeypatch.setattr(module, constant, getattr(module, constant) + 1)
    assert made_by() != before


def test_every_option_of_a_generated_set_is_in_its_identity():
    options = GenerationOptions(1)
    others = {"label": "sme", "scenarios": options.scenarios[:1]}
    found = [each.identity() for _, each in varied(options, **others)]
    assert len(found) == len(dataclasses.fields(options)) - 1
    assert options.identity() not in found
    assert replace(options, lists=2).identity() == options.identity()


def test_everything_that_a_training_depends_on_names_its_folder(tmp_path):
    first = PlannedTraining("first", "First", start="zero", limit=5, lists=5)
    zero, nought = PlannedTraining("zero", "Zero"), PlannedTraining("nought", "Nought")
    sets = {"one": GenerationOptions(2)}

    def folder(training=first, sets=sets):
        plan = Plan(sets=sets, trainings={each.name: each for each in (training, zero, nought)})
        return Workshop(plan, tmp_path).runs(training.name)[0].folder

    others = {
        "preset": "paper", "options": {"hidden": 8}, "data": ("one",), "start": "nought",
    }  # fmt: skip
    folders = [folder(), *(folder(each) for _, each in varied(first, **others))]
    assert len(folders) == len({*folders}) == len(dataclasses.fields(first)) - 1
    generated = replace(first, data=("one",))
    longer = {"one": GenerationOptions(3)}
    assert folder(generated) != folder(generated, longer)
    seeds = Workshop(Plan(trainings={"first": replace(first, start="", seeds=(0, 1))}), tmp_path)
    assert len({run.folder for run in seeds.runs("first")}) == 2


def test_what_weights_say_is_kept_by_training_and_cases(tmp_path, monkeypatch):
    plan = Plan(trainings={"first": PlannedTraining("first", "First", seeds=(0, 1))})
    one, other = Workshop(plan, tmp_path).runs("first")
    part, less = (JudgedPart(Part.TEST, tmp_path) for _ in range(2))
    part.cases, less.cases = (SimpleNamespace(fingerprint=lambda name=name: name) for name in "ab")
    keys = {part._key(one), part._key(other), less._key(one)}
    for name in ("VERSION", "FEATURES", "INFERENCE"):
        with monkeypatch.context() as changed:
            changed.setattr(verdicts, name, altered(getattr(verdicts, name)))
            keys.add(part._key(one))
    assert len(keys) == 6
