"""Sections on cases without a verdict, on floors, and on what the numbers hang on."""

from __future__ import annotations

from steadyload.layouts.model.question import Question
from steadyload.reports.pages.page import Section
from steadyload.reports.table import (
    Column,
    Table,
    columns_for,
    counts,
    estimates_table,
    percent,
    words,
)
from steadyload.studies.real.summary import RealSummary


def no_verdict_section(found: RealSummary) -> Section:
    """Section of the cases without a verdict, by method and status."""
    columns = [
        words("method"),
        words("status"),
        Column("cases"),
        Column("boxes", lambda row: f"{row.fewest} to {row.most}"),
        words("reason, with most boxes", "reason"),
    ]
    return Section(
        "Cases without a verdict",
        "Over all cases of this page, the small ones too."
        if found.lost
        else "Every method came to a verdict on every case.",
        [Table(found.lost, columns)] if found.lost else [],
    )


def floors_section(found: RealSummary) -> Section:
    """Section of customers' pallets on several floors; there are some."""
    specs = [key.spec for key, _ in found.floors[0].stable]
    titles = {key.spec: key.title for key, _ in found.floors[0].stable}
    stable = columns_for(
        specs,
        lambda spec: f"{titles[spec]}: stable %",
        lambda row, spec: next(share for key, share in row.stable if key.spec == spec),
        percent,
    )
    changed = columns_for(specs, lambda spec: f"{titles[spec]}: changed", "changed")
    return Section(
        "What the deck's edge and small gaps change",
        f"{found.floors[0].pallets} customers' pallets of this part of the set: the share that a "
        "method calls stable, and on how many its failing step is another than as delivered. "
        "Vertical gaps of the file are closed by lowering boxes (docs/pallets.md).",
        [Table(found.floors, [words("floor"), *stable, *changed])],
    )


def labels_section(found: RealSummary) -> Section:
    """Section on the labels, the share of failures, and the machine."""
    screened = found.screened
    columns = [
        words("the reference was asked, because", "reason"),
        Column("steps"),
        Column("too far, screen", "screen"),
        Column("too far, reference", "reference"),
        Column("disagree", "differ"),
        Column("disagree %", "share", percent),
    ]
    missing = (
        f" {counts(found.unlabelled)} cases of the set have no label." if found.unlabelled else ""
    )
    drawn = screened.of("drawn")
    missed = (
        ""
        if drawn is None
        else f" Of {drawn.steps} steps that were drawn at random, since nothing else spoke for "
        f"asking, the two disagree about {drawn.differ} ({percent(drawn.share)} %)."
    )
    shown = {"the cases of this page": found.real.failing, "the whole set": found.natural}
    return Section(
        "What the numbers hang on",
        "*Labels* come from screening: a fast simulation answers about every step, the reference "
        "where it depends on it, and its answer counts (docs/benchmark.md). On "
        f"{screened.cases} cases that took {screened.steps} steps.{missed}{missing} A label is one "
        "verdict of one simulation, and no ensemble tells how robust it is. "
        "*Failures* decide how much the constant verdict is worth; their share depends on who "
        "packed, and stable cases were left out of the part that is judged where it had too many. "
        "*Times* are of the machine below.",
        [
            *([Table(screened.reasons, columns)] if screened.reasons else []),
            estimates_table(
                "label",
                {f"{q}, {where}": shares[q] for q in Question for where, shares in shown.items()},
                "fails %",
                caption="**Cases whose label is a failing step**",
            ),
        ],
    )
