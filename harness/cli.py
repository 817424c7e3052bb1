"""The command ``steadyload``: parse, call one documented function, print."""

from __future__ import annotations

import argparse
import io
import json
import math
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib import metadata
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from engines.registry import EngineNotInstalledError
from harness.layouts.formats import Format, read_layouts, write_layouts
from harness.layouts.model import LayoutError
from harness.layouts.packing import random_layouts
from harness.layouts.scenarios import Scenario
from harness.layouts.snapping import SNAP_GAP
from harness.methods.registry import method_listing
from harness.methods.spec import SpecError, nearest
from harness.studies.definition import EMBEDDED, StudyError, load_study
from harness.studies.executors import WorkerDiedError
from harness.studies.results import ResultsError
from harness.studies.scoring import score_layouts

_BAD_INPUT = (
    LayoutError,
    SpecError,
    StudyError,
    ResultsError,
    EngineNotInstalledError,
    OSError,
)
"""What a user can mend: one sentence on stderr, exit status 2."""

_BENCH_SEED = 7
_CLOSED_FORMS = "closed-forms"

_errors = Console(stderr=True, soft_wrap=True, highlight=False, markup=False)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Returns the exit status: 0 done, 1 failed, 2 wrong input, 130 interrupted.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a name the terminal cannot show
    options = _parser().parse_args(arguments)
    try:
        options.run(options)
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader (head, less) has gone; Python must not complain about it again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except _BAD_INPUT as error:
        _errors.print(f"steadyload: {_sentence(error)}")
        return 2
    except WorkerDiedError as error:
        _errors.print(f"steadyload: {error}")
        return 1
    except KeyboardInterrupt:
        _errors.print("steadyload: interrupted")
        return 130
    return 0


def _sentence(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    return " ".join(str(error).split())


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="steadyload", description="How stable is this pallet while it is being loaded?"
    )
    parser.add_argument("--version", action="version", version=metadata.version("steadyload"))
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    score = commands.add_parser("score", help="score layout files with one or more methods")
    score.add_argument("files", nargs="+", metavar="FILE", type=Path)
    score.add_argument(
        "--method",
        "-m",
        action="append",
        metavar="SPEC",
        help="for example sme, pbs:alpha=0.7, ps3@mujoco; may be repeated (default: sme)",
    )
    score.add_argument(
        "--scenario",
        choices=[str(scenario) for scenario in Scenario],
        help="draw centres of mass (default: as in the file)",
    )
    score.add_argument(
        "--seed", type=_at_least(0), default=0, help="seed of the scenario (default: 0)"
    )
    score.add_argument("--max-items", type=_at_least(1), metavar="J", help="only the first J items")
    score.add_argument("--limit", type=_at_least(1), metavar="N", help="only the first N layouts")
    score.add_argument(
        "--skip-invalid",
        action="store_true",
        help="record an invalid layout as refused and go on, instead of ending with status 2",
    )
    score.add_argument(
        "--timeout", type=_positive, metavar="S", help="wall seconds a judgement may take"
    )
    score.add_argument("--json", action="store_true", help="print one JSON array of records")
    _add_snap(score)
    score.set_defaults(run=_score)

    convert = commands.add_parser("convert", help="convert layout files between formats")
    convert.add_argument("files", nargs="+", metavar="FILE", type=Path)
    convert.add_argument("--output", "-o", required=True, type=Path, metavar="FILE")
    convert.add_argument(
        "--to",
        choices=[str(kind) for kind in (Format.NATIVE, Format.CSV, Format.JOB)],
        help="format of the output (default: csv for *.csv, else native)",
    )
    _add_snap(convert)
    convert.set_defaults(run=_convert)

    study = commands.add_parser("study", help="compare methods on many layouts")
    actions = study.add_subparsers(required=True, metavar="ACTION")
    run = actions.add_parser("run", help="run or resume a study")
    run.add_argument("study", metavar="STUDY.toml", help=f"a study file, or the word {EMBEDDED!r}")
    run.add_argument("--output", "-o", type=Path, metavar="DIR", help="default: runs/NAME")
    run.add_argument(
        "--workers", "-j", type=_at_least(1), default=os.cpu_count() or 1, help="default: all cores"
    )
    run.add_argument("--rerun", action="store_true", help="compute everything anew")
    run.set_defaults(run=_study_run)

    report = commands.add_parser("report", help="write report.md of a study's folder")
    report.add_argument("directory", type=Path, metavar="DIR")
    report.set_defaults(run=_report)

    bench = commands.add_parser("bench", help="compare engines: agreement, options, speed")
    bench.add_argument("--output", "-o", type=Path, metavar="DIR", default=Path("runs/bench"))
    bench.add_argument(
        "--part",
        action="append",
        choices=["agreement", "options", "speed", "throughput", _CLOSED_FORMS],
        help="measure only this; may be repeated (default: speed and throughput); "
        f"{_CLOSED_FORMS} has a page of its own",
    )
    bench.add_argument(
        "--engine",
        action="append",
        metavar="NAME",
        help=f"only this engine ({_CLOSED_FORMS} alone); may be repeated",
    )
    bench.add_argument(
        "--layouts",
        type=_at_least(1),
        default=300,
        metavar="N",
        help="generated layouts for agreement and options (default: 300)",
    )
    bench.add_argument(
        "--most-items",
        type=_at_least(20),
        default=200,
        metavar="J",
        help="largest layout of the speed part (default: 200)",
    )
    bench.set_defaults(run=_bench)

    methods = commands.add_parser("methods", help="list methods and presets, or explain one")
    methods.add_argument("name", nargs="?", metavar="NAME")
    methods.set_defaults(run=_methods)

    engines = commands.add_parser("engines", help="which engine honours which setting")
    engines.add_argument("--markdown", action="store_true", help="print a Markdown page")
    engines.set_defaults(run=_engines)
    return parser


