"""Trained weights in a folder: a safetensors file a member, and a manifest that says it all.

Judging reads them by itself; writing takes the safetensors library, which training installs.
"""

from __future__ import annotations

import hashlib
import math
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from steadyload.atomic import (
    ChecksumError,
    manifest_text,
    verified_manifest,
    write_atomically,
)
from steadyload.errors import nearest
from steadyload.layouts.files.record import shown
from steadyload.learners import LearnerError
from steadyload.learners.features import FeatureKind, names
from steadyload.learners.inference import Network
from steadyload.learners.options import TrainingOptions, options_from
from steadyload.learners.ranges import TrainedRanges, quantities_of
from steadyload.learners.tensors import check_tensors, tensor_shapes
from steadyload.reading import (
    MAX_STORED_BYTES,
    MAX_TABLE_BYTES,
    content_of,
    in_words,
    json_of,
    own_file,
)

VERSION = 1

MANIFEST = "manifest.json"

WEIGHTS = "weights"
"""The folder of the weights in that of the training that made them."""

SHIPPED = own_file("steadyload.learners", "weights")
"""The folder of the weights that come with the package, a folder a name in it."""

_TYPES = {"F32": np.float32, "F64": np.float64, "I64": np.int64}
_MOST_HEADER = 1024**2
_MOST_MEMBERS = 100


@dataclass(frozen=True)
class Weights:
    """Networks of one ensemble, and the provenance of their weights.

    Attributes:
        kind: of features that they take.
        networks: the members, one or more.
        ranges: what they were trained on.
        manifest: see :func:`save_weights`.
        digest: hash of the weights and the manifest.
    """

    kind: FeatureKind
    networks: tuple[Network, ...]
    ranges: TrainedRanges
    manifest: Mapping[str, Any]
    digest: str


def save_weights(
    folder: Path, members: Sequence[Mapping[str, np.ndarray]], manifest: Mapping[str, Any]
) -> Path:
    """Write weights; the manifest comes last, and without it a folder holds none.

    Args:
        folder: made when it does not exist; weights in it are replaced.
        members: arrays of every network by name.
        manifest: at least ``features``, the kind; ``ranges``, as of
            :func:`steadyload.learners.ranges.trained_ranges`; ``command``, what makes the weights
            again; ``members``, of every network its ``options``, which say its tensors.

    Returns:
        The folder.
    """
    from safetensors.numpy import save

    folder.mkdir(parents=True, exist_ok=True)
    (folder / MANIFEST).unlink(missing_ok=True)
    hashes = []
    for number, arrays in enumerate(members):
        content = save({name: np.ascontiguousarray(value) for name, value in arrays.items()})
        write_atomically(folder / _file(number), content)
        hashes.append(hashlib.sha256(content).hexdigest())
    for old in folder.glob("member_*.safetensors"):
        if old.name not in {_file(k) for k in range(len(hashes))}:
            old.unlink()
    whole = {"version": VERSION, "hashes": hashes, **manifest}
    write_atomically(folder / MANIFEST, manifest_text(whole))
    return folder


