"""The part of a page on which methods say the same, and on which cases two of them differ."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from steadyload.app.viewing import view_of
from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.verdict import Verdict
from steadyload.methods.session.recording import record_plan
from steadyload.reports.interactive import STABLE, AnswerChart, AnsweredCase
from steadyload.reports.viewer.page import MARKS, player_html
from steadyload.runs.answers import Answers
from steadyload.runs.provenance import provenance_lines


def answer_chart(titles: Mapping[str, str], answers: Answers | None) -> AnswerChart | None:
    """The chart in the place of the picture in a browser; None without the answers.

    Args:
        titles: of methods, by spec.
        answers: of all of them.
    """
    if answers is None:
        return None
    asked = "Number of cases on which two methods name different failing steps, or one names none."
    specs, made = list(answers.said.columns), provenance_lines()
    cases = []
    for (name, scenario), said in answers.said.iterrows():
        steps = tuple(_step(said[spec], answers.counts[name, scenario]) for spec in specs)
        layout = answers.layouts.get((name, scenario))
        player = "" if layout is None else _player(layout, specs[0], steps[0], made)
        cases.append(AnsweredCase(name, str(scenario), steps, player))
    shown = tuple(titles.get(spec, spec) for spec in specs)
    return AnswerChart(shown, tuple(cases), asked)


def _step(said: object, items: int) -> int | None:
    if pd.isna(said):
        return None
    return STABLE if said == items else int(said)  # type: ignore[call-overload]


def _player(layout: Layout, spec: str, step: int | None, made: Mapping[str, str]) -> str:
    """The plan, up to the step at which one of the answers lets it fail."""
    verdict = Verdict(len(layout), failing_step=None if step == STABLE else step)
    return player_html(view_of(layout, [record_plan(layout, spec, verdict)], made), MARKS)
