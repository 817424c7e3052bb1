"""Files that are no valid file with a small change: holes, devices, bombs in headers.

Also the door that writes what it has read: a file of plans with its repairs.
"""

import base64
import io
import json
import lzma
import os
import random
import shutil
import struct
import tarfile
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import parquet
import pyarrow as pa
import pyarrow.parquet as pq
from mutation import mutated

from steadyload.app.repaired_files import write_repaired
from steadyload.app.repairs import RepairOptions, repair_all
from steadyload.errors import UserError
from steadyload.labelling.building.authors_files import Reader as ResultReader
from steadyload.labelling.building.authors_files import RotationUnit
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.benchmark.tables import BenchmarkError
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.files.record import Refused
from steadyload.layouts.files.sources import Content
from steadyload.layouts.formats import read_written, scan_layouts
from steadyload.layouts.writers import as_csv, as_job, as_native
from steadyload.runs import tidy
from steadyload.runs.labels import LABELS, LABELS_FILE, as_labels, load_labels
from steadyload.runs.scoring import read_entries
from steadyload.runs.store import checksum
from steadyload.studies.kept_rows import unpack
from steadyload.studies.published import Entry

SIZES = (0, 0, 2**10, 2**17, 2**20 + 1, 2**23 + 1, 2**26 + 1, 2**28 - 1, 2**28 + 1, 2**32 + 1)
"""Bytes of zeros after a file, about the limits of the readers."""

PLACES = (0.0, 0.5, 1.0, 1.0)
"""Where a hole begins, as a share of the file."""

DEVICES = ("/dev/null", "/dev/zero", "/dev/urandom", "/dev/full", "/proc/self/mem", "/tmp")

Reader = Callable[[Path], object]


def hole(content: bytes, draw: random.Random) -> bytes:
    """A file with a hole: the reader's number, the size of the hole, and what stands before it."""
    kept = content[9 : 9 + round(draw.choice(PLACES) * (len(content) - 9))]
    return content[:1] + struct.pack("<Q", draw.choice(SIZES)) + kept


def whole(number: int, content: bytes) -> bytes:
    """A file without a hole, as :func:`hole` takes it."""
    return bytes([number]) + bytes(8) + content


def placed_hole(folder: Path, content: bytes) -> Path:
    """Write a file with its hole, which takes no space, beside the number of its reader."""
    path = folder / f"hole-{content[0]}.toml"
    path.write_bytes(content[9:])
    (size,) = struct.unpack("<Q", content[1:9])
    os.truncate(path, len(content) - 9 + size)
    return path


def linked(number: int, content: bytes) -> bytes:
    """A link to a file, as :func:`placed_device` takes it."""
    return bytes([number]) + b"=" + content


def device(content: bytes, draw: random.Random) -> bytes:
    """A link to the file, or to a device or folder."""
    return content if draw.random() < 0.4 else content[:1] + draw.choice(DEVICES).encode()


def placed_device(folder: Path, content: bytes) -> Path:
    """Put a link where the reader looks for a file."""
    path, file = folder / f"device-{content[0]}.toml", folder / "linked"
    path.unlink(missing_ok=True)
    if content[1:2] == b"=":
        file.write_bytes(content[2:])
    path.symlink_to(file if content[1:2] == b"=" else content[1:].decode())
    return path


def by_number(readers: list[Reader]) -> Reader:
    """The reader whose number stands in the name of a file."""
    return lambda path: readers[int(path.stem.partition("-")[2])](path)


def bomb(content: bytes, draw: random.Random) -> bytes:
    """Weights whose header states more, larger, shared or unordered tensors, or another length."""
    (length,) = struct.unpack("<Q", content[:8])
    header, body = json.loads(content[8 : 8 + length]), content[8 + length :]
    name = draw.choice(list(header))
    entry = header[name]
    kind = draw.randrange(7)
    if kind == 0:
        header |= {f"t{k}": entry for k in range(draw.choice((1, 100, 5000)))}
    elif kind == 1:
        entry["shape"] = [draw.choice((0, -1, 2**31, 2**62)) for _ in range(draw.randrange(1, 40))]
    elif kind == 2:
        entry["data_offsets"] = [draw.choice((-1, 0, 1, len(body), 2**63)) for _ in range(2)]
    elif kind == 3:
        body += bytes(draw.choice((1, 4, 2**16)))
    elif kind == 4:
        header = dict(draw.sample(list(header.items()), len(header)))
    elif kind == 5:
        header["__metadata__"] = {f"k{k}": "v" for k in range(draw.choice((1, 1000, 60_000)))}
    text = json.dumps(header).encode()
    stated = draw.choice((0, 2**20 + 1, 2**40, 2**64 - 1)) if kind == 6 else len(text)
    return struct.pack("<Q", stated) + text + body


