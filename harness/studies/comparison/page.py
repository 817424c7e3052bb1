"""The page of a study: verdicts and cost of every method, and disagreements between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.escaping import markdown
from steadyload.reports.charts.front import front
from steadyload.reports.charts.scene import scene
from steadyload.reports.pages.page import Page, Picture, Section
from steadyload.reports.table import (
    MISSING,
    Column,
    Table,
    columns_for,
    markdown_table,
    names,
    percent,
    significant,
    words,
)
from steadyload.runs.evaluation import ALL, Evaluation, LabelledPart, MethodEvaluation, PhaseTimes
from steadyload.studies import method_sections as column
from steadyload.studies.agreement_section import agreement_picture
from steadyload.studies.comparison.figures import plot_phases
from steadyload.studies.comparison.summary import (
    BeyondEnvelope,
    Comparison,
    SameTuning,
    SettingsUse,
)
from steadyload.studies.method_sections import best_in_words, by_group, terms_explained

_PICTURED_DISAGREEMENTS = 2

_NEAR = 0.02
"""Largest difference to the best accuracy at which a method counts as nearly as accurate."""

_LABELS_EXPLAINED = (
    "A *label* is the failing step that the labelled set keeps for a case, found once by the "
    "reference simulator; *accuracy* is the share of cases on which a method names the same one."
)
_MARKS_EXPLAINED = (
    "good methods stand at the upper left. Colour tells the method, marker tells the engine, "
    "hollow markers have parameters of their own, bars are 95 % intervals; equal methods hide each "
    "other."
)


def study_page(comparison: Comparison) -> Page:
    """Compose the page of a comparison."""
    found = comparison.evaluation
    several = len(found.methods) > 1
    sections = [
        *([_accuracy(found, found.labelled)] if found.labelled else []),
        *([_behind(found)] if found.labelled and several else []),
        _scores(comparison),
        *([_same_tunings(comparison.tunings)] if comparison.tunings else []),
        _costs(found),
        *([_agreement(comparison), _disagreements(comparison)] if several else []),
        _settings(comparison.uses),
        *([_beyond(comparison.beyond)] if comparison.beyond else []),
    ]
    summary = _partial(comparison) + _refused(comparison) + _summary(comparison, found.labelled)
    return Page(f"Study: {comparison.title}", summary, sections, comparison.manifest)


def _summary(comparison: Comparison, labelled: LabelledPart | None) -> str:
    packed = f"packed from {labelled.item_lists} item lists, " if labelled else ""
    counted = "where scenarios are pooled, both count layouts, not cases"
    if labelled:
        counted = "both count item lists, not cases"
    best = best_in_words(comparison.evaluation.methods, _NEAR) if labelled else ""
    return (
        f"{best}{len(comparison.evaluation.methods)} methods on {comparison.cases} cases: "
        f"{comparison.layouts} layouts, {packed}scenarios {', '.join(comparison.scenarios)}. "
        f"On {comparison.disputed} of {comparison.cases} cases the methods do not all agree.\n\n"
        "A *score* is the share of a layout's items that can be loaded one after the other before "
        "something moves too far; two methods *agree* on a case when they name the same failing "
        f"step. Brackets hold 95 % intervals: Wilson's for shares, bootstrap for means; {counted}. "
        "A case without a verdict counts as not stable and as no agreement; it is left out of the "
        "mean score. "
        + (
            _LABELS_EXPLAINED
            if labelled
            else "There are no reference labels on this page: agreement is not accuracy."
        )
    )


def _partial(comparison: Comparison) -> str:
    """Paragraph on rows that are still missing; empty where all are there."""
    if not comparison.missing_rows:
        return ""
    missing = ", ".join(comparison.missing_methods)
    without = f", without {missing}, which have judged none" if missing else ""
    return (
        f"**Partial: {comparison.missing_rows} rows are still missing.** Only cases that every "
        f"method has judged are shown{without}; run the study again to go on.\n\n"
    )


def _refused(comparison: Comparison) -> str:
    """Paragraph on layouts that are not valid; empty where all are."""
    if not comparison.refused:
        return ""
    one = comparison.refused == 1
    what, they = (
        ("layout of the files was", "it is") if one else ("layouts of the files were", "they are")
    )
    return (
        f"**{comparison.refused} further {what} refused**, since {they} not valid: `manifest.json` "
        f"says why. {they.capitalize()} not on this page.\n\n"
    )


def _accuracy(found: Evaluation, about: LabelledPart) -> Section:
    columns = [
        column.METHOD, column.N, column.ACCURACY, column.CPU, column.OVER, column.UNDER,
        column.STABLE_OR_NOT, column.WITHIN_ONE,
    ]  # fmt: skip
    more = [*column.natural_prevalence(about), column.WALL, column.NO_VERDICT]

    further = {"stands": ", until all rests"} if about.stands else {}
    shown = front(found.methods, groups=column.by_title(found), more=further)

    def table(group: str) -> Table:
        rows = found.rows[group]
        asked = column.of_stands(about)
        return Table(rows, [*columns, *asked, *column.robust_and_fragile(rows), *more])

    return Section(
        "Accuracy and cost",
        f"Part `{about.part}` of the labelled set: {about.cases} cases, of which {about.stable} "
        f"are stable, {about.robust} have a robust label and {about.fragile} a fragile one. All "
        f"cases first, then each scenario by itself.\n\n{terms_explained(about)} *Stable or "
        "not*: both say that the whole layout is stable, or both that it is not. *Within one*: the "
        "numbers of items placed safely differ by at most one. A case without a verdict counts as "
        "wrong in every accuracy, and as neither over- nor underestimated. Intervals stand on the "
        f"{about.item_lists} item lists.{column.stands_explained(about)} "
        f"{found.cost_source.explained()}",
        by_group(found.groups, table),
        [
            Picture(
                "accuracy",
                shown.figure,
                f"Accuracy against CPU time; {_MARKS_EXPLAINED}",
                shown.interactive,
            ),
            *_stands(found, about),
        ],
    )


def _stands(found: Evaluation, about: LabelledPart) -> list[Picture]:
    """The same by the labels of the question ``stands``, where there are any."""
    if not about.stands:
        return []
    label = "stands (% of cases with that label's step)"
    figure = front(found.methods, y="stands", y_label=label).figure
    caption = (
        f"Accuracy where it is asked whether a load stands, against CPU time; {_MARKS_EXPLAINED}"
    )
    return [Picture("stands", figure, caption)]


def _behind(found: Evaluation) -> Section:
    best = next(m for m in found.methods if m.behind is None)
    others = [m for m in found.methods if m.behind is not None]
    columns = [column.METHOD, Column("n", "behind.n"), Column("difference", "behind", percent)]
    return Section(
        "Behind the most accurate method",
        f"Accuracy minus that of {best.method.title}, on the same cases, in percentage points. "
        "An interval that holds 0 tells no difference.",
        [Table(others, columns)],
    )


def _scores(comparison: Comparison) -> Section:
    found, agreement = comparison.evaluation, comparison.agreement

    def table(group: str) -> Table:
        agreed = column.by_spec("agreement with simulations %", agreement[group], percent)
        cpu = column.titled(column.CPU, "CPU ms a layout")
        return Table(
            found.rows[group],
            [column.METHOD, *column.SCORED, agreed, cpu, column.NO_VERDICT],
        )

    points = [(m, agreement[ALL][m.method.spec]) for m in found.methods]
    shown = [
        {"method": m.method, "cpu": m.cpu, "agreement": agreed}
        for m, agreed in points
        if agreed is not None
    ]
    label = "agreement with simulations on other engines (%)"
    caption = f"Agreement against CPU time; {_MARKS_EXPLAINED}"
    return Section(
        "Scores and cost",
        "All cases first, then each scenario by itself. *Agreement with simulations* is the mean "
        "share of equal failing steps with all simulations that run on another engine.",
        by_group(found.groups, table),
        [Picture("trade_off", front(shown, y="agreement", y_label=label).figure, caption)]
        if shown
        else [],
    )


def _same_tunings(tunings: Sequence[SameTuning]) -> Section:
    return Section(
        "The same tuning on every engine",
        "Equal SI values, side by side. Where an engine ignores a setting, its row answers a "
        "slightly different question: its settings are named under *ignored*.",
        [_engines(tuning) for tuning in tunings],
    )


def _engines(tuning: SameTuning) -> Table:
    """A row an engine, and its agreement with each of the others."""
    use = {u.method.spec: u for u in tuning.uses}
    agreement = columns_for(
        [str(row.method.engine) for row in tuning.rows], "agrees with {} %",
        lambda row, other: tuning.agreement.get((str(row.method.engine), other)), percent,
    )  # fmt: skip
    return Table(
        tuning.rows,
        [
            words("engine", "method.engine"),
            column.N_SCORED,
            *agreement,
            column.CPU,
            column.SCORE,
            column.FULLY_STABLE,
            Column("build / step / read ms", "phases", _phases),
            Column("emulated", lambda row: use[row.method.spec].emulated, names),
            Column("ignored", lambda row: use[row.method.spec].ignored, names),
        ],
        f"**{tuning.title}**{f' ({_listed(tuning.settings)})' if tuning.settings else ''}",
    )


def _phases(found: PhaseTimes | None) -> str:
    if found is None:
        return MISSING
    return " / ".join(significant(each) for each in (found.build, found.step, found.read))


def _listed(settings: Mapping[str, str]) -> str:
    return ", ".join(f"{name} {value}" for name, value in settings.items())


def _costs(found: Evaluation) -> Section:
    def time(row: MethodEvaluation, phase: str) -> float | None:
        assert row.phases is not None, "only methods with phases are shown"
        return getattr(row.phases, phase) if row.phases.step else None

    rows = [row for row in found.methods if row.phases is not None]
    columns = [
        column.METHOD, column.N_TIMED, column.CPU, column.WALL,
        *columns_for(("build", "step", "read"), "{} ms", time, significant),
        Column("other ms", "phases.other", significant),
    ]  # fmt: skip
    simulated = any(row.phases and row.phases.step for row in rows)
    caption = "Where the CPU time of a simulation goes."
    return Section(
        "Time a layout, by phase",
        "*Build* makes worlds and adds boxes, *step* is the engine's own work, *read* looks at the "
        "poses. Each worker judges a layout once before it measures. "
        f"{found.cost_source.explained()}",
        [Table(rows, columns)],
        [Picture("phases", plot_phases(found.methods), caption)] if simulated else [],
    )


def _agreement(comparison: Comparison) -> Section:
    matrix = comparison.matrix
    columns = columns_for(
        range(len(matrix.titles)), matrix.titles.__getitem__, lambda row, at: row[1][at], percent
    )
    return Section(
        "Agreement between every two methods",
        f"Share of equal failing steps between two different methods, in per cent, "
        f"n = {comparison.cases} each.",
        [
            Table(
                list(zip(matrix.titles, matrix.shares, strict=True)), [words("method", 0), *columns]
            )
        ],
        [agreement_picture(matrix)],
    )


def _disagreements(comparison: Comparison) -> Section:
    shown = comparison.disagreements
    if not shown:
        return Section("Where they disagree", "No two methods disagree on any case.")
    return Section(
        "Where they disagree",
        f"Of {comparison.disputed} cases with more than one answer, the {len(shown)} on which most "
        "pairs of simulations differ (of all methods, where there are no simulations): the failing "
        "step that each method names, counted from 0, or *stable*.",
        [Table(shown, [*column.CASE, *columns_for(shown[0].said, "{}", "said", markdown)])],
        [
            Picture(
                f"disagreement_{rank}",
                scene(d.drawn, title=f"{d.layout}, {d.scenario}", marked=d.marked).figure,
                f"{markdown(d.layout)}, {d.scenario}: in red, items at whose placement some "
                "method sees the loading fail; dots are centres of mass.",
            )
            for rank, d in enumerate(shown[:_PICTURED_DISAGREEMENTS], start=1)
        ],
    )


def _settings(uses: Sequence[SettingsUse]) -> Section:
    columns = [
        column.METHOD,
        *(words(use, form=names) for use in ("honoured", "emulated", "ignored")),
        words("all parameters that ask for something", "settings", _listed),
    ]
    return Section(
        "Which engine judged what, under which settings",
        "Lengths eps_t in cm and margin in m, times in s, frequency in Hz, angles in degrees. "
        "What *emulated* and *ignored* mean for each engine is said by `steadyload engines`.",
        [Table(uses, columns)] if uses else ["No simulations in this study."],
    )


def _beyond(found: Sequence[BeyondEnvelope]) -> Section:
    """Section of the cases beyond the envelope of an engine."""
    rows = [
        (b.method, f"{b.cases} of {b.of}", f"{what} ({count})", f"{layout}: {sentence}")
        for b in found
        if b.cases
        for what, count, layout, sentence in b.reasons
    ]
    unmeasured = [b.method for b in found if b.cases is None]
    text = (
        "Verdicts on such cases are less sure than the others; `steadyload extremes` measured how "
        "far each engine holds, and docs/extremes.md says what that covers."
        if any(b.cases for b in found)
        else "No case is known to lie beyond what the engine that judged it was measured to hold."
    )
    if unmeasured:
        text += f" Nothing was measured of the engine and frequency of {names(unmeasured)}."
    header = ("method", "cases beyond", "by (cases)", "for example")
    tables = [markdown_table(header, rows, left=4)] if rows else []
    return Section("Beyond the engines' envelopes", text, tables)
