"""Pin of published pages: what a change of studies must leave as it is, byte for byte.

``pin.py record FOLDER [PAGE ...] [--tree TREE]`` remakes pages of a tree from their kept rows;
``pin.py compare BEFORE AFTER [PAGE ...]`` tells what differs. Nothing is judged, and nothing in
the tree is changed. Either side of a comparison may be ``reports/published`` of a tree: its pages
are compared, and what they write into the tree; it has no keys. A recording holds, of every page,

- ``pages/PAGE``: its files, and in ``written`` those that it writes into the source tree;
- ``keys/PAGE.json``: keys that its stores were asked for, those ``found`` and those ``absent``,
  and all keys of its ``archive`` of rows; null where it keeps none. A page that cannot be made,
  for want of a row, has these alone.
"""

import argparse
import difflib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

HERE = Path(__file__).parent
TOGETHER = 2
"""Pages that are made at the same time."""

MOST = 20
"""Lines of a difference, and keys, that are shown."""

WIDTH = 160
"""Characters of a line that are shown."""

_OUTPUT = ("report.md", "report.html", "report-details*", "figures")
"""Files of a published page that are no input of it, as patterns."""

_NOT_IN_GIT = "report.html"
"""File of a page that a clone does not have."""

_SUM = re.compile(r"\.[0-9a-f]{16}(?=\.)")
_KEYS = {
    "found": ("no longer asked for", "newly asked for"),
    "absent": ("no longer asked for in vain", "not found"),
    "archive": ("no longer kept", "newly kept"),
}


Keys = dict[str, list[str] | None]


class PinError(Exception):
    """A tree that is none, or a page that is not made."""


def record(folder: Path, names: list[str], tree: Path) -> bool:
    """Make pages of a tree into a folder; all where none is named. True if every one was made.

    Raises:
        PinError: the tree is none, or has no such page; or all pages are asked for
            and the folder holds some already, of which one may be of no page any more.
    """
    if not names and (folder / "pages").exists():
        raise PinError(f"{folder} holds a recording; name pages to make anew, or another folder")
    listed = _run(tree, Path.cwd())
    if listed.returncode:
        raise PinError(listed.stderr.strip())
    known = listed.stdout.split()
    unknown = sorted(set(names) - set(known))
    if unknown:
        raise PinError(f"no page is called {', '.join(unknown)}; there are {', '.join(known)}")
    with ThreadPoolExecutor(TOGETHER) as pool:
        every = True
        for line, made in pool.map(partial(_record, folder, tree), names or known):
            print(line, flush=True)
            every = every and made
    return every


def _record(folder: Path, tree: Path, name: str) -> tuple[str, bool]:
    """Make one page; a line about it, and whether it was made."""
    page, keys = folder / "pages" / name, folder / "keys" / f"{name}.json"
    shutil.rmtree(page, ignore_errors=True)
    keys.unlink(missing_ok=True)
    with tempfile.TemporaryDirectory(prefix="pin-") as scratch:
        there = Path(scratch, "tree")
        if (tree.parent / "shared").exists():
            Path(scratch, "shared").symlink_to(tree.parent / "shared")
        inputs = Path("reports", "published")
        shutil.copytree(tree / inputs, there / inputs, ignore=shutil.ignore_patterns(*_OUTPUT))
        Path(there, "reports", "rows").symlink_to(tree / "reports" / "rows")
        ended = _run(tree, there, name)
        if ended.returncode:
            return f"{name}: NOT MADE\n{ended.stderr.strip()}", False
        made = json.loads((there / "made.json").read_text())
        keys.parent.mkdir(parents=True, exist_ok=True)
        keys.write_text(json.dumps(made["keys"], indent=1) + "\n")
        if not made["made"]:
            return f"{name}: NOT MADE\n{ended.stderr.strip()}", False
        shutil.copytree(there / made["folder"], page)
        if (there / "written").exists():
            shutil.copytree(there / "written", page / "written")
    asked, kept = len(made["keys"]["found"]), made["keys"]["archive"]
    about = "keeps no rows" if kept is None else f"{asked} keys asked for, {len(kept)} kept"
    return f"{name}: {made['seconds']:.1f} s CPU, {about}", True


def _run(tree: Path, there: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """A run of ``making.py`` in a folder."""
    own = tree / ".venv" / "bin" / "python"
    python = own if own.exists() else sys.executable
    given = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "STEADYLOAD"))}
    one = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL")}
    return subprocess.run(
        [python, HERE / "making.py", tree, *words], cwd=there, capture_output=True, text=True,
        check=False, env=given | one | {"MUJOCO_GL": "disable"},
    )  # fmt: skip


def compare(before: Path, after: Path, names: list[str]) -> bool:
    """Print page by page what differs of two sides; all where none is named. True if equal.

    Raises:
        PinError: one of the folders holds neither a recording nor published pages.
    """
    sides = _Side(before), _Side(after)
    equal = True
    for name in names or sorted(sides[0].names | sides[1].names):
        told = list(_differences(*sides, name))
        keeps_none = any(side.keys(name).get("archive", ()) is None for side in sides)
        note = " (keeps no rows)" if keeps_none and not told else ""
        print(f"{name}: {'DIFFERS' if told else 'equal'}{note}", *told, sep="\n  ")
        equal = equal and not told
    return equal


