"""Titles and forms of the columns of frames of results."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

from steadyload.reports import table as forms
from steadyload.reports.table import MISSING
from steadyload.statistics.estimate import Estimate


class Shown(NamedTuple):
    """How a column is shown.

    Attributes:
        title: its header; of a column ``NAME:KEY`` it holds ``{}`` in the place of the key.
        form: makes the cell's text of the value.
        left: whether its cells are aligned left; None: where they are texts.
        notable: see :class:`steadyload.reports.table.Column`.
    """

    title: str
    form: Callable[[Any], str] = forms.cell
    left: bool | None = None
    notable: bool = False


FEW = 10
"""Smallest number of cases of which a mean over samples is shown."""


def _share(found: Any) -> str:
    return forms.factor(found) if isinstance(found, Estimate) else forms.cell(found)


def _with_n(found: Estimate) -> str:
    return f"{forms.percent(found)}, n {found.n}"


def _taken(time: float) -> str:
    """A time [ms]; a dash for a method that has no such phase."""
    return forms.significant(time or None)


def _of_several(found: Estimate) -> str:
    return forms.percent(found) if found.n >= FEW else MISSING


def _whole(found: Estimate) -> str:
    return f"{found.value:.0f} [{found.low:.0f}, {found.high:.0f}]"


_two = partial(forms.fixed, digits=2)
_percent = forms.percent

COLUMNS: Mapping[str, Shown] = {
    # Methods and their accuracy
    "title": Shown("method"),
    "right": Shown("accuracy %", _percent),
    "cheap": Shown("cheapest within one point"),
    "cheap_right": Shown("accuracy %", _percent),
    "over": Shown("overestimated %", _percent),
    "under": Shown("underestimated %", _percent),
    "under_or_none": Shown("underestimated or no verdict %", _percent),
    "stable_or_not": Shown("stable or not %", _percent),
    "right_stands": Shown("stands %", _percent),
    "right_robust": Shown("robust %", _percent),
    "right_fragile": Shown("fragile %", _percent),
    "right_failing": Shown("failing: accuracy %", _percent),
    "natural": Shown("natural prevalence %", _percent),
    "behind": Shown("difference", _percent),
    "lost": Shown("no verdict", forms.counts, notable=True),
    "refused": Shown("refused %", _percent),
    "paper": Shown("paper %", partial(forms.plain_percent, digits=2)),
    "fragile_errors": Shown("errors on fragile labels %"),
    "boxes_right": Shown("{}", _percent),
    "class_right": Shown("class {}", _percent),
    "scenario_right": Shown("{} %", _percent),
    "family_right": Shown("{} %", _percent),
    "rule_right": Shown("{}", _percent),
    "rule_rank": Shown("{}", left=False),
    "alarms": Shown("{}", _with_n),
    "found": Shown("found of {} %", _percent),
    "false_alarms": Shown("false alarms, {}"),
    # Costs
    "cpu": Shown("CPU ms", forms.milliseconds),
    "wall": Shown("wall ms", forms.milliseconds),
    "median": Shown("median ms", forms.significant),
    "cheap_median": Shown("median ms", forms.significant),
    "ninety": Shown("90 % ms", forms.significant),
    "worst": Shown("worst ms", forms.significant),
    "brief": Shown("judged in 0.3 s %", _percent),
    "long": Shown("judged in 1 s %", _percent),
    "exponent": Shown("exponent, the set", forms.decimal),
    "exponent_of_all": Shown("exponent, all", forms.decimal),
    "of_yardstick": Shown("share", _share),
    "of_unit": Shown("multiple", forms.factor),
    "substeps": Shown("substeps", partial(forms.fixed, digits=1)),
    "cost_ratio": Shown("share of its time", forms.factor),
    "body_substeps": Shown("body-substeps", forms.factor),
    "body_ratio": Shown("body-substeps", forms.compact),
    "cpu_median": Shown("CPU, median", forms.compact),
    "cpu_paired": Shown("CPU, paired", forms.factor),
    "cpu_boxes": Shown("{}: CPU", forms.compact),
    "boxes_cpu": Shown("{}", forms.milliseconds),
    "scenario_cpu": Shown("{} CPU ms", forms.significant),
    "origin_cost": Shown("{}"),
    "cost_at": Shown("cost at {}", forms.factor),
    # Comparisons
    "alike": Shown("same %", _percent),
    "alike_boxes": Shown("{} boxes: same %", _percent),
    "changes": Shown("earlier / later / none", left=False),
    "without_verdict": Shown("no verdict", forms.counts, left=True),
    "letters": Shown("letters"),
    "difference": Shown("difference", _percent),
    "ahead": Shown("cascade ahead", _percent),
    "shown": Shown("shown", forms.least_shown),
    "only_it": Shown("only it is right %", _percent),
    "only_other": Shown("only the other is right %", _percent),
    "family_gain": Shown("{}", _percent),
    "p": Shown("p", forms.compact),
    "p_shown": Shown("p", forms.p_value),
    "corrected": Shown("corrected p", forms.compact),
    "first": Shown("first"),
    "second": Shown("second"),
    "scenario_difference": Shown("{}"),
    "least": Shown("ratio from", forms.compact),
    "most": Shown("to", forms.compact),
    "by_list": Shown("item lists", _two),
    "by_both": Shown("lists and heuristics", _two),
    "ratio": Shown("ratio", _two),
    "paper_right": Shown("{} %, paper / ours"),
    "paper_wall": Shown("paper, wall ms", forms.compact),
    "paper_share": Shown("paper, of its PS_3", forms.compact),
    # Rules
    "claim": Shown("conclusion"),
    "knowledge": Shown("methods"),
    "fate": Shown("fate"),
    "holds": Shown("holds under", left=False),
    "turned": Shown("turned under"),
    "least_difference": Shown("least difference", _percent),
    "greatest": Shown("greatest", _percent),
    "rule": Shown("rule"),
    "rule_stable": Shown("stable %", forms.plain_percent),
    "changed": Shown("label changed %", forms.plain_percent),
    "most_accurate": Shown("most accurate"),
    "most_accurate_told": Shown("with the rule's parameters"),
    # Engines
    "engine": Shown("engine"),
    "single": Shown("precision"),
    "engine_right": Shown("{} %", _percent),
    "genotypes": Shown("parameter sets searched"),
    "searched_on": Shown("cases searched on"),
    "found_there": Shown("accuracy there %", forms.plain_percent),
    "more": Shown("more than ps_opt, points", _percent),
    "pair": Shown("engines"),
    "same": Shown("{} Hz", _percent),
    "stable_at": Shown("{} Hz", _percent),
    "cpu_at": Shown("{} Hz", forms.milliseconds),
    "option": Shown("option"),
    "option_changed": Shown("{}", _percent),
    "option_ratio": Shown("{}", forms.significant),
    "whole": Shown("share of all differences %", _percent),
    "always": Shown("the same on all cases %", _percent),
    "by_case": Shown("from case to case %", _percent),
    "component": Shown("variance component %", _percent),
    "freedom": Shown("degrees of freedom"),
    # A run
    "within_one": Shown("within one %", _percent),
    "score": Shown("mean score %", _percent),
    "fully_stable": Shown("fully stable %", _percent),
    "agreement": Shown("agreement with simulations %", _percent),
    "agrees": Shown("{}", _percent),
    "agrees_with": Shown("agrees with {} %", _percent),
    "build": Shown("build ms", _taken),
    "step_ms": Shown("step ms", _taken),
    "read": Shown("read ms", _taken),
    "other": Shown("other ms", forms.significant),
    "phases": Shown("build / step / read ms", left=False),
    "honoured": Shown("honoured"),
    "emulated": Shown("emulated"),
    "ignored": Shown("ignored"),
    "settings": Shown("all parameters that ask for something"),
    "beyond": Shown("cases beyond"),
    "by": Shown("by (cases)"),
    "example": Shown("for example"),
    "said_of": Shown("{}", left=False),
    # Tuning
    "question": Shown("question"),
    "start": Shown("start of the search %", _percent),
    "preset": Shown("ps_opt %", _percent),
    "gain": Shown("gain (points)", _percent),
    "change": Shown("change"),
    "values": Shown("to"),
    "accuracy_change": Shown("change of accuracy", _percent),
    "cost_change": Shown("cost factor", forms.compact),
    "validation": Shown("validation %", forms.plain_percent),
    "seed": Shown("seed", left=True),
    "fitness": Shown("fitness", "{:.4f}".format),
    "gene": Shown("{}"),
    "tuned_on": Shown("tuned on"),
    "judged_on": Shown("judged on"),
    # Cascades
    "budget": Shown("budget, points"),
    "aim": Shown("aim"),
    "measured": Shown("measured"),
    "reached": Shown("reached"),
    "stage": Shown("stage"),
    "low": Shown("stable below", partial(forms.compact, digits=3)),
    "high": Shown("unstable above", partial(forms.fixed, digits=4)),
    "stage_steps": Shown("steps %", _percent),
    "steps_right": Shown("right %", _percent),
    "stage_layouts": Shown("layouts %", _percent),
    "layouts_right": Shown("right %", _percent),
    "before_last": Shown("stages before the last"),
    "losses": Shown("lost (allowed)", left=False),
    "gained": Shown("gained"),
    "bound": Shown("bound %", partial(forms.plain_percent, digits=2)),
    "sure_bound": Shown("95 % bound %", partial(forms.plain_percent, digits=2)),
    "left_out": Shown("left out lost", left=False),
    "together": Shown("accuracy %", forms.plain_percent),
    "alone": Shown("last alone %", forms.plain_percent),
    "step_times": Shown("CPU ms", partial(forms.compact, digits=3)),
    "step_times_alone": Shown("last alone", partial(forms.compact, digits=3)),
    "counted_steps": Shown("steps"),
    "decided": Shown("decided"),
    "wrong": Shown("wrong"),
    "lost_cases": Shown("cases lost"),
    "above": Shown("boxes above"),
    "label_changed": Shown("changed %", _percent),
    "stable_changed": Shown("of stable %", _percent),
    "unstable_changed": Shown("of unstable %", _percent),
    "earlier": Shown("earlier"),
    "later": Shown("later"),
    "slowest": Shown("slowest ms", forms.significant),
    # Limits of loads on the road
    "limits": Shown("n"),
    "limit_apart": Shown("less the other, g", partial(forms.decimal, digits=3)),
    "clearly_above": Shown("> 0.02 g above %", _percent),
    "clearly_below": Shown("> 0.02 g below %", _percent),
    "direction_cpu": Shown("CPU ms a direction", forms.milliseconds),
    "friction": Shown("friction", forms.general),
    "of_loads": Shown("loads"),
    "weakest": Shown("weakest, g", partial(forms.decimal, digits=3)),
    "held": Shown("{} g held %", _percent),
    "tips": Shown("tips %", _percent),
    # Samples
    "plan_right": Shown("plan %", _percent),
    "likeliest": Shown("likeliest step %", _percent),
    "plan_brier": Shown("Brier, plan", forms.factor),
    "p_brier": Shown("Brier, P", forms.factor),
    "unsure": Shown("unsure %", _of_several),
    "samples_change": Shown("changed %", _of_several),
    "change_robust": Shown("robust %", _of_several),
    "change_fragile": Shown("fragile %", _of_several),
    "samples": Shown("samples", _whole),
    "plan_cpu": Shown("CPU ms, plan", forms.milliseconds),
    "endings": Shown("sampling ended", forms.counts),
    "samples_lost": Shown("samples without a verdict"),
    "unjudged": Shown("cases without one"),
    "deviates": Shown("deviates"),
    "margin": Shown("margin cm"),
    "p_stands": Shown("P %", _percent),
    "firm": Shown("P 95 % or more %", _percent),
    "p_least": Shown("least P %", forms.plain_percent),
    # Errors of engines
    "test": Shown("test"),
    "error_unit": Shown("error in"),
    "rate": Shown("substeps", left=False),
    "value": Shown("found", forms.general),
    "error": Shown("error"),
    "error_shown": Shown("error", left=False),
    "error_of": Shown("{}"),
    "best": Shown("best other"),
    "why": Shown("why"),
    # Sessions
    "bins": Shown("bins a list", _two),
    "asked": Shown("judged an item", partial(forms.significant, digits=2)),
    "rejected": Shown("rejected an item", partial(forms.significant, digits=2)),
    "judging": Shown("of this judging", forms.milliseconds),
    "scene": Shown("scene"),
    "ms_at": Shown("ms at {}", forms.significant),
    "growth": Shown("exponent", _two),
    "whole_layout": Shown("whole layout, ms at 200", forms.significant),
    "over_session": Shown("over session", partial(forms.significant, digits=2)),
    # A labelled set
    "item_class": Shown("class", left=True),
    "mean_items": Shown("items a layout", partial(forms.fixed, digits=1)),
    "split": Shown("split"),
    "stable_cases": Shown("stable"),
    "unstable_cases": Shown("unstable"),
    "of_packings": Shown("stable % of packings", _percent),
    "published": Shown("paper's %", forms.plain_percent),
    "by_paper": Shown("stable % by the other criterion", _percent),
    "other_label": Shown("other failing step %", _percent),
    "event": Shown("at the failing step"),
    "robust": Shown("robust %", _percent),
    "confidence": Shown("confidence %", _percent),
    "part": Shown("{} %", _percent),
    "pooled": Shown("all %", _percent),
    "apart_at": Shown("step"),
    "corner": Shown("corner cm", left=False),
    "angle": Shown("angle deg", left=False),
    "apart_by": Shown("margin cm", left=False),
    # Plans of packers
    "packer": Shown("packer"),
    "kind": Shown("lists of"),
    "plans": Shown("n"),
    "plan_boxes": Shown("boxes a plan", partial(forms.fixed, digits=1)),
    "within": Shown("stand within 0.3 s %", _percent),
    "unsettled": Shown("unsettled"),
    "stands_in": Shown("{}: stand %", _percent),
    "cause": Shown("{} %", _percent),
    "own": Shown("moves itself %", _percent),
    "known": Shown("labelled"),
    "boxes_known": Shown("boxes each", forms.significant),
    "new": Shown("not labelled"),
    "boxes_new": Shown("boxes each of these", forms.significant),
    "failed": Shown("no end"),
    "narrow": Shown("within 1 mm %", _percent),
    "in_air": Shown("in the air %", _percent),
    "widest_gap": Shown("widest gap cm", partial(forms.fixed, digits=1)),
    "way": Shown("way"),
    "stands": Shown("stand %", _percent),
    "none_out": Shown("stand, none left out %", _percent),
    "boxes_out": Shown("boxes left out %", _percent),
    "volume_out": Shown("volume left out %", _percent),
    "moved_median": Shown("boxes moved, median", forms.general),
    "moved": Shown("boxes moved, mean", forms.one_decimal),
    "moved_by": Shown("moved by cm", forms.one_decimal),
    "retimed": Shown("loaded at another time", forms.one_decimal),
    "judge": Shown("judge"),
    "unknown": Shown("no answer"),
    "group": Shown("plans"),
    "as_planned": Shown("balance as planned"),
    "margin_median": Shown("margin cm, median", forms.significant),
    "close": Shown("below 1 cm %", _percent),
    # Cases
    "family": Shown("family"),
    "about": Shown("boxes"),
    "label_cpu": Shown("CPU ms a label", forms.milliseconds),
    "unlabelled": Shown("without label", forms.counts, notable=True),
    "cases": Shown("cases"),
    "boxes": Shown("boxes", left=False),
    "size": Shown("boxes"),
    "middle": Shown("median", forms.general),
    "lists": Shown("item lists"),
    "layouts": Shown("layouts"),
    "stable": Shown("stable by the label %", _percent),
    "fails": Shown("fails %", _percent),
    "fails_by": Shown("fails {} %", _percent),
    "origin": Shown("cases"),
    "case_label": Shown("label"),
    "status": Shown("status"),
    "reason": Shown("reason, with most boxes"),
    "layout": Shown("layout"),
    "scenario": Shown("scenario"),
    "items": Shown("items"),
    "step": Shown("label", left=False),
    "right_method": Shown("right", left=False),
    "wrong_method": Shown("wrong", left=False),
    "wrong_methods": Shown("wrong methods", left=False),
    "floor": Shown("floor"),
    "floor_stable": Shown("{}: stable %", _percent),
    "floor_changed": Shown("{}: changed"),
}
"""By name, the columns of frames of results: the one place of their titles and forms.

A name before a colon stands for one column a key, see :func:`steadyload.reports.frames.across`.
"""