def archive() -> bytes:
    """Rows of a page, packed as they are kept."""
    return _packed([("manifest.json", b"{}"), ("results/a.0a.json", b"[1, 2]\n" * 100)])


def _packed(files: list[tuple[str, bytes]], **about: object) -> bytes:
    """An archive; ``about`` is stated of its first file."""
    into = io.BytesIO()
    with tarfile.open(fileobj=into, mode="w", format=tarfile.PAX_FORMAT) as packing:
        for number, (name, content) in enumerate(files):
            member = tarfile.TarInfo(name)
            member.size = len(content)
            for key, value in about.items() if number == 0 else ():
                setattr(member, key, value)
            packing.addfile(member, io.BytesIO(content + bytes(512)))
    return lzma.compress(into.getvalue(), preset=0)


def harmed_archive(content: bytes, draw: random.Random) -> bytes:
    """An archive with changed bytes, outside or inside, or with members that lead elsewhere."""
    kind = draw.randrange(4)
    if kind == 0:
        return mutated(content, draw)
    if kind == 1:
        return lzma.compress(mutated(lzma.decompress(content), draw), preset=0)
    name = draw.choice(("a", "../a", "/tmp/a", "a/../../b", "a" * 300, "a\x1b[2J", ".", ""))
    if kind == 2:
        return _packed([(name, b"x"), ("b", b"y")])
    of = draw.choice((tarfile.SYMTYPE, tarfile.LNKTYPE, tarfile.CHRTYPE, tarfile.FIFOTYPE))
    target = draw.choice(("..", "/etc/passwd", "b", "a"))
    return _packed([("a", b""), ("a/b", b"y")], type=of, linkname=target)


def placed_archive(folder: Path, content: bytes) -> Path:
    """Put an archive where the rows of a page are kept, and nothing where they are unpacked."""
    path = folder / "rows" / "work.tar.xz"
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(content)
    shutil.rmtree(folder / "work", ignore_errors=True)
    return path


def read_archive(path: Path, *, verdicts: bool = False) -> None:
    """Unpack an archive, or a table of verdicts; refused, it leaves nothing behind."""
    work = path.parents[1] / "work"
    try:
        unpack(Entry("page", "", ("study",), work, verdicts), path.parent)
    except Exception:
        assert not work.exists(), "a folder of a refused archive"
        raise


def verdict_table(manifest: bytes) -> bytes:
    """A table of verdicts of one run, as it is kept, with the manifest of the run beside it."""
    row = {
        "run": "spatial", "shard": "0a", "layout": "A", "layout_hash": "0" * 16, "scenario": "S1",
        "item_count": 3, "method": "fbs", "method_name": "fbs", "parameters": "{}", "reason": "",
        "question": "within", "repetition": 0, "status": "done", "score": 1.0, "ignored": [],
        "emulated": [], "substeps": 0, **{n: 1 for n in tidy.ABOUT if n.endswith("_ns")},
    }  # fmt: skip
    table = pa.Table.from_pylist([row, {**row, "layout": "B"}], schema=tidy.TABLE)
    beside = _packed([("spatial/manifest.json", manifest)])
    return tidy.content(table, files=base64.b85encode(beside).decode())


def harmed_table(content: bytes, draw: random.Random) -> bytes:
    """A table with changed bytes, columns or values, or with another archive beside it."""
    if draw.random() < 0.6:
        return parquet.mutated_table(content, draw)
    source, sink = pa.BufferReader(content), io.BytesIO()
    beside = harmed_archive(base64.b85decode(pq.read_metadata(source).metadata[b"files"]), draw)
    pq.write_table(
        pq.read_table(source).replace_schema_metadata({"files": base64.b85encode(beside)}), sink
    )
    return sink.getvalue()


def placed_verdict_table(folder: Path, content: bytes) -> Path:
    """Put a table where the verdicts of a page are kept, and nothing where they are unpacked."""
    return placed_archive(folder, content).rename(folder / "rows" / "work.parquet")


def read_verdict_table(path: Path) -> None:
    """Unpack a table; refused, it leaves nothing behind."""
    read_archive(path, verdicts=True)


def failing_plans() -> list[bytes]:
    """Files of a plan with a box that leans, in which is room, and of one that stands."""
    items = tuple(
        Item(k, (x, y, 0.0), (40.0, 30.0, 40.0), 12.0, name=f"box {k}")
        for k, (x, y) in enumerate(((0.0, 0.0), (25.0, 30.0), (60.0, 0.0)))
    )
    plans = [Layout("A", Pallet(120, 160, 80), items), Layout("B", Pallet(120, 160, 80), items[:1])]
    written = "".join(as_native(plans)), as_job(plans), as_csv(plans)
    return [text.encode() for text in written]


