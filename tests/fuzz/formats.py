"""All formats that are read: valid files to begin with, and the reader of the product for each."""

import hashlib
import json
import signal
import struct
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from importlib import resources
from itertools import islice
from pathlib import Path

import batches
import doors
import numpy as np
import pandas as pd
import parquet
import stored
from mutation import mutated, mutated_json

from steadyload.atomic import manifest_text
from steadyload.cli.flags import read_config
from steadyload.config import methods_option, option
from steadyload.labelling.building.item_lists import read_items, read_products
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark import tables
from steadyload.layouts.benchmark.dataset import load_benchmark, row_of
from steadyload.layouts.files.dialect import load_profile
from steadyload.layouts.files.parquet_layouts import as_parquet
from steadyload.layouts.files.record import Refused
from steadyload.layouts.formats import Format as LayoutFormat
from steadyload.layouts.formats import scan_layouts
from steadyload.layouts.packers.with_packingsolver import from_packingsolver
from steadyload.layouts.packers.with_packvium import from_packvium
from steadyload.layouts.writers import as_csv, as_job, as_native
from steadyload.learners.features import FeatureKind, names
from steadyload.learners.options import TrainingOptions
from steadyload.learners.plans.plan_file import load_plan
from steadyload.learners.ranges import QUANTITIES
from steadyload.learners.tensors import tensor_shapes
from steadyload.learners.weights import load_weights
from steadyload.measured.field_files import read_field_tests
from steadyload.measured.motion_files import read_motion, write_motion
from steadyload.measured.profiles import motion_profile
from steadyload.methods.cascade.thresholds import FILE as THRESHOLDS
from steadyload.methods.cascade.thresholds import load_thresholds
from steadyload.methods.contract.method import judge
from steadyload.methods.registry import make_method
from steadyload.runs.definition import load_study
from steadyload.runs.results import ROWS, load_results, result_row, said_of
from steadyload.runs.store import checksum
from steadyload.studies.kept_rows import MADE_WITH, made_with
from steadyload.transport.history import recorded
from steadyload.transport.rules import rule_named

ACLPP = b"""\
flights:
  X1: {aircraft_type: md11f}
segments:
  X1-FRA:
    built_ulds:
      pmc_F_ld-14:
        finish: 1
        loaded:
        - {height: 91, lat: 173, lng: 151, piece: p0, shipment: s0, start_height: 0,
           start_lat: 44, start_lng: 10}
        - {height: 20, lat: 100, lng: 50, piece: p1, shipment: s0, start_height: 93,
           start_lat: 44, start_lng: 10}
        uld_type: pmc_F_ld
    shipments:
      s0:
        pieces:
          p0: {weight: 39.5}
          p1: {weight: 7}
"""

CERTIFICATE = b"""\
TYPE,ID,COPIES,BIN,STACK,X,Y,Z,LX,LY,LZ,GROUP_ID,ROTATION
BIN,0,2,0,-1,0,0,0,100,100,100,,
STACK,0,1,0,0,0,0,0,20,30,80,,
ITEM,1,1,0,0,0,0,40,20,30,40,0,XYZ
ITEM,0,1,0,0,0,0,0,20,30,40,0,XYZ
BIN,0,1,1,-1,0,0,0,100,100,100,,
ITEM,2,1,1,0,0,0,0,60,30,40,0,XYZ
"""

STUDY = b"""\
name = "trial"
methods = ["sme", "pbs:alpha=0.7", "ps3@mujoco"]
generated = 3
scenarios = ["S1", "S2a"]
seed = 7
limit = 2
max_items = 5
repetitions = 1
shard_size = 12
snap_gap = 0.5
timeout = 10.0
"""

PROFILE = b"""\
units = "mm"
weight = "g"
up = "z"
positions = "centre"
other_columns = "ignore"

[columns]
length = "L"
width = "B"
id = "SKU"
"""

RULE = b"""\
[ours]
title = "Our road"
levels = { forwards = 0.3, sideways = 0.2 }
rise = 0.1
hold = 1
rest = 0.5
rotation = 5
displacement = 2
"""

