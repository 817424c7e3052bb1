"""The command ``steadyload``: parse, call one documented function, print."""

from __future__ import annotations

import argparse
import io
import json
import os
import sys
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from steadyload.cli.benchmark import add_benchmark
from steadyload.cli.cascade import add_cascade
from steadyload.cli.extremes import add_extremes
from steadyload.cli.learned import add_learned
from steadyload.cli.properties import add_properties
from steadyload.cli.recommend import add_recommend
from steadyload.cli.session import add_session
from steadyload.cli.study import add_report, add_study
from steadyload.cli.table5 import add_table5
from steadyload.cli.terminal import (
    at_least,
    positive_number,
    print_table,
    progress_bar,
    say,
    say_warnings,
    status_line,
)
from steadyload.cli.train import add_generate, add_train
from steadyload.cli.tune import add_tune, add_tuned
from steadyload.cli.uncertain import (
    add_uncertain,
    add_uncertainty,
    asked_for,
    uncertain_table,
    without_effect,
)
from steadyload.cli.verify import add_verify
from steadyload.cli.view import add_view
from steadyload.engines.registry import EngineNotInstalledError
from steadyload.layouts.benchmark import BenchmarkError
from steadyload.layouts.formats import Format, read_layouts, write_layouts
from steadyload.layouts.model import LayoutError
from steadyload.layouts.packing import random_layouts
from steadyload.layouts.scenarios import Scenario
from steadyload.layouts.snapping import SNAP_GAP
from steadyload.learners import LearnerError
from steadyload.methods.recording import RecordingError
from steadyload.methods.registry import method_listing
from steadyload.methods.spec import SpecError, nearest
from steadyload.properties import PropertyError
from steadyload.reports.viewer.three_js import ThreeJsError
from steadyload.runs.definition import StudyError
from steadyload.runs.envelope_use import score_warnings
from steadyload.runs.executors import ExecutorError, WorkerDiedError
from steadyload.runs.results import ResultsError
from steadyload.runs.scoring import score_layouts
from steadyload.studies.table5.front import FrontError
from steadyload.studies.viewing import ViewError
from steadyload.tuning import TuningError

_BAD_INPUT = (
    LayoutError,
    SpecError,
    StudyError,
    ExecutorError,
    ResultsError,
    BenchmarkError,
    PropertyError,
    TuningError,
    FrontError,
    LearnerError,
    RecordingError,
    ViewError,
    ThreeJsError,
    EngineNotInstalledError,
    OSError,
)
"""What a user can mend: one sentence on stderr, exit status 2."""

_BENCH_SEED = 7


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Returns the exit status: 0 done, 1 failed, 2 wrong input, 130 interrupted.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a name the terminal cannot show
    say_warnings()
    options = command_parser().parse_args(arguments)
    try:
        status = options.run(options)
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader (head, less) has gone; Python must not complain about it again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except _BAD_INPUT as error:
        say(f"steadyload: {_sentence(error)}")
        return 2
    except WorkerDiedError as error:
        say(f"steadyload: {error}")
        return 1
    except KeyboardInterrupt:
        say("steadyload: interrupted")
        return 130
    return status or 0


