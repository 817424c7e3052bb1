"""How many planted faults the quick tests of their rooms catch: ``make mutants``.

``mutants.py [--count N] [--seed SEED] [--room ROOM]... [--jobs J]`` plants one fault at a time in
a copy of the project, and runs the quick tests of the room that it stands in until the first one
fails. What is known is kept in ``runs/mutants``, so that an interrupted run goes on; ``report.md``
there has the share that was caught by room, and every fault that was not. ``unchanging.toml``
beside this file lists faults that were shown by hand to change nothing.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import statistics
import subprocess
import sys
import time
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from pathlib import Path
from queue import Queue
from threading import Timer

from faults import Fault, drawn, source_files

ROOT = Path(__file__).resolve().parents[2]
ROOMS: dict[str, tuple[str, ...]] = {
    "harness/*.py": ("tests/test_config.py", "tests/test_errors.py", "tests/test_escaping.py",
                     "tests/test_reading.py", "tests/test_site.py", "tests/cli/test_entry.py",
                     "tests/methods/test_time_limit.py", "tests/runs"),
    "harness/app": ("tests/app", "tests/cli"),
    "harness/cli": ("tests/cli", "tests/app", "tests/studies/test_registry.py"),
    "harness/core": ("tests/core", "tests/methods", "tests/repairing"),
    "harness/core/*.c": ("tests/core", "tests/statics", "tests/methods", "tests/golden"),
    "harness/gym": ("tests/gym",),
    "harness/labelling": ("tests/labelling",),
    "harness/layouts": ("tests/layouts",),
    "harness/measured": ("tests/measured",),
    "harness/methods": ("tests/methods", "tests/golden", "tests/conformance"),
    "harness/properties": ("tests/properties",),
    "harness/repairing": ("tests/repairing", "tests/app"),
    "harness/runs": ("tests/runs", "tests/studies/test_kit.py"),
    "harness/statics": ("tests/statics", "tests/methods", "tests/golden"),
    "harness/statistics": ("tests/statistics",),
    "harness/studies": ("tests/studies",),
    "harness/transport": ("tests/transport",),
    "harness/tuning": ("tests/tuning",),
    "engines": ("tests/engines", "tests/conformance", "tests/physics", "tests/golden"),
    "learners": ("tests/learners",),
    "reports": ("tests/reports",),
}  # fmt: skip
"""Folders of the project, and of the tests that are to catch their faults."""

KEPT = ROOT / "runs" / "mutants"
SECONDS = 900
"""Time of the tests of a fault: what takes longer was caught. It is wall time: a limit of CPU time
(``RLIMIT_CPU``) makes Linux count the CPU time of a process by ticks, and tests of times fail."""

_COPIED = ("harness", "engines", "learners", "reports", "tests", "docs")
_FILES = ("pyproject.toml", "README.md", "CHANGELOG.md", "Makefile", "CITATION.cff", "setup.py")
_COMPILED = "engines/reference/"
_BUILD = [sys.executable, "harness/core/building.py"]
_PYTEST = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "--no-header"]
_UNCHANGING = Path(__file__).parent / "unchanging.toml"


@dataclass(frozen=True)
class Outcome:
    """What became of a fault: caught or not, by which test, and CPU seconds until then.

    ``compiling``: CPU seconds of compiling anew what the fault stands in, apart.
    """

    room: str
    fault: Fault
    is_caught: bool
    by: str
    seconds: float
    compiling: float


def planned(rooms: list[str], count: int, seed: int) -> list[tuple[str, Fault]]:
    """The faults of a run, of every room as many as of the others."""
    unchanging = set(tomllib.loads(_UNCHANGING.read_text())["unchanging"])
    found = []
    for place, room in enumerate(rooms):
        own = count // len(rooms) + (place < count % len(rooms))
        # Those that change nothing are drawn, too, and left out: a longer list moves no other.
        faults = drawn(source_files(ROOT, room), own, seed)
        found += [(room, fault) for fault in faults if fault.key not in unchanging]
    return found


def copy_of_the_project(folder: Path) -> Path:
    """A copy with its compiled code and links, as an editable install has them."""
    if folder.exists():
        shutil.rmtree(folder)
    folder.mkdir(parents=True)
    for name in (*_COPIED, ".src"):
        shutil.copytree(ROOT / name, folder / name, symlinks=True)
    for name in _FILES:
        shutil.copy2(ROOT / name, folder / name)
    shared = ROOT.parent / "shared"
    if shared.exists() and not (folder.parent / "shared").exists():
        (folder.parent / "shared").symlink_to(shared)
    return folder


def tried(room: str, fault: Fault, copy: Path) -> Outcome:
    """Plant a fault in a copy, run the tests of its room, and take it out again.

    A test that fails in the copy without the fault, too, catches nothing and is left out.
    """
    status, output, _ = _run(copy, [sys.executable, "-c", "import steadyload.core.library"])
    if status:
        raise RuntimeError(f"{copy} does not work without a fault: {output}")
    left_out: list[str] = []
    while True:
        outcome = _tried(room, fault, copy, left_out)
        if not outcome.by.startswith("tests/"):
            return outcome
        fails_anyhow, _, _ = _run(copy, [*_PYTEST, outcome.by])
        if not fails_anyhow:
            return outcome
        left_out.append(outcome.by)


def _tried(room: str, fault: Fault, copy: Path, left_out: list[str]) -> Outcome:
    file = copy / fault.path
    source, times = file.read_text(), file.stat()
    file.write_text(fault.planted(source))
    compiling = 0.0
    try:
        if fault.path.endswith(".c"):
            status, _, compiling = _run(copy, _BUILD)
            if status:
                return Outcome(room, fault, True, "the compiler", 0.0, compiling)
        elif _COMPILED in fault.path:
            _, _, compiling = _run(copy, [sys.executable, "-m", "steadyload.cli", "warm-up"])
        tests = [test for test in ROOMS[room] if (copy / test).exists()]
        without = [f"--deselect={test}" for test in left_out]
        status, output, seconds = _run(copy, [*_PYTEST, "-m", "not deep", *without, *tests])
    finally:
        file.write_text(source)
        os.utime(file, ns=(times.st_atime_ns, times.st_mtime_ns))
        if fault.path.endswith(".c"):
            _run(copy, _BUILD)
    failed = [line for line in output.splitlines() if line.startswith(("FAILED ", "ERROR "))]
    by = failed[0].split(" - ")[0].partition(" ")[2] if failed else ""
    return Outcome(room, fault, status != 0, by or f"status {status}", seconds, compiling)


def _run(copy: Path, command: list[str]) -> tuple[int, str, float]:
    """Status, output and CPU seconds of a command in a copy."""
    environment = os.environ | {
        "PYTHONPATH": os.pathsep.join(filter(None, [str(copy / ".src"), os.getenv("PYTHONPATH")])),
        "PYTHONDONTWRITEBYTECODE": "1", "OMP_NUM_THREADS": "1", "PYTEST_ADDOPTS": "",
    }  # fmt: skip
    process = subprocess.Popen(
        command, cwd=copy, env=environment, text=True, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, start_new_session=True,
    )  # fmt: skip
    assert process.stdout is not None, "it is a pipe"
    timer = Timer(SECONDS, os.killpg, (process.pid, signal.SIGKILL))
    timer.start()
    with process.stdout:
        output = process.stdout.read()
    timer.cancel()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, output, usage.ru_utime + usage.ru_stime


def _known() -> dict[tuple[str, Fault], Outcome]:
    """The last outcome of every fault that was tried, by room and fault."""
    file = KEPT / "outcomes.jsonl"
    outcomes = [
        Outcome(**{**known, "fault": Fault(**known["fault"])})
        for known in map(json.loads, file.read_text().splitlines() if file.exists() else [])
    ]
    return {(one.room, one.fault): one for one in outcomes}


def run(rooms: list[str], count: int, seed: int, jobs: int) -> list[Outcome]:
    """Try all faults of a run that are not known yet; the outcomes of all."""
    asked = planned(rooms, count, seed)
    KEPT.mkdir(parents=True, exist_ok=True)
    known = _known()
    missing = [each for each in asked if each not in known]
    copies: Queue[Path] = Queue()
    for job in range(min(jobs, len(missing))):
        copies.put(copy_of_the_project(KEPT / f"copy{job}" / "project"))

    def one(room: str, fault: Fault) -> Outcome:
        copy = copies.get()
        try:
            return tried(room, fault, copy)
        finally:
            copies.put(copy)

    begun = time.monotonic()
    with ThreadPoolExecutor(max(1, jobs)) as pool, (KEPT / "outcomes.jsonl").open("a") as kept:
        futures = [pool.submit(one, room, fault) for room, fault in missing]
        for done, future in enumerate(futures, 1):
            outcome = future.result()
            kept.write(json.dumps(asdict(outcome)) + "\n")
            kept.flush()
            said = f"caught by {outcome.by}" if outcome.is_caught else "NOT CAUGHT"
            passed = time.monotonic() - begun
            print(f"{done}/{len(missing)} {passed:.0f} s  {outcome.fault.path}:"
                  f"{outcome.fault.line} {outcome.fault.kind}: {said} ({outcome.seconds:.0f} s)",
                  flush=True)  # fmt: skip
    known = _known()
    return [known[each] for each in asked if each in known]


def report(outcomes: list[Outcome], seed: int) -> str:
    """The share caught by room, and what was not, in Markdown."""
    lines = [
        f"# Planted faults that the quick tests of their rooms catch, seed {seed}", "",
        "| room | planted | caught | % | CPU s until caught, median |",
        "| ---- | ------: | -----: | -: | -------------------------: |",
    ]  # fmt: skip
    for room in (*dict.fromkeys(one.room for one in outcomes), ""):
        own = [one for one in outcomes if room in ("", one.room)]
        caught = [one for one in own if one.is_caught]
        seconds = statistics.median([one.seconds for one in caught] or [0.0])
        share = 100.0 * len(caught) / max(1, len(own))
        title = room or "all"
        lines.append(f"| {title} | {len(own)} | {len(caught)} | {share:.0f} | {seconds:.0f} |")
    lines += ["", "Not caught:", ""]
    for one in outcomes:
        if not one.is_caught:
            fault = one.fault
            lines.append(
                f"- `{fault.path}:{fault.line}` {fault.kind}: `{fault.before}` -> `{fault.after}`"
            )
    return "\n".join(lines) + "\n"


def main(words: list[str] | None = None) -> int:
    """The command; returns its status."""
    reader = argparse.ArgumentParser(description=__doc__)
    reader.add_argument("--count", type=int, default=100, help="faults of a run (default: 100)")
    reader.add_argument("--seed", type=int, default=0, help="of the draw (default: 0)")
    reader.add_argument("--room", action="append", choices=list(ROOMS), help="only this; repeated")
    reader.add_argument("--jobs", type=int, default=2, help="at the same time (default: 2)")
    asked = reader.parse_args(words)
    outcomes = run(asked.room or list(ROOMS), asked.count, asked.seed, asked.jobs)
    text = report(outcomes, asked.seed)
    (KEPT / "report.md").write_text(text)
    print(text)
    print(f"{KEPT / 'report.md'}; compiling is not counted in the CPU seconds")
    return 0


if __name__ == "__main__":
    sys.exit(main())
