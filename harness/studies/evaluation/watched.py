"""Cases that divide the methods most, to be watched side by side."""

from __future__ import annotations

import shlex
from typing import Any

import pandas as pd

from steadyload.escaping import markdown, printable
from steadyload.layouts.benchmark.dataset import KEYS
from steadyload.runs import frames as v
from steadyload.runs.definition import StudyDefinition

_WATCHED = 8


def watched(frame: pd.DataFrame, rows: pd.DataFrame, study: StudyDefinition) -> dict[str, Any]:
    """Robust cases that divide the methods most evenly, no two of one item list.

    Cases on which about half the methods are right are preferred. Cases whose label has no ensemble
    count where none is known to be robust.

    Returns:
        ``watched``: the layout, its label, the most accurate method on either side and the step
        that the wrong one names. ``commands``: those that export the cases and play them.
    """
    order = v.values(rows["right"]).sort_values(ascending=False, kind="stable").index
    order = [method for method in order if method in set(frame["method"])]
    right = frame.pivot(index=KEYS, columns="method", values="right")[order].astype(bool)
    said = frame.pivot(index=KEYS, columns="method", values="said")[order]
    of = v.once(frame).set_index(KEYS)
    right, said = right.loc[of.index], said.loc[of.index]
    wrong = len(order) - right.sum(axis=1)
    divided = wrong[(wrong > 0) & (wrong < len(order)) & (of["robust"] | ~of["robust"].any())]
    evenly = (divided - 0.5 * len(order)).abs().sort_values(kind="stable")
    found: dict[str, dict[str, Any]] = {}
    exports, views = [], []
    directory, part = str(study.benchmark_directory or ""), str(study.benchmark)
    for name, scenario in evenly.index:
        case, about = (name, scenario), of.loc[(name, scenario)]
        bad = next((m for m in order if not right[m][case] and not pd.isna(said[m][case])), None)
        if bad is None or about["list"] in found:
            continue
        good, shown = next(m for m in order if right[m][case]), f"{name}_{scenario}"
        step, told = (_step(safe, about["items"]) for safe in (about["expected"], said[bad][case]))
        found[about["list"]] = {
            "layout": markdown(name), "scenario": scenario, "items": about["items"], "step": step,
            "right_method": rows["title"][good],
            "wrong_method": f"{rows['title'][bad]}: {told}",
            "wrong_methods": f"{wrong[case]} of {len(order)}",
        }  # fmt: skip
        file = "-".join(filter(None, (directory, part, scenario))) + ".json"
        page = _quoted(shown.replace("/", "_") + ".html")
        exports.append(
            f"steadyload benchmark export {directory + ' ' if directory else ''}--part {part} "
            f"--scenario {scenario} -o {file}"
        )
        views.append(
            f"steadyload view {file} --layout {_quoted(shown)} -m {bad} --beside {good} -o {page}"
        )
        if len(found) == _WATCHED:
            break
    return {
        "watched": pd.DataFrame(list(found.values())),
        "commands": [*dict.fromkeys(exports), *views],
    }


def _step(safe: Any, items: int) -> str:
    """A failing step as text; all items for a stable layout."""
    return "stable" if int(safe) == int(items) else str(int(safe))


def _quoted(name: str) -> str:
    """A name as a word of a command line, without what ends a block of code."""
    return shlex.quote(printable(name).replace("`", "'"))