def _add_snap(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--snap", action="store_true", help="close small vertical gaps when reading (default: off)"
    )
    parser.add_argument(
        "--snap-gap",
        type=_positive,
        metavar="CM",
        help=f"close gaps up to this; implies --snap (default: {SNAP_GAP:g})",
    )


def _snap_gap(options: argparse.Namespace) -> float:
    return options.snap_gap or (SNAP_GAP if options.snap else 0.0)


def _at_least(least: int) -> Callable[[str], int]:
    def whole(text: str) -> int:
        if not (text.isascii() and text.isdigit() and int(text) >= least):
            raise argparse.ArgumentTypeError(f"{text!r}; allowed: a whole number, {least} or more")
        return int(text)

    return whole


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0.0 < value < 1e9:
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: a number above 0")
    return value


# --- commands -----------------------------------------------------------------------------------


def _score(options: argparse.Namespace) -> None:
    with _progress("judging") as advance:
        records = score_layouts(
            options.files,
            options.method or ["sme"],
            scenario=Scenario(options.scenario) if options.scenario else None,
            seed=options.seed,
            max_items=options.max_items,
            limit=options.limit,
            snap_gap=_snap_gap(options),
            skip_invalid=options.skip_invalid,
            timeout=options.timeout,
            progress=advance,
        )
    if options.json:
        print(json.dumps(records, indent=1))
        return
    rows = [
        (
            r["layout"],
            r["method"],
            str(r["items"]) if r["items"] is not None else "-",
            f"{r['score']:.3f}" if r["score"] is not None else "-",
            "-" if r["failing_step"] is None else str(r["failing_step"]),
            r["status"],
            f"{1e3 * r['seconds']:.2f}",
            _why(r),
        )
        for r in records
    ]
    _print_table(
        ("layout", "method", "items", "score", "failing step", "status", "ms", "why"), rows
    )


def _why(record: dict[str, Any]) -> str:
    """The reason, and which settings the engine ignored: that is never silent."""
    ignored = f"ignored: {', '.join(record['ignored'])}" if record["ignored"] else ""
    return "; ".join(filter(None, (record["reason"], ignored)))


def _convert(options: argparse.Namespace) -> None:
    layouts = [
        layout
        for file in options.files
        for layout in read_layouts(file, snap_gap=_snap_gap(options))
    ]
    by_name = Format.CSV if options.output.suffix.lower() == ".csv" else Format.NATIVE
    write_layouts(options.output, layouts, Format(options.to) if options.to else by_name)
    print(f"{len(layouts)} layouts -> {options.output}")


def _study_run(options: argparse.Namespace) -> None:
    from harness.studies.runner import run_study

    study = load_study(options.study)
    directory = options.output or Path("runs") / study.name
    try:
        with _progress("judging") as advance:
            computed = run_study(
                study, directory, workers=options.workers, rerun=options.rerun, progress=advance
            )
    except KeyboardInterrupt:
        _errors.print(f"What is finished stays in {directory}; run the same command to go on.")
        raise
    print(f"{computed} rows computed; results in {directory}")


