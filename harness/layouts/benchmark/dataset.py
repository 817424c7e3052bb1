"""The labelled set as studies, learners and pages read it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from steadyload.layouts.benchmark.confidence import confidence
from steadyload.layouts.benchmark.parts import SETS, SHIPPED, Part
from steadyload.layouts.benchmark.tables import (
    LABELS,
    SCREENING,
    BenchmarkError,
    no_rows,
    read_further,
    read_tables,
)
from steadyload.layouts.files.record import shown
from steadyload.layouts.model.batch import LayoutBatch, checked_batch
from steadyload.layouts.model.batch_checks import Pallets
from steadyload.layouts.model.layout import FloatArray, Layout, LayoutError, Pallet
from steadyload.layouts.model.question import Question, question_named
from steadyload.layouts.model.scenarios import Scenario
from steadyload.reading import MAX_STORED_BYTES, content_of

KEYS = ["layout", "scenario"]
"""What names a case."""

PAPER_SIZE = 300
"""Cases a scenario in the paper's test set; the first ranks of ``test`` are such a set."""


@dataclass(frozen=True)
class Benchmark:
    """A labelled set.

    Attributes:
        layouts: a row a geometry, :data:`steadyload.layouts.benchmark.tables.LAYOUTS`, indexed by
            ``layout``.
        cases: a row a layout and scenario, :data:`steadyload.layouts.benchmark.tables.CASES`, and
            the column ``instance``.
        opinions: verdicts of further methods on some cases, by question,
            :data:`steadyload.layouts.benchmark.tables.OPINIONS`.
        manifest: what it was made with.
        notes: what people found when they looked at its disputed labels, as Markdown; its folder
            may hold them as ``notes.md``.
        further_labels: of some cases, of other questions than ``within``,
            :data:`steadyload.layouts.benchmark.tables.LABELS`.
        screening: what was seen of the steps of cases that were labelled by screening,
            :data:`steadyload.layouts.benchmark.tables.SCREENING`.
        word: of :data:`SETS`, where it was read by one; empty for the large set of the package, and
            for other folders.
    """

    layouts: pd.DataFrame
    cases: pd.DataFrame
    opinions: pd.DataFrame
    manifest: dict[str, Any]
    notes: str = ""
    further_labels: pd.DataFrame = field(default_factory=partial(no_rows, LABELS))
    screening: pd.DataFrame = field(default_factory=partial(no_rows, SCREENING))
    word: str = ""

    def labels_on(self, question: Question) -> pd.DataFrame:
        """Labels of a question, and how labelling ended without one: ``status``, ``failing_step``.

        Of ``stands`` also what moved, see :data:`steadyload.layouts.benchmark.tables.LABELS`.
        """
        return _on(self._labels, question)

    def further_verdicts_on(self, question: Question) -> pd.DataFrame:
        """Verdicts of further methods on a question."""
        return _on(self.opinions, question)

    def confidence_on(self, question: Question) -> pd.DataFrame:
        """Confidence of labels of a question, a row a case that the ensemble judged.

        See :func:`steadyload.layouts.benchmark.confidence.confidence`.
        """
        return self._confidence[question_named(question)]

    @cached_property
    def _labels(self) -> pd.DataFrame:
        own = self.cases[[*KEYS, "status", "failing_step"]].assign(question=str(Question.WITHIN))
        return pd.concat([own, self.further_labels], ignore_index=True)

    @cached_property
    def _confidence(self) -> dict[Question, pd.DataFrame]:
        return {
            question: confidence(
                labelled(self.labels_on(question)), self.further_verdicts_on(question)
            )
            for question in Question
        }

    @cached_property
    def natural_stable(self) -> dict[str, float]:
        """Share of stable cases by scenario, over all cases, whether in a split or not."""
        done = self.cases[self.cases["status"] == "done"]
        stable = done["failing_step"].isna().groupby(done["scenario"], sort=False).mean()
        return {str(scenario): float(value) for scenario, value in stable.items()}

    def select(
        self,
        part: Part | str = Part.ALL,
        *,
        scenarios: tuple[str, ...] = (),
        limit: int | None = None,
        question: Question = Question.WITHIN,
    ) -> pd.DataFrame:
        """The labelled cases of a part, in order of scenario and rank.

        Args:
            part: which; see :class:`Part`.
            scenarios: only these; empty for all.
            limit: at most this many a scenario, those of the first ranks. In ``validation`` and
                ``test`` any even number of first ranks is half stable, half unstable, by the label
                of the question ``within``.
            question: whose labels ``failing_step`` holds. For ``stands`` there are only those of
                these cases that have such a label; ``failing_step_paper`` and what was stored of a
                simulation are of the other question.

        Raises:
            BenchmarkError: no such part or scenario, or no such case.
            QuestionError: no such question.
        """
        question = question_named(question)
        if part not in list(Part):
            raise BenchmarkError(f"part is {part!r}; allowed: {', '.join(Part)}")
        known = [str(s) for s in Scenario]
        for scenario in scenarios:
            if scenario not in known:
                raise BenchmarkError(f"scenario is {scenario!r}; allowed: {', '.join(known)}")
        cases = self.cases[self.cases["status"] == "done"]
        if part != Part.ALL:
            split = Part.TEST if part == Part.TEST_300 else part
            cases = cases[cases["split"] == str(split)]
        if part == Part.TEST_300:
            cases = cases[cases["rank"] < PAPER_SIZE]
        if scenarios:
            cases = cases[cases["scenario"].isin(scenarios)]
        order = cases["scenario"].map(known.index)
        cases = cases.assign(_order=order).sort_values(["_order", "rank"], kind="stable")
        cases = cases.drop(columns="_order")
        if limit is not None:
            cases = cases[cases.groupby("scenario").cumcount() < limit]
        steps = labelled(self.labels_on(question)).set_index(KEYS)["failing_step"]
        keys = pd.MultiIndex.from_frame(cases[KEYS])
        known = keys.isin(steps.index)
        cases = cases[known].assign(failing_step=steps.reindex(keys[known]).array)
        if cases.empty:
            words = ("holds no labelled case of", str(part), *scenarios)
            raise BenchmarkError(f"{' '.join(words)} for the question {question}")
        return cases.reset_index(drop=True)

    def drawn(self, cases: pd.DataFrame) -> Benchmark:
        """Some of the cases as a set of their own, ranked in their order.

        It has their labels of both questions, and no opinions of further methods.

        Args:
            cases: rows of :attr:`cases`.
        """
        ranked = cases.assign(rank=cases.groupby("scenario").cumcount().astype("Int32"))
        keys, further = pd.MultiIndex.from_frame(cases[KEYS]), self.further_labels
        return Benchmark(
            self.layouts.loc[cases["layout"].unique()],
            ranked,
            self.opinions.head(0),
            {"origin": "drawn"},
            further_labels=further[pd.MultiIndex.from_frame(further[KEYS]).isin(keys)],
        )

    def layout(self, name: str, scenario: str) -> Layout:
        """A case's layout with its centres of mass.

        Raises:
            BenchmarkError: no such case, or its row is damaged.
            LayoutError: its row is no valid layout.
        """
        try:
            row, offsets = self._rows[name], self._offsets[name, scenario]
        except KeyError:
            raise BenchmarkError(f"no case of layout {name!r} in scenario {scenario!r}") from None
        try:
            return _layout_of(name, row, offsets)
        except LayoutError as error:
            raise error.located(layout=name) from None
        except (TypeError, ValueError):
            raise BenchmarkError(
                f"layout {shown(name)} in scenario {shown(scenario)}: its lists of numbers do not "
                "fit together, the labelled set is damaged"
            ) from None

    def batch(self, cases: pd.DataFrame) -> LayoutBatch:
        """The layouts of some cases, with their centres of mass, as arrays.

        Args:
            cases: rows of :meth:`select`; layout k of the batch is that of row k.

        Raises:
            BenchmarkError: no such case, or a row is damaged.
            LayoutError: a row is no valid layout.
        """
        names, scenarios = cases["layout"].tolist(), cases["scenario"].tolist()
        try:
            return self._batch(names, scenarios)
        except (KeyError, LayoutError, TypeError, ValueError):
            for case in zip(names, scenarios, strict=True):
                self.layout(*case)
            raise

    def _batch(self, names: list[str], scenarios: list[str]) -> LayoutBatch:
        """Raises KeyError, TypeError and ValueError where cases are missing or damaged."""
        rows = [self._rows[name] for name in names]
        offsets = [self._offsets[case] for case in zip(names, scenarios, strict=True)]
        weights = [row["weights"] for row in rows]
        starts = np.cumsum([0, *map(len, weights)], dtype=np.int64)
        shifts = [
            np.zeros(3 * len(own)) if given is None else given
            for own, given in zip(weights, offsets, strict=True)
        ]
        return checked_batch(
            starts,
            _vectors([row["positions"] for row in rows], starts),
            _vectors([row["sizes"] for row in rows], starts),
            np.concatenate([np.empty(0), *weights]),
            _vectors(shifts, starts),
            pallets=Pallets.sized(np.array([row["pallet"] for row in rows]).reshape(-1, 3)),
            names=tuple(names),
        )

    @cached_property
    def _rows(self) -> dict[str, dict[str, Any]]:
        """Rows of the table of layouts, by name."""
        keys = ("pallet", "positions", "sizes", "weights")
        columns = [self.layouts[key] for key in keys]
        cells = zip(*columns, strict=True)
        names = self.layouts.index
        return {n: dict(zip(keys, row, strict=True)) for n, row in zip(names, cells, strict=True)}

    @cached_property
    def _offsets(self) -> dict[tuple[str, str], Any]:
        return dict(
            zip(zip(self.cases["layout"], self.cases["scenario"], strict=True),
                self.cases["offsets"], strict=True)
        )  # fmt: skip


