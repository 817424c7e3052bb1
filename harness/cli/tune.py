"""``steadyload tune``: search the parameters of a simulation, for accuracy at a small cost."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from steadyload.cli.flags import UsageError
from steadyload.cli.readers import duration, milliseconds
from steadyload.cli.studies import workers_option
from steadyload.cli.terminal import progress_bar, resumable, say
from steadyload.config import option, output_option

_WORK, _REMADE = Path("runs/tune"), Path("runs/remade")


@dataclass(frozen=True)
class Tune:
    """Options of a search."""

    engine: str | None = option(None, "engine to tune")
    remake: str | None = option(
        None, "search again as a preset was found, for example ps_opt@mujoco, and compare",
        metavar="PRESET",
    )  # fmt: skip
    budget: float | None = option(
        None, "no generation is begun after this, such as 20m, over all starts of the search",
        metavar="TIME", read=duration,
    )  # fmt: skip
    generations: int | None = option(None, "end after so many", least=1)
    algorithm: str = option(
        "genetic",
        "genetic (fitness of the paper), or nsga2 (accuracy against cost) (default: genetic)",
    )
    space: str = option(
        "extended",
        "extended or stands, large or large-stands for large piles, or table3 as the "
        "paper prints it (default: extended)",
    )
    seed: int = option(0, "default: 0", least=0)
    population: int = option(
        60, "genotypes a generation (default: 60; the paper has 1000)", least=4
    )
    begin_with: tuple[str, ...] = option(
        (), "a simulation that the first generation holds, such as the preset found before; may "
        "be repeated", metavar="SPEC",
    )  # fmt: skip
    benchmark: str | None = option(
        None, "labelled set to tune on, its part search or else validation (default: choosing; "
        "for a 2-D engine planar)", metavar="SET",
    )  # fmt: skip
    data: tuple[str, ...] = option(
        (), "further labelled set that is tuned on, such as real; may be repeated", metavar="SET"
    )  # fmt: skip
    limit: int | None = option(None, "only N cases a scenario of every set", least=1)
    cost: Path | None = option(
        None, "what judging costs on the engine; measured when it is not there, while nothing else "
        "should run (default: runs/tune/cost-ENGINE-SPACE.json, or ...-SET.json)",
    )  # fmt: skip
    goal: float | None = option(
        None, "mean cost of a layout that counts as fast, such as 20ms (default: 18.5 % of that of "
        "PS_3)", metavar="TIME", read=milliseconds,
    )  # fmt: skip
    output: Path | None = output_option(
        None, "folder of the search; an interrupted one goes on (default: runs/tune/ENGINE-..., "
        "or runs/remade/ENGINE-...)", metavar="DIR",
    )  # fmt: skip
    workers: int = workers_option(0)
    preset: str = option(
        "ps_opt", "what is found becomes this preset with --write-preset: ps_opt, or ps_opt-equal "
        "of searches that differ in their engine alone (default: ps_opt)", metavar="NAME",
    )  # fmt: skip
    write_preset: bool = option(False, "make what is found that preset on that engine")

    def __post_init__(self) -> None:
        if self.engine is None and self.remake is None:
            raise UsageError("tune: one of the arguments --engine --remake is required")
        if self.engine is not None and self.remake is not None:
            raise UsageError("tune: --remake: not allowed with --engine")

    def run(self) -> int:
        """Search, write the page, and the preset."""
        from steadyload.reports.pages.writing import write_page
        from steadyload.runs.provenance import provenance, provenance_lines
        from steadyload.studies.tuning.presets import Found
        from steadyload.studies.tuning.searching import of_searches
        from steadyload.studies.tuning.study import Tuning
        from steadyload.tuning.presets import (
            check_preset,
            check_remakable,
            differences,
            preset,
            write_preset,
        )
        from steadyload.tuning.search import Search

        check_preset(self.preset)
        chosen = self._options()
        name = _named(chosen.engine, chosen.algorithm, chosen.space, chosen.seed, on=chosen.source)
        # A repeated search must not find the judgements of the first one.
        directory = self.output or (_REMADE if self.remake else _WORK) / name
        search = Search(directory, chosen)
        if self.write_preset:  # reported before hours of work
            check_remakable(search.ledger.facts.get("made_by") or provenance())
        with resumable(directory):
            if chosen.model is None and "model" not in search.ledger.facts:
                search.options = dataclasses.replace(search.options, model=self._cost_model(chosen))
            with progress_bar("searching") as advance:
                search.run(workers=self.workers, progress=advance, report=say)
        study = Tuning(searches=(directory,), limit=None, write_presets=False)
        found = Found(**of_searches([search]), made_with=provenance_lines(search.made_by))
        print(write_page(study.page(found), directory))
        # Compared before it replaces the preset that it is compared with.
        unlike = differences(self.remake, preset(search)) if self.remake else []
        if self.write_preset:
            print(write_preset(search, self.preset))
        if self.remake:
            say(f"{self.remake}: " + ("; ".join(unlike) or "the same parameters were found"))
            return 1 if unlike else 0
        best = search.space.spec(search.fittest().genotype)
        say(f"{self.preset}@{chosen.engine} would be {best}")
        return 0

    def _options(self) -> Any:
        """The options of the search."""
        from steadyload.tuning.options import SearchOptions
        from steadyload.tuning.presets import options_of

        if self.remake:
            return options_of(self.remake)
        own = (
            "benchmark", "data", "limit", "algorithm", "space", "seed", "population", "generations",
            "budget", "begin_with", "goal",
        )  # fmt: skip
        return SearchOptions.on(self.engine or "", **{name: getattr(self, name) for name in own})

    def _cost_model(self, chosen: Any) -> Any:
        from steadyload.tuning.cost import kept_model
        from steadyload.tuning.space import space_on

        space = space_on(chosen.engine, chosen.space)
        name = _named("cost", chosen.engine, chosen.space, on=chosen.source)
        return kept_model(
            self.cost or _WORK / f"{name}.json", space, chosen.source, workers=self.workers,
            with_goal=chosen.goal is None, report=say,
        )  # fmt: skip


def _named(*parts: object, on: Any) -> str:
    """Name of what is made on some cases: its parts, and the further labelled sets."""
    return "-".join((*map(str, parts), *(Path(path).name for path in on.data)))
