"""The page of a study: verdicts and cost of every method, and disagreements between them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.escaping import markdown
from steadyload.reports.charts import CostPoint, plot_cost_accuracy, plot_matrix
from steadyload.reports.page import Page, Picture, Section
from steadyload.reports.scene import plot_scene
from steadyload.reports.table import (
    MISSING,
    markdown_table,
    milliseconds,
    names,
    percent,
    significant,
)
from steadyload.runs.evaluation import ALL, MethodEvaluation
from steadyload.statistics.estimate import Estimate
from steadyload.studies.comparison.accuracy_sections import (
    LABELS_EXPLAINED,
    accuracy_sections,
)
from steadyload.studies.comparison.figures import plot_phases
from steadyload.studies.comparison.summary import (
    BeyondEnvelope,
    Comparison,
    SameTuning,
    SettingsUse,
)

_PICTURED_DISAGREEMENTS = 2


def study_page(comparison: Comparison) -> Page:
    """Compose the page of a comparison."""
    scenarios = ", ".join(comparison.scenarios)
    methods = comparison.evaluation.methods
    several = len(methods) > 1
    labelled = comparison.evaluation.labelled
    packed = f"packed from {labelled.item_lists} item lists, " if labelled else ""
    counted = "where scenarios are pooled, both count layouts, not cases"
    if labelled:
        counted = "both count item lists, not cases"
    summary = (
        f"{len(methods)} methods on {comparison.cases} cases: {comparison.layouts} "
        f"layouts, {packed}scenarios {scenarios}. "
        f"On {comparison.disputed} of {comparison.cases} cases the methods do not all agree.\n\n"
        "A *score* is the share of a layout's items that can be loaded one after the other before "
        "something moves too far; two methods *agree* on a case when they name the same failing "
        f"step. Brackets hold 95 % intervals: Wilson's for shares, bootstrap for means; {counted}. "
        "A case without a verdict counts as not stable and as no agreement; it is left out of the "
        "mean score. "
        + (
            "There are no reference labels on this page: agreement is not accuracy."
            if labelled is None
            else LABELS_EXPLAINED
        )
    )
    if comparison.refused:
        summary = (
            f"**{comparison.refused} further layouts of the files were refused**, since they are "
            f"not valid: `manifest.json` says why. They are not on this page.\n\n{summary}"
        )
    missing = comparison.missing_methods
    if comparison.missing_rows:
        summary = (
            f"**Partial: {comparison.missing_rows} rows are still missing.** Only cases that every "
            "method has judged are shown"
            + (f", without {', '.join(missing)}, which have judged none" if missing else "")
            + f"; run the study again to go on.\n\n{summary}"
        )
    sections = [
        *(accuracy_sections(comparison.evaluation) if labelled else []),
        _scores(comparison),
        *_same_tunings(comparison.tunings),
        _costs(comparison),
        *([_agreement(comparison), _disagreements(comparison)] if several else []),
        _settings(comparison.uses),
        *([_beyond(comparison.beyond)] if comparison.beyond else []),
    ]
    return Page(f"Study: {comparison.title}", summary, sections, comparison.manifest)


def _scores(comparison: Comparison) -> Section:
    evaluation, agreement = comparison.evaluation, comparison.agreement
    tables = []
    for group in evaluation.groups:
        table = _score_table(evaluation.rows[group], agreement[group])
        tables.append(table if group == ALL else f"**Scenario {group}**\n\n{table}")
    points = [(m, agreement[ALL][m.method.spec]) for m in evaluation.methods]
    shown = [CostPoint(m.method, agreed, m.cpu) for m, agreed in points if agreed is not None]
    return Section(
        "Scores and cost",
        "All cases first, then each scenario by itself. *Agreement with simulations* is the mean "
        "share of equal failing steps with all simulations that run on another engine.",
        tables,
        [
            Picture(
                "trade_off",
                plot_cost_accuracy(
                    shown,
                    y_label="agreement with simulations on other engines (%)",
                ),
                "Agreement against CPU time; good methods stand at the upper left. "
                "Colour tells the method, marker tells the engine, hollow markers have parameters "
                "of their own, bars are 95 % intervals; equal methods hide each other.",
            )
        ]
        if shown
        else [],
    )


def _score_table(
    methods: Sequence[MethodEvaluation], agreement: Mapping[str, Estimate | None]
) -> str:
    header = (
        "method",
        "n",
        "mean score %",
        "fully stable %",
        "agreement with simulations %",
        "CPU ms a layout",
        "no verdict",
    )
    return markdown_table(
        header,
        [
            (
                m.method.title,
                str(m.fully_stable.n),
                percent(m.score),
                percent(m.fully_stable),
                percent(agreement[m.method.spec]),
                milliseconds(m.cpu),
                names(f"{count} {status}" for status, count in m.without_verdict.items()),
            )
            for m in methods
        ],
    )


def _same_tunings(tunings: Sequence[SameTuning]) -> list[Section]:
    if not tunings:
        return []
    parts = []
    for tuning in tunings:
        engines = [str(row.method.engine) for row in tuning.rows]
        header = (
            "engine",
            "n",
            "mean score %",
            "fully stable %",
            *(f"agrees with {e} %" for e in engines),
            "CPU ms",
            "build / step / read ms",
            "emulated",
            "ignored",
        )
        use = {u.method.spec: u for u in tuning.uses}
        rows = [
            (
                str(row.method.engine),
                str(row.fully_stable.n),
                percent(row.score),
                percent(row.fully_stable),
                *(
                    percent(tuning.agreement.get((str(row.method.engine), engine)))
                    for engine in engines
                ),
                milliseconds(row.cpu),
                _phases(row),
                names(use[row.method.spec].emulated),
                names(use[row.method.spec].ignored),
            )
            for row in tuning.rows
        ]
        settings = ", ".join(f"{k} {v}" for k, v in tuning.settings.items())
        parts.append(f"**{tuning.title}** ({settings})\n\n{markdown_table(header, rows)}")
    return [
        Section(
            "The same tuning on every engine",
            "Equal SI values, side by side. Where an engine ignores a setting, its row answers a "
            "slightly different question; the last column says so.",
            parts,
        )
    ]


def _costs(comparison: Comparison) -> Section:
    header = ("method", "n", "CPU ms", "wall ms", "build ms", "step ms", "read ms", "other ms")
    methods = comparison.evaluation.methods
    rows = [
        (
            m.method.title,
            str(m.cpu.n),
            milliseconds(m.cpu),
            milliseconds(m.wall),
            *(
                significant(value) if m.phases.step else MISSING
                for value in (m.phases.build, m.phases.step, m.phases.read)
            ),
            significant(m.phases.other),
        )
        for m in methods
        if m.phases is not None
    ]
    pictures = []
    if any(m.phases and m.phases.step for m in methods):
        caption = "Where the CPU time of a simulation goes."
        pictures = [Picture("phases", plot_phases(methods), caption)]
    return Section(
        "Time a layout, by phase",
        "*Build* makes worlds and adds boxes, *step* is the engine's own work, *read* looks at the "
        "poses. Each worker judges a layout once before it measures. "
        f"{comparison.evaluation.cost_source.explained()}",
        [markdown_table(header, rows)],
        pictures,
    )


def _phases(row: MethodEvaluation) -> str:
    p = row.phases
    if p is None:
        return MISSING
    return f"{significant(p.build)} / {significant(p.step)} / {significant(p.read)}"


def _agreement(comparison: Comparison) -> Section:
    methods = comparison.matrix.methods
    rows = [
        (key.title, *(percent(e) for e in row))
        for key, row in zip(methods, comparison.matrix.shares, strict=True)
    ]
    return Section(
        "Agreement between every two methods",
        f"Share of equal failing steps, in per cent, n = {comparison.cases} each.",
        [markdown_table(("method", *(m.title for m in methods)), rows)],
        [
            Picture(
                "agreement",
                plot_matrix(
                    comparison.matrix.titles,
                    comparison.matrix.shares,
                    label="same failing step (%)",
                ),
                "Share of cases on which two methods name the same failing step.",
            )
        ],
    )


def _disagreements(comparison: Comparison) -> Section:
    shown = comparison.disagreements
    if not shown:
        return Section("Where they disagree", "No two methods disagree on any case.")
    titles = list(shown[0].said)
    header = ("layout", "scenario", "items", *titles)
    rows = [
        (markdown(d.layout), d.scenario, str(d.item_count), *(markdown(d.said[t]) for t in titles))
        for d in shown
    ]
    return Section(
        "Where they disagree",
        f"Of {comparison.disputed} cases with more than one answer, the {len(shown)} on which most "
        "pairs of simulations differ (of all methods, where there are no simulations): the failing "
        "step that each method names, counted from 0, or *stable*.",
        [markdown_table(header, rows, left=2)],
        [
            Picture(
                f"disagreement_{rank}",
                plot_scene(d.drawn, title=f"{d.layout}, {d.scenario}", marked=d.marked),
                f"{markdown(d.layout)}, {d.scenario}: in red, items at whose placement some "
                "method sees the loading fail; dots are centres of mass.",
            )
            for rank, d in enumerate(shown[:_PICTURED_DISAGREEMENTS], start=1)
        ],
    )


def _settings(uses: Sequence[SettingsUse]) -> Section:
    rows = [
        (
            use.method.title,
            names(use.honoured),
            names(use.emulated),
            names(use.ignored),
            ", ".join(f"{k} {v}" for k, v in use.settings.items()),
        )
        for use in uses
    ]
    header = ("method", "honoured", "emulated", "ignored", "all parameters that ask for something")
    return Section(
        "Which engine judged what, under which settings",
        "Lengths eps_t in cm and margin in m, times in s, frequency in Hz, angles in degrees. "
        "What *emulated* and *ignored* mean for each engine is said by `steadyload engines`.",
        [markdown_table(header, rows, left=5)] if rows else ["No simulations in this study."],
    )


def _beyond(found: Sequence[BeyondEnvelope]) -> Section:
    """Section of the cases beyond the envelope of an engine."""
    outside = [b for b in found if b.cases]
    rows = [
        (b.method, f"{b.cases} of {b.of}", f"{what} ({count})", f"{layout}: {sentence}")
        for b in outside
        for what, count, layout, sentence in b.reasons
    ]
    unmeasured = names(b.method for b in found if b.cases is None)
    text = (
        "Verdicts on such cases are less sure than the others; `steadyload extremes` measured how "
        "far each engine holds, and docs/extremes.md says what that covers."
        if outside
        else "No case is known to lie beyond what the engine that judged it was measured to hold."
    )
    if unmeasured != MISSING:
        text += f" Nothing was measured of the engine and frequency of {unmeasured}."
    header = ("method", "cases beyond", "by (cases)", "for example")
    tables = [markdown_table(header, rows, left=4)] if rows else []
    return Section("Beyond the engines' envelopes", text, tables)