def load_benchmark(directory: str | Path | None = None) -> Benchmark:
    """Read a labelled set.

    Args:
        directory: its folder, or as a text a word of :data:`SETS` (a folder of that name in the
            working directory is ``./planar``); None reads the large set of the package.

    Raises:
        BenchmarkError: not such a folder, or a damaged one.
    """
    word = directory if isinstance(directory, str) and directory in SETS else ""
    folder = SETS[word] if word else Path(directory or SHIPPED)
    layouts, cases, opinions, manifest = read_tables(folder)
    layouts = layouts.set_index("layout")
    try:
        instance = layouts["instance"].reindex(cases["layout"])
    except ValueError:
        raise BenchmarkError(f"{folder}: a layout stands there twice") from None
    if instance.isna().any():
        missing = cases["layout"][instance.isna().to_numpy()].iloc[0]
        raise BenchmarkError(f"{folder}: layout {shown(missing)} is missing")
    unknown = cases["scenario"][~cases["scenario"].isin(list(Scenario))]
    if len(unknown):
        raise BenchmarkError(
            f"{folder}: scenario of a case is {shown(unknown.iloc[0])}; "
            f"allowed: {', '.join(Scenario)}"
        )
    cases = cases.assign(instance=instance.to_numpy())
    written = folder / "notes.md"
    notes = content_of(written, MAX_STORED_BYTES) if written.exists() else b""
    return Benchmark(
        layouts,
        cases,
        opinions,
        manifest,
        notes.decode(errors="replace"),
        further_labels=read_further(folder, "labels"),
        screening=read_further(folder, "screening"),
        word=word,
    )


