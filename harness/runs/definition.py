"""A study's definition: one TOML file, validated when it is read."""

from __future__ import annotations

import glob
import logging
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from importlib import resources
from itertools import islice
from pathlib import Path
from typing import Any

from steadyload.engines.registry import absent_engines
from steadyload.errors import UserError, nearest
from steadyload.layouts.benchmark import Part
from steadyload.layouts.benchmark.dataset import set_named
from steadyload.layouts.files.dialect import Dialect, DialectError, load_profile
from steadyload.layouts.files.record import Refused, shown
from steadyload.layouts.formats import Reading, scan_layouts
from steadyload.layouts.model.floor import FloorKind
from steadyload.layouts.model.layout import Layout, LayoutError
from steadyload.layouts.model.scenarios import Scenario, apply_scenario
from steadyload.layouts.packing.packing import drawn_layouts
from steadyload.methods.contract.spec import SpecError, parse_spec
from steadyload.methods.registry import make_method
from steadyload.reading import toml_of

_log = logging.getLogger("steadyload")

_MOST = 2**63 - 1
"""Of a whole number: what libraries count with."""

AS_GIVEN = "as given"
"""Scenario of layouts that keep the centres of mass of their files."""

EMBEDDED = "embedded"
"""Stands for the study that comes with the package."""


class StudyError(UserError):
    """A study definition that cannot be run; says which key and what is allowed."""


@dataclass(frozen=True, slots=True)
class StudyDefinition:
    """The methods and cases that a study compares.

    Attributes:
        name: for people.
        methods: spec strings, each once; kept in their canonical form.
        files: layout files, absolute.
        generated: this many generated layouts after those of the files, drawn with the seed.
        scenarios: scenarios to apply; empty keeps the centres of mass as given.
        seed: root of every random draw, 0 or more.
        max_items: judge only the first items of a layout; None for all.
        limit: use only the first layouts; None for all.
        snap_gap: vertical gaps to close when reading [cm].
        dialect: units, axes, positions and columns of the files, which are then CSV files.
        strict: end at the first layout that is not valid; else it is left out.
        overhang: how far items may stand out over the edges of the deck [cm]; None for what a file
            states, or else 10.
        floor: what the layouts stand on; None for what a file states, or else ``auto``.
        repetitions: judgements of every case, for timing.
        shard_size: cases a unit of work.
        timeout: CPU seconds a judgement may take; None for no limit.
        benchmark: the part of a labelled set whose cases are judged, or its name; None for layouts
            without labels. The set has its own layouts and centres of mass: ``scenarios`` picks
            among them (empty for all) and ``limit`` counts cases a scenario, those of the first
            ranks.
        benchmark_directory: the folder of the labelled set, or a word of
            :data:`steadyload.layouts.benchmark.dataset.SETS` as a text; None for the large set that
            comes with the package.

    Raises:
        SpecError: no such method, engine or parameter.
        StudyError: no such part, or an option that cannot be combined with a labelled set.
    """

    name: str
    methods: tuple[str, ...]
    files: tuple[Path, ...] = ()
    generated: int = 0
    scenarios: tuple[Scenario, ...] = ()
    seed: int = 0
    max_items: int | None = None
    limit: int | None = None
    snap_gap: float = 0.0
    overhang: float | None = None
    floor: FloorKind | None = None
    repetitions: int = 1
    shard_size: int = 12
    timeout: float | None = None
    benchmark: Part | str | None = None
    benchmark_directory: Path | str | None = None
    dialect: Dialect = Dialect()
    strict: bool = False

    def __post_init__(self) -> None:
        methods = tuple(str(make_method(spec).spec) for spec in self.methods)
        object.__setattr__(self, "methods", methods)
        if self.benchmark is None:
            if self.benchmark_directory is not None:
                raise StudyError('benchmark_directory needs a part: benchmark = "test"')
            return
        if self.benchmark not in list(Part):
            raise StudyError(
                f"benchmark: {shown(self.benchmark)}; {nearest(str(self.benchmark), list(Part))}"
            )
        object.__setattr__(self, "benchmark", Part(self.benchmark))
        own = "a labelled set has its own layouts and centres of mass"
        for key, given, why in (
            ("layouts", self.files, own),
            ("generated", self.generated, own),
            ("seed", self.seed, own),
            ("snap_gap", self.snap_gap, own),
            ("profile", self.dialect.stated(), own),
            ("overhang", self.overhang is not None, own),
            ("floor", self.floor, "labels hold for an infinite floor"),
            ("max_items", self.max_items, "labels hold for whole layouts"),
        ):
            if given:
                raise StudyError(f"{key} cannot stand beside benchmark: {why}")

    def layouts(self, refused: Callable[[Refused], None] = lambda one: None) -> Iterator[Layout]:
        """The study's own layouts in turn, whole and without scenarios, those of the files first.

        Those of a labelled set come from :func:`steadyload.runs.labels.labelled_material`.

        Args:
            refused: called with each layout that is not valid, which is left out.

        Raises:
            LayoutError: a file is invalid; or a layout, if the study is strict or has no other.
            StudyError: two layouts have the same name, or a file cannot be read.
        """
        names: set[str] = set()
        first: list[LayoutError] = []
        for layout in islice(self._sources(refused, first), self.limit):
            if layout.name in names:
                raise StudyError(
                    f"layouts: name {layout.name!r} stands in two files; allowed: once"
                )
            names.add(layout.name)
            yield layout
        if not names and first:
            raise first[0]
        if not names:
            raise StudyError("layouts: the files hold none; allowed: one or more")

    def reading(self) -> Reading:
        """Choices in reading the files."""
        return {
            "dialect": self.dialect,
            "snap_gap": self.snap_gap,
            "overhang": self.overhang,
            "floor": self.floor,
        }

    def _sources(
        self, refused: Callable[[Refused], None], first: list[LayoutError]
    ) -> Iterator[Layout]:
        for file in self.files:
            try:
                for entry in scan_layouts(file, **self.reading()):
                    if isinstance(entry, Layout):
                        yield entry
                    elif self.strict:
                        raise entry.error
                    else:
                        first[:] = first or [entry.error]
                        refused(entry)
            except OSError as error:
                raise StudyError(f"layouts: {file}: {error.strerror}") from None
        for layout in islice(drawn_layouts(self.seed), self.generated):
            yield layout if self.floor is None else layout.on(self.floor)

    def cases(self, layouts: Iterable[Layout]) -> Iterator[tuple[str, Layout]]:
        """Every (scenario, layout) to judge, cut to ``max_items`` after the scenario is drawn."""
        for layout in layouts:
            for scenario in self.scenarios or (None,):
                yield str(scenario or AS_GIVEN), case(layout, scenario, self.seed, self.max_items)


