"""The page on the convergence of the reference's labels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.escaping import markdown
from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import (
    MISSING,
    Column,
    Table,
    columns_for,
    counts,
    milliseconds,
    names,
    percent,
    significant,
    words,
)
from steadyload.runs.costs import CostKind, CostSource
from steadyload.studies.convergence.figures import (
    plot_engines_against_reference,
    plot_sweeps,
)
from steadyload.studies.convergence.summary import (
    Convergence,
    ConvergenceRow,
    LabelDispute,
)
from steadyload.studies.method_sections import NO_VERDICT, titled

_COMPARED = (
    Column("n", "changed.n"),
    Column("changed %", "changed", percent),
    Column("of stable %", "changed_stable", percent),
    Column("of unstable %", "changed_unstable", percent),
    Column("earlier"),
    Column("later"),
    Column("CPU ms", "cpu", milliseconds),
    Column("slowest ms", "slowest", significant),
    titled(NO_VERDICT, "without verdict"),
)


def convergence_page(found: Convergence, manifest: Mapping[str, str]) -> Page:
    """Compose the page; methods that have not judged are left out."""
    sections = [_reference(found), _variants(found), _engines(found.engines)]
    if found.opinions:
        sections.append(_slow_methods(found.opinions))
    sections.append(_disputes(found))
    return Page(
        "Are the reference's labels converged?",
        f"{_answer(found)}\n\nA label is the failing step of a layout by `label@reference`: every "
        "placement afresh, 0.3 s, 10 cm or 10 degrees. It is compared with itself under other "
        "numerics and other models, with other engines, and with unrelated integrators. Brackets "
        "hold 95 % intervals (Wilson for shares, bootstrap for means). "
        f"{CostSource(CostKind.ONE_PROCESS).explained()}",
        sections,
        manifest,
    )


def _answer(found: Convergence) -> str:
    changed = found.any_change
    return (
        f"Of {changed.n} labels {percent(changed)} % change under any other numerics of the "
        "reference: tolerances, dampings, stiction speeds, longest steps, and stiffnesses of "
        "1e8 N/m and more."
    )


def _reference(found: Convergence) -> Section:
    reference = found.reference
    rows = [
        ("layouts", str(reference.changed.n)),
        ("items a layout", milliseconds(found.items)),
        ("stable %", percent(found.stable)),
        ("CPU ms a layout", milliseconds(reference.cpu)),
        ("slowest, ms", significant(reference.slowest)),
        *((f"CPU ms, {band}", milliseconds(time)) for band, time in found.by_size),
        ("without verdict", counts(reference.without_verdict)),
        (f"label changes under any other numerics %, n = {found.any_change.n}",
         percent(found.any_change)),
    ]  # fmt: skip
    return Section(
        "The reference",
        "Generated layouts of at most 20 items, three classes and three scenarios. *Other "
        "numerics* are all tolerances, dampings, stiction speeds, longest steps, and stiffnesses "
        "from 1e8 N/m, of the next section together.",
        [Table(rows, [words("", 0), Column("measured", 1)])],
    )


def _variants(found: Convergence) -> Section:
    return Section(
        "Under other numerics and other models",
        "One parameter is changed at a time (with the stiffness also the damping, and the "
        "limit that makes contacts of light items softer). Changes that decide whether the labels "
        "are converged are tried on all layouts, the others on fewer. *Earlier* and "
        "*later* count layouts that then fail at an earlier or a later step.",
        [_table("change", found.variants)],
        [
            Picture(
                "sweeps",
                plot_sweeps(found.variants),
                "Changed labels against each parameter. Numerical parameters stand on a floor near "
                "zero over decades; what belongs to the question itself (time, thresholds, "
                "friction) does not.",
            )
        ],
    )


def _engines(rows: Sequence[ConvergenceRow]) -> Section:
    return Section(
        "Other engines",
        "The same question asked of other engines, untuned, at more and more substeps a second.",
        [_table("engine", rows)],
        [
            Picture(
                "engines",
                plot_engines_against_reference(rows),
                "Unrelated engines come to the reference's labels as their step shrinks: what a "
                "right answer costs.",
            )
        ],
    )


_ABOUT = {
    "integrator=radau": "the same forces, followed by scipy's Radau without groups, with "
    "tolerances ten times smaller than the label's (1e-8 m; at 1e-9 m a layout that rattles does "
    "not come to its end)",
    "contact=adams": "the contact parameters of the paper's reference simulation; each placement "
    "begins with a drop of 1 mm there, and piles that differ tip in it (without the drop they "
    "stand)",
    "label@drake": "another model of contact altogether (hydroelastic), with Drake's own error "
    "control, in a process of its own whose time is not counted",
}
"""Description of a slow method, by a part of its name."""


def _slow_methods(rows: Sequence[ConvergenceRow]) -> Section:
    asked = [
        f"`{part}`: {what}"
        for part, what in _ABOUT.items()
        if any(part in row.title for row in rows)
    ]
    return Section(
        "Second opinions",
        f"Slow judges, asked of the first layouts only. {'; '.join(asked)}.",
        [_table("judge", rows)],
    )


def _table(what: str, rows: Sequence[ConvergenceRow]) -> Table:
    return Table(rows, [words(what, "title"), *_COMPARED])


def _disputes(found: Convergence) -> Section:
    if not found.disputes:
        return Section("Disagreements", "MuJoCo and Bullet at 480 Hz agree on every layout.")
    columns = [
        words("layout", lambda d: markdown(d.layout)),
        Column("items", "item_count"),
        Column("reference", "label"),
        Column("moved", _moved),
        *columns_for(found.disputes[0].said, "{}", "said"),
        Column("label changes under", lambda d: names(d.changes_under or [f"none of {d.tried}"])),
    ]
    return Section(
        "Disagreements",
        "Every layout on which MuJoCo or Bullet at 480 Hz names another failing step. *Moved*: by "
        "how much at the reference's failing step. The last column names the changes of the "
        "reference itself that change the label, too, of those tried on this layout.",
        [Table(found.disputes, columns)],
    )


def _moved(dispute: LabelDispute) -> str:
    if dispute.displacement_cm is None or dispute.rotation_deg is None:
        return MISSING
    return f"{dispute.displacement_cm:.1f} cm, {dispute.rotation_deg:.1f} deg"
