"""What a page shows, as small typed records.

Whoever computes something (a study, a learner, a property test) fills these in; whoever draws reads
nothing else. A table, a figure and a web page of the same record show the same numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from steadyload.studies.comparison.records import BeyondEnvelope

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Estimate:
    """A number with its 95 % interval and the number of cases behind it."""

    value: float
    low: float
    high: float
    n: int


@dataclass(frozen=True, slots=True)
class MethodKey:
    """How a method is named and recognised: ``family`` fixes its colour, ``engine`` its marker."""

    title: str
    spec: str
    family: str
    engine: str | None = None


@dataclass(frozen=True, slots=True)
class PhaseTimes:
    """Mean CPU time a layout by phase [ms]."""

    build: float
    step: float
    read: float
    other: float


@dataclass(frozen=True, slots=True)
class MethodSummary:
    """One method over all cases of a study.

    ``agreement`` is the mean agreement with the simulations on *other* engines, None where there is
    none to compare with. Times are a layout, in ms.
    """

    method: MethodKey
    score: Estimate
    stable: Estimate
    agreement: Estimate | None
    cpu: Estimate
    wall: Estimate
    phases: PhaseTimes
    without_verdict: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class AgreementMatrix:
    """Share of equal failing steps between every two methods."""

    methods: tuple[MethodKey, ...]
    shares: tuple[tuple[Estimate, ...], ...]


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
class Scene:
    """A layout to draw: corners (n, 3) [cm], y up, in loading order; ``marked`` items stand out."""

    title: str
    contour: tuple[float, float, float]
    lower: FloatArray
    upper: FloatArray
    mass_centres: FloatArray
    marked: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Disagreement:
    """A case on which methods differ: what each said (failing step, ``stable`` or a status)."""

    layout: str
    scenario: str
    item_count: int
    said: Mapping[str, str]
    scene: Scene


@dataclass(frozen=True, slots=True)
class AccuracySummary:
    """One method against the labels: shares of cases.

    ``accuracy``: the failing step is the label's. ``over``, ``under``: it is later, earlier; a
    stable layout fails later than all. ``stable``: both say stable, or neither does.
    ``within_one``: the numbers of items placed safely differ by at most one. ``robust``,
    ``fragile``: accuracy on cases whose label is so. ``natural``: accuracy at the natural share of
    stable layouts. Estimates that no case speaks of have n = 0. Times are a layout, in ms.
    ``behind``: accuracy minus that of the most accurate method on the same cases, None for that
    method itself. A case without a verdict counts as wrong, and as neither over nor under.
    """

    method: MethodKey
    accuracy: Estimate
    over: Estimate
    under: Estimate
    stable: Estimate
    within_one: Estimate
    robust: Estimate
    fragile: Estimate
    natural: Estimate
    cpu: Estimate
    wall: Estimate
    without_verdict: Mapping[str, int]
    behind: Estimate | None = None


@dataclass(frozen=True, slots=True)
class Accuracies:
    """All methods against the labels of a part of a labelled set.

    ``stable``, ``robust``, ``fragile``: cases whose label is so; what is neither robust nor fragile
    was not asked. ``natural_stable``: share of stable layouts by scenario in the whole set.
    """

    part: str
    cases: int
    instances: int
    stable: int
    robust: int
    fragile: int
    natural_stable: Mapping[str, float]
    methods: tuple[AccuracySummary, ...]
    by_scenario: Mapping[str, tuple[AccuracySummary, ...]]


@dataclass(frozen=True, slots=True)
class TradeOff:
    """A method's place between a share [0 to 1] and CPU time a layout [ms]."""

    method: MethodKey
    share: Estimate
    cpu: Estimate


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


@dataclass(frozen=True, slots=True)
class SpeedPoint:
    """Cost of one layout [CPU ms, medians over ``repeats``].

    ``floor`` is the engine's own stepping, ``create`` the adding of boxes; None where they were not
    measured.
    """

    item_count: int
    total: float
    build: float
    step: float
    read: float
    floor: float | None
    create: float | None
    repeats: int


@dataclass(frozen=True, slots=True)
class SpeedCurve:
    """Cost against the number of items: one engine, one scene, one scope."""

    engine: str
    scene: str
    scope: str
    points: tuple[SpeedPoint, ...]
    exponent: float


@dataclass(frozen=True, slots=True)
class Throughput:
    """Layouts a second [1/s, wall time] over one process and over two."""

    engine: str
    layouts: int
    one: float
    two: float


