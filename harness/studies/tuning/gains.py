"""Accuracy that searches add to the parameters that they begin with, on cases unseen by them."""

from __future__ import annotations

from collections.abc import Iterable

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import LISTS, Part
from steadyload.layouts.model.question import Question, with_question
from steadyload.methods.registry import make_method
from steadyload.methods.tuned import TUNED, tuned
from steadyload.reports.columns import column, least_shown, percent, row
from steadyload.runs.comparison import detectable
from steadyload.runs.labels import Cases
from steadyload.statistics.estimate import Estimate
from steadyload.studies.kit import Lab
from steadyload.tuning.space import space_on

_SHARD_SIZE = 60


@row
class SearchGain:
    """Accuracy of a preset on an engine, and of the start of the search that found it."""

    question: str = column()
    engine: str = column()
    n: int = column()
    start: Estimate = column("start of the search %", percent)
    found: Estimate = column("ps_opt %", percent)
    gain: Estimate = column("gain (points)", percent)
    shown: float = column(
        "shown", least_shown, "least gain that these cases show with a probability of 80 %"
    )


def search_gains(lab: Lab, engines: Iterable[str], limit: int) -> list[SearchGain]:
    """Judge the presets of all questions and their starts, on cases of many item lists.

    Args:
        lab: where they are judged.
        engines: of three dimensions; those without a preset for a question are left out.
        limit: cases a scenario, those of the first ranks.

    Raises:
        as :meth:`steadyload.studies.kit.Lab.judge`.
    """
    wanted, gains = tuple(engines), []
    for question in Question:
        entries = tuned(question)
        specs = {
            engine: (_start(engine, entries[engine].made_by["space"]), _preset(engine, question))
            for engine in wanted
            if engine in entries
        }
        if specs:
            found = lab.judge(
                [spec for pair in specs.values() for spec in pair],
                Cases(load_benchmark(LISTS), Part.TEST, limit=limit),
                question=question, folder=f"gains/{question}", shard_size=_SHARD_SIZE,
            )  # fmt: skip
            for engine, (start, own) in specs.items():
                before, after = found.row(start).accuracy, found.row(own).accuracy
                gain = found.difference(own, start)
                least = detectable(gain, found.judged.clusters.nunique())
                gains.append(SearchGain(question, engine, after.n, before, after, gain, least))
    return gains


def _start(engine: str, space: str) -> str:
    searched = space_on(engine, space)
    return str(make_method(searched.spec(searched.start)).spec)


def _preset(engine: str, question: Question) -> str:
    return str(make_method(with_question(f"{TUNED}@{engine}", question)).spec)