def case(
    layout: Layout, scenario: Scenario | None, seed: int, max_items: int | None = None
) -> Layout:
    """A layout as it is judged: its centres of mass drawn, then cut to its first items."""
    drawn = layout if scenario is None else apply_scenario(layout, scenario, seed)
    return drawn if max_items is None else drawn.first(max_items)


def load_study(source: str | Path) -> StudyDefinition:
    """Read a study file, or the embedded study for the word ``embedded``.

    Raises:
        StudyError: not valid TOML, an unknown key or method, or a value that is not allowed.
        TooLargeError: it has too many bytes.
        OSError: the file cannot be read.
    """
    if str(source) == EMBEDDED:
        path = Path(str(resources.files("steadyload.runs.embedded") / "study.toml"))
    else:
        path = Path(source)
    content = toml_of(path, StudyError)
    try:
        if str(source) == EMBEDDED:
            content["methods"] = _had_here(content["methods"])
        return _definition(content, path)
    except (StudyError, SpecError, DialectError) as error:
        raise StudyError(f"{path}: {error}") from None


def _had_here(methods: Sequence[str]) -> list[str]:
    """The methods without those on engines that this Python cannot have, of which a log tells."""
    kept = list(methods)
    for engine, why in absent_engines().items():
        lost = [spec for spec in kept if parse_spec(spec).engine == engine]
        kept = [spec for spec in kept if spec not in lost]
        if lost:
            _log.warning("left out: %s, since %s", ", ".join(lost), why)
    return kept