@dataclass(frozen=True, slots=True)
class ScaleStep:
    """What one process needed for a step: wall and CPU time [s], the most memory [MiB]."""

    wall: float
    cpu: float
    peak: float


@dataclass(frozen=True, slots=True)
class ScalePoint:
    """What a study of so many rows needs; ``size`` of its folder [MiB].

    ``run`` is the process that coordinates and writes, ``load`` reads all columns of all rows,
    ``report`` makes what a page shows.
    """

    rows: int
    layouts: int
    size: float
    run: ScaleStep
    load: ScaleStep
    report: ScaleStep


@dataclass(frozen=True, slots=True)
class EngineAgreement:
    """Engines against each other at one frequency [Hz]; ``cpu`` in ms a layout."""

    frequency: int
    stable: Mapping[str, Estimate]
    cpu: Mapping[str, Estimate]
    agreement: Mapping[tuple[str, str], Estimate]


@dataclass(frozen=True, slots=True)
class OptionEffect:
    """What an option changes on one engine.

    ``changed``: share of layouts with another failing step. ``ratio``: CPU time with the option
    over that without. ``cpu``: with it, in ms a layout.
    """

    option: str
    engine: str
    changed: Estimate
    ratio: float
    cpu: Estimate


@dataclass(frozen=True, slots=True)
class ClosedFormTest:
    """A question that mechanics answers.

    ``series`` is the heading; tests that differ in one number share it and have that number as
    ``argument``, named ``argument_name``. ``expected`` is in ``unit``. An error is the difference
    in ``unit``, or in per cent of the expected value where ``relative``. ``resolution``, in the
    unit of the error: smaller errors are not told from none. ``when_soft``: why an engine with
    compliant contact and regularised friction cannot be exact here, however small its steps.
    """

    name: str
    series: str
    definition: str
    expected: float
    unit: str
    relative: bool
    resolution: float
    argument: float | None = None
    argument_name: str = ""
    when_soft: str = ""

    @property
    def error_unit(self) -> str:
        """Per cent, or the unit of what was measured."""
        return "%" if self.relative else self.unit


@dataclass(frozen=True, slots=True)
class ClosedFormResult:
    """What one engine answered: ``found`` in the test's unit, ``error`` in its error unit.

    ``frequency`` is None for an engine that chooses its own steps. ``note`` says why there is no
    value, or what is special about it.
    """

    test: str
    engine: str
    frequency: int | None
    found: float | None
    error: float | None
    note: str = ""


@dataclass(frozen=True, slots=True)
class ConvergenceRow:
    """A changed reference, or another judge, against the reference itself.

    ``changed``: share of layouts with another label; ``changed_stable`` of those that the reference
    calls stable, ``changed_unstable`` of the others. ``earlier``, ``later``: layouts that fail at
    an earlier or later step. ``cpu``, ``slowest`` in ms a layout. ``value`` is a place on an axis.
    """

    group: str
    title: str
    spec: str
    value: float | None
    changed: Estimate
    changed_stable: Estimate
    changed_unstable: Estimate
    earlier: int
    later: int
    cpu: Estimate
    slowest: float
    without_verdict: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class LabelDispute:
    """A layout that another judge labels otherwise: failing steps, ``stable`` or a status.

    ``displacement`` [cm] and ``rotation`` [degrees] are those of the reference at its failing step.
    ``changes_under`` names those changes of the reference, of ``tried`` ones, that change the
    label, too.
    """

    layout: str
    item_count: int
    label: str
    displacement: float | None
    rotation: float | None
    said: Mapping[str, str]
    tried: int
    changes_under: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Convergence:
    """How firm the reference's labels are.

    ``any_change``: share of layouts whose label changes under any change of the numerics.
    ``by_size``: CPU time of the reference in ms a layout, by number of items.
    """

    items: Estimate
    stable: Estimate
    reference: ConvergenceRow
    variants: tuple[ConvergenceRow, ...]
    engines: tuple[ConvergenceRow, ...]
    opinions: tuple[ConvergenceRow, ...]
    any_change: Estimate
    by_size: tuple[tuple[str, Estimate], ...]
    disputes: tuple[LabelDispute, ...]


@dataclass(frozen=True, slots=True)
class EngineSettings:
    """An engine's declared answers: setting -> (how it is met, a note)."""

    name: str
    title: str
    dimensions: int
    answers: Mapping[str, tuple[str, str]]
    notes: str
