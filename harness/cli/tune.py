"""``steadyload tune``: search the parameters of a simulation, for accuracy at a small cost."""

from __future__ import annotations

import argparse
import dataclasses
import os
from pathlib import Path
from typing import Any

from steadyload.cli.terminal import at_least, duration, progress_bar, resumable, say

_WORK, _REMADE = Path("runs/tune"), Path("runs/remade")


def add_tune(commands: Any) -> None:
    """Add the command to the parser's commands."""
    tune = commands.add_parser(
        "tune", help="search the parameters of a simulation on an engine, against labels"
    )
    what = tune.add_mutually_exclusive_group(required=True)
    what.add_argument("--engine", metavar="NAME", help="engine to tune")
    what.add_argument(
        "--remake", metavar="PRESET",
        help="search again as a preset was found, for example ps_opt@mujoco, and compare",
    )  # fmt: skip
    tune.add_argument(
        "--budget", type=duration, metavar="TIME",
        help="no generation is begun after this, such as 20m, over all starts of the search",
    )  # fmt: skip
    tune.add_argument("--generations", type=at_least(1), metavar="N", help="end after so many")
    tune.add_argument(
        "--algorithm", default="genetic", metavar="NAME",
        help="genetic (fitness of the paper), or nsga2 (accuracy against cost) (default: genetic)",
    )  # fmt: skip
    tune.add_argument(
        "--space", default="extended", metavar="NAME",
        help="extended, or table3 as the paper prints it (default: extended)",
    )  # fmt: skip
    tune.add_argument("--seed", type=at_least(0), default=0, help="default: 0")
    tune.add_argument(
        "--population", type=at_least(4), default=60, metavar="N",
        help="genotypes a generation (default: 60; the paper has 1000)",
    )  # fmt: skip
    tune.add_argument(
        "--begin-with", action="append", metavar="SPEC", default=[],
        help="a simulation that the first generation holds, such as the preset found before; may "
        "be repeated",
    )  # fmt: skip
    tune.add_argument(
        "--benchmark", metavar="SET",
        help="labelled set to tune on (default: the shipped one; for a 2-D engine the planar one)",
    )  # fmt: skip
    tune.add_argument(
        "--cost", type=Path, metavar="FILE",
        help="what judging costs on the engine; measured when it is not there, while nothing else "
        "should run (default: runs/tune/cost-ENGINE-SPACE.json)",
    )  # fmt: skip
    tune.add_argument(
        "--output", "-o", type=Path, metavar="DIR",
        help="folder of the search; an interrupted one goes on (default: runs/tune/ENGINE-..., "
        "or runs/remade/ENGINE-...)",
    )  # fmt: skip
    tune.add_argument(
        "--workers", "-j", type=at_least(1), default=os.cpu_count() or 1, help="default: all cores"
    )
    tune.add_argument(
        "--write-preset", action="store_true", help="make what is found ps_opt on that engine"
    )
    tune.set_defaults(run=_tune)


def _tune(options: argparse.Namespace) -> int:
    from steadyload.methods.tuned import TUNED
    from steadyload.reports.page import write_page
    from steadyload.runs.provenance import provenance, provenance_lines
    from steadyload.studies.tuning.history import tuning_of
    from steadyload.studies.tuning.page import tuning_page
    from steadyload.tuning.options import SearchOptions
    from steadyload.tuning.presets import (
        check_remakable,
        differences,
        options_of,
        preset,
        write_preset,
    )
    from steadyload.tuning.search import Search

    if options.remake:
        chosen = options_of(options.remake)
    else:
        chosen = SearchOptions.on(
            options.engine,
            benchmark=options.benchmark,
            algorithm=options.algorithm,
            space=options.space,
            seed=options.seed,
            population=options.population,
            generations=options.generations,
            budget=options.budget,
            begin_with=tuple(options.begin_with),
        )
    name = f"{chosen.engine}-{chosen.algorithm}-{chosen.space}-{chosen.seed}"
    # What is remade must not find what was judged the first time.
    directory = options.output or (_REMADE if options.remake else _WORK) / name
    search = Search(directory, chosen)
    if options.write_preset:  # said before hours are spent
        check_remakable(search.ledger.facts.get("made_by") or provenance())
    with resumable(directory):
        if chosen.model is None and "model" not in search.ledger.facts:
            search.options = dataclasses.replace(search.options, model=_cost_model(chosen, options))
        with progress_bar("searching") as advance:
            search.run(workers=options.workers, progress=advance, report=say)
    record = tuning_of([search])
    print(write_page(tuning_page(record, provenance_lines(search.made_by)), directory))
    # Compared before it takes the place of what it is compared with.
    unlike = differences(options.remake, preset(search)) if options.remake else []
    if options.write_preset:
        print(write_preset(search))
    if options.remake:
        say(f"{options.remake}: " + ("; ".join(unlike) or "the same parameters were found"))
        return 1 if unlike else 0
    say(f"{TUNED}@{chosen.engine} would be {search.space.spec(search.fittest().genotype)}")
    return 0


def _cost_model(chosen: Any, options: argparse.Namespace) -> Any:
    from steadyload.tuning.cost import kept_model
    from steadyload.tuning.space import space_on

    space = space_on(chosen.engine, chosen.space)
    file = options.cost or _WORK / f"cost-{chosen.engine}-{chosen.space}.json"
    return kept_model(file, space, chosen.source, workers=options.workers, report=say)


def add_tuned(commands: Any) -> None:
    """Add the command to the parser's commands."""
    study = commands.add_parser(
        "tuned", help="hold the tuned presets against others on test, and write the page of tuning"
    )
    study.add_argument(
        "searches", nargs="+", type=Path, metavar="DIR",
        help="folders of searches",
    )  # fmt: skip
    study.add_argument(
        "--write-presets", action="store_true",
        help="first make the fittest genotype of all searches on an engine its preset",
    )  # fmt: skip
    study.add_argument(
        "--work", type=Path, metavar="DIR", default=Path("runs/tuned"),
        help="folder of what is judged; an interrupted run goes on (default: runs/tuned)",
    )  # fmt: skip
    study.add_argument(
        "--output", "-o", type=Path, metavar="DIR", help="folder of the page (default: --work)"
    )
    study.add_argument(
        "--limit", type=at_least(2), metavar="N", help="only the first N cases a scenario"
    )
    study.add_argument(
        "--workers", "-j", type=at_least(1), default=os.cpu_count() or 1, help="default: all cores"
    )
    study.set_defaults(run=_tuned)


def _tuned(options: argparse.Namespace) -> None:
    from steadyload.reports.page import write_page
    from steadyload.runs.provenance import provenance_lines
    from steadyload.studies.tuning.page import tuning_page
    from steadyload.studies.tuning.study import tuning_study
    from steadyload.tuning import TuningError
    from steadyload.tuning.presets import by_worth, write_preset
    from steadyload.tuning.search import Search

    names = [folder.resolve().name for folder in options.searches]
    if len(set(names)) < len(names):
        raise TuningError(f"folders of searches: {', '.join(names)}; allowed: names that differ")
    searches = [Search.of(folder) for folder in options.searches]
    if options.write_presets:
        for best, *_ in by_worth(searches).values():
            print(write_preset(best))
    with resumable(options.work), progress_bar("judging") as advance:
        record = tuning_study(
            searches,
            options.work,
            workers=options.workers,
            limit=options.limit,
            progress=advance,
        )
    output = options.output or options.work
    for name, search in zip(names, searches, strict=True):
        search.ledger.keep(output / "searches" / name)
    print(write_page(tuning_page(record, provenance_lines()), output))
