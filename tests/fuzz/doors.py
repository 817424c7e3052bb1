"""Files that are no valid file with a small change: holes, devices, bombs in headers."""

import json
import os
import random
import struct
from collections.abc import Callable
from pathlib import Path

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