class _Side:
    """One side of a comparison: a recording, or the published pages of a tree."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.is_recording = (folder / "pages").is_dir()
        if not self.is_recording and not any(folder.glob("*/report.md")):
            raise PinError(f"{folder} holds no recording and no published pages")
        self._pages = folder / "pages" if self.is_recording else folder
        self.names = {path.name for path in self._pages.iterdir() if path.is_dir()}
        self.names |= {path.stem for path in folder.glob("keys/*.json")}

    def page(self, name: str) -> Path:
        return self._pages / name

    def keys(self, name: str) -> Keys:
        """The keys of a page; none where it has none."""
        file = self.folder / "keys" / f"{name}.json"
        found: Keys = json.loads(file.read_text()) if file.is_file() else {}
        return found

    def files(self, name: str, other: Path) -> dict[str, bytes]:
        """The files of a page; published, with those of the tree that the other side writes."""
        found = _files(self.page(name))
        if not self.is_recording and (other / "written").is_dir():
            for path in _files(other / "written"):
                place = self.folder.resolve().parents[1] / path
                found |= {f"written/{path}": place.read_bytes()} if place.is_file() else {}
        return found


def _differences(before: _Side, after: _Side, name: str) -> Iterator[str]:
    """Lines on what differs in a page; none where it is equal."""
    sides = before, after
    pages = [side.page(name) for side in sides]
    lost = [side for side in sides if not side.page(name).is_dir()]
    yield from (f"is missing in {side.folder}" for side in lost)
    are_recordings = before.is_recording and after.is_recording
    if not lost:
        old, new = before.files(name, pages[1]), after.files(name, pages[0])
        for files in () if are_recordings else (old, new):
            files.pop(_NOT_IN_GIT, None)
        yield from _of_files(old, new)
    if are_recordings:
        keys = [side.keys(name) for side in sides]
        yield from (f"has no keys in {s.folder}" for s, k in zip(sides, keys, strict=True) if not k)
        if all(keys):
            yield from _of_lists(*keys)


def _of_lists(was: Keys, now: Keys) -> Iterator[str]:
    for kind, (gone, come) in _KEYS.items():
        lists = was[kind], now[kind]
        if (None in lists) and lists != (None, None):
            yield "keeps no rows any more" if lists[1] is None else "keeps rows now"
        first, second = (set(keys or ()) for keys in lists)
        yield from _of_keys(gone, first - second)
        yield from _of_keys(come, second - first)


def _files(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def _of_files(old: dict[str, bytes], new: dict[str, bytes]) -> Iterator[str]:
    """Files that differ; one whose name has a new checksum is compared with the one before."""
    was, now = (
        {_SUM.sub("", file): file for file in sorted(files.keys() - others.keys())}
        for files, others in ((old, new), (new, old))
    )
    renamed = {was[bare]: now[bare] for bare in was.keys() & now.keys()}
    for file in sorted(old.keys() | new.keys() - renamed.values()):
        other = renamed.get(file, file)
        if file not in old or other not in new:
            yield f"{file}: {'new' if other in new else 'gone'}"
            continue
        if file != other:
            yield f"{file}: is now {other}"
        if old[file] != new[other]:
            yield f"{other}: differs"
            yield from _of_texts(old[file], new[other])


def _of_texts(old: bytes, new: bytes) -> Iterator[str]:
    try:
        texts = [content.decode().splitlines() for content in (old, new)]
    except UnicodeDecodeError:
        yield f"  {len(old)} bytes before, {len(new)} after"
        return
    lines = list(difflib.unified_diff(*texts, "before", "after", n=0, lineterm=""))[2:]
    yield from (f"  {line[:WIDTH]}" for line in lines[:MOST])
    if len(lines) > MOST:
        yield f"  and {len(lines) - MOST} lines more"


def _of_keys(what: str, keys: Iterable[str]) -> Iterator[str]:
    listed = sorted(keys)
    if listed:
        yield f"{len(listed)} keys {what}"
        yield from (f"  {key}" for key in listed[:MOST])
    if len(listed) > MOST:
        yield f"  and {len(listed) - MOST} more"


def main() -> int:
    """Record or compare; 1 where a page was not made or differs, 2 where nothing could be done."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    actions = parser.add_subparsers(dest="action", required=True)
    for action, folders in (("record", ("folder",)), ("compare", ("before", "after"))):
        of = actions.add_parser(action)
        for folder in folders:
            of.add_argument(folder, type=Path)
        of.add_argument("pages", nargs="*", metavar="page", help="only these (default: all)")
        if action == "record":
            of.add_argument("--tree", type=Path, default=HERE.parents[1], help="another clone")
    given = parser.parse_args()
    try:
        if given.action == "record":
            good = record(given.folder.resolve(), given.pages, given.tree.resolve())
        else:
            good = compare(given.before, given.after, given.pages)
    except PinError as error:
        print(f"pin: {error}", file=sys.stderr)
        return 2
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