def _definition(content: dict[str, Any], path: Path) -> StudyDefinition:
    known = {f.name for f in fields(StudyDefinition)} - {"files", "dialect"}
    known |= {"layouts", "profile"}
    for key in content:
        if key not in known:
            raise StudyError(f"unknown key {shown(key)}; {nearest(key, known)}")
    methods: list[str] = []
    seen: dict[object, str] = {}
    for text in _texts(content, "methods"):
        method = make_method(text)
        spec = str(method.spec)
        identity = (type(method), method.spec.engine, method.parameters)
        if identity in seen:
            raise StudyError(f"methods: {spec!r} is the same as {seen[identity]!r}; name it once")
        seen[identity] = spec
        methods.append(spec)
    files: list[Path] = []
    if not {"layouts", "generated", "benchmark", "benchmark_directory"} & set(content):
        raise StudyError(
            "layouts is missing; allowed: a list of files, or generated = a number, or "
            "benchmark = a part of the labelled set"
        )
    for pattern in _texts(content, "layouts") if "layouts" in content else []:
        found = sorted(glob.glob(str(path.parent / pattern), recursive=True))
        if not found:
            raise StudyError(f"layouts: {shown(pattern)} matches no file")
        files += [Path(name).resolve() for name in found]
    scenarios = _texts(content, "scenarios") if "scenarios" in content else []
    for scenario in scenarios:
        if scenario not in list(Scenario):
            raise StudyError(f"scenarios: {shown(scenario)}; {nearest(scenario, [*Scenario])}")
    numbers = {
        key: _whole(content[key], key, least)
        for key, least in (
            ("generated", 1), ("seed", 0), ("max_items", 1), ("limit", 1), ("repetitions", 1),
            ("shard_size", 1),
        )
        if key in content
    }  # fmt: skip
    snap_gap = content.get("snap_gap", 0.0)
    if type(snap_gap) not in (int, float) or not 0.0 <= snap_gap < 1e6:
        raise StudyError(f"snap_gap is {shown(snap_gap)}; allowed: 0 or more [cm]")
    overhang = content.get("overhang")
    if overhang is not None and (type(overhang) not in (int, float) or not 0.0 <= overhang < 1e5):
        raise StudyError(f"overhang is {shown(overhang)}; allowed: 0 or more [cm]")
    floor = content.get("floor")
    if floor is not None and floor not in list(FloorKind):
        raise StudyError(f"floor is {shown(floor)}; {nearest(str(floor), [*FloorKind])}")
    benchmark, folder = content.get("benchmark"), content.get("benchmark_directory")
    if folder is not None and not (isinstance(folder, str) and folder):
        raise StudyError(f"benchmark_directory is {shown(folder)}; allowed: the path of a folder")
    profile, strict = content.get("profile"), content.get("strict", False)
    if profile is not None and not (isinstance(profile, str) and profile):
        raise StudyError(f"profile is {shown(profile)}; allowed: the path of a TOML file")
    if not isinstance(strict, bool):
        raise StudyError(f"strict is {shown(strict)}; allowed: true or false")
    timeout = content.get("timeout")
    if timeout is not None and (type(timeout) not in (int, float) or not 0.0 < timeout < 1e9):
        raise StudyError(f"timeout is {shown(timeout)}; allowed: more than 0 [s]")
    name = content.get("name", path.stem)
    if not isinstance(name, str) or not re.fullmatch(r"\w[\w .+-]*", name):
        raise StudyError(f"name is {shown(name)}; allowed: letters, digits, and any of _ . + -")
    return StudyDefinition(
        name=name,
        methods=tuple(methods),
        files=tuple(dict.fromkeys(files)),
        scenarios=tuple(Scenario(s) for s in dict.fromkeys(scenarios)),
        snap_gap=float(snap_gap),
        overhang=overhang,
        floor=None if floor is None else FloorKind(floor),
        timeout=timeout,
        benchmark=benchmark,
        benchmark_directory=set_named(folder, path.parent),
        dialect=Dialect() if profile is None else load_profile(path.parent / profile),
        strict=strict,
        **numbers,
    )


def _texts(content: dict[str, Any], key: str) -> list[str]:
    if key not in content:
        raise StudyError(f"{key} is missing; allowed: a list of one or more texts")
    value = content[key]
    if not (isinstance(value, list) and value and all(isinstance(v, str) for v in value)):
        raise StudyError(f"{key} is {shown(value)}; allowed: a list of one or more texts")
    return value


def _whole(value: Any, key: str, least: int) -> int:
    if type(value) is not int or value < least:
        raise StudyError(f"{key} is {shown(value)}; allowed: a whole number, {least} or more")
    if value > _MOST:
        raise StudyError(f"{key} is {shown(value)}; allowed: a whole number of at most {_MOST}")
    return value
