"""Sections on the splits, the files, the trainings, and what the figures depend on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from steadyload.escaping import markdown
from steadyload.reports.pages.page import Section
from steadyload.reports.table import (
    Column,
    Table,
    names,
    percent,
    plain_percent,
    significant,
    words,
)
from steadyload.runs.evaluation import ALL
from steadyload.studies.replication.splits import TABLE_2, SplitKind
from steadyload.studies.replication.summary import (
    GROUPS,
    MethodRow,
    ReplicationSummary,
)

KINDS: Mapping[SplitKind, str] = {
    SplitKind.FILE: "file",
    SplitKind.FEWER: "file, fewer",
    SplitKind.GEOMETRY: "geometry",
    SplitKind.LIST: "item list",
}
"""Words for splits."""


def method_table(rows: Sequence[MethodRow]) -> Table:
    """Methods that learn nothing, with the paper's figure of all scenarios beside ours."""
    return Table(
        rows,
        [
            words("method", "line.title"),
            *(
                Column(
                    f"{'all' if group == ALL else group} %",
                    lambda row, group=group: row.accuracy[group],  # type: ignore[misc]
                    percent,
                )
                for group in GROUPS
            ),
            Column("the paper, all %", lambda row: row.paper.get(ALL), plain_percent),
        ],
    )


def costs_section(found: ReplicationSummary) -> Section:
    """Section of the cost of the methods that learn nothing, and of their missing verdicts."""
    return Section(
        "Cost, and cases without a verdict",
        "CPU time of judging, beside whatever else the machine did: the timing pass is that of "
        "[table5](../table5/report.md). A case without a verdict counts as wrong.",
        [
            Table(
                found.methods,
                [
                    words("method", "line.title"),
                    Column("test files", lambda row: row.accuracy[ALL].n),
                    Column("no verdict", "lost"),
                    Column("CPU ms", "cpu", significant),
                ],
            )
        ],
    )


def splits_section(found: ReplicationSummary) -> Section:
    """Section of the splits and of the twins in them."""
    columns = [
        words("split by", lambda row: KINDS[row.kind]),
        Column("trainings"),
        Column("training cases", lambda row: _between(row.cases)),
        *(
            Column(
                f"{group}, twin in training %",
                lambda row, group=group: row.twins[group],  # type: ignore[misc]
                percent,
            )
            for group in GROUPS[:-1]
        ),
    ]
    memorised = [row for row in found.learned if row.kind is SplitKind.FILE]
    return Section(
        "Twins",
        "A twin is another file with the same geometry. Many of the 160 heuristics pack a bin "
        "alike, and centres of mass were drawn file by file: in S1 twins are one case under two "
        "names, with one label; in S2a and S2b their labels may differ.",
        [
            Table(found.splits, columns),
            Table(
                memorised,
                [
                    words("split by file", "name"),
                    Column("n", "with_twin.n"),
                    Column("with a twin %", "with_twin", percent),
                    Column("n ", "without_twin.n"),
                    Column("without %", "without_twin", percent),
                ],
                "Accuracy on the test files with a twin in the training of their scenario, and on "
                "the others:",
            ),
        ],
    )


def counts_section(found: ReplicationSummary) -> Section:
    """Section of the files beside Table 2 of the paper."""
    sizes = {name: sum(size.validation) for name, size in TABLE_2.items()}
    missing = (
        f" {found.unlabelled} have no label and take part in nothing." if found.unlabelled else ""
    )
    return Section(
        "Files",
        f"{found.files} files of {found.geometries} geometries and {found.lists} item lists"
        f"{' (every third of the data set)' if found.quick else ''}; the paper has 9,689 files. "
        "Validation and test are drawn as in its Table 2 "
        f"({names(f'{count} in {name}' for name, count in sizes.items())} for validation, 300 for "
        f"the test, half of them stable).{missing}",
        [
            Table(
                found.counts,
                [
                    words("scenario"),
                    Column("files", "labelled"),
                    Column("distinct cases", "distinct"),
                    Column("stable %", "stable", percent),
                    Column("validation"),
                    Column("test"),
                ],
            )
        ],
    )


def trainings_section(found: ReplicationSummary) -> Section:
    """Section of the trainings: epochs and time."""
    return Section(
        "Trainings",
        "Networks, learning rates and the optimiser are those of Table 4, on the features of the "
        f"paper's Fig. 2; at most {found.epochs} epochs (the paper: 700). The epoch with the "
        "highest accuracy on the validation files counts. *Cut off*: trainings that the time "
        "budget ended.",
        [
            Table(
                found.efforts,
                [
                    words("network", "name"),
                    words("split by", lambda row: KINDS[row.kind]),
                    Column("trainings", lambda row: f"{row.trainings}, {row.cut_off} cut off"),
                    Column("epochs", lambda row: _between(row.epochs)),
                    Column("best epoch", lambda row: _between(row.best)),
                    Column("hours", "hours", significant),
                ],
            )
        ],
    )


def depends_section(found: ReplicationSummary) -> Section:
    """Section on what was inferred, and what cannot be had."""
    reasons = "".join(
        f"\n\n**Left out.** `{spec}`: {markdown(why)}." for spec, why in found.left_out.items()
    )
    return Section(
        "What these figures depend on",
        "**The data set is a rebuild.** The authors' own could not be had here. Item lists, the "
        "order of the heuristics and the number of items of a list are read off the names of "
        "their files; weights are 250 kg/m3, since the paper names no density (`--weights authors` "
        "takes the law of their code). Labels come from the reference simulator, theirs from MSC "
        "ADAMS.\n\n"
        "**That the paper split by file is inferred.** Its Table 2 splits every scenario by itself "
        "and names neither geometries nor item lists; that networks learnt from all scenarios "
        "together is taken from its totals.\n\n"
        "**Differences between scenarios** are between different test files, half of them stable "
        f"in every scenario.{reasons}",
    )


def _between(ends: tuple[int, int]) -> str:
    least, most = ends
    return str(most) if least == most else f"{least} to {most}"