MOTION = b"""\
trial,time,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz,size_x,size_y,size_z,mass,friction
a,0,0,0,0.5,1,0,0,0,0.1,0,0,0,0,0.2,0.1,0.1,0.1,0.5,0.3
a,0.1,0.01,0,0.45,0.9999,0,0,0.01,0.1,0,-1,0,0,0.2,0.1,0.1,0.1,0.5,0.3
a,0.2,0.02,0,0.3,0.9998,0,0,0.02,0.1,0,-2,0,0,0.2,0.1,0.1,0.1,0.5,0.3
b,0,0,0,0.05,1,0,0,0,,,,,,,,,,,
b,0.1,0,0,0.05,1,0,0,0,,,,,,,,,,,
b,0.2,0,0,0.05,1,0,0,0,,,,,,,,,,,
"""

MOTION_PROFILE = b"""\
body = "a cube"
ignored = ["frame"]
[columns]
trial = "toss"
time = "t"
[constants]
mass = 0.4
[noise]
spin_rads = 0.3
"""

FIELD = b"""\
# invented
test,plan,layout,done,towards,tilt_deg,acceleration_g,moved_box,moved_at_box,moved_at_deg,moved_at_g,note
1,plan.csv,A,placed,,,,box 0,box 3,,,leaned
2,plan.csv,A,tilted,front,20,,step 2,,19.5,,
3,plan.csv,"B, two",accelerated,45,,0.5,,,,,held
4,plan.csv,A,accelerated,back,,0.5,?,,,0.3,
"""

HISTORY = b"time_s,acceleration_g\n0,0\n0.1,0.5\n0.4,0.5\n"

_PLAN = Path(str(resources.files("steadyload.learners.plans") / "plan.toml"))


@dataclass(frozen=True)
class Configured:
    """A command that a configuration file may fill in."""

    part: str = option("test", "of a set", choices=("test", "train"))
    limit: int | None = option(None, "cases", least=1)
    workers: int = option(1, "processes", least=1)
    methods: tuple[str, ...] = methods_option("to compare")


CONFIG = b"""\
part = "test"
limit = 6
workers = 2
methods = ["sme"]
"""


@dataclass(frozen=True)
class Format:
    """A format: its valid files, how they are changed, where they are put, and how they are read.

    ``read`` returns nothing, or an error that was handed out instead of raised.
    """

    seeds: Callable[[], list[bytes]]
    read: Callable[[Path], object]
    mutate: Callable[..., bytes] = mutated
    place: Callable[[Path, bytes], Path] = lambda folder, content: written(folder / "file", content)

    def warm(self, folder):
        """Read every valid file once: what is imported and kept is no cost of an input."""
        for content in self.seeds():
            self.read(self.place(folder, content))


def nothing(read):
    """What has been read is of no further interest."""


