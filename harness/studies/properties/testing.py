"""Properties x methods: tested over processes, stored in files, resumable.

A folder holds ``results/*.json``, a :class:`steadyload.runs.store.Store` with a shard for every
property and method. ``counterexamples/*.json`` beside the page are layout files like any other.
"""

from __future__ import annotations

import dataclasses
import json
import re
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib import metadata
from pathlib import Path

import numpy as np

from steadyload.atomic import not_a_link, without_link
from steadyload.engines.registry import engines_here, package_versions
from steadyload.layouts.files.record import Record, to_layout
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.readers import read_json
from steadyload.layouts.writers import as_native
from steadyload.methods.envelope import ENVELOPES
from steadyload.methods.naming import MethodKey, method_key
from steadyload.methods.tuned import TUNED, tuned
from steadyload.properties.findings import finding
from steadyload.properties.property import Case, MethodUnderTest, Property
from steadyload.properties.registry import PROPERTIES, by_kind
from steadyload.properties.search import (
    VERSION,
    Counterexample,
    Frequency,
    PropertyResult,
    search,
)
from steadyload.reading import own_file
from steadyload.runs.asked import Keyed
from steadyload.runs.pool import SinglePart
from steadyload.runs.provenance import key_of, made_by, provenance_lines
from steadyload.runs.store import Codec, Store, locked
from steadyload.statistics.metrics import share
from steadyload.stored import REMEDY, stored_object
from steadyload.studies.kit import Lab, asked
from steadyload.studies.properties.outcomes import (
    ENOUGH,
    Found,
    MethodTested,
    Pairs,
    PropertyRow,
    Refused,
    SmallestCase,
    Standing,
)

EXAMPLES, SEED = 1000, 1
"""Cases of a property and method, and the seed by which they are drawn."""

STATIC_METHODS = (
    "fbs",
    "pbs",
    "sme",
    "equilibrium",
    "equilibrium:sides=frictionless",
    "equilibrium:sides=friction",
    "equilibrium:time=0.3",
    "settling",
)

FITTED_METHODS = ("lstm_1", "lstm_e", "cascade@mujoco", "cascade@rapier")
"""Methods that were trained or fitted on labels, which the default tests beside all others."""

_READABLE = 100
"""Number of characters of a counterexample's file name that name property and method."""


class PropertyUnit(SinglePart, Keyed):
    """A property, and a method of which it is tested; everything that the result depends on."""

    property: str = asked("question")
    version: int
    method: str
    made_by: Mapping[str, str] = asked("made by")
    examples: int
    seed: int

    def describe(self, part: int) -> str:
        """Description of the test for messages."""
        return f"{self.property!r} of {self.method}"


def usual_methods() -> list[str]:
    """The methods that are tested by default.

    These are the static methods, the label's way and the tuned preset on all engines that studies
    compare here, and the methods that were fitted on labels.
    """
    return [
        *STATIC_METHODS,
        *(f"label@{name}" for name in engines_here()),
        *(f"{TUNED}@{name}" for name in engines_here() if name in tuned()),
        *FITTED_METHODS,
    ]


def run_properties(
    lab: Lab,
    methods: Sequence[str],
    examples: int = EXAMPLES,
    properties: Iterable[Property] = PROPERTIES.values(),
) -> Found:
    """Test the missing pairs of properties and methods.

    A method with two spellings is tested once.
    """
    tested = list(properties)
    most = {each.name: max(1, round(each.share * examples)) for each in tested}
    specs = methods or usual_methods()
    subjects = list({s.spec: s for s in map(MethodUnderTest, specs)}.values())
    for subject in subjects:
        subject.method.prepare()
    units = [unit for subject in subjects for unit in units_of(subject, tested, most, SEED)]
    with locked(lab.work):
        store = Store(lab.work / "results", OUTCOMES)
        store.complete(
            units,
            _ask,
            # For an engine that ends its process the case is not known.
            crashed=lambda unit, part, reason: PropertyResult(0, 0, None, crashed=reason),
            workers=lab.workers,
            progress=lambda *done: lab.progress("asking", *done),
        )
        rows = [_row(unit, store.read(unit.key)) for unit in units]
    keys = [method_key(subject.method) for subject in subjects]
    return Found(
        statements=tested,
        methods=[_tested(method, rows) for method in keys],
        rows=rows,
        pairs={
            kind: [_pairs(method, rows, of_kind) for method in keys]
            for kind, of_kind in by_kind(each.name for each in tested).items()
        },
        made_with={
            "examples": f"up to {max(most.values())} a property and method, seed {SEED}",
            **provenance_lines(),
            "hypothesis": metadata.version("hypothesis"),
        },
    )