def repair_file(path: Path) -> Exception | None:
    """Repair the plans of a file, and write it again: what is written has all its layouts."""
    source, target = Content.of(path), path.with_name("repaired")
    entries = read_entries([source])
    found = repair_all(entries, RepairOptions(method="equilibrium", seconds=0.3), workers=0)
    write_repaired(source, target, found)
    refused = [entry.error for _, entry in entries if isinstance(entry, Refused)]
    kept = [entry.name for entry in scan_layouts(target)]
    assert kept == [entry.name for _, entry in entries], "a layout is gone"
    return refused[0] if refused else None


WAREHOUSE = b"""\
Palette;PL;PB;PH;Folge;Artikel;X;Y;Z;L;B;H;Gewicht;SX;SY;SZ
P-1;1200;800;2000;1;SKU-2001;149;197,5;105,5;298;395;211;8611;15;0;0
P-1;1200;800;2000;2;SKU-2002;149;595,5;105,5;298;401;211;7250;0;3;-10
P-2;1200;800;2000;1;SKU-2003;157;300;79,5;300;600;159;12000;0;0;0
"""
FORM = Dialect(
    units="mm", weight="g", up="z", positions="centre", order="from-1",
    columns={"layout": "Palette", "pallet_length": "PL", "pallet_width": "PB",
             "pallet_height": "PH", "sequence": "Folge", "id": "Artikel", "length": "L",
             "width": "B", "height": "H", "weight": "Gewicht", "offset_x": "SX", "offset_y": "SY",
             "offset_z": "SZ"},
)  # fmt: skip
"""The form of that file, as of a warehouse system."""


def read_form(path: Path) -> Exception | None:
    """A file of another form than ours; the error of its last layout that is refused."""
    refused = None
    for entry in scan_layouts(path, dialect=FORM):
        refused = entry.error if isinstance(entry, Refused) else refused
    return refused


def read_given(path: Path) -> Exception | None:
    """The content of a file as bytes, and the open file: both are answered as the file is."""
    expected = _said(path)
    with path.open("rb") as file:
        for given in (path.read_bytes(), file):
            found = _said(given)
            assert found[0] == expected[0], "another answer"
    return expected[1]


def _said(given: object) -> tuple[list[str], Exception | None]:
    """Contents of layouts, and kinds of errors; the last error."""
    said, error = [], None
    try:
        for entry in scan_layouts(given):
            error = entry.error if isinstance(entry, Refused) else error
            said.append(str(type(error)) if isinstance(entry, Refused) else entry.content_hash())
    except UserError as raised:
        error = raised
        said.append(str(type(raised)))
    return said, error


def read_copy(path: Path) -> None:
    """The layouts of a run as they are kept beside its results, in JSON.

    Those in Parquet are not checked again: their checksum is compared before.
    """
    for _ in read_written(path):
        pass


MADE = b"""{"engines": ["mujoco", "rapier"], "versions": {"numpy": "2.4.0"},
 "machine": "AMD Zen 4, 2 cores", "git": "0123456789ab"}"""
"""With what the rows of a page were made."""

TYPES = b"X,Y,Z,COPIES,ROTATIONS\n60,40,30,12,1\n120,80,100,3,1\n"
"""Items of PackingSolver."""

PRODUCTS = b"#products 2\n1 0 12 400 300 250 8.5 x\n2 0 3 600 400 300 12 y\n"
"""Products of Alonso et al."""


def results() -> list[bytes]:
    """Results of the authors' benchmark on a layout of two items: a score, and observations."""
    sample = {"translation": {"x": 0.0, "y": 0.1, "z": 0.0}, "rotation": dict.fromkeys("xyz", 0.0)}
    steps = [
        {"sequence": k, "itemDeltas": {"0": {"observations": [sample, sample]}}} for k in range(2)
    ]
    return [b'{"score": 0.5}', json.dumps(steps).encode()]


def read_result(path: Path) -> Exception | None:
    """A result of the authors'; what is written down as refused is handed out."""
    reader = ResultReader(path.parent, RotationUnit.DEGREES, [])
    reader.label([(True, path)], 2)
    return BenchmarkError(reader.refused[0][1]) if reader.refused else None


def labels() -> bytes:
    """Labels of a run of two cases."""
    rows = [
        {"layout": name, "scenario": "S1", "instance": "one", "item_count": 3, "failing_step": step,
         "confidence": 0.9, "robust": True, "offsets": [0.0] * 9, "item_class": "2",
         "stands": "done", "failing_step_stands": step}
        for name, step in (("A", 1), ("B", None))
    ]  # fmt: skip
    return as_labels(pd.DataFrame(rows)[LABELS.names])


def placed_labels(folder: Path, content: bytes) -> Path:
    """Put labels where those of a run lie."""
    run = folder / "labelled-run"
    run.mkdir(exist_ok=True)
    (run / LABELS_FILE).write_bytes(content)
    return run


def read_labels(run: Path) -> None:
    """The labels of a run whose manifest has their checksum."""
    load_labels(run, {"files": {LABELS_FILE: checksum((run / LABELS_FILE).read_bytes())}})
