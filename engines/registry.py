"""Names of engines. Listing them imports none; a missing library is one sentence.

An engine is one line in :data:`ENGINES`. Other distributions register engines through the
entry-point group ``steadyload.engines``, with values of the form ``module:Class``.
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.metadata
import platform
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache

from steadyload.engines import system_python
from steadyload.engines.world import (
    Capabilities,
    EngineNotInstalledError,
    FixedStepWorld,
    WorldSettings,
)
from steadyload.plugins import PluginError, faulty, loaded

GROUP = "steadyload.engines"
"""Group of entry points of engines."""


@dataclass(frozen=True, slots=True)
class EngineEntry:
    """An engine in the registry: the place of its class ("module:Class") and the packages it needs.

    ``options``: where a dataclass of the options of this engine alone lives; its fields are
    parameters of a simulation on this engine (see :func:`steadyload.engines.quantities.quantity`).
    ``extra`` names the optional dependencies of this distribution that bring them, ``system`` the
    package of a Linux distribution that brings them for the system's own Python. An engine that has
    one of the two takes part in studies where it is installed, and in tests where it is named.
    ``base``: every installation has its packages, but on platforms that they are not published for;
    its extra is another name of them, and tests need not name it.
    ``check_only``: it checks others, and is compared with them only where it is named.
    ``newest``: the newest Python that its packages are published for; None where that is any.
    """

    target: str
    packages: tuple[str, ...] = ()
    options: str = ""
    extra: str = ""
    system: str = ""
    base: bool = False
    check_only: bool = False
    newest: tuple[int, int] | None = None

    @property
    def optional(self) -> bool:
        """Whether an installation may be without it."""
        return bool(self.extra or self.system)


ENGINES: dict[str, EngineEntry] = {
    "bullet": EngineEntry(
        "steadyload.engines.with_bullet:BulletWorld", ("pybullet",), newest=(3, 11)
    ),
    "mujoco": EngineEntry(
        "steadyload.engines.with_mujoco:MujocoWorld",
        ("mujoco",),
        options="steadyload.engines.mujoco_options:MujocoOptions",
    ),
    "dart": EngineEntry(
        "steadyload.engines.with_dart:DartWorld",
        ("dartpy",),
        options="steadyload.engines.dart_options:DartOptions",
    ),
    "chipmunk": EngineEntry("steadyload.engines.with_chipmunk:ChipmunkWorld", ("pymunk",)),
    "reference": EngineEntry(
        "steadyload.engines.reference.world:ReferenceWorld",
        ("numba",),
        options="steadyload.engines.reference.options:ReferenceOptions",
        extra="reference",
    ),
    "physx": EngineEntry("steadyload.engines.with_physx:PhysxWorld", ("sapien",), extra="physx"),
    "rapier": EngineEntry(
        "steadyload.engines.with_rapier:RapierWorld",
        ("rapier3d",),
        options="steadyload.engines.rapier_options:RapierOptions",
        extra="rapier",
        base=True,
    ),
    "drake": EngineEntry(
        "steadyload.engines.with_drake:DrakeWorld", ("drake",), extra="drake", check_only=True
    ),
    "siconos": EngineEntry(
        "steadyload.engines.with_siconos:SiconosWorld",
        ("siconos",),
        system="python3-siconos",
        check_only=True,
    ),
}


_ROWS: ContextVar[tuple[Collection[str], Mapping[str, str]] | None] = ContextVar(
    "engines of rows", default=None
)


@contextlib.contextmanager
def engines_of_rows(names: Collection[str], versions: Mapping[str, str]) -> Iterator[None]:
    """Let the engines that kept rows were made on take the place of those that are installed here.

    Studies then compare these engines, and a package that is not installed has the version that the
    rows were made with, so that their keys are found. Nothing can be simulated by it.

    Args:
        names: of the engines.
        versions: of packages, by name.
    """
    before = _ROWS.set((names, versions))
    try:
        yield
    finally:
        _ROWS.reset(before)


def engines() -> dict[str, EngineEntry]:
    """All engines by name, with the optional ones and those of other distributions."""
    return _from_other_distributions() | ENGINES


@cache
def _from_other_distributions() -> dict[str, EngineEntry]:
    found = importlib.metadata.entry_points(group=GROUP)
    return {entry.name: EngineEntry(entry.value) for entry in found}


def engine_names() -> tuple[str, ...]:
    """Names of the engines that every installation has, in the order in which tables show them.

    Missing are those alone that this Python cannot have (:func:`absent_engines`).
    :func:`engines_here` has the optional ones that are installed, too, :func:`engines` all.
    """
    absent = absent_engines()
    return tuple(
        name for name, entry in engines().items() if not entry.optional and name not in absent
    )


def engines_here() -> tuple[str, ...]:
    """Names of the engines that studies compare: with the optional ones that are installed.

    Those that only check others are not among them. Inside of :func:`engines_of_rows` they are the
    engines of the rows.
    """
    return tuple(name for name in usable_engines() if not engines()[name].check_only)


def usable_engines() -> tuple[str, ...]:
    """Names of the engines that rows can be made on: :func:`engines_here`, and installed ones that
    only check others.

    Inside of :func:`engines_of_rows` they are the engines of the rows.
    """
    usual = engine_names() if _ROWS.get() is None else ()
    return tuple(
        name for name, entry in engines().items() if name in usual or not _missing(name, entry)
    )


def missing_packages(name: str) -> tuple[str, ...]:
    """Packages of an engine that are not installed.

    Raises:
        KeyError: no engine of that name.
    """
    return _missing(name, engines()[name])


def _missing(name: str, entry: EngineEntry) -> tuple[str, ...]:
    """Packages that are not installed; of an engine of rows none, of any other all."""
    rows = _ROWS.get()
    if rows is not None:
        return () if name in rows[0] else entry.packages or (name,)
    return _not_installed(entry)


def _not_installed(entry: EngineEntry) -> tuple[str, ...]:
    if entry.system:
        return tuple(p for p in entry.packages if system_python.version(p) is None)
    return tuple(package for package in entry.packages if not _is_installed(package))


@cache
def absent_engines() -> dict[str, str]:
    """Engines whose packages are not published for this Python, and are not here; with reasons."""
    found = {}
    for name, entry in engines().items():
        if entry.newest is None or sys.version_info[:2] <= entry.newest:
            continue
        if lost := _not_installed(entry):
            here = platform.python_version()
            newest = ".".join(map(str, entry.newest))
            found[name] = f"{lost[0]} is published for Python {newest} at most, and this is {here}"
    return found


def world_class(name: str) -> type[FixedStepWorld]:
    """The world class of an engine.

    Raises:
        KeyError: no engine of that name.
        EngineNotInstalledError: its library is missing.
    """
    entry = engines()[name]
    if entry.packages and (lost := _missing(name, entry)):
        raise _not_here(name, lost[0])
    return _declared_class(name)


def warm_up(name: str, box_count: int) -> None:
    """Make what worlds of an engine share, see :meth:`FixedStepWorld.warm_up`; where its packages
    are not installed, and kept rows stand for them, there is nothing to make.

    Raises:
        KeyError, EngineNotInstalledError: see :func:`world_class`.
    """
    world = world_class(name)
    if not _not_installed(engines()[name]):
        world.warm_up(box_count)


def capabilities(name: str) -> Capabilities:
    """Capabilities of an engine, also without its library if its adapter imports that later.

    Raises:
        KeyError, EngineNotInstalledError: see :func:`world_class`.
    """
    return _declared_class(name).capabilities


def _declared_class(name: str) -> type[FixedStepWorld]:
    if name not in ENGINES:
        return _class_of_others(name)
    module, _, attribute = ENGINES[name].target.partition(":")
    try:
        return getattr(importlib.import_module(module), attribute)
    except ModuleNotFoundError as error:
        missing = (error.name or "").partition(".")[0]
        if missing == module.partition(".")[0]:
            raise
        raise _not_here(name, missing) from error


def _class_of_others(name: str) -> type[FixedStepWorld]:
    """The world class of an engine of another distribution."""
    target = engines()[name].target
    try:
        found = loaded(target, GROUP, name)
        if not (isinstance(found, type) and issubclass(found, FixedStepWorld)):
            raise faulty(GROUP, name, f"{target} is no FixedStepWorld")
        if not isinstance(getattr(found, "capabilities", None), Capabilities):
            raise faulty(GROUP, name, f"{target} has no Capabilities")
    except PluginError as error:
        missing = error.__cause__
        if isinstance(missing, ModuleNotFoundError):
            package = (missing.name or "").partition(".")[0]
            raise EngineNotInstalledError(_needs(name, package)) from missing
        raise EngineNotInstalledError(str(error)) from error
    return found


def _not_here(name: str, package: str) -> EngineNotInstalledError:
    why = absent_engines().get(name)
    return EngineNotInstalledError(
        f"engine {name!r} is not here: {why}" if why else _needs(name, package)
    )


def _needs(name: str, package: str) -> str:
    entry = engines()[name]
    if entry.system:
        return (
            f"engine {name!r} needs the package {package} of the system's Python: "
            f"apt-get install {entry.system}"
        )
    told = f"'steadyload[{entry.extra}]'" if entry.extra and not entry.base else package
    return f"engine {name!r} needs the package {package}: pip install {told}"


def numerics(name: str) -> frozenset[str]:
    """Packages whose numbers an engine's motion hangs on: its own, and those of its adapter.

    Raises:
        KeyError, EngineNotInstalledError: see :func:`world_class`.
    """
    return frozenset((*engines()[name].packages, *world_class(name).capabilities.numerics))


def engine_options(name: str) -> type | None:
    """Dataclass of the options of this engine alone; None where there are none.

    Raises:
        KeyError: no engine of that name.
    """
    module, _, attribute = engines()[name].options.partition(":")
    return getattr(importlib.import_module(module), attribute) if module else None


@cache
def _is_installed(package: str) -> bool:
    return any(True for _ in importlib.metadata.distributions(name=package))


def open_world(name: str, settings: WorldSettings) -> FixedStepWorld:
    """A new, empty world of the named engine; the caller closes it.

    Raises:
        KeyError, EngineNotInstalledError: see :func:`world_class`.
    """
    if lost := _not_installed(engines()[name]):
        raise _not_here(name, lost[0])
    return world_class(name)(settings)


def installed_versions(engine: str | None = None) -> dict[str, str]:
    """Version of every engine package that is installed, by package name.

    Args:
        engine: leave out the optional packages of other engines than this one; None leaves out
            none. What a result was made with does not change when another engine is installed.
    """
    return package_versions(
        package
        for name, entry in engines().items()
        if engine is None or not entry.optional or name == engine
        for package in entry.packages
    )


def package_versions(names: Iterable[str]) -> dict[str, str]:
    """Versions of those packages that are installed, by name, in the order of the names.

    Inside of :func:`engines_of_rows` also of those that the rows were made with.
    """
    of_system = {p for entry in engines().values() if entry.system for p in entry.packages}
    _, of_rows = _ROWS.get() or ((), {})
    versions = {}
    for name in names:
        found = system_python.version(name) if name in of_system else _version(name)
        if found := found or of_rows.get(name):
            versions[name] = found
    return versions


def _version(package: str) -> str | None:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None
