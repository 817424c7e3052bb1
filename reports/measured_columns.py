"""Titles and forms of the columns of what is measured of bodies and loads that move."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from steadyload.reports import table as forms
from steadyload.reports.table import Shown

_percent = forms.percent
_two = partial(forms.fixed, digits=2)
_degrees = partial(forms.decimal, digits=0)

MEASURED: Mapping[str, Shown] = {
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
    # Throws of a real body
    "right_face": Shown("right face %", _percent),
    "off_cm": Shown("rest off cm, median", forms.one_decimal),
    "most_cm": Shown("90 % within cm", forms.one_decimal),
    "turn_deg": Shown("attitude off degrees, median", _degrees),
    "throw_cpu": Shown("CPU ms", forms.significant),
    "fit_right_face": Shown("half for fitting: right face %", _percent),
    "fit_off_cm": Shown("half for fitting: rest off cm", forms.one_decimal),
    "fit_turn_deg": Shown("half for fitting: degrees", _degrees),
    "other_right_face": Shown("other half: right face %", _percent),
    "other_off_cm": Shown("other half: rest off cm", forms.one_decimal),
    "other_turn_deg": Shown("other half: degrees", _degrees),
    "taken": Shown("what is taken from the record"),
    "gain_of_step": Shown("more than before, points", _percent),
    "step_off": Shown("rest off cm, median", partial(forms.fixed, digits=1)),
    "step_turn": Shown("attitude off degrees, median", forms.fixed),
    "engine_face": Shown("{}: right face %", _percent),
    "height_mm": Shown("height mm, median", forms.one_decimal),
    "sunk_mm": Shown("sunk in at rest mm", _two),
    "deepest_mm": Shown("deepest corner mm, median", forms.one_decimal),
    "later_s": Shown("rests later by s, median", forms.decimal),
    "moving": Shown("still moving"),
    "no_end": Shown("failed"),
    "trials": Shown("trials"),
    "n": Shown("n"),
    "x_mm": Shown("centre of mass, x mm", forms.one_decimal),
    "y_mm": Shown("y mm", forms.one_decimal),
    "z_mm": Shown("z mm", forms.one_decimal),
    "gravity": Shown("gravity m/s2", forms.decimal),
    "scale": Shown("lengths times", partial(forms.fixed, digits=3)),
    "fit_s": Shown("fit s", forms.fixed),
    "tried": Shown("sets tried"),
    "jitters_s": Shown("jitters s", forms.fixed),
    "verdict_changed": Shown("changed %", _percent),
    "before": Shown("preset: accuracy %", _percent),
    "after": Shown("changed: accuracy %", _percent),
    "as_reference": Shown("as the reference so changed %", _percent),
    "fails_earlier": Shown("fails earlier %", _percent),
    "parameter": Shown("parameter"),
    "preset_value": Shown("preset", forms.general),
    "label_value": Shown("label's", forms.general),
    "fitted_value": Shown("fitted", forms.general),
    "interval": Shown("interval"),
    "factor": Shown("noise times", forms.general),
    "likeliest_face": Shown("likeliest face right %", _percent),
    "its_chance": Shown("its chance %", _percent),
    "log_loss": Shown("log loss", forms.decimal),
    "brier": Shown("Brier", forms.decimal),
    "trial": Shown("trial"),
    "half": Shown("half"),
    "recorded_face": Shown("face"),
    "predicted": Shown("by engines", forms.counts),
    "impacts": Shown("impacts"),
    "departure_mm": Shown("off free flight mm", _two),
    "turned_by": Shown("turned by degrees", forms.fixed),
}
"""A part of :data:`steadyload.reports.frame_columns.COLUMNS`."""
