"""The presets that searches have found: made, and made again."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from steadyload.errors import nearest
from steadyload.layouts.model.question import Question, with_question
from steadyload.methods.contract.spec import as_plain, parse_spec
from steadyload.methods.tuned import ABOUT, TUNED, Tuned, tuned, write_tuned
from steadyload.tuning import TuningError
from steadyload.tuning.cost import CostModel
from steadyload.tuning.options import SearchOptions
from steadyload.tuning.search import Search
from steadyload.tuning.trial import worth


def write_preset(search: Search, name: str = TUNED) -> Path:
    """Make the fittest genotype of a search a preset on its engine; returns the file.

    Args:
        search: a finished one.
        name: of the preset, one of :data:`steadyload.methods.tuned.ABOUT`.

    Raises:
        TuningError: see :func:`check_preset` and :func:`check_remakable`.
    """
    check_preset(name)
    check_remakable(search.made_by)
    options = search.options
    return write_tuned(options.source.question, options.engine, preset(search), name)


def check_preset(name: str) -> None:
    """Check that searches may find a preset of this name.

    Raises:
        TuningError: it is none of :data:`steadyload.methods.tuned.ABOUT`.
    """
    if name not in ABOUT:
        raise TuningError(f"preset is {name!r}; {nearest(name, ABOUT)}")


def by_worth(searches: Iterable[Search]) -> dict[tuple[str, str], list[Search]]:
    """Searches by engine and question, the one that found the fittest genotype first."""
    found: dict[tuple[str, str], list[Search]] = {}
    for search in searches:
        key = search.options.engine, search.options.source.question
        found.setdefault(key, []).append(search)
    return {key: sorted(own, key=_fitness, reverse=True) for key, own in found.items()}


def _fitness(search: Search) -> float:
    return worth(search.fittest().trial, search.goal)[0]


def check_remakable(made_by: Mapping[str, Any]) -> None:
    """Check that the result of a search may become a preset.

    Args:
        made_by: provenance of the search.

    Raises:
        TuningError: it is made by code that is in no commit: nobody could make the preset again.
    """
    if "dirty" in str(made_by["git"]):
        raise TuningError(
            f"the search is made by {made_by['git']}, which is in no commit: nobody could make its "
            "preset again; commit, then search in another folder"
        )


def options_of(spec: str) -> SearchOptions:
    """The options of the search that found a preset, up to the generation it was found by.

    Args:
        spec: such as ``ps_opt@mujoco``.

    Raises:
        TuningError: no search found it.
    """
    made_by = _entry(spec).made_by
    model = CostModel(**made_by["model"])
    return SearchOptions.restored(made_by, made_by["generations"], model)


def differences(spec: str, found: Tuned) -> list[str]:
    """Differences from a preset: parameters, and their evaluation; empty when there are none."""
    stored = _entry(spec)
    pairs = (
        (stored.parameters, found.parameters), (stored.made_by["found"], found.made_by["found"])
    )  # fmt: skip
    return [
        f"{key} is {now.get(key)!r}, was {then.get(key)!r}"
        for then, now in pairs
        for key in {**then, **now}
        if key != "wall_seconds" and then.get(key) != now.get(key)
    ]


def _entry(spec: str) -> Tuned:
    parsed = parse_spec(spec)
    question = dict(parsed.values).get("question", Question.WITHIN)
    found = tuned(question, parsed.name)
    if parsed.engine is None or parsed.engine not in found:
        known = [
            with_question(f"{name}@{engine}", asked)
            for name in ABOUT
            for asked in Question
            for engine in tuned(asked, name)
        ]
        raise TuningError(f"{spec}: no search found it; allowed: {', '.join(known) or 'none yet'}")
    return found[parsed.engine]


def preset(search: Search) -> Tuned:
    """The fittest genotype as a preset, with all that is needed to find it again."""
    best = search.fittest()
    chosen = {*search.space.fixed, *(gene.name for gene in search.space.genes)}
    parameters = as_plain(search.space.parameters(best.genotype))
    fitness, accuracy, cost = worth(best.trial, search.goal)
    return Tuned(
        {name: value for name, value in parameters.items() if name in chosen},
        {
            **search.options.stored(),
            "generations": len(search.ledger.ends),
            "model": search.ledger.facts["model"],
            "found": {
                "fitness": round(fitness, 6),
                "accuracy": round(accuracy, 6),
                "cost_ms": round(cost, 4),
                "goal_ms": search.goal,
                "cases": len(search.cases),
                "genotypes": len(search.judged()),
                "wall_seconds": round(search.wall),
            },
            **search.made_by,
        },
    )
