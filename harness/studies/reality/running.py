"""Everything that the study measures: the record, fits, releases, jitters, and labels."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TypeVar

from steadyload.engines.registry import (
    capabilities,
    engines,
    engines_here,
    missing_packages,
    package_versions,
    world_class,
)
from steadyload.engines.world import Support
from steadyload.measured.errors import MotionError
from steadyload.methods.registry import make_method
from steadyload.methods.tuned import TUNED, tuned
from steadyload.runs.evaluation import Evaluation
from steadyload.studies.kit import Asked, Lab
from steadyload.studies.reality.chances import AS_MEASURED, FACTORS, chosen_factor, loss
from steadyload.studies.reality.fitting import Fitted, FitUnit, genes_on
from steadyload.studies.reality.loading import judged
from steadyload.studies.reality.record import (
    FIT,
    MEASURED,
    Record,
    Recorded,
    RecordUnit,
    note_record,
    open_record,
)
from steadyload.studies.reality.releasing import (
    AS_RECORDED,
    Batch,
    Jittered,
    JitterUnit,
    ReleasedUnit,
    Taken,
    by_flights,
    is_slow,
    made_on_engine,
    simulation_of,
)
from steadyload.tuning.space import spec_of

FREQUENCY = 480
"""Substeps a second, but of presets; as of labels."""

JITTERS = 24
"""Released states within the noise for each trial."""

LAYOUTS = 300
"""Layouts of the labelled set that are judged with fitted contacts, too."""

SEED = 0
"""Of the halves, the search and the jitters."""

CENTRE = "centre of mass by flights"
"""Title of the step of :func:`steps_of_the_body` that takes it."""

R = TypeVar("R")


class Way(StrEnum):
    """Where the parameters of a contact, and the body, are from."""

    IDENTIFIED = "identified"
    PRESET = "preset"
    FITTED = "fitted"


@dataclass(frozen=True)
class ByEngine:
    """All that is known of an engine.

    Attributes:
        name: registered.
        slow: whether it is run once a trial, without jitters: the reference, or one that checks.
        preset, label: specs of loading: its preset, and the label's simulation.
        batches: by way; without the identified one where the record states no friction.
        steps: by title of :func:`steps_of_the_body`, with identified contacts; empty for a slow
            engine, or where the record states no friction.
        fitted: contacts.
        jittered: by half and factor of the noise; empty for a slow engine.
        evaluation: of layouts; None of an engine that only checks others.
    """

    name: str
    slow: bool
    preset: str
    label: str
    batches: Mapping[Way, Batch]
    steps: Mapping[str, Batch]
    fitted: Fitted
    jittered: Mapping[tuple[str, float], Jittered] = field(default_factory=dict)
    evaluation: Evaluation | None = None

    @property
    def title(self) -> str:
        """Its title."""
        return capabilities(self.name).title

    @property
    def restitution(self) -> Support:
        """Its support of a coefficient of restitution."""
        return capabilities(self.name).settings["restitution"].support

    @property
    def slides_badly(self) -> bool:
        """Whether it declares to fail the check of a fast slide."""
        return any(one.check == "a_fast_slide" for one in capabilities(self.name).known_failures)

    @property
    def is_reference(self) -> bool:
        """Whether labels are made by it: it chooses its own steps."""
        return capabilities(self.name).error_controlled

    @property
    def is_timed(self) -> bool:
        """Whether its CPU time is known: that of an engine in a process of its own is not."""
        return not engines()[self.name].check_only

    def trial_ms(self, trials: int) -> float | None:
        """CPU time of a trial from its release to rest, on average over all sets tried [ms]."""
        return (
            1e3 * self.fitted.cpu_s / (len(self.fitted.tried) * trials) if self.is_timed else None
        )


@dataclass(frozen=True)
class AllMeasured:
    """Results of the study.

    ``engines``: those with rows, in the order of the registry. ``missing``: titles of slow engines
    whose rows are not complete. ``taken``: the body as its flights show it.
    """

    recorded: Recorded
    engines: Sequence[ByEngine]
    missing: Sequence[str]
    taken: Taken
    made_with: Mapping[str, str]


def able_engines() -> tuple[str, ...]:
    """Installed engines of three dimensions that take a body in flight."""
    here = engines_here()
    found = []
    for name, entry in engines().items():
        if name in here or (entry.check_only and not missing_packages(name)):
            facts = capabilities(name)
            if facts.dimensions == 3 and facts.in_flight.support is not Support.IGNORED:
                found.append(name)
    return tuple(found)


def steps_of_the_body(flight: Taken, *, has_inertia: bool) -> dict[str, Taken]:
    """Ways to take the body and its release, each with one thing more than the one before."""
    found = {
        "first frame, uniform density": Taken(first_frame=True, uniform=True),
        "all frames of the flight": Taken(uniform=True),
    }
    if has_inertia:
        found["moments of inertia as stated"] = AS_RECORDED
    found[CENTRE] = Taken(offset=flight.offset)
    found["lengths by flights"] = flight
    return found


def measured(
    lab: Lab,
    data: Path | None = None,
    profile: Path | None = None,
    limit: int | None = None,
    reference: bool = False,
) -> AllMeasured:
    """Measure what is missing, by the options of the study, and read the rest.

    Raises:
        MotionError: see :func:`steadyload.studies.reality.record.open_record`; trials are to be
            simulated, and the file is not here.
    """
    if reference:
        world_class("reference")
    record = open_record(lab.work, data, profile, limit)
    unit = RecordUnit(record, SEED, package_versions(("numpy", "scipy")))
    [recorded], made_with = lab.measure([unit], Recorded, folder="record")
    note_record(lab.work, record)
    taken = by_flights(recorded.fitted_flight)
    found, missing = [], []
    for name in able_engines():
        of_engine = _Runs(lab, record, recorded, taken, name, min(LAYOUTS, limit or LAYOUTS))
        one = of_engine.run(measure=reference or not is_slow(name))
        if one is None:
            missing.append(capabilities(name).title)
        else:
            found.append(one)
    if not found:
        raise MotionError(
            f"no rows of {', '.join(missing)}; allowed: --reference, which simulates them"
        )
    return AllMeasured(recorded, found, missing, taken, made_with)


@dataclass(frozen=True)
class _Runs:
    """Measurements of one engine."""

    lab: Lab
    record: Record
    recorded: Recorded
    taken: Taken
    engine: str
    layouts: int

    def run(self, *, measure: bool) -> ByEngine | None:
        """All of it; None where rows are missing and nothing is to be measured."""
        slow, made = is_slow(self.engine), made_on_engine(self.engine)
        rows = partial(_rows, self.lab, measure)
        fitting = rows([self._fit()], Fitted, "fitted")
        if fitting is None:
            return None
        [fitted] = fitting
        preset = f"{TUNED if self.engine in tuned() else 'label'}@{self.engine}"
        identified = self._identified()
        ways = {Way.PRESET: (_spelled(preset), AS_RECORDED), Way.FITTED: (fitted.spec, self.taken)}
        steps: dict[str, Taken] = {}
        if identified is not None:
            ways = {Way.IDENTIFIED: (identified, AS_RECORDED), **ways}
            has_inertia = self.recorded.inertia is not None
            steps = {} if slow else steps_of_the_body(self.taken, has_inertia=has_inertia)
        units = [
            *(ReleasedUnit(self.record, spec, taken, made) for spec, taken in ways.values()),
            *(ReleasedUnit(self.record, identified or "", t, made) for t in steps.values()),
        ]
        batches = rows(units, Batch, "released", parallel=True)
        if batches is None:
            return None
        jittered = {} if slow else dict(self._jittered(fitted, made))
        return ByEngine(
            self.engine,
            slow,
            preset,
            f"label@{self.engine}",
            dict(zip(ways, batches[: len(ways)], strict=True)),
            dict(zip(steps, batches[len(ways) :], strict=True)),
            fitted,
            jittered,
            None
            if engines()[self.engine].check_only
            else judged(self.lab, self.engine, preset, fitted, self.layouts),
        )

    def _identified(self) -> str | None:
        """The contact as the record states it; None where it does not."""
        body = self.recorded
        if body.friction is None:
            return None
        values = [f"friction={body.friction!r}", f"frequency={FREQUENCY}"]
        if body.restitution:
            values += [f"restitution={body.restitution!r}", "emulate=restitution"]
        return str(make_method(f"simulation@{self.engine}:{','.join(values)}").spec)

    def _fit(self) -> FitUnit:
        stated = {"friction": self.recorded.friction, "restitution": self.recorded.restitution}
        known = {name: value for name, value in stated.items() if value is not None}
        made = {**made_on_engine(self.engine), **package_versions(("pygad",))}
        genes = genes_on(self.engine)
        return FitUnit(self.record, SEED, self.engine, genes, known, self.taken, made)

    def _jittered(
        self, fitted: Fitted, made: Mapping[str, str]
    ) -> Iterator[tuple[tuple[str, float], Jittered]]:
        """By half and factor: all factors on the half for fitting, then those that are shown."""

        def of(half: str, factors: Sequence[float]) -> dict[tuple[str, float], Jittered]:
            units = [
                JitterUnit(
                    self.record, half, SEED, fitted.spec, self.taken, self.recorded.noise,
                    factor, JITTERS, made,
                )
                for factor in factors
            ]  # fmt: skip
            found = self.lab.measure(units, Jittered, folder="jittered", parallel=True).rows
            return {(half, factor): one for factor, one in zip(factors, found, strict=True)}

        on_fit = of(FIT, FACTORS)
        yield from on_fit.items()
        faces = {toss.name: toss.face for toss in self.recorded.tosses}
        losses = {factor: loss(one, faces) for (_, factor), one in on_fit.items()}
        yield from of(MEASURED, sorted({AS_MEASURED, chosen_factor(losses)})).items()


def _rows(
    lab: Lab,
    measure: bool,
    units: Sequence[Asked[R]],
    row: type[R],
    folder: str,
    *,
    parallel: bool = False,
) -> list[R] | None:
    """Rows, measured where they are missing; None where some are, and are not to be measured."""
    if measure:
        return lab.measure(units, row, folder=folder, parallel=parallel).rows
    found = lab.so_far(units, row, folder=folder)
    there = [one for one in found if one is not None]
    return there if len(there) == len(found) else None


def _spelled(preset: str) -> str:
    """A preset with its parameters: it may be tuned anew."""
    return spec_of(*simulation_of(preset))
