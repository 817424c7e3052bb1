"""The page of packers' plans: how many stand box by box, and why the others do not."""

from __future__ import annotations

import math
from collections.abc import Mapping

from matplotlib.figure import Figure

from steadyload.layouts.scenarios import Scenario
from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.scene import plot_scene
from steadyload.reports.table import (
    MISSING,
    Column,
    Table,
    columns_for,
    names,
    percent,
    significant,
    words,
)
from steadyload.studies.packers.causes import Cause
from steadyload.studies.packers.figures import plot_failed_by
from steadyload.studies.packers.summary import PackersSummary, WorstPlan

_PACKER = words("packer")
_STAND = (
    Column("stand within 0.3 s %", "within", percent),
    Column("stand %", "stands", percent),
)
_SHARES = (
    _PACKER,
    Column("lists"),
    Column("n", "plans"),
    Column("boxes a plan", "boxes.value", "{:.1f}".format),
    *_STAND,
    Column("ls %", "score", percent),
    Column("unsettled"),
)
_KINDS = (_PACKER, words("lists of", "kind"), Column("lists"), Column("n", "plans"), *_STAND)
_SCENARIOS = (
    _PACKER,
    Column("n", "plans"),
    *columns_for([str(s) for s in Scenario], "{}: stand %", "stands", percent),
)
_PAIRS = (
    words("A", "first"),
    words("B", "second"),
    Column("lists"),
    Column("only A stands %", "only_first", percent),
    Column("only B stands %", "only_second", percent),
    Column("p", "p", lambda p: significant(p, 2) if p >= 1e-4 else "< 0.0001"),
)
_CAUSES = (
    _PACKER,
    Column("n", "plans"),
    *columns_for(list(Cause), "{} %", "causes", percent),
    Column("moves itself %", "own", percent),
)
_COVERAGE = (
    _PACKER,
    Column("plans"),
    Column("labelled", "known"),
    Column("boxes each", "boxes_known", significant),
    Column("not labelled", "unlabelled"),
    Column("boxes each of these", "boxes_new", significant),
    Column("no end", "failed"),
)
_CLOSE = (
    _PACKER,
    Column("within 1 mm %", "narrow", percent),
    Column("in the air %", "in_air", percent),
    Column("widest gap cm", "widest_gap", "{:.1f}".format),
)


def packers_page(found: PackersSummary, manifest: Mapping[str, str]) -> Page:
    """Compose the page.

    Args:
        found: the summary; sections without results are left out.
        manifest: provenance of the set.
    """
    sections = [_how_many(found), _parts(found)]
    if found.pairs:
        sections.append(_pairs(found))
    sections.append(_why(found))
    if found.worst:
        sections.append(_worst(found))
    sections.append(_hangs_on(found))
    made = dict(manifest)
    if found.versions:
        made["packers"] = ", ".join(f"{k} {v}" for k, v in found.versions.items())
    return Page("Do packers' plans stand while they are loaded?", _answer(found), sections, made)


def _answer(found: PackersSummary) -> str:
    ranked = sorted(found.packers, key=lambda row: row.stands.value)
    shares = "; ".join(
        f"{row.packer} {percent(row.stands)} % of {row.stands.n}" for row in ranked if row.stands.n
    )
    text = f"Loaded box by box, centres of mass in the middle, plans stand: {shares}."
    failing = found.all_causes
    if failing.plans:
        main = {c: failing.causes[c] for c in (Cause.NOTHING, Cause.OUT)}
        text += (
            f" Of the {failing.plans} that fail, {percent(main[Cause.NOTHING])} % do at a box with "
            f"nothing under it, and {percent(main[Cause.OUT])} % at one whose centre of mass is "
            "out over what carries it."
        )
    missing = sum(row.unlabelled + row.failed for row in found.coverage)
    if missing:
        total = sum(row.plans for row in found.coverage)
        text += f" Of {total} plans {missing} have no label yet and are left out."
    return (
        f"{text} What these shares hang on (the order of loading, densities, the packers' "
        "settings) is listed [below](#what-it-hangs-on). Brackets hold 95 % intervals, clustered "
        "by published instance."
    )


def _how_many(found: PackersSummary) -> Section:
    return Section(
        "How many plans stand",
        "Scenario S1, by the labels of both questions; *ls* is the share of boxes placed safely by "
        "`stands`, in the mean over plans. [What is counted](#what-is-counted) says the rest.",
        [Table(found.packers, _SHARES)],
    )


def _parts(found: PackersSummary) -> Section:
    return Section(
        "What is counted",
        "A plan is one bin of the set of real size (docs/benchmark.md). It stands *within 0.3 s* "
        "when nothing moves by more than 10 cm or turns by more than 10 degrees in the first 0.3 s "
        "after any placement; it *stands* when that holds until everything rests, or for 3 s. A "
        "plan in which something still moves then is *unsettled*: it has no label of `stands` and "
        "counts within 0.3 s alone. Packers packed the same lists; a list of which no bin has an "
        "allowed number of boxes is missing. The palletising software packed customers' orders, "
        "which nobody else packed: its lists are orders. A plan that two packers found counts for "
        "both.",
        [
            Table(
                found.scenarios,
                _SCENARIOS,
                "By scenario, plans with a label in each: in S2a and S2b centres of mass are drawn "
                "off the middle.",
            ),
            Table(found.kinds, _KINDS, "By kind of list, S1."),
        ],
    )