def _sentence(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    return " ".join([*str(error).split(), *getattr(error, "__notes__", [])])


def command_parser() -> argparse.ArgumentParser:
    """What reads the words of the command."""
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
        "--seed", type=at_least(0), default=0, help="of scenario and deviations (default: 0)"
    )
    add_uncertainty(score)
    score.add_argument("--max-items", type=at_least(1), metavar="J", help="only the first J items")
    score.add_argument("--limit", type=at_least(1), metavar="N", help="only the first N layouts")
    score.add_argument(
        "--skip-invalid",
        action="store_true",
        help="record an invalid layout as refused and go on, instead of ending with status 2",
    )
    score.add_argument(
        "--timeout", type=positive_number, metavar="S", help="wall seconds a judgement may take"
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

    add_study(commands)
    add_report(commands)

    bench = commands.add_parser("bench", help="compare engines: agreement, options, speed")
    bench.add_argument("--output", "-o", type=Path, metavar="DIR", default=Path("runs/bench"))
    bench.add_argument(
        "--part",
        action="append",
        choices=["agreement", "options", "speed", "throughput"],
        help="measure only this; may be repeated (default: speed and throughput)",
    )
    bench.add_argument(
        "--layouts",
        type=at_least(1),
        default=300,
        metavar="N",
        help="generated layouts for agreement and options (default: 300)",
    )
    bench.add_argument(
        "--most-items",
        type=at_least(20),
        default=200,
        metavar="J",
        help="largest layout of the speed part (default: 200)",
    )
    bench.set_defaults(run=_bench)

    add_verify(commands)
    add_extremes(commands)
    add_tune(commands)
    add_tuned(commands)
    add_train(commands)
    add_generate(commands)
    add_learned(commands)
    add_cascade(commands)
    add_recommend(commands)
    add_benchmark(commands)
    add_properties(commands)
    add_uncertain(commands)
    add_session(commands)
    add_table5(commands)
    add_view(commands)

    methods = commands.add_parser(
        "methods", help="list methods and presets, or explain one, NAME or NAME@ENGINE"
    )
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
        type=positive_number,
        metavar="CM",
        help=f"close gaps up to this; implies --snap (default: {SNAP_GAP:g})",
    )


def _snap_gap(options: argparse.Namespace) -> float:
    return options.snap_gap or (SNAP_GAP if options.snap else 0.0)


# --- commands -----------------------------------------------------------------------------------


def _score(options: argparse.Namespace) -> None:
    with progress_bar("judging") as advance:
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
            **asked_for(options),
            progress=advance,
        )
    for warning in [*score_warnings(records), *without_effect(records)]:
        say(warning)
    if options.json:
        print(json.dumps(records, indent=1))
        return
    if options.uncertain is not None:
        print_table(*uncertain_table(records))
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
    print_table(("layout", "method", "items", "score", "failing step", "status", "ms", "why"), rows)


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


def _bench(options: argparse.Namespace) -> None:
    from steadyload.reports.page import write_page
    from steadyload.runs.provenance import provenance_lines
    from steadyload.studies.engines.page import engine_study_page
    from steadyload.studies.engines.speed import ITEM_COUNTS, speed_curves, throughput
    from steadyload.studies.engines.study import engine_agreement, option_effects

    parts = options.part or ["speed", "throughput"]
    made_with = provenance_lines()  # of the code that measures, not of what it has become meanwhile
    layouts = random_layouts(options.layouts, seed=_BENCH_SEED)
    counts = [n for n in ITEM_COUNTS if n <= options.most_items]
    with status_line() as say:
        page = engine_study_page(
            engine_agreement(layouts, progress=say) if "agreement" in parts else [],
            option_effects(layouts, progress=say) if "options" in parts else [],
            speed_curves(counts, progress=say) if "speed" in parts else [],
            throughput(progress=say) if "throughput" in parts else [],
            {"generated layouts": f"{options.layouts}, seed {_BENCH_SEED}"} | made_with,
        )
    print(write_page(page, options.output))


def _methods(options: argparse.Namespace) -> None:
    name, _, engine = (options.name or "").partition("@")
    listing = method_listing(engine or None)
    if options.name is None:
        print_table(
            ("name", "needs an engine", "what it is"),
            [(m.name, "yes" if m.needs_engine else "no", m.about) for m in listing],
        )
        return
    found = {m.name: m for m in listing}.get(name)
    if found is None:
        known = nearest(options.name, [m.name for m in listing])
        raise SpecError(f"unknown method {options.name!r}; {known}")
    print(f"{found.name}: {found.about}\n")
    print_table(
        ("parameter", "value", "unit", "allowed", "what it is"),
        [(p.name, p.value, p.unit, p.allowed, p.about) for p in found.parameters],
    )


def _engines(options: argparse.Namespace) -> None:
    from steadyload.studies.engines.settings import engine_records
    from steadyload.studies.engines.settings_page import engines_markdown, engines_rows

    records = engine_records()
    if options.markdown:
        print(engines_markdown(records))
        return
    header, rows = engines_rows(records)
    print_table(header, rows)
    print("\nNotes: steadyload engines --markdown")
