"""A study's definition: one TOML file, validated when it is read."""

from __future__ import annotations

import glob
import logging
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any

from steadyload.config import REQUIRED, option, refuse_missing, values_of
from steadyload.engines.registry import absent_engines
from steadyload.errors import UserError, nearest
from steadyload.escaping import shown
from steadyload.layouts.benchmark.parts import Part, set_named
from steadyload.layouts.files.dialect import Dialect, DialectError, load_profile
from steadyload.layouts.files.record import Refused
from steadyload.layouts.formats import Reading, scan_batches
from steadyload.layouts.model.batch import LayoutBatch
from steadyload.layouts.model.distinct_names import DistinctNames
from steadyload.layouts.model.floor import FloorKind
from steadyload.layouts.model.layout import Layout, LayoutError
from steadyload.layouts.model.scenarios import Scenario, apply_scenario
from steadyload.layouts.packing.packing import drawn_layouts
from steadyload.methods.contract.method import Method
from steadyload.methods.contract.spec import SpecError, parse_spec
from steadyload.methods.registry import make_method
from steadyload.numbers import NumberError, seconds_allowed
from steadyload.reading import own_file, toml_of

_log = logging.getLogger("steadyload")

AS_GIVEN = "as given"
"""Scenario of layouts that keep the centres of mass of their files."""

EMBEDDED = "embedded"
"""Stands for the study that comes with the package."""


class StudyError(UserError):
    """A study definition that cannot be run; says which key and what is allowed."""


def _study_name(text: str) -> str:
    if not re.fullmatch(r"\w[\w .+-]*", text):
        raise ValueError(f"{shown(text)}; allowed: letters, digits, and any of _ . + -")
    return text


@dataclass(frozen=True, slots=True)
class StudyDefinition:
    """The methods and cases that a study compares.

    Raises:
        SpecError: no such method, engine or parameter.
        NumberError: the timeout is no limit on a time.
        StudyError: no such part, or an option that cannot be combined with a labelled set.
    """

    name: str = option(REQUIRED, "for people", read=_study_name)
    methods: tuple[str, ...] = option(
        REQUIRED, "spec strings, each once; kept in their canonical form", fewest=1
    )
    files: tuple[Path, ...] = option((), "layout files, absolute")
    generated: int = option(
        0, "so many generated layouts after those of the files, drawn with the seed", least=1
    )
    scenarios: tuple[Scenario, ...] = option(
        (), "scenarios to apply; empty keeps the centres of mass as given", fewest=1
    )
    seed: int = option(0, "root of every random draw", least=0)
    max_items: int | None = option(
        None, "judge only the first items of a layout; None for all", least=1
    )
    limit: int | None = option(None, "use only the first layouts; None for all", least=1)
    snap_gap: float = option(
        0.0, "vertical gaps to close when reading", unit="cm", least=0, most=1e6
    )
    overhang: float | None = option(
        None, "how far items may stand out over the edges of the deck; None for what a file "
        "states, or else 10", unit="cm", least=0, most=1e5,
    )  # fmt: skip
    floor: FloorKind | None = option(
        None, "what the layouts stand on; None for what a file states, or else auto"
    )
    repetitions: int = option(1, "judgements of every case, for timing", least=1)
    shard_size: int | None = option(
        None, "cases a unit of work; None for 12 to 100 by the number of cases, and 20,000 where "
        "methods judge batches", least=1,
    )  # fmt: skip
    timeout: float | None = option(
        None, "CPU time that a judgement may take; None for no limit", unit="s"
    )
    benchmark: Part | str | None = option(
        None, "the part of a labelled set whose cases are judged, or its name; None for layouts "
        "without labels. The set has its own layouts and centres of mass: scenarios picks among "
        "them (empty for all) and limit counts cases a scenario, those of the first ranks",
    )  # fmt: skip
    benchmark_directory: Path | str | None = option(
        None, "the folder of the labelled set, or a word of its SETS as a text; None for the "
        "large set that comes with the package",
    )  # fmt: skip
    dialect: Dialect = option(
        Dialect(), "units, axes, positions and columns of the files, which are then CSV files"
    )
    strict: bool = option(False, "end at the first layout that is not valid; else it is left out")

    made: tuple[Method, ...] = field(default=(), repr=False, compare=False)
    """The methods themselves, in the same order; made of their specs where they are not given."""

    def __post_init__(self) -> None:
        if tuple(map(str, self.made)) != self.methods:
            object.__setattr__(self, "made", tuple(map(make_method, self.methods)))
        object.__setattr__(self, "methods", tuple(map(str, self.made)))
        # Keys of kept rows do not depend on whether 20 or 20.0 is stated.
        object.__setattr__(self, "timeout", seconds_allowed(self.timeout))
        if self.overhang is not None:
            object.__setattr__(self, "overhang", float(self.overhang))
        if self.benchmark is None:
            if self.benchmark_directory is not None:
                raise StudyError('benchmark_directory needs a part: benchmark = "test"')
            return
        if self.benchmark not in list(Part):
            raise StudyError(
                f"benchmark is {shown(self.benchmark)}; {nearest(str(self.benchmark), list(Part))}"
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
        for entry in self.batches(refused):
            yield from entry if isinstance(entry, LayoutBatch) else (entry,)

    def batches(
        self, refused: Callable[[Refused], None] = lambda one: None
    ) -> Iterator[LayoutBatch | Layout]:
        """As :meth:`layouts`, but layouts that became arrays at once come as batches."""
        names, several = DistinctNames(), len(self.files) + bool(self.generated) > 1
        first: list[LayoutError] = []
        empty = True
        for entry in self._first(self._sources(refused, first)):
            own = entry.names if isinstance(entry, LayoutBatch) else (entry.name,)
            if several and (again := names.add(own)) is not None:
                raise StudyError(f"layouts: name {again!r} stands in two files; allowed: once")
            empty = False
            yield entry
        if empty and first:
            raise first[0]
        if empty:
            raise StudyError("layouts: the files hold none; allowed: one or more")

    def _first(self, entries: Iterable[LayoutBatch | Layout]) -> Iterator[LayoutBatch | Layout]:
        """The first layouts, as many as are wanted."""
        left = self.limit
        for entry in entries:
            if left is None:
                yield entry
                continue
            kept = entry[:left] if isinstance(entry, LayoutBatch) else entry
            left -= len(kept) if isinstance(kept, LayoutBatch) else 1
            yield kept
            if left == 0:
                return

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
    ) -> Iterator[LayoutBatch | Layout]:
        for file in self.files:
            try:
                for entry in scan_batches(file, **self.reading()):
                    if not isinstance(entry, Refused):
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
        path = own_file("steadyload.runs.embedded", "study.toml")
    else:
        path = Path(source)
    content = {"name": path.stem, **toml_of(path, StudyError)}
    if str(source) == EMBEDDED:
        content["methods"] = _had_here(content["methods"])
    stated = values_of(
        StudyDefinition, content, str(path), StudyError,
        apart=("files", "dialect", "made"), beside=(_Named,),
    )  # fmt: skip
    refuse_missing(StudyDefinition, stated, str(path), StudyError)
    try:
        return _definition(stated, path.parent)
    except (StudyError, SpecError, DialectError, NumberError) as error:
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


