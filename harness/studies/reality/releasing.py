"""Trials released in engines: how the body is taken, and where each comes to rest."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from steadyload.engines.errors import EngineError
from steadyload.engines.registry import capabilities, engines, package_versions, warm_up
from steadyload.engines.world import Box, WorldSettings
from steadyload.measured.derived import face_down
from steadyload.measured.deviations import before_impacts, deviation, distances
from steadyload.measured.errors import MotionError
from steadyload.measured.flight import FlightFacts, flight_frames, scaled
from steadyload.measured.motion import Trial
from steadyload.measured.releases import CENTRED, Noise, Release, first_frame, release
from steadyload.measured.simulating import VERSION, end_pose, simulated
from steadyload.methods.registry import make_method
from steadyload.methods.simulation.simulation_parameters import SimulationParameters
from steadyload.reports.columns import row
from steadyload.runs.provenance import made_on
from steadyload.studies.kit import Asked
from steadyload.studies.reality.record import Record

FACES = ("-x", "+x", "-y", "+y", "-z", "+z")

SINCE_CONTACT = tuple(round(0.05 * k, 2) for k in range(15))
"""Times after the last frame of free flight at which positions are compared [s]."""

_DIGITS_OF_OFFSETS, _DIGITS_OF_SCALES = 5, 4
"""To which digits offsets [m] and scales that flights show are rounded, far below their
intervals: keys of rows depend on them."""


@dataclass(frozen=True)
class Taken:
    """How a body and its released state are taken from the record.

    Attributes:
        first_frame: the state is that of the first frame; else of all frames of free flight.
        uniform: moments of inertia are those of uniform density; else those that are stated, if so.
        offset: centre of mass minus geometric centre, in the body's axes [m].
        scale: that lengths of the record are multiplied by.
    """

    first_frame: bool = False
    uniform: bool = False
    offset: tuple[float, float, float] = CENTRED
    scale: float = 1.0

    def record(self, trial: Trial) -> Trial:
        """A trial in true lengths, with its body as it is taken."""
        found = trial if self.scale == 1.0 else scaled(trial, self.scale)
        return replace(found, body=replace(found.body, inertia=None)) if self.uniform else found

    def release(self, record: Trial) -> Release:
        """The released state of a trial of :meth:`record`."""
        return first_frame(record) if self.first_frame else release(record, self.offset)

    def box(self, record: Trial, start: Release) -> Box:
        """The body in a state, as engines are given it."""
        return start.box(record.body, self.offset)


AS_RECORDED = Taken()
"""With moments of inertia that are stated, and the centre of mass in the middle."""


def by_flights(flight: FlightFacts, *, in_true_lengths: bool = True) -> Taken:
    """The body as its flights show it: with its centre of mass, and in true lengths."""
    x, y, z = (round(part, _DIGITS_OF_OFFSETS) for part in flight.offset)
    scale = round(flight.scale, _DIGITS_OF_SCALES) if in_true_lengths else 1.0
    return Taken(offset=(x, y, z), scale=scale)


@dataclass(frozen=True)
class Contact:
    """An engine and what it is told of contacts, as a simulation states it.

    Attributes:
        engine: registered name.
        settings: of its worlds.
        frequency: substeps a second.
    """

    engine: str
    settings: WorldSettings
    frequency: float


@cache
def contact_of(spec: str) -> Contact:
    """The engine and the contacts of the spec of a simulation; nothing else of it counts."""
    engine, parameters = simulation_of(spec)
    return Contact(engine, parameters.world_settings(), parameters.frequency)


def simulation_of(spec: str) -> tuple[str, SimulationParameters]:
    """The engine of the spec of a simulation, and its parameters."""
    method = make_method(spec)
    assert isinstance(method.parameters, SimulationParameters), f"{spec} is a simulation"
    assert method.spec.engine is not None, "which is on an engine"
    return method.spec.engine, method.parameters


@cache
def is_slow(engine: str) -> bool:
    """Whether an engine is run once a trial: it chooses its own steps, or checks others alone."""
    return capabilities(engine).error_controlled or engines()[engine].check_only


def made_on_engine(engine: str) -> Mapping[str, str]:
    """Versions that results of an engine and of the released states depend on."""
    return made_on(engine) | package_versions(("numpy", "scipy"))


@row
class Ended:
    """A trial as an engine simulates it, compared with the record; None after a failure.

    Attributes:
        since_contact: distances of the centres at :data:`SINCE_CONTACT` [m]; None after its end.
        through_impacts: distances before each impact of the record, and at its last frame [m].
        failed: why there is nothing; empty where the engine simulated it.
    """

    name: str
    face: str
    same_face: bool
    off_m: float | None
    turn_deg: float | None
    height_m: float | None
    deepest_m: float | None
    rest_s: float | None
    since_contact: Sequence[float | None]
    through_impacts: Sequence[float | None]
    failed: str = ""


@row
class Batch:
    """All trials of a record by an engine, and the CPU time of that [s]."""

    ended: Sequence[Ended]
    cpu_s: float


class ReleasedUnit(Asked[Batch], what="released bodies", version=VERSION):
    """All trials of a record, released in an engine and simulated until they rest."""

    record: Record
    spec: str
    taken: Taken
    made_by: Mapping[str, str]

    def describe(self, part: int) -> str:
        """Description for messages."""
        return f"{self.spec} on record {self.record.digest}"

    def measure(self) -> Batch:
        """Simulate them."""
        contact = contact_of(self.spec)
        trials = self.record.here()
        _warm_up(self.spec)
        begun = time.process_time()
        ended = [_ended(trial, contact, self.taken) for trial in trials]
        return Batch(ended, time.process_time() - begun)


def _ended(trial: Trial, contact: Contact, taken: Taken) -> Ended:
    record = taken.record(trial)
    box = taken.box(record, taken.release(record))
    try:
        found = simulated(
            trial.name, box, contact.engine, contact.settings, contact.frequency, record.times
        )
    except (EngineError, MotionError) as error:
        failed = str(error) or type(error).__name__
        return Ended(trial.name, "", False, None, None, None, None, None, [], [], failed)
    end = deviation(record, found)
    contact_s = float(record.times[flight_frames(record) - 1] - record.times[0])
    return Ended(
        trial.name,
        end.face,
        end.same_face,
        end.off_m,
        end.turn_deg,
        end.height_m,
        end.deepest_m,
        end.rest_s,
        distances(record, found, [contact_s + later for later in SINCE_CONTACT]),
        distances(record, found, before_impacts(record)),
    )


@row
class Jittered:
    """How often each trial of a half ends on each face, when its start is moved within the noise.

    Attributes:
        names: of the trials.
        counts: by trial, of :data:`FACES`; a failed simulation counts for none.
        cpu_s: CPU time [s].
    """

    names: Sequence[str]
    counts: Sequence[Sequence[int]]
    cpu_s: float


class JitterUnit(Asked[Jittered], what="jittered releases", version=VERSION):
    """The trials of a half, each released many times within the noise times a factor.

    The same numbers are drawn for every engine and factor.
    """

    record: Record
    half: str
    seed: int
    spec: str
    taken: Taken
    noise: Noise
    factor: float
    jitters: int
    made_by: Mapping[str, str]

    def describe(self, part: int) -> str:
        """Description for messages."""
        return f"{self.spec}, noise times {self.factor:g}, half {self.half}"

    def measure(self) -> Jittered:
        """Simulate them."""
        trials = self.record.of(self.half, self.seed)
        _warm_up(self.spec)
        begun = time.process_time()
        found = [list(self._faces(trial)) for trial in trials]
        counts = [[faces.count(face) for face in FACES] for faces in found]
        return Jittered([trial.name for trial in trials], counts, time.process_time() - begun)

    def _faces(self, trial: Trial) -> Iterator[str]:
        record = self.taken.record(trial)
        start = self.taken.release(record)
        random = np.random.default_rng([self.seed, *trial.name.encode()])
        for _ in range(self.jitters):
            box = self.taken.box(record, start.moved(self.noise, self.factor, random))
            end = end_of(record, box, self.spec)
            if end is not None:
                yield face_down(end[1]).name


def end_of(record: Trial, box: Box, spec: str) -> tuple[np.ndarray, np.ndarray] | None:
    """Centre and attitude of a released body at rest; None where the engine fails on it."""
    contact = contact_of(spec)
    try:
        centre, attitude = end_pose(
            box, contact.engine, contact.settings, contact.frequency, record.times
        )
    except EngineError:
        return None
    finite = np.isfinite(centre).all() and np.isfinite(attitude).all()
    return (centre, attitude) if finite else None


@cache
def _warm_up(spec: str) -> None:
    """Import and compile what the engine needs, so that no trial's time holds it."""
    warm_up(contact_of(spec).engine, 1)