def labelled(labels: pd.DataFrame) -> pd.DataFrame:
    """The rows of cases that have a label."""
    return labels[labels["status"] == "done"]


def _on(table: pd.DataFrame, question: Question) -> pd.DataFrame:
    """The rows of a question."""
    return table[table["question"] == str(question_named(question))]


def _layout_of(name: str, row: Mapping[str, Any], offsets: Any) -> Layout:
    """A layout from a row of the table of layouts and a list of offsets (None: all zero).

    Raises:
        LayoutError: the values are no valid layout.
    """
    weights = np.array(row["weights"], dtype=float)
    shape = (len(weights), 3)
    return checked_batch(
        np.array([0, len(weights)]),
        np.array(row["positions"], dtype=float).reshape(shape),
        np.array(row["sizes"], dtype=float).reshape(shape),
        weights,
        np.zeros(shape) if offsets is None else np.array(offsets, dtype=float).reshape(shape),
        pallets=Pallets.of([_pallet(*np.asarray(row["pallet"]).tolist())]),
        names=(name,),
    )[0]


@lru_cache(maxsize=1024)
def _pallet(width: float, height: float, depth: float) -> Pallet:
    return Pallet(width, height, depth)


def _vectors(cells: list[Any], starts: NDArray[np.int64]) -> FloatArray:
    """Lists of numbers, three an item, as one array of vectors.

    Raises:
        ValueError: a layout has more or fewer.
    """
    counts = np.diff(starts)
    if list(map(len, cells)) != (3 * counts).tolist():
        raise ValueError("three numbers an item")
    return np.concatenate([np.empty(0), *cells]).reshape(-1, 3)


def row_of(
    layout: Layout, instance: str, item_class: int, sources: tuple[str, ...]
) -> dict[str, Any]:
    """The row of the table of layouts for a layout; as :meth:`Benchmark.layout` reads it."""
    return {
        "layout": layout.name,
        "instance": instance,
        "item_class": item_class,
        "sources": list(sources),
        "pallet": list(layout.pallet.size),
        "positions": layout.lower.ravel().tolist(),
        "sizes": [side for item in layout.items for side in item.size],
        "weights": layout.weights.tolist(),
    }


def stored_offsets(layout: Layout) -> list[float] | None:
    """The cell ``offsets`` of the table of cases for a layout; None where all are zero."""
    offsets = layout.mass_offsets
    return offsets.ravel().tolist() if offsets.any() else None
