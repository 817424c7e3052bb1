"""Makes one published page of a tree from its kept rows, in the present folder; judges nothing.

``making.py TREE`` prints the names of all pages, ``making.py TREE PAGE`` makes one. It is run by
the Python of that tree, see :mod:`pin`.
"""

import base64
import io
import json
import os
import re
import sys
import tarfile
from contextlib import contextmanager
from functools import partial, wraps
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq

import steadyload
from steadyload import atomic
from steadyload.cli import main
from steadyload.runs.kept_only import kept_only
from steadyload.runs.store import Store
from steadyload.studies import published
from steadyload.studies.kept_rows import archive_of

WRITTEN = Path("written")
"""Folder of files that a page writes into the source tree, at their places in that."""

MADE = Path("made.json")
"""What is told of a page: whether it was made, its keys, and CPU seconds."""

_SHARD = re.compile(rf"(.*/)?([^./][^/]*)\.[0-9a-f]{{{atomic.CHECKSUM_DIGITS}}}\.\w+")
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_TRUNC


def make(name: str, tree: Path) -> None:
    """Make a page, and tell of it in :data:`MADE`."""
    entry, rows = published.named((name,))[0], tree / published.ROWS
    asked: dict[str, set[str]] = {"found": set(), "absent": set()}
    atomic._replace = _beside(tree)(atomic._replace)
    sys.addaudithook(partial(_refuse_writing, tree))
    with kept_only("a pin judges nothing"), _noting(asked):
        status = main(["pages", "remake", name, "--rows", str(rows)])
    archive = archive_of(entry, rows)
    told = {
        "made": status == 0,
        "folder": str(published.FOLDER / name),
        "keys": {
            "archive": kept_keys(archive, entry.work) if archive.exists() else None,
            **{kind: sorted(keys) for kind, keys in asked.items()},
        },
        "seconds": sum(os.times()[:4]),
    }
    MADE.write_text(json.dumps(told))


def kept_keys(archive: Path, work: Path) -> list[str]:
    """The keys of all shards of a page's rows, below its work folder."""
    if archive.suffix == ".parquet":
        shards = pd.read_parquet(archive, columns=["run", "shard"]).drop_duplicates()
        kept = [work / run / "results" / shard for run, shard in shards.to_numpy()]
        packed = pq.read_metadata(archive).metadata[b"files"]
        beside = _keys_in(work, fileobj=io.BytesIO(base64.b85decode(packed)))
        return sorted([*map(str, kept), *beside])
    return _keys_in(work, name=archive)


def _keys_in(work: Path, **archive) -> list[str]:
    with tarfile.open(**archive) as kept:
        found = map(_SHARD.fullmatch, kept.getnames())
        return sorted(str(work / (shard[1] or "") / shard[2]) for shard in found if shard)


@contextmanager
def _noting(asked):
    """Note every key that a store is asked for, and whether it is there."""
    before = {name: getattr(Store, name) for name in ("__contains__", "content", "_is_whole")}

    def noted(ask):
        @wraps(ask)
        def asking(self, key):
            where = os.path.relpath(self._folder / key)
            try:
                answer = ask(self, key)
            except Exception:
                asked["absent"].add(where)
                raise
            asked["absent" if answer is False else "found"].add(where)
            return answer

        return asking

    for name, ask in before.items():
        setattr(Store, name, noted(ask))
    try:
        yield
    finally:
        for name, ask in before.items():
            setattr(Store, name, ask)


def _beside(tree):
    """What a page writes into the tree is written to :data:`WRITTEN` instead."""

    def beside(replace):
        def replacing(target, parts):
            whole = target.resolve()
            if whole.is_relative_to(tree):
                target = WRITTEN / whole.relative_to(tree)
                target.parent.mkdir(parents=True, exist_ok=True)
            replace(target, parts)

        return replacing

    return beside


def _refuse_writing(tree, event, values):
    """Audit hook: nothing is written into the tree in another way, but compiled code."""
    if event == "open":
        paths = values[:1] if (values[2] or 0) & _WRITING else ()
    else:
        places = {"os.mkdir": 1, "os.remove": 1, "os.rmdir": 1, "os.rename": 2, "os.link": 2}
        paths = values[: places.get(event, 0)]
    for path in paths:
        if isinstance(path, str | bytes | os.PathLike):
            whole = Path(os.path.abspath(os.fsdecode(path)))  # noqa: PTH100
            if whole.is_relative_to(tree) and "__pycache__" not in whole.parts:
                raise PermissionError(f"{whole}: a pin writes nothing into the tree")


if __name__ == "__main__":
    root = Path(sys.argv[1])
    if not Path(steadyload.__file__).is_relative_to(root):
        sys.exit(f"{sys.executable} runs {steadyload.__file__}, which is not of {root}")
    if sys.argv[2:]:
        make(sys.argv[2], root)
    else:
        print("\n".join(entry.name for entry in published.entries()))
