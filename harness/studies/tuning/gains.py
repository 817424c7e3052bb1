"""Accuracy that searches add to the parameters that they begin with, on cases unseen by them."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.benchmark.parts import LISTS, Part
from steadyload.layouts.model.question import Question, with_question
from steadyload.methods.registry import make_method
from steadyload.methods.tuned import TUNED, tuned
from steadyload.runs import frames as v
from steadyload.runs.labels import Cases
from steadyload.statistics.paired import detectable
from steadyload.studies.kit import Lab
from steadyload.tuning.space import space_on

_SHARD_SIZE = 60


def search_gains(lab: Lab, engines: Iterable[str], limit: int) -> pd.DataFrame:
    """Judge the presets of all questions and their starts, on cases of many item lists.

    Returns:
        A row a question and engine: accuracy of the ``start`` of the search, of the ``preset``, and
        their difference, ``gain``; ``shown``: the least that these cases show.
    """
    wanted, gains = tuple(engines), []
    for question in Question:
        entries = tuned(question)
        specs = {
            engine: (_preset(engine, question), _start(engine, entries[engine].made_by["space"]))
            for engine in wanted
            if engine in entries
        }
        if specs:
            judged = lab.judge(
                [spec for own, start in specs.values() for spec in (start, own)],
                Cases(load_benchmark(LISTS), Part.TEST, limit=limit),
                question=question, folder=f"gains/{question}", shard_size=_SHARD_SIZE,
            ).judged  # fmt: skip
            frame = v.verdicts(judged)
            right = v.share(frame, "right", ["method"])
            gain = v.pairs(frame, chosen=specs.values())["difference"]
            gains += [
                {
                    "question": question, "engine": engine, "start": right[both[1]],
                    "preset": right[both[0]], "gain": gain[both],
                    "shown": detectable(gain[both], judged.clusters.nunique()),
                }
                for engine, both in specs.items()
            ]  # fmt: skip
    return pd.DataFrame(gains)


def _start(engine: str, space: str) -> str:
    searched = space_on(engine, space)
    return str(make_method(searched.spec(searched.start)).spec)


def _preset(engine: str, question: Question) -> str:
    return str(make_method(with_question(f"{TUNED}@{engine}", question)).spec)