def _report(options: argparse.Namespace) -> None:
    from harness.studies.comparison import compare
    from reports.pages import write_page
    from reports.study_page import study_page

    print(write_page(study_page(compare(options.directory)), options.directory))


def _closed_forms(options: argparse.Namespace) -> None:
    from harness.studies.closed_forms import closed_form_tests, closed_forms
    from harness.studies.results import provenance_lines
    from reports.closed_forms_page import closed_forms_page
    from reports.pages import write_page

    made_with = provenance_lines()
    with _status() as say:
        results = closed_forms(options.engine, progress=say)
    print(write_page(closed_forms_page(closed_form_tests(), results, made_with), options.output))


def _bench(options: argparse.Namespace) -> None:
    if _CLOSED_FORMS in (options.part or ()):
        if set(options.part) != {_CLOSED_FORMS}:
            raise SpecError(f"part {_CLOSED_FORMS} writes a page of its own; ask for it alone")
        _closed_forms(options)
        return
    if options.engine:
        raise SpecError(f"--engine goes with --part {_CLOSED_FORMS} alone")
    from harness.studies.engine_study import engine_agreement, option_effects
    from harness.studies.results import provenance_lines
    from harness.studies.speed import ITEM_COUNTS, speed_curves, throughput
    from reports.engine_study_page import engine_study_page
    from reports.pages import write_page

    parts = options.part or ["speed", "throughput"]
    made_with = provenance_lines()  # of the code that measures, not of what it has become meanwhile
    layouts = random_layouts(options.layouts, seed=_BENCH_SEED)
    counts = [n for n in ITEM_COUNTS if n <= options.most_items]
    with _status() as say:
        page = engine_study_page(
            engine_agreement(layouts, progress=say) if "agreement" in parts else [],
            option_effects(layouts, progress=say) if "options" in parts else [],
            speed_curves(counts, progress=say) if "speed" in parts else [],
            throughput(progress=say) if "throughput" in parts else [],
            {"generated layouts": f"{options.layouts}, seed {_BENCH_SEED}"} | made_with,
        )
    print(write_page(page, options.output))


def _methods(options: argparse.Namespace) -> None:
    listing = method_listing()
    if options.name is None:
        _print_table(
            ("name", "needs an engine", "what it is"),
            [(m.name, "yes" if m.needs_engine else "no", m.about) for m in listing],
        )
        return
    found = {m.name: m for m in listing}.get(options.name.partition("@")[0])
    if found is None:
        known = nearest(options.name, [m.name for m in listing])
        raise SpecError(f"unknown method {options.name!r}; {known}")
    print(f"{found.name}: {found.about}\n")
    _print_table(
        ("parameter", "value", "unit", "allowed", "what it is"),
        [(p.name, p.value, p.unit, p.allowed, p.about) for p in found.parameters],
    )


def _engines(options: argparse.Namespace) -> None:
    from harness.studies.engine_table import engine_records
    from reports.engines_page import engines_markdown, engines_rows

    records = engine_records()
    if options.markdown:
        print(engines_markdown(records))
        return
    header, rows = engines_rows(records)
    _print_table(header, rows)
    print("\nNotes: steadyload engines --markdown")


# --- printing -----------------------------------------------------------------------------------


def _print_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    table = Table(box=None, pad_edge=False, header_style="bold")
    for title in header:
        table.add_column(title, overflow="fold")
    for row in rows:
        table.add_row(*row)
    # A pipe has no width: never cut what a program reads.
    console = Console(highlight=False, markup=False, width=None if sys.stdout.isatty() else 4000)
    with console.capture() as capture:
        console.print(table)
    print("\n".join(line.rstrip() for line in capture.get().splitlines()))


@contextmanager
def _progress(label: str) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on stderr, shown only where somebody can see it."""
    console = Console(stderr=True)
    columns = (TextColumn(label), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(
        *columns, console=console, transient=True, disable=not console.is_terminal
    ) as bar:
        task = bar.add_task(label, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


@contextmanager
def _status() -> Iterator[Callable[[str], None]]:
    """A line on stderr that says what is being measured, where somebody can see it."""
    console = Console(stderr=True)
    with console.status("") as status:
        yield lambda what: status.update(what)


if __name__ == "__main__":
    sys.exit(main())
