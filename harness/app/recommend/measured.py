"""The front of methods that were evaluated on the same cases."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from steadyload.app.recommend.front import Front, Measured
from steadyload.layouts.model.question import Question
from steadyload.methods.contract.spec import SpecError
from steadyload.runs.able import asked_question
from steadyload.runs.judged import JudgedCases
from steadyload.statistics.error_costs import ErrorShares


def front_of(
    judged: JudgedCases,
    question: Question,
    methods: pd.DataFrame,
    times: str,
    about: Mapping[str, str],
) -> Front:
    """The front of methods that were evaluated on the same cases.

    Args:
        judged: the cases, with labels of the question.
        question: methods that were made for another one do not take part.
        methods: a row each, as of :func:`steadyload.runs.frames.by_method`, with ``right``,
            ``over``, ``under_or_none`` and ``cpu``; one that came to no verdict on any case is left
            out with that reason, like one without times, from another installation, or on an
            engine that gave the labels.
        times: the kind of their CPU times, in words.
        about: provenance.
    """
    labels, named, apart = judged.labels, judged.manifest["labels"], judged.apart
    assert labels is not None, "the study is on a labelled set"
    measured, left_out = [], {}
    for spec, row in methods.iterrows():
        try:
            made_for = asked_question(spec)
        except SpecError as error:
            left_out[spec] = str(error)
            continue
        if made_for not in (None, question):
            continue
        if spec in apart:
            left_out[spec] = f"labels of its cases rest on {' and '.join(judged.screens)}"
        elif (lost := sum(row["lost"].values()) if isinstance(row["lost"], dict) else 0) == len(
            labels
        ):
            left_out[spec] = f"no verdict on any of {len(labels)} cases"
        elif pd.isna(row["cpu"]):
            left_out[spec] = "not timed"
        else:
            errors = ErrorShares(row["over"], row["under_or_none"])
            measured.append(
                Measured(
                    spec, row["title"], row["key"].engine, row["right"], row["cpu"], lost, errors
                )
            )
    return Front(
        measured=tuple(measured),
        question=question,
        fewest=int(labels["item_count"].min()),
        most=int(labels["item_count"].max()),
        part=f"{named['part']} of the set {named['set']}" if "set" in named else named["part"],
        cases=len(labels),
        item_lists=labels["instance"].nunique(),
        study=judged.manifest["study"]["name"],
        times=times,
        about=about,
        left_out=left_out,
    )
