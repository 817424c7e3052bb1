"""Provenance of a run: the versions on which its rows depend, and further facts for pages.

Rows are stored under a key of everything that they depend on (:func:`key_of`). Code enters it by
versions of parts that are raised by hand (:func:`made_by`), never by its text: moving, renaming or
speeding up code keeps rows valid. Source revision, Python and machine (:func:`provenance`) are
reported and do not enter keys.
"""

from __future__ import annotations

import hashlib
import inspect
import json
import platform
import re
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

from steadyload.engines.registry import (
    engines,
    engines_of_rows,
    installed_versions,
    numerics,
    package_versions,
    usable_engines,
    world_class,
)
from steadyload.engines.world import VERSION as WORLD
from steadyload.methods.contract.method import Method
from steadyload.methods.contract.spec import stored_values
from steadyload.methods.envelope import ENVELOPES

OWN = "steadyload"
"""The package whose classes have versions of parts."""

_ENTRY_POINTS = ("steadyload.methods", "steadyload.engines")


def key_of(parts: Mapping[str, Any] | Sequence[Any]) -> str:
    """Key of everything that rows depend on: a hash of canonical JSON, 20 hexadecimal digits.

    Args:
        parts: values that JSON can hold; the order of the keys of a mapping does not matter.
    """
    text = json.dumps(parts, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:20]


def made_by(method: Method) -> dict[str, str]:
    """Everything besides its input on which a method's verdicts depend, by name.

    These are its full parameters (a preset that is tuned anew keeps its spec), versions of its
    parts and of the packages that they declare, digests of weights and thresholds, and, where a
    class is from another distribution, the version of that and a hash of the source of the class.
    """
    made = {"parameters": key_of(stored_values(method.parameters))}
    made |= {f"version of {part}": str(number) for part, number in method.parts().items()}
    made |= package_versions(sorted(method.numerics()))
    if method.made_of():
        made["weights and thresholds"] = method.made_of()
    for each in method.classes():
        made |= _from_outside(each)
    return made


def made_on(engine: str) -> dict[str, str]:
    """Versions on which results of an engine alone depend: its own, all adapters', packages'."""
    world = world_class(engine)
    parts = {"world": WORLD, "engine": world.capabilities.version}
    made = {f"version of {part}": str(number) for part, number in parts.items()}
    return made | package_versions(sorted(numerics(engine))) | _from_outside(world)


def raised(version: int) -> dict[str, int]:
    """The version of a computation as an entry of a key, once it was raised above 1.

    Version 1 has no entry, so that keys made before versions were introduced stay valid.
    """
    return {} if version == 1 else {"version": version}


def _from_outside(cls: type) -> dict[str, str]:
    """Entries of a key that identify the code of a class without versions of parts."""
    if cls.__module__.partition(".")[0] == OWN:
        return {}
    source = Path(inspect.getsourcefile(cls) or "")
    made = {f"source of {cls.__qualname__}": hashlib.sha256(source.read_bytes()).hexdigest()}
    for group in _ENTRY_POINTS:
        for entry in metadata.entry_points(group=group):
            if entry.dist is not None and entry.value == f"{cls.__module__}:{cls.__qualname__}":
                made[entry.dist.name] = entry.dist.version
    return made


_ROWS: ContextVar[MadeWith | None] = ContextVar("provenance of rows", default=None)


@dataclass(frozen=True)
class MadeWith:
    """With what rows were made.

    Attributes:
        engines: that they can be of.
        versions: of packages, by name.
        machine: on which they were made.
        git: the source revision; None for that of an installed package.
    """

    engines: tuple[str, ...]
    versions: Mapping[str, str]
    machine: str
    git: str | None = None

    @classmethod
    def here(cls) -> MadeWith:
        """With what rows are made here."""
        return cls(usable_engines(), **provenance())


@contextmanager
def of_rows(made: MadeWith) -> Iterator[None]:
    """Let :func:`provenance` and the engines that studies compare be those of kept rows.

    Nothing is judged or measured inside; see :func:`steadyload.engines.registry.engines_of_rows`.
    """
    before = _ROWS.set(made)
    try:
        with engines_of_rows(made.engines, made.versions):
            yield
    finally:
        _ROWS.reset(before)


def provenance() -> dict[str, Any]:
    """Versions, source revision and kind of machine; nothing that identifies a person or host.

    Inside of :func:`of_rows` those of the rows.
    """
    made = _ROWS.get()
    if made is not None:
        return {"git": made.git, "versions": dict(made.versions), "machine": made.machine}
    versions = package_versions(("numpy", "pandas", "pyarrow", "scipy"))
    return {
        "git": _git_revision(),
        "versions": {
            "python": platform.python_version(),
            **package_versions((OWN,)),
            **versions,
            **installed_versions(),
        },
        "machine": machine(),
    }


def machine() -> str:
    """This kind of machine: its system and its processor."""
    return f"{platform.system()} {platform.machine()}, {machine_kind()}"


@cache
def machine_kind() -> str:
    """Kind of processor: times are comparable on the same kind alone."""
    info = Path("/proc/cpuinfo")
    pairs = re.findall(
        r"^(model name|cpu family|model|CPU implementer|CPU part)\s*:\s*(.*\S)",
        info.read_text(encoding="utf-8") if info.exists() else "", re.MULTILINE,
    )  # fmt: skip
    first = dict(pairs[: len({name for name, _ in pairs})])  # of the first processor
    named = [first.pop("model name", ""), *(f"{name} {number}" for name, number in first.items())]
    return ", ".join(filter(None, named)) or platform.processor() or platform.machine()


def provenance_lines(made: Mapping[str, Any] | None = None, of: str = "") -> dict[str, str]:
    """A provenance as a page shows it.

    Args:
        made: the manifest of a run folder; None for a run with the present code and machine.
        of: the part of the page that was made so, which every line then names; empty: all of it.
    """
    made = provenance() if made is None else made
    found = {
        "source": source_line(made),
        "versions": ", ".join(f"{k} {v}" for k, v in made["versions"].items()),
        "machine": made["machine"],
    }
    without = [
        name
        for name, entry in engines().items()
        if entry.newest is not None and not made["versions"].keys() >= {*entry.packages}
    ]
    if without:
        found["without the engines"] = ", ".join(without)
    return {f"{of}: {name}": text for name, text in found.items()} if of else found


def source_line(made: Mapping[str, Any]) -> str:
    """The source revision of a provenance, or the version of the package that was installed."""
    if made.get("git"):
        return f"git {made['git']}"
    return f"installed package {made['versions'].get(OWN, '')}".rstrip()


def _git_revision() -> str | None:
    """Commit of the source tree this code runs from, marked when it has changes; None outside.

    What remaking published pages writes does not count (pages, the rows behind them, and the
    envelopes of engines): one is remade after the other.
    """
    root = Path(__file__).resolve().parents[2]
    if not (root / ".git").exists():
        return None
    described = _git(root, "describe", "--always", "--abbrev=12")
    made = ("reports/published", "reports/rows", f"harness/methods/{ENVELOPES}")
    others = [f":!{path}" for path in made]
    changed = _git(root, "status", "--porcelain", "--untracked-files=no", "--", ".", *others)
    if not described or changed is None:
        return None
    return f"{described}-dirty" if changed else described


def _git(root: Path, *words: str) -> str | None:
    """The output of git; None where it fails."""
    command = ["git", "-C", str(root), *words]
    try:
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            encoding="utf-8",
            errors="replace",
            timeout=10,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()
