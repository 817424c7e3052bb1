"""Fixtures of all tests: engines, small layouts, real data, commands to interrupt, a set clock.

Also what is said of deep tests and of skipped ones: see docs/testing.md.
"""

import gc
import importlib
import logging
import os
import re
import signal
import subprocess
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from functools import cache, partial
from pathlib import Path
from types import ModuleType, SimpleNamespace
from xml.etree import ElementTree
from zlib import crc32

import matplotlib.image
import pytest
from hypothesis import HealthCheck, settings
from tested_engines import TESTED

from steadyload.engines.registry import (
    EngineEntry,
    absent_engines,
    engines,
    world_class,
)
from steadyload.engines.world import EngineNotInstalledError
from steadyload.layouts import Item, Layout, Pallet
from steadyload.methods import registry
from steadyload.runs import pool

# A busy machine fails no test.
settings.register_profile("unhurried", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("unhurried")

ACLPP = Path(__file__).resolve().parents[2] / "shared" / "data" / "aclpp"
PALLETS = Path(__file__).resolve().parents[2] / "shared" / "data" / "pallets" / "pallets.json"
_JUDGES = Path(__file__).parent / "outside" / "outside_judges.py"
_ALLOWED_SKIPS = Path(__file__).parent / "allowed_skips.toml"
_PERTURBING = Path(__file__).parent / "perturbing"
_DEEP = tomllib.loads((Path(__file__).parent / "deep.toml").read_text())
"""Tests that take long, by file or folder: each, or a case of it, or ``all`` of them, and why."""


gc.disable()
"""Until tests are collected: nothing that collecting makes is garbage."""


def pytest_collection_finish() -> None:
    """What collecting has made is not looked at again for garbage."""
    gc.freeze()
    gc.enable()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options of the run as a whole."""
    parser.addoption(
        "--strict-skips",
        action="store_true",
        help=f"fail when a test is skipped for a reason that {_ALLOWED_SKIPS.name} does not name",
    )
    parser.addoption(
        "--may-skip", action="append", default=[], metavar="REASON",
        help="the beginning of another reason that is allowed in this run",
    )  # fmt: skip
    parser.addoption(
        "--perturb", metavar="SEED",
        help="move every start of a simulation by up to 1e-7 of a box's lengths, by this seed",
    )  # fmt: skip
    parser.addoption("--share", metavar="K/N", help="run the K-th of N shares of the tests alone")


def pytest_configure(config: pytest.Config) -> None:
    """Move starts, where that is asked for, also in processes that tests start."""
    if config.option.perturb is not None:
        _moved_starts().begin(config.option.perturb)


def _moved_starts() -> ModuleType:
    """The module of that name, which no process has to import that moves nothing."""
    if str(_PERTURBING) not in sys.path:
        sys.path.insert(0, str(_PERTURBING))
    return importlib.import_module("moved_starts")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """A test of what holds to the last bit by definition has its starts where they are planned."""
    if item.config.option.perturb is None or item.get_closest_marker("exact") is None:
        return (yield)
    with _moved_starts().by(None):
        return (yield)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark what takes long, before tests are chosen by their marks."""
    config.files = {item.path for item in items}  # type: ignore[attr-defined]
    config.deep = set()  # type: ignore[attr-defined]
    for item in items:
        for place, name in _names(item):
            if name in _DEEP.get(place, {}):
                config.deep.add((place, name))  # type: ignore[attr-defined]
                item.add_marker(pytest.mark.deep(_DEEP[place][name]))
        for mark in item.iter_markers():
            has_a_reason = len(mark.args) == 1 and isinstance(mark.args[0], str)
            if mark.name in ("deep", "exact") and not has_a_reason:
                raise pytest.UsageError(f"{item.nodeid}: {mark.name} takes one reason")
    if config.option.share is not None:
        shared = [(item, _is_in(item.nodeid, config.option.share)) for item in items]
        items[:] = [item for item, is_in in shared if is_in]
        config.hook.pytest_deselected(items=[item for item, is_in in shared if not is_in])


def _is_in(test: str, share: str) -> bool:
    """Whether a test is in a share, whatever other tests there are."""
    try:
        number, of = map(int, share.split("/"))
    except ValueError:
        number, of = 0, 0
    if not 1 <= number <= of:
        raise pytest.UsageError(f"--share is {share!r}; allowed: K/N, K from 1 to N, such as 2/5")
    return crc32(test.encode()) % of == number - 1


def _names(item: pytest.Item) -> Iterator[tuple[str, str]]:
    """What names a test in ``deep.toml``: a file or folder, and a name there."""
    file, *folders = _places(item.path)
    test = item.nodeid.partition("::")[2]
    yield from ((file, test), (file, test.partition("[")[0]), (file, "all"))
    yield from ((folder, "all") for folder in folders)


@cache
def _places(path: Path) -> list[str]:
    """A file and the folders that it is in, below this one."""
    file = Path(os.path.relpath(path, Path(__file__).parent))
    return [each.as_posix() for each in (file, *file.parents)]


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail a strict run with a skip that is not allowed."""
    config = session.config
    if config.option.strict_skips and not all(_allowed(config, r) for r in _skips(config)):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print how many tests were skipped, and why."""
    config = terminalreporter.config
    counted = Counter(_skips(config))
    terminalreporter.section(f"{counted.total()} skipped")
    for reason, count in counted.most_common():
        verdict = "" if _allowed(config, reason) else " (NOT ALLOWED)"
        terminalreporter.line(f"{count:4} {reason}{verdict}")


def _skips(config: pytest.Config) -> list[str]:
    """The reasons of the tests and files skipped in this run; none where another process knows."""
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    reports = reporter.stats.get("skipped", []) if reporter else []
    return [report.longrepr[2].removeprefix("Skipped: ") for report in reports]


def _allowed(config: pytest.Config, reason: str) -> bool:
    patterns = tomllib.loads(_ALLOWED_SKIPS.read_text())["reasons"]
    return any(re.match(p, reason) for p in patterns) or any(
        reason.startswith(beginning) for beginning in config.option.may_skip
    )


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Iterator[None]:
    """A test that needs an engine that this Python cannot have is skipped."""
    return _skipped_without_an_engine((yield), item)


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Iterator[None]:
    """So is a file of such tests."""
    return _skipped_without_an_engine((yield), collector)


def _skipped_without_an_engine(report, at):
    told = report.longreprtext + "".join(text for _, text in report.sections)
    marks = {name for mark in at.iter_markers("engine") for name in mark.args}
    for engine, why in absent_engines().items():
        lacking = [why, *(f"No module named '{p}'" for p in engines()[engine].packages)]
        lacking += [f"needs the package {p}" for p in engines()[engine].packages]
        if report.failed and (engine in marks or any(text in told for text in lacking)):
            report.outcome = "skipped"
            report.longrepr = (str(at.path), 0, f"Skipped: {why}")
    return report


@pytest.fixture(scope="session", autouse=True)
def _compiling_quietly() -> Iterator[None]:
    """Let commands in this process say nothing of what the first run of a clone compiles."""
    log = logging.getLogger("steadyload.engines.reference.compilation")
    log.disabled = True
    yield
    log.disabled = False


def _needed(entry: EngineEntry) -> str:
    """Why tests of an optional engine are deep."""
    return f"needs the package {entry.system}" if entry.system else f"needs the extra {entry.extra}"


@pytest.fixture(params=TESTED)
def engine(request: pytest.FixtureRequest) -> str:
    """Every engine that is compared unasked, one after the other."""
    return request.param


@pytest.fixture(
    params=[
        pytest.param(name, marks=pytest.mark.deep(_needed(entry)))
        if entry.optional and not entry.base and name not in TESTED
        else name
        for name, entry in engines().items()
    ]
)
def any_engine(request: pytest.FixtureRequest) -> str:
    """Every registered engine; an optional one is deep, and skipped where it is not installed."""
    if engines()[request.param].optional:
        try:
            world_class(request.param)
        except EngineNotInstalledError as error:
            pytest.skip(str(error))
    return request.param


@pytest.fixture
def aclpp_files() -> list[Path]:
    files = sorted(ACLPP.glob("*.yaml"))
    if not files:
        pytest.skip("the ACLPP schedules are not beside the project (../shared/data/aclpp)")
    return files


@pytest.fixture
def customers_pallets() -> Path:
    if not PALLETS.exists():
        pytest.skip("customers' pallets are not beside the project (../shared/data/pallets)")
    return PALLETS


@pytest.fixture
def stack() -> Callable[..., Layout]:
    """Makes a column of 10 cm cubes; ``shifts`` are their x positions."""

    def make(*shifts: float, offset: float = 0.0, weight: float = 1.0) -> Layout:
        items = tuple(
            Item(
                step,
                (40.0 + shift, 10.0 * step, 40.0),
                (10.0, 10.0, 10.0),
                weight,
                (offset, 0.0, 0.0) if step == len(shifts) - 1 else (0.0, 0.0, 0.0),
            )
            for step, shift in enumerate(shifts)
        )
        return Layout("stack", Pallet(100.0, 100.0, 100.0), items)

    return make


@pytest.fixture
def plate() -> Callable[[float], Layout]:
    """Makes a plate on posts at two opposite corners; ``offset_z`` shifts its centre of mass.

    Contacts (0..1, 0..1) and (9..10, 9..10). Their hull's edge from (0, 1) to (9, 10) passes
    x = 4.5, where the centre of mass lies, at z = 5.5: an offset of 0.5.
    """

    def make(offset_z: float) -> Layout:
        items = (
            Item(0, (0.0, 0.0, 0.0), (1.0, 5.0, 1.0), 1.0),
            Item(1, (9.0, 0.0, 9.0), (1.0, 5.0, 1.0), 1.0),
            Item(2, (0.0, 5.0, 0.0), (10.0, 1.0, 10.0), 1.0, (-0.5, 0.0, offset_z)),
        )
        return Layout("plate", Pallet(100.0, 100.0, 100.0), items)

    return make


@pytest.fixture
def outside(tmp_path, monkeypatch):
    """The judges of another distribution, found by entry points as an installed one's are."""
    site = tmp_path / "site"
    about = site / "outside_judges-1.0.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: outside-judges\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(
        "[steadyload.methods]\nharmful = outside_judges:Harmful\n"
        "harmful_batches = outside_judges:HarmfulBatches\n"
    )
    (site / "outside_judges.py").write_bytes(_JUDGES.read_bytes())
    monkeypatch.syspath_prepend(site)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(site), *filter(None, sys.path)]))
    monkeypatch.setenv("OUTSIDE_JUDGES", str(tmp_path))
    registry._from_other_distributions.cache_clear()
    yield importlib.import_module("outside_judges")
    registry._from_other_distributions.cache_clear()
    del sys.modules["outside_judges"]