def _tested(method: MethodKey, rows: Sequence[PropertyRow]) -> MethodTested:
    own = [row for row in rows if row.method == method]
    named = {s: [row.property for row in own if row.standing is s] for s in Standing}
    return MethodTested(
        method,
        holds=len(named[Standing.HOLDS]),
        violated=named[Standing.VIOLATED],
        findings=named[Standing.FINDING],
        too_few=named[Standing.TOO_FEW],
        refused=Refused(sum(row.refused for row in own), sum(row.examples for row in own)),
    )


def _pairs(method: MethodKey, rows: Sequence[PropertyRow], properties: Sequence[str]) -> Pairs:
    own = {row.property: row for row in rows if row.method == method}
    return Pairs(method.title, {name: own.get(name) for name in properties})


def write_counterexamples(found: Found, folder: Path) -> None:
    """Write the smallest cases as layout files, where the page in a folder links to them."""
    for smallest in filter(None, (one.smallest for one in found.rows)):
        path = folder / smallest.file
        not_a_link(path.parent).mkdir(parents=True, exist_ok=True)
        write_layouts(without_link(path), [smallest.layout], Format.NATIVE)


def units_of(
    subject: MethodUnderTest, properties: Sequence[Property], examples: Mapping[str, int], seed: int
) -> list[PropertyUnit]:
    """Units of a method, of the properties that apply to it; ``examples`` by property."""
    envelopes = stored_object(own_file("steadyload.methods", ENVELOPES), REMEDY)
    made = {
        **made_by(subject.method),
        **package_versions(("hypothesis",)),
        "version of search": str(VERSION),
        "envelopes": key_of({engine: entry["rows"] for engine, entry in envelopes.items()}),
    }
    return [
        PropertyUnit(each.name, each.version, subject.spec, made, examples[each.name], seed)
        for each in properties
        if each.applies(subject)
    ]


def _ask(unit: PropertyUnit) -> Iterator[PropertyResult]:
    subject = MethodUnderTest(unit.method)
    subject.method.prepare()
    yield search(PROPERTIES[unit.property], subject, examples=unit.examples, seed=unit.seed)


def _encoded(answers: Sequence[PropertyResult]) -> bytes:
    [outcome] = answers
    held = outcome.counterexample
    kept = dataclasses.asdict(dataclasses.replace(outcome, counterexample=None))
    del kept["counterexample"]
    kept["failure"] = held and {
        "found": held.found,
        "change": dict(held.case.change),
        "layout": json.loads("".join(as_native([held.case.layout]))),
    }
    return (json.dumps(kept, indent=1) + "\n").encode()


def _decoded(content: bytes) -> PropertyResult:
    kept = json.loads(content)
    failure, frequency = kept.pop("failure"), kept.pop("frequency")
    counterexample = None
    if failure is not None:
        [record] = read_json([json.dumps(failure["layout"]).encode()])
        assert isinstance(record, Record)
        case = Case(to_layout(record), failure["change"])
        counterexample = Counterexample(case, failure["found"])
    return PropertyResult(
        **kept, counterexample=counterexample, frequency=frequency and Frequency(**frequency)
    )


OUTCOMES: Codec[PropertyResult, PropertyResult] = Codec(".json", _encoded, _decoded)
"""Codec of the result of a property and method."""


def _row(unit: PropertyUnit, outcome: PropertyResult) -> PropertyRow:
    """A result as a page shows it; declared findings are included even where not found here."""
    known = finding(unit.property, unit.method)
    shown, standing = outcome.counterexample, Standing.HOLDS
    if known is not None:
        standing = Standing.FINDING
        shown = shown or Counterexample(known.case, known.found)
    elif shown is not None or outcome.crashed:
        standing = Standing.VIOLATED
    elif not outcome.asked:
        standing = Standing.NOT_ASKED
    elif outcome.asked < ENOUGH * outcome.examples:
        standing = Standing.TOO_FEW
    found = outcome.frequency
    return PropertyRow(
        property=unit.property,
        method=method_key(MethodUnderTest(unit.method).method),
        standing=standing,
        examples=outcome.examples,
        asked=outcome.asked,
        refused=outcome.refused,
        why=known.why if known else outcome.crashed,
        smallest=None
        if shown is None
        else SmallestCase(shown.found, shown.case.change, shown.case.layout, _file(unit)),
        n=None if found is None else found.tested,
        share=None if found is None else share(np.arange(found.tested) < found.violated),
        steps=None if found is None else found.steps,
    )


def _file(unit: PropertyUnit) -> str:
    """File, readable and unique for every pair; specs may differ in punctuation alone."""
    pair = f"{unit.property} {unit.method}"
    readable = re.sub(r"[^a-z0-9]+", "-", pair.lower()).strip("-")[:_READABLE]
    return f"counterexamples/{readable}-{zlib.crc32(pair.encode()):08x}.json"