def _pairs(found: PackersSummary) -> Section:
    return Section(
        "Packers on the same lists",
        "Lists of which both have a plan with a label: the share on which one plan stands and the "
        "other does not. *p* is that of a paired sign-flip test over instances, corrected by Holm "
        "for all pairs. A plan is the first bin with an allowed number of boxes, so that two plans "
        "of a list hold different boxes of it.",
        [Table(found.pairs, _PAIRS)],
    )


def _why(found: PackersSummary) -> Section:
    figure = Picture(
        "failed_by",
        plot_failed_by(found.failed_by),
        "Where in the loading plans fail: the share that has failed by the share of boxes placed "
        "safely; in brackets the number of plans.",
    )
    if not found.all_causes.plans:
        return Section("Why they fail", "No plan fails.", pictures=[figure])
    return Section(
        "Why they fail",
        "Of the plans that do not stand, in S1, by the box that is placed at the failing step; the "
        "first reason that applies. *Nothing under it*: it is placed in the air. *Centre of mass "
        "out over its supports*: it would tip on what carries it, were that firm. *Something below "
        "gives way*: it could stand on that, which tips with it. *In balance*: vertical forces can "
        "balance everything, as when a centre of mass lies above an edge, and something moves all "
        "the same. *Moves itself*: the box that moves farthest is the one just placed.",
        [Table([*found.causes, found.all_causes], _CAUSES)],
        [figure],
    )


def _worst(found: PackersSummary) -> Section:
    failing = {plan.packer for plan in found.worst}
    spared = names(row.packer for row in found.packers if row.packer not in failing)
    return Section(
        "The worst plans",
        "Of each packer the plan with the smallest share of boxes placed safely, S1, as it is "
        "loaded at the failing step; of equal ones the largest. Marked is the box that moves too "
        "far. Boxes bear their numbers in the order of loading, from 0."
        + (f" No plan fails of: {spared}." if spared != MISSING else ""),
        pictures=[
            Picture(f"worst_{number}", _scene(plan), _caption(plan))
            for number, plan in enumerate(found.worst)
        ],
    )


def _scene(plan: WorstPlan) -> Figure:
    marked = () if plan.moved_item is None else (plan.moved_item,)
    return plot_scene(plan.drawn, title=f"{plan.layout}, step {plan.step}", marked=marked)


def _caption(plan: WorstPlan) -> str:
    moved = "something" if plan.moved_item is None else f"box {plan.moved_item}"
    far = "too far"
    if not math.isnan(plan.displacement + plan.rotation):
        far = f"{plan.displacement:.1f} cm and {plan.rotation:.1f} degrees within 0.3 s"
        if plan.is_late:
            far += ", and too far later"
    return (
        f"{plan.packer}: `{plan.layout}` fails at step {plan.step} of {plan.items}; {moved} "
        f"moves {far}."
    )


def _hangs_on(found: PackersSummary) -> Section:
    lines = [
        f"**Order of loading.** {_sentence(found.loading_order)} A packer says where boxes lie, "
        "not when they are loaded. In a plan whatever could carry a box is loaded before it, so "
        "that no other order puts more under it.",
        f"**Weights.** {_sentence(found.densities)} In S1 the first two reasons above hang on no "
        "weight: a box in the air falls, and one that is out over its supports tips, unless boxes "
        "beside it stop it.",
        "**Settings of packers.** PackingSolver: one pass of at most 10 s, so that its plans hang "
        "on the machine, too; Packvium: balanced settings, bounded by counted work, once without "
        "and once with a least share of 75 % of every base supported; py3dbp: largest boxes first. "
        "Only the second one of Packvium was asked for support. Versions: "
        f"{names(f'{name} {version}' for name, version in found.versions.items())}.",
        f"**Turning.** {_sentence(found.turning)} Where an instance forbids that, plans that keep "
        "to it are others.",
        "**Thresholds.** A box in the air that falls by less than 10 cm and lands flat counts as "
        "placed safely. *In the air* is the share of standing plans with such a box, and *widest "
        "gap* how far it is above what lies below.",
        f"**Tolerance.** {_labels(found)} Its contacts are firm but not rigid. *Within 1 mm* is "
        "the share of plans in which a box is so close to its point of balance, at the failing "
        "step or anywhere in a load that stands: real boxes decide those. Walls of a container "
        "carry nothing.",
    ]
    if any(row.unlabelled + row.failed for row in found.coverage):
        lines.append(
            "**Plans without a label** are in no other table. Large layouts are labelled last, so "
            "packers are compared fairly by pairs on the same lists alone. *No end*: labelling "
            "came to none."
        )
    return Section(
        "What it hangs on",
        "\n".join(f"- {line}" for line in lines),
        [
            Table(found.coverage, _CLOSE, "S1, plans with a label."),
            Table(found.coverage, _COVERAGE, "S1, all plans of the set."),
        ],
    )


def _labels(found: PackersSummary) -> str:
    if not found.screen:
        return "A label is one verdict of the reference simulator."
    return (
        f"`{found.screen}` looked at every step, and the reference simulator decided about those "
        "that hang on it."
    )


def _sentence(text: str) -> str:
    """An entry of the manifest as a sentence."""
    return f"{text[:1].upper()}{text[1:]}." if text else MISSING
