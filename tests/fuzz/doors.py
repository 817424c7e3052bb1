"""Files that are no valid file with a small change: holes, devices, bombs in headers.

Also the door that writes what it has read: a file of plans with its repairs.
"""

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

from mutation import mutated

from steadyload.app.repaired_files import write_repaired
from steadyload.app.repairs import RepairOptions, repair_all
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.files.record import Refused
from steadyload.layouts.files.sources import Content
from steadyload.layouts.formats import scan_layouts
from steadyload.layouts.writers import as_csv, as_native
from steadyload.runs.scoring import read_entries
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


def read_archive(path: Path) -> None:
    """Unpack an archive; refused, it leaves nothing behind."""
    work = path.parents[1] / "work"
    try:
        unpack(Entry("page", "", ("study",), work), path.parent)
    except Exception:
        assert not work.exists(), "a folder of a refused archive"
        raise


def failing_plans() -> list[bytes]:
    """Files of a plan with a box that leans, in which is room, and of one that stands."""
    items = tuple(
        Item(k, (x, y, 0.0), (40.0, 30.0, 40.0), 12.0, name=f"box {k}")
        for k, (x, y) in enumerate(((0.0, 0.0), (25.0, 30.0), (60.0, 0.0)))
    )
    plans = [Layout("A", Pallet(120, 160, 80), items), Layout("B", Pallet(120, 160, 80), items[:1])]
    return ["".join(as_native(plans)).encode(), as_csv(plans).encode()]


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
