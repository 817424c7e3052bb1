"""Compare the numbers of every kind of page with recorded ones.

``python tests/pins/compare.py [--published] [PAGE ...]`` runs each page's commands of this
checkout in a fresh folder and looks for every recorded fact; status 1 if one is missing or has
another value. ``--record`` writes what is found as the new record.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

from definitions import HERE, PUBLISHED, Definition, RunError, definitions
from differences import Found, Renames, compare_pages, compare_rows
from facts import Page, read_page
from rows import rows_of

FIXTURES = HERE / "fixtures"
_SHOWN = 40


def main() -> int:
    """Compare or record; the exit status."""
    options = _options()
    known = definitions()
    renames = Renames(tomllib.loads((HERE / "renames.toml").read_text()))
    if options.published:
        named = {d.published: d for d in known.values() if d.published}
        return _all(options, named, renames, _published)
    return _all(options, known, renames, _ran)


def _all(
    options: argparse.Namespace,
    known: dict[str, Definition],
    renames: Renames,
    one: Callable[[str, Definition, argparse.Namespace, Renames], bool],
) -> int:
    """Do one thing to all pages asked for; the exit status."""
    unknown = [name for name in options.pages if name not in known]
    if unknown:
        print(f"no page {', '.join(unknown)}; there are: {', '.join(known)}", file=sys.stderr)
        return 2
    clean = True
    for name in options.pages or known:
        try:
            clean &= one(name, known[name], options, renames)
        except (RunError, OSError) as error:
            print(f"{name}: FAILED: {error}", flush=True)
            clean = False
    return 0 if clean else 1


def _ran(name: str, page: Definition, options: argparse.Namespace, renames: Renames) -> bool:
    """Make a page, and record or compare it."""
    with tempfile.TemporaryDirectory(prefix=f"pins-{name}-") as fresh:
        work = Path(fresh)
        if options.keep:
            work = options.keep.resolve() / name
            work.mkdir(parents=True, exist_ok=True)
        seconds = page.make(work) if not any(work.iterdir()) else 0.0
        facts, rows = page.page(work), rows_of(work)
    folder = FIXTURES / name
    count = sum(len(table["rows"]) for table in rows.values())
    print(f"{name}: {seconds:.0f} CPU s, {facts.fact_count()} facts, {count} rows", flush=True)
    if options.record:
        _write(folder / "facts.json", facts.to_json())
        _write(folder / "rows.json", rows)
        return True
    old = Page.from_json(json.loads((folder / "facts.json").read_text()))
    found = compare_pages(name, old, facts, renames)
    held = compare_rows(name, json.loads((folder / "rows.json").read_text()), rows, renames)
    _tell("facts", found, options.verbose)
    _tell("rows", held, options.verbose)
    return found.clean and held.clean


def _published(name: str, page: Definition, options: argparse.Namespace, renames: Renames) -> bool:
    """Record or compare a published page as it is."""
    facts = read_page((PUBLISHED / name / "report.md").read_text())
    print(f"published {name}: {facts.fact_count()} facts", flush=True)
    file = FIXTURES / "published" / f"{name}.json"
    if options.record:
        _write(file, facts.to_json())
        return True
    old = Page.from_json(json.loads(file.read_text()))
    if not options.clocks:
        old, facts = page.without_clocks(old), page.without_clocks(facts)
    found = compare_pages(f"published/{name}", old, facts, renames)
    _tell("facts", found, options.verbose)
    return found.clean


def _tell(what: str, found: Found, verbose: bool) -> None:
    counts = [f"{found.same} the same"]
    for kind in ("moved", "elsewhere", "reworded", "waived", "changed", "missing", "new"):
        lines = getattr(found, kind)
        if lines:
            counts.append(f"{len(lines)} {kind}")
    print(f"  {what}: {', '.join(counts)}")
    told = ("moved", "elsewhere", "reworded", "waived", "new") if verbose else ()
    for kind in ("changed", "missing", *told):
        lines = getattr(found, kind)
        for line in lines if verbose else lines[:_SHOWN]:
            print(f"    {kind}: {line}")
        if len(lines) > _SHOWN and not verbose:
            print(f"    {kind}: {len(lines) - _SHOWN} more (--verbose)")


def _write(file: Path, content: dict[str, Any]) -> None:
    """Write JSON with a line a row."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(_text(content) + "\n")


def _text(content: Any) -> str:
    """JSON in which a list without tables or rows in it stands on one line."""
    if isinstance(content, dict):
        inner = [f"{json.dumps(key)}: {_text(value)}" for key, value in content.items()]
        return "{" + ",\n".join(inner) + "}"
    if isinstance(content, list) and any(isinstance(value, dict | list) for value in content):
        nested = any(isinstance(value, dict) for value in content)
        inner = [_text(v) if nested else json.dumps(v, ensure_ascii=False) for v in content]
        return "[\n" + ",\n".join(inner) + "]"
    return json.dumps(content, ensure_ascii=False)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pages", nargs="*", metavar="PAGE", help="default: all")
    parser.add_argument("--record", action="store_true", help="write what is found as the record")
    parser.add_argument("--published", action="store_true", help="the published pages as they are")
    parser.add_argument(
        "--clocks", action="store_true", help="with --published: values of clocks, too"
    )
    parser.add_argument(
        "--keep", type=Path, metavar="DIR",
        help="work in DIR/PAGE and leave it; what is there already is read, not run",
    )  # fmt: skip
    parser.add_argument("--verbose", "-v", action="store_true", help="list everything")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