def written(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    return path


@cache
def layouts():
    pallet = Pallet(120.0, 160.0, 80.0)
    first = tuple(
        Item(
            k,
            (40.0 * (k % 3), 30.0 * (k // 3), 0.0),
            (40.0, 30.0, 40.0),
            12.0,
            (2.0, 0.0, -1.0),
            f"box {k}",
        )
        for k in range(6)
    )  # fmt: skip
    return Layout("A", pallet, first), Layout("B, two", pallet, first[:1])


def read_layout_file(path):
    refused = None
    for entry in scan_layouts(path):
        refused = entry.error if isinstance(entry, Refused) else refused
    return refused


@cache
def _layout_table(max_load=None):
    """Layouts as rows, which become a batch, or records where they state loads."""
    first, second = layouts()
    limited = replace(second.items[0], max_load=max_load)
    return b"".join(as_parquet([first, Layout(second.name, second.pallet, (limited,))]))


@cache
def _motion_table():
    with tempfile.TemporaryDirectory() as made:
        target = Path(made) / "motion.parquet"
        write_motion(target, read_motion(written(Path(made) / "motion.csv", MOTION)))
        return target.read_bytes()


def _placed_field(folder, content):
    """A table of tests beside its plan."""
    written(folder / "field" / "plan.csv", as_csv(layouts()).encode())
    return written(folder / "field" / "tests.csv", content)


def read_study(path):
    list(islice(load_study(path).layouts(), 2))


# Plans of packers.


def _measures(names, *values):
    return {
        name: {"ticks": 160_000 * value, "value": str(value), "unit": "cm"}
        for name, value in zip(names, values, strict=True)
    }


def _packed(name, *heights):
    sides = ("length", "width", "height")
    placements = [
        {
            "item_id": f"{name}#{height}", "item_type": "a",
            "position": _measures("xyz", 0, 0, height), "dimensions": _measures(sides, 20, 30, 10),
        }
        for height in heights
    ]  # fmt: skip
    return {
        "id": name, "inner_dimensions": _measures(sides, 100, 100, 100),
        "payload_weight": {"ticks": 8_000_000_000}, "placements": placements,
    }  # fmt: skip


@cache
def _packvium():
    left = [{"item_id": "b#1", "reason": "too large"}]
    containers = [_packed("one", 0, 10), _packed("two", 0)]
    return json.dumps(
        {"status": "feasible", "containers": containers, "unpacked_items": left}
    ).encode()


def read_certificate_in_python(path):
    """As a layout file, and as the functions for plans read it."""
    from_packingsolver(path)
    return read_layout_file(path)


def read_packvium_in_python(path):
    from_packvium(path)
    return read_layout_file(path)


# Folders of searches, and of sets that are made to learn from.


def _alone(folder, name, content):
    """A folder that holds only one file."""
    made = folder / "alone"
    for old in made.glob("*"):
        old.unlink()
    written(made / name, content)
    return made


@cache
def _ledger():
    with tempfile.TemporaryDirectory() as made:
        return stored.ledger(Path(made))


# Shards and manifests of runs.


@cache
def _rows():
    method = make_method("fbs")
    said = said_of(method)
    return tuple(
        result_row(layout, "as given", said, 0, judge(method, layout)) for layout in layouts()
    )


@cache
def _shard():
    return ROWS.encode(_rows())


@cache
def _run_manifest():
    about = {
        "schema_version": 2, "study": {"name": "trial", "methods": ["fbs"]}, "study_hash": "0" * 16,
        "data_hash": "1" * 16, "shards": ["one"], "finished": True,
        "files": {"layouts.parquet": "0" * 16},
    }  # fmt: skip
    return manifest_text(about).encode()


def _placed_run(folder, manifest, shard):
    run = folder / "run"
    for old in run.glob("results/*"):
        old.unlink()
    written(run / "manifest.json", manifest)
    written(run / "results" / f"one.{checksum(shard)}.parquet", shard)
    return run


# Labelled sets.


@cache
def _tables():
    rows = [row_of(layout, "one", 3, (layout.name,)) for layout in layouts()]
    cases = [
        {"layout": layout.name, "scenario": "S1", "item_count": len(layout), "split": "test",
         "rank": rank, "status": "done", "offsets": layout.mass_offsets.ravel().tolist()}
        for rank, layout in enumerate(layouts())
    ]  # fmt: skip
    opinions = [
        {"layout": "A", "scenario": "S1", "question": "within", "reason": "model",
         "judge": "smooth", "status": "done"}
    ]  # fmt: skip
    frames = zip(
        (rows, cases, opinions), (tables.LAYOUTS, tables.CASES, tables.OPINIONS), strict=True
    )
    return [tables.as_parquet(pd.DataFrame(r).reindex(columns=s.names), s) for r, s in frames]


_SET_MANIFEST = manifest_text({"version": 2, "layouts": 2, "cases": 2, "opinions": 1}).encode()


def _placed_set(folder, name, content):
    made = folder / "set"
    for kept, whole in zip(("layouts", "cases", "opinions"), _tables(), strict=True):
        written(made / f"{kept}.parquet", whole)
    written(made / "manifest.json", _SET_MANIFEST)
    written(made / name, content)
    return made


def _placed_table(folder, content):
    which = content[0] % 3
    return _placed_set(folder, ("layouts", "cases", "opinions")[which] + ".parquet", content[1:])


def _mutated_table(content, draw):
    return content[:1] + parquet.mutated_table(content[1:], draw)


def read_rule(path):
    rule = rule_named(str(path))
    for level in rule.directions().values():
        rule.history(level)


def read_set(folder):
    found = load_benchmark(folder)
    for row in found.select().itertuples():
        found.layout(row.layout, row.scenario)


# Weights.

_OPTIONS = {"features": "support", "network": "lstm", "hidden": 2, "layers": 1}


@cache
def _tensors():
    """A safetensors file, written by hand."""
    shapes = tensor_shapes(TrainingOptions(hidden=2, layers=1))
    header, body = {}, b""
    for name, shape in shapes.items():
        array = np.ones(shape, np.float32).tobytes()
        header[name] = {
            "dtype": "F32",
            "shape": list(shape),
            "data_offsets": [len(body), len(body) + len(array)],
        }
        body += array
    text = json.dumps(header).encode()
    return struct.pack("<Q", len(text)) + text + body


def _weights_manifest(tensors):
    about = {
        "version": 1, "hashes": [hashlib.sha256(tensors).hexdigest()], "features": "support",
        "feature_names": list(names(FeatureKind.SUPPORT)), "command": "steadyload train",
        "ranges": {name: [0.0, 100.0] for name in QUANTITIES}, "members": [{"options": _OPTIONS}],
    }  # fmt: skip
    return manifest_text(about).encode()


def _mutated_tensors(content, draw):
    if draw.random() < 0.5:
        return mutated(content, draw)
    (length,) = struct.unpack("<Q", content[:8])
    header = mutated_json(content[8 : 8 + length], draw)
    return struct.pack("<Q", len(header)) + header + content[8 + length :]


def _placed_weights(folder, manifest, tensors):
    made = folder / "weights"
    written(made / "manifest.json", manifest)
    written(made / "member_0.safetensors", tensors)
    return made


# Files with holes, and devices, by what reads them.


def _files():
    """A valid file of every kind that a user names, with its reader."""
    return [
        ("".join(as_native(layouts())).encode(), read_layout_file),
        (as_csv(layouts()).encode(), read_layout_file),
        (as_job(layouts()).encode(), read_layout_file),
        (ACLPP, read_layout_file),
        (CERTIFICATE, read_layout_file),
        (_packvium(), read_layout_file),
        (_layout_table(), read_layout_file),
        (STUDY, read_study),
        (PROFILE, lambda path: nothing(load_profile(path))),
        (CONFIG, lambda path: nothing(read_config(path, Configured))),
        (RULE, read_rule),
        (HISTORY, lambda path: nothing(recorded(path))),
        (MOTION, lambda path: nothing(read_motion(path))),
        (MOTION_PROFILE, lambda path: nothing(motion_profile(path))),
        (_PLAN.read_bytes(), lambda path: nothing(load_plan(path))),
        (THRESHOLDS.read_bytes(), lambda path: nothing(load_thresholds("mujoco", path))),
        (stored.front(), stored.read_front),
        (stored.cost(), stored.read_cost),
        (stored.noted()[0], stored.read_noted),
    ]


FORMATS = {
    LayoutFormat.NATIVE.value: Format(
        lambda: ["".join(as_native(layouts())).encode()], read_layout_file, mutated_json
    ),
    LayoutFormat.JOB.value: Format(
        lambda: [as_job(layouts()).encode(), as_job(layouts()[:1]).encode()],
        read_layout_file, mutated_json,
    ),
    LayoutFormat.CSV.value: Format(
        lambda: [
            as_csv(layouts()).encode(), as_csv(layouts()).replace(",", ";").encode(),
        ],
        read_layout_file,
    ),
    "tab-separated": Format(
        lambda: [as_csv(layouts()[:1]).replace(",", "\t").encode()], read_layout_file
    ),
    "csv-of-others": Format(lambda: [doors.WAREHOUSE], doors.read_form),
    "given": Format(
        lambda: [
            "".join(as_native(layouts())).encode(), as_csv(layouts()).encode(), _layout_table(),
        ],
        doors.read_given,
    ),
    "native-batch": Format(
        lambda: ["".join(as_native(layouts())).encode()], batches.read_json_alike,
        batches.rewritten(mutated),
    ),
    "csv-batch": Format(
        lambda: [
            as_csv(layouts()).replace('"B, two"', "B").encode(),
            as_csv(layouts()[:1]).replace(",", ";").encode(),
        ],
        batches.read_alike,
    ),
    LayoutFormat.ACLPP.value: Format(lambda: [ACLPP], read_layout_file),
    LayoutFormat.PACKINGSOLVER.value: Format(lambda: [CERTIFICATE], read_certificate_in_python),
    "packvium": Format(lambda: [_packvium()], read_packvium_in_python, mutated_json),
    LayoutFormat.PARQUET.value: Format(
        lambda: [_layout_table(), _layout_table(max_load=7.0)], read_layout_file,
        parquet.mutated_table,
    ),
    "repaired": Format(
        doors.failing_plans, doors.repair_file,
        lambda file, draw: (mutated_json if file[:1] == b"{" else mutated)(file, draw),
    ),
    "written": Format(
        lambda: ["".join(as_native(layouts())).encode()], doors.read_copy
    ),
    "items": Format(lambda: [doors.TYPES], lambda path: nothing(read_items(path))),
    "products": Format(lambda: [doors.PRODUCTS], lambda path: nothing(read_products(path))),
    "results": Format(doors.results, doors.read_result, mutated_json),
    "study": Format(lambda: [STUDY], read_study),
    "profile": Format(lambda: [PROFILE], lambda path: nothing(load_profile(path))),
    "config": Format(
        lambda: [CONFIG],
        lambda path: nothing(read_config(path, Configured)),
    ),
    "rule": Format(
        lambda: [RULE], read_rule, place=lambda folder, rule: written(folder / "rule.toml", rule)
    ),
    "history": Format(lambda: [HISTORY], lambda path: nothing(recorded(path))),
    "motion": Format(
        lambda: [MOTION, MOTION.replace(b",", b";")], lambda path: nothing(read_motion(path))
    ),
    "motion-table": Format(
        lambda: [_motion_table()], lambda path: nothing(read_motion(path)), parquet.mutated_table
    ),
    "motion-profile": Format(
        lambda: [MOTION_PROFILE], lambda path: nothing(motion_profile(path))
    ),
    "field-tests": Format(
        lambda: [FIELD, FIELD.replace(b'"B, two"', b"B, two").replace(b",", b";")
                 .replace(b"B; two", b"B, two")],
        lambda path: nothing(read_field_tests(path)), place=_placed_field,
    ),
    "plan": Format(lambda: [_PLAN.read_bytes()], lambda path: nothing(load_plan(path))),
    "shard": Format(
        lambda: [_shard()],
        lambda run: nothing(load_results(run)),
        parquet.mutated_table,
        lambda folder, content: _placed_run(folder, _run_manifest(), content),
    ),
    "run-manifest": Format(
        lambda: [_run_manifest()],
        lambda run: nothing(load_results(run)),
        stored.summed(mutated_json),
        lambda folder, content: _placed_run(folder, content, _shard()),
    ),
    "labels": Format(
        lambda: [doors.labels()], doors.read_labels, parquet.mutated_table, doors.placed_labels
    ),
    "labelled-tables": Format(
        lambda: [bytes([k]) + table for k, table in enumerate(_tables())],
        read_set,
        _mutated_table,
        _placed_table,
    ),
    "labelled-manifest": Format(
        lambda: [_SET_MANIFEST], read_set, stored.summed(mutated_json),
        lambda folder, content: _placed_set(folder, "manifest.json", content),
    ),
    "weights": Format(
        lambda: [_tensors()], lambda made: nothing(load_weights(made)), _mutated_tensors,
        lambda folder, content: _placed_weights(folder, _weights_manifest(content), content),
    ),
    "weights-header": Format(
        lambda: [_tensors()], lambda made: nothing(load_weights(made)), doors.bomb,
        lambda folder, content: _placed_weights(folder, _weights_manifest(content), content),
    ),
    "weights-manifest": Format(
        lambda: [_weights_manifest(_tensors())], lambda made: nothing(load_weights(made)),
        stored.summed(mutated_json),
        lambda folder, content: _placed_weights(folder, content, _tensors()),
    ),
    "thresholds": Format(
        lambda: [THRESHOLDS.read_bytes()],
        lambda path: nothing(load_thresholds("mujoco", path)), stored.summed(mutated_json),
    ),
    "tuned": Format(
        lambda: [stored.tuned()], stored.read_tuned_file, stored.summed(mutated_json)
    ),
    "front": Format(
        lambda: [stored.front()], stored.read_front, stored.summed(mutated_json)
    ),
    "cost-model": Format(
        lambda: [stored.cost()], stored.read_cost, stored.summed(mutated_json)
    ),
    "noted-runs": Format(stored.noted, stored.read_noted, stored.summed(mutated_json)),
    "asked-set": Format(
        lambda: [stored.asked()], stored.read_asked, stored.summed(mutated_json),
        lambda folder, content: _alone(folder, "asked.json", content),
    ),
    "made-with": Format(
        lambda: [doors.MADE], lambda folder: nothing(made_with(folder)), mutated_json,
        lambda folder, content: _alone(folder, MADE_WITH, content),
    ),
    "search": Format(
        lambda: [_ledger()], stored.read_ledger, mutated,
        lambda folder, content: _alone(folder, "search.jsonl", content),
    ),
    "archive": Format(
        lambda: [doors.archive()], doors.read_archive, doors.harmed_archive, doors.placed_archive
    ),
    "verdict-table": Format(
        lambda: [doors.verdict_table(_run_manifest())], doors.read_verdict_table,
        doors.harmed_table, doors.placed_verdict_table,
    ),
    "sparse": Format(
        lambda: [doors.whole(k, content) for k, (content, _) in enumerate(_files())],
        doors.by_number([read for _, read in _files()]), doors.hole, doors.placed_hole,
    ),
    "device": Format(
        lambda: [doors.linked(k, content) for k, (content, _) in enumerate(_files())],
        doors.by_number([read for _, read in _files()]), doors.device, doors.placed_device,
    ),
}  # fmt: skip
"""Formats by name."""

COSTLY = (
    LayoutFormat.PARQUET.value, "motion-table", "shard", "labels", "run-manifest",
    "labelled-tables", "labelled-manifest", "plan",
    "archive", "verdict-table", "sparse", "device", "repaired",
)  # fmt: skip
"""Those of which an input takes milliseconds."""


def _plant(harm):
    """A reader that does harm to one input of two, whatever the file."""

    def read(path):
        if path.read_bytes() == b"xxx":
            harm()

    return Format(
        lambda: [b"x"], read, lambda content, draw: b"xxx" if draw.random() < 0.5 else content
    )


def _hang():
    while True:
        pass


def _grow():
    bytearray(2 * 10**9)


def _raise():
    raise KeyError("x")


def _crash():
    signal.raise_signal(signal.SIGSEGV)


class _LyingError(tables.BenchmarkError):
    """One that does not make a printable line of its message, as others do."""

    def __str__(self):
        return "a name: \x1b[2J"


def _lie():
    raise _LyingError


PLANTED = {
    "hangs": _plant(_hang),
    "grows": _plant(_grow),
    "raises": _plant(_raise),
    "crashes": _plant(_crash),
    "lies": _plant(_lie),
}
"""Readers that do what a run has to find."""
