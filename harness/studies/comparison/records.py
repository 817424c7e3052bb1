"""Results of a comparison of methods, as small typed records."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from steadyload.layouts.model import Layout
from steadyload.methods.naming import MethodKey
from steadyload.runs.evaluation import Accuracies, AgreementMatrix, MethodSummary
from steadyload.statistics.estimate import Estimate


@dataclass(frozen=True, slots=True)
class BeyondEnvelope:
    """How many cases of a study lie beyond what the engine of a method was measured to hold.

    ``cases`` is None where nothing was measured. ``reasons``, the most frequent first: what is
    left, in how many cases, and of the first of them its layout and how far that goes.
    """

    method: str
    cases: int | None
    of: int
    reasons: tuple[tuple[str, int, str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class SettingsUse:
    """How one engine met the settings that one method asked for."""

    method: MethodKey
    settings: Mapping[str, str]
    honoured: tuple[str, ...]
    emulated: tuple[str, ...]
    ignored: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SameTuning:
    """One parameter set on several engines.

    ``agreement`` maps (engine, engine) to the share of equal failing steps.
    """

    title: str
    settings: Mapping[str, str]
    rows: tuple[MethodSummary, ...]
    uses: tuple[SettingsUse, ...]
    agreement: Mapping[tuple[str, str], Estimate]


@dataclass(frozen=True, slots=True)
class Disagreement:
    """A case on which methods differ: what each said (failing step, ``stable`` or a status).

    ``drawn``: the layout as it was judged. ``marked``: the failing steps that some method names.
    """

    layout: str
    scenario: str
    item_count: int
    said: Mapping[str, str]
    drawn: Layout
    marked: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Comparison:
    """Everything that a study's page shows."""

    title: str
    cases: int
    layouts: int
    scenarios: tuple[str, ...]
    methods: tuple[MethodSummary, ...]
    by_scenario: Mapping[str, tuple[MethodSummary, ...]]
    matrix: AgreementMatrix
    tunings: tuple[SameTuning, ...]
    uses: tuple[SettingsUse, ...]
    disagreements: tuple[Disagreement, ...]
    disputed: int
    missing_rows: int = 0
    missing_methods: tuple[str, ...] = ()
    manifest: Mapping[str, str] = field(default_factory=dict)
    accuracies: Accuracies | None = None
    beyond: tuple[BeyondEnvelope, ...] = ()