@dataclass(frozen=True)
class _Named:
    """Keys of a study file that name files, relative to its folder."""

    layouts: tuple[str, ...] = option((), "layout files, or patterns of them", fewest=1)
    profile: Path | None = option(None, "TOML file of a dialect")
    benchmark_directory: str | None = option(None, "folder of a labelled set, or its word")


def _definition(stated: dict[str, Any], folder: Path) -> StudyDefinition:
    """The study of the values of its file, and of the files that these name."""
    if not {"layouts", "generated", "benchmark", "benchmark_directory"} & stated.keys():
        raise StudyError(
            "layouts is missing; allowed: a list of files, or generated = a number, or "
            "benchmark = a part of the labelled set"
        )
    stated["made"] = _distinct(stated["methods"])
    stated["methods"] = tuple(map(str, stated["made"]))
    stated["files"] = _matched(stated.pop("layouts", ()), folder)
    stated["scenarios"] = tuple(dict.fromkeys(stated.get("scenarios", ())))
    stated["benchmark_directory"] = set_named(stated.get("benchmark_directory"), folder)
    if (profile := stated.pop("profile", None)) is not None:
        stated["dialect"] = load_profile(folder / profile)
    return StudyDefinition(**stated)


def _distinct(methods: Sequence[str]) -> tuple[Method, ...]:
    """The methods of specs, each once."""
    seen: dict[object, Method] = {}
    for text in methods:
        method = make_method(text)
        identity = (type(method), method.spec.engine, method.parameters)
        if identity in seen:
            raise StudyError(
                f"methods: {str(method)!r} is the same as {str(seen[identity])!r}; name it once"
            )
        seen[identity] = method
    return tuple(seen.values())


def _matched(patterns: Sequence[str], folder: Path) -> tuple[Path, ...]:
    """The files of patterns, each once."""
    files: list[Path] = []
    for pattern in patterns:
        found = sorted(glob.glob(str(folder / pattern), recursive=True))
        if not found:
            raise StudyError(f"layouts: {shown(pattern)} matches no file")
        files += [Path(name).resolve() for name in found]
    return tuple(dict.fromkeys(files))