@pytest.fixture
def begin():
    """Starts the command as the leader of a process group, which Ctrl-C reaches as a whole."""

    def started(*arguments, cwd=None):
        return subprocess.Popen(
            [sys.executable, "-m", "steadyload.cli", *arguments], cwd=cwd, stderr=subprocess.PIPE,
            text=True, start_new_session=True,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            # What a shell runs in the background ignores interrupts, and so does all it starts.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )  # fmt: skip

    return started


@pytest.fixture
def begin_study(begin):
    """Starts ``study.toml`` in a folder, and returns when the first of its results is there."""

    def started(folder, *options):
        process = begin("study", "run", "study.toml", "-o", "run", *options, cwd=folder)
        deadline = time.monotonic() + 600
        while not list(folder.glob("run/results/*.parquet")) and time.monotonic() < deadline:
            time.sleep(0.005)
        return process

    return started


@pytest.fixture
def moved_by() -> Callable[[str | None], AbstractContextManager[None]]:
    """Moves starts by a seed, or none, whatever ``--perturb`` says; in this process alone."""
    return _moved_starts().by


@pytest.fixture
def told_time(monkeypatch):
    """Puts a clock into modules that stands still but for two things that ``engine`` does.

    A substep takes a millisecond, and adding a box takes 20. What is clocked can then be told
    exactly, on any machine. ``busy`` is how much more wall time passes than CPU time.
    """

    def installed(engine, *modules, busy=1.0, patch=monkeypatch):
        world, now = world_class(engine), 0.0
        advance, add_box = world._advance, world.add_box

        def stepping(self, substeps, length):
            nonlocal now
            advance(self, substeps, length)
            now += 1e-3 * substeps

        def adding(self, box):
            nonlocal now
            now += 20e-3
            return add_box(self, box)

        patch.setattr(world, "_advance", stepping)
        patch.setattr(world, "add_box", adding)
        clock = SimpleNamespace(
            process_time=lambda: now, thread_time=lambda: now, perf_counter=lambda: busy * now
        )
        for module in modules:
            patch.setattr(module, "time", clock)

    return installed


def _in_this_process() -> Iterator[None]:
    """Commands judge in this process: for tests of what they say, wherever it was judged."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pool, "Processes", lambda workers=None: pool.Serial())
        yield


in_this_process = pytest.fixture(_in_this_process)
file_in_this_process = pytest.fixture(_in_this_process, scope="module")


@pytest.fixture
def undrawn(monkeypatch):
    """Pages are written with empty pictures: for tests of what a page says.

    Figures are made all the same. What a kind of page shows is drawn by one test of that kind.
    """
    monkeypatch.setattr(
        "steadyload.reports.pages.writing.image", lambda figure: (".svg", b"<svg/>")
    )


@pytest.fixture
def undrawn_text() -> Callable[[str], str]:
    """Takes checksums out of names of pictures, and of details that name some: those of empty
    pictures are other ones.
    """
    return partial(re.sub, r"\.[0-9a-f]{16}(?=\.(?:svg|png|md)[)#])", "")


@pytest.fixture
def assert_drawn() -> Callable[[Path], None]:
    """Asserts that a figure's file is of a fair size, and not blank."""

    def check(path: Path) -> None:
        if path.suffix == ".png":
            image = matplotlib.image.imread(path)
            assert min(image.shape[:2]) > 100, path
            assert image[..., :3].std() > 0.01, path
            return
        root = ElementTree.parse(path).getroot()
        assert min(map(float, root.attrib["viewBox"].split()[2:])) > 70, path
        shapes = [e for e in root.iter() if e.tag.rpartition("}")[2] in ("path", "use", "image")]
        assert len(shapes) > 20, path

    return check