def load_weights(where: str | Path) -> Weights:
    """Read weights.

    Args:
        where: see :func:`weights_folder`.

    Raises:
        LearnerError: no weights there, damaged ones, of another version, or with tensors that are
            not those of their networks.
        TooLargeError: a file has more bytes than such a network.
    """
    folder = weights_folder(where)
    text = content_of(folder / MANIFEST, MAX_STORED_BYTES)
    try:
        manifest = json_of(text)
        version, hashes = manifest["version"], list(manifest["hashes"])
        kind = FeatureKind(manifest["features"])
        known = set(manifest["ranges"]) >= set(quantities_of(kind))
        ranges = TrainedRanges(manifest["ranges"], kind) if known else None
        made = [dict(member["options"]) for member in manifest["members"][: len(hashes)]]
        features = tuple(manifest.get("feature_names", names(kind)))
        if not 0 < len(hashes) == len(made) <= _MOST_MEMBERS:
            raise ValueError
    except (
        ValueError, TypeError, LookupError, AttributeError, RecursionError, OverflowError
    ):  # fmt: skip
        raise LearnerError(f"{folder / MANIFEST}: is not the manifest of weights") from None
    if version != VERSION:
        raise LearnerError(f"{folder / MANIFEST}: version is {shown(version)}; allowed: {VERSION}")
    if features != names(kind) or ranges is None:
        raise LearnerError(
            f"{folder}: its features or ranges are not those of this version; train it again"
        )
    options = [options_from(values, where=str(folder / MANIFEST)) for values in made]
    size = sum(map(_bytes_of, options))
    if size > MAX_TABLE_BYTES:
        raise LearnerError(
            f"{folder / MANIFEST}: its networks have {in_words(size)}; "
            f"allowed: {in_words(MAX_TABLE_BYTES)}"
        )
    networks = []
    for number, (expected, trained) in enumerate(zip(hashes, options, strict=True)):
        path = folder / _file(number)
        content = content_of(path, _MOST_HEADER + _bytes_of(trained)) if path.exists() else b""
        if hashlib.sha256(content).hexdigest() != expected:
            raise LearnerError(f"{path}: is {'damaged' if content else 'missing'}")
        if trained.features is not kind:
            raise LearnerError(
                f"{folder / MANIFEST}: features of member {number} are {trained.features}; "
                f"allowed: {kind}, as of all"
            )
        arrays = parse_arrays(content, path)
        check_tensors(arrays, trained, where=path)
        networks.append(Network(arrays))
    try:
        manifest = verified_manifest(manifest)
    except ChecksumError:
        raise LearnerError(f"{folder / MANIFEST}: is damaged; train again to mend it") from None
    digest = hashlib.sha256(text).hexdigest()[:16]
    return Weights(kind, tuple(networks), ranges, manifest, digest)


def weights_folder(where: str | Path) -> Path:
    """The folder that holds weights.

    Args:
        where: as a text a name of shipped weights (a folder of that name in the working directory
            is ``./lstm_1``), else a folder: of weights, or of the training that made some.

    Raises:
        LearnerError: it is neither a name of shipped weights nor a folder of some.
    """
    if isinstance(where, str) and where in shipped_weights():
        return SHIPPED / where
    for folder in (Path(where), Path(where) / WEIGHTS):
        if (folder / MANIFEST).is_file():
            return folder
    known = nearest(str(where), shipped_weights())
    raise LearnerError(
        f"weights {str(where)!r}: there are none of that name, nor in such a folder; {known}; "
        f"steadyload train --preset quick -o {where} makes some"
    )


def shipped_weights() -> list[str]:
    """Names of the weights that come with the package."""
    return sorted(path.parent.name for path in SHIPPED.glob(f"*/{MANIFEST}"))


def load_arrays(where: str | Path, member: int = 0) -> dict[str, np.ndarray]:
    """The arrays of one member, to train on from.

    Raises:
        LearnerError: as :func:`load_weights`, or there is no such member.
    """
    path = weights_folder(where) / _file(member)
    if not path.exists():
        raise LearnerError(f"{path}: is missing")
    return parse_arrays(content_of(path, MAX_TABLE_BYTES), path)


def parse_arrays(content: bytes, path: Path) -> dict[str, np.ndarray]:
    """The arrays of a safetensors file.

    The format: length of the header (8 bytes, little-endian), the header as JSON, which says type,
    shape and place of every array, then the arrays.

    Args:
        content: the file.
        path: for messages.

    Raises:
        LearnerError: it is none, holds other types than floats and whole numbers, or arrays that
            do not fill it one after the other.
    """
    try:
        (length,) = struct.unpack("<Q", content[:8])
        if length > min(_MOST_HEADER, len(content) - 8):
            raise ValueError
        header, body = json_of(content[8 : 8 + length]), memoryview(content)[8 + length :]
        header.pop("__metadata__", None)
        end = 0
        for begin, following in sorted(entry["data_offsets"] for entry in header.values()):
            if begin != end or following < begin:
                raise ValueError
            end = following
        if end != len(body):
            raise ValueError
        return {
            name: np.frombuffer(
                body[slice(*entry["data_offsets"])], dtype=np.dtype(_TYPES[entry["dtype"]])
            ).reshape(entry["shape"])
            for name, entry in header.items()
        }
    except (struct.error, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        raise LearnerError(f"{path}: is no safetensors file of numbers") from None


def _bytes_of(options: TrainingOptions) -> int:
    """Bytes of the tensors of a network."""
    return 4 * sum(map(math.prod, tensor_shapes(options).values()))


def _file(member: int) -> str:
    return f"member_{member}.safetensors"
