"""Cases that divide the methods most, to be watched side by side."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from operator import attrgetter
from pathlib import Path
from typing import Any

import pandas as pd

from steadyload.app.viewing import write_view
from steadyload.atomic import not_a_link, without_link
from steadyload.escaping import markdown, printable
from steadyload.layouts.benchmark import load_benchmark
from steadyload.methods.naming import MethodKey
from steadyload.reports.columns import column, row
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.evaluation import MethodEvaluation

_WATCHED = 8

FOLDER = "views"
"""Folder of pages that play cases, beside the page."""


@row
class Watch:
    """A robustly labelled case on which methods differ, and two of them to watch side by side.

    Attributes:
        linked: name of the layout, with a link where a page plays both loadings.
        label: failing step, or ``stable``.
        right: the most accurate method with the label's failing step.
        wrong: the most accurate one without.
        said: that method, and what it says.
        wrong_methods: how many of all are wrong.
        commands: those that export the case, and play it.
        view: path of the page that plays it, from that of the study; empty without one.
    """

    layout: str
    linked: str = column("layout")
    scenario: str = column()
    item_count: int = column("items")
    label: str = column(left=False)
    right: MethodKey = column(form=attrgetter("title"))
    wrong: MethodKey
    said: str = column("wrong", left=False)
    wrong_methods: str = column("wrong methods", left=False)
    directory: str
    commands: tuple[str, str]
    view: str


def watched(
    study: StudyDefinition,
    methods: Sequence[MethodEvaluation],
    said: pd.DataFrame,
    right: pd.DataFrame,
    labels: pd.DataFrame,
    views: int = 0,
) -> tuple[Watch, ...]:
    """Robust cases that divide the methods most evenly, no two of one item list.

    Cases on which about half the methods are right are preferred. Cases whose label has no ensemble
    count where none is known to be robust. The first ``views`` of them are played by pages.
    """
    order = sorted(methods, key=lambda m: -m.accuracy.value)
    robust = labels["robust"].fillna(False).to_numpy(bool)
    own = right[[m.method.spec for m in methods]]
    cases = own[robust] if robust.any() else own
    wrong = len(order) - cases.sum(axis=1)
    divided = wrong[(wrong > 0) & (wrong < len(order))]
    evenly = (divided - 0.5 * len(order)).abs().sort_values(kind="stable")
    found: dict[str, Watch] = {}
    for case in evenly.index:
        name, scenario = case
        truth, label = right.loc[case], labels.loc[case]
        answers = said.loc[case]
        good = next(m.method for m in order if truth[m.method.spec])
        others = [m.method for m in order if not truth[m.method.spec]]
        bad = next((m for m in others if not pd.isna(answers[m.spec])), None)
        if bad is None or label["instance"] in found:
            continue
        directory, part = str(study.benchmark_directory or ""), str(study.benchmark)
        shown, item_count = f"{name}_{scenario}", int(label["item_count"])
        file = "-".join(filter(None, (directory, part, scenario))) + ".json"
        page = _quoted(shown.replace("/", "_") + ".html")
        view = f"{FOLDER}/{shown}.html" if len(found) < views else ""
        found[label["instance"]] = Watch(
            layout=name,
            linked=f"[{markdown(name)}]({view})" if view else markdown(name),
            scenario=scenario,
            item_count=item_count,
            label=_step(label["failing_step"], item_count),
            right=good,
            wrong=bad,
            said=f"{bad.title}: {_step(answers[bad.spec], item_count)}",
            wrong_methods=f"{wrong.loc[case]} of {len(order)}",
            directory=directory,
            commands=(
                f"steadyload benchmark export {directory + ' ' if directory else ''}--part {part} "
                f"--scenario {scenario} -o {file}",
                f"steadyload view {file} --layout {_quoted(shown)} -m {bad.spec} "
                f"--beside {good.spec} -o {page}",
            ),
            view=view,
        )
        if len(found) == _WATCHED:
            break
    return tuple(found.values())


def _step(safe: Any, item_count: int) -> str:
    """A failing step as text; ``safe`` is missing or all items for a stable layout."""
    return "stable" if pd.isna(safe) or int(safe) == int(item_count) else str(int(safe))


def _quoted(name: str) -> str:
    """A name as a word of a command line, without what ends a block of code."""
    return shlex.quote(printable(name).replace("`", "'"))


def write_views(cases: Iterable[Watch], folder: Path) -> None:
    """Write the pages that play cases, half a megabyte each, into the folder of a page.

    Raises:
        BenchmarkError: the labelled set cannot be read any more.
        as :func:`steadyload.app.viewing.write_view`.
    """
    for case in cases:
        if case.view:
            layout = load_benchmark(case.directory or None).layout(case.layout, case.scenario)
            not_a_link(folder / FOLDER).mkdir(parents=True, exist_ok=True)
            methods = [case.wrong.spec, case.right.spec]
            write_view(layout, methods, without_link(folder / case.view))
