"""The record: trials of a file, what they show by themselves, and their halves."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from steadyload.atomic import manifest_text, write_atomically
from steadyload.engines.attitudes import degrees_apart, lengths
from steadyload.engines.world import GRAVITY
from steadyload.escaping import shown
from steadyload.measured.bodies import Vector
from steadyload.measured.derived import face_down, impacts, resting_height, time_to_rest
from steadyload.measured.errors import MotionError
from steadyload.measured.flight import FlightFacts, flight_facts, flight_frames, scaled
from steadyload.measured.motion import Trial
from steadyload.measured.profiles import MotionProfile, motion_profile
from steadyload.measured.releases import Noise, Release, departure, landed, release
from steadyload.reports.columns import row
from steadyload.stored import StoredFileError, stored_object
from steadyload.studies.kit import Asked

VERSION = 1
"""Of what is said of a record: raised when something else is."""

NOTE = "record.json"
"""File in the work folder that says of which record its rows are."""

HEAVIER = 2.0
"""Factor by which the gravity in a record may differ from that of the earth."""

FEWEST = 8
"""Trials of a record, at least."""

FIT, MEASURED = "fit", "measured"
"""Halves: contacts are fitted on the one, and errors are measured on the other."""


class Record:
    """Trials of a record, or its digest alone, where rows of it are kept and the file is not here.

    Attributes:
        digest: of all that rows depend on: trials, bodies, noise, and what is said of them.
        trials: none where the file is not here.
        profile: how the file was read.
        file: of the trials, for messages.
    """

    def __init__(
        self,
        digest: str,
        trials: Sequence[Trial] = (),
        profile: MotionProfile | None = None,
        file: Path | None = None,
    ) -> None:
        self.digest = digest
        self.trials = tuple(trials)
        self.profile = profile or MotionProfile()
        self.file = file

    def content_hash(self) -> str:
        """The digest, which is what keys of rows hold."""
        return self.digest

    def of(self, half: str, seed: int) -> list[Trial]:
        """The trials of a half."""
        own = halves([trial.name for trial in self.here()], seed)
        return [trial for trial in self.trials if own[trial.name] == half]

    def here(self) -> Sequence[Trial]:
        """The trials.

        Raises:
            MotionError: the file is not here.
        """
        if not self.trials:
            raise MotionError(
                "trials would have to be simulated, and the record is not here; allowed: --data "
                "FILE, the file that the rows are of"
            )
        return self.trials


def halves(names: Sequence[str], seed: int) -> dict[str, str]:
    """The half of each of some trials by name, drawn by a seed; the first has the one more."""
    order = np.random.default_rng(seed).permutation(len(names))
    fitted = {names[k] for k in order[: (len(names) + 1) // 2]}
    return {name: FIT if name in fitted else MEASURED for name in names}


def open_record(
    work: Path, data: Path | None, profile: Path | None, limit: int | None = None
) -> Record:
    """The record of a file; without a file that of the note in the work folder.

    Raises:
        MotionError: no file, and no note; the file cannot be read; fewer than eight trials; a trial
            whose body is not known or is another one, that does not begin in free flight, or that
            moves in the end.
        StoredFileError: the note is damaged.
    """
    note = work / NOTE
    if data is None:
        if not note.exists():
            raise MotionError(f"{work}: no record was compared here yet; allowed: --data FILE")
        again = "name the record again by --data FILE"
        digest = stored_object(note, again).get("digest")
        if not isinstance(digest, str):
            raise StoredFileError(note, again)
        return Record(digest)
    said = MotionProfile() if profile is None else motion_profile(profile)
    trials = said.read(data)[:limit]
    try:
        _check(trials)
    except MotionError as error:
        raise MotionError(f"{data}: {error}") from None
    return Record(_digest(trials, said), trials, said, data)


def note_record(work: Path, record: Record) -> None:
    """Note in the work folder that its rows are of a record whose file is here."""
    if record.trials:
        work.mkdir(parents=True, exist_ok=True)
        facts = {"digest": record.digest, "trials": len(record.trials)}
        write_atomically(work / NOTE, manifest_text(facts))


def _check(trials: Sequence[Trial]) -> None:
    if len(trials) < FEWEST:
        raise MotionError(f"holds {len(trials)} trials; allowed: {FEWEST} or more")
    for trial in trials:
        if trial.body.size is None or trial.body.mass is None:
            raise MotionError(
                f"trial {shown(trial.name)}: size or mass are not known; allowed: both, as columns "
                "or as constants of a profile"
            )
        if trial.body != trials[0].body:
            raise MotionError(
                f"trial {shown(trial.name)}: its body is not that of trial "
                f"{shown(trials[0].name)}; allowed: one body in all trials"
            )
        flight_frames(trial)
        if time_to_rest(trial) is None:
            raise MotionError(
                f"trial {shown(trial.name)}: moves in the end; allowed: a record that ends below "
                "5 cm/s and 0.5 rad/s"
            )


def _digest(trials: Sequence[Trial], profile: MotionProfile) -> str:
    found = hashlib.sha256(repr((profile.body, profile.source, profile.noise)).encode())
    for trial in trials:
        found.update(repr((trial.name, len(trial), trial.body)).encode())
        arrays = (trial.times, trial.positions, trial.attitudes, trial.velocities, trial.spins)
        for array in arrays:
            found.update(b"none" if array is None else np.ascontiguousarray(array).tobytes())
    return found.hexdigest()[:20]


@row
class Guess:
    """An end that is predicted without an engine, compared with the record."""

    face: str
    same_face: bool
    off_m: float
    turn_deg: float


@row
class Toss:
    """A trial as it is recorded; lengths are those of the record."""

    name: str
    half: str
    frames: int
    seconds: float
    face: str
    height_m: float
    rest_s: float
    impacts: int
    travel_m: float
    turn_deg: float
    departure_m: float
    as_released: Guess
    as_landed: Guess


@row
class Recorded:
    """Contents of a record, and facts that follow from it alone.

    Attributes:
        inertia, friction, restitution: None where the record does not state them.
        rate_hz: frames a second, median.
        flights: facts of free flight of all trials, and of each half, by its name.
    """

    body: str
    source: str
    size: Vector
    mass: float
    inertia: Vector | None
    friction: float | None
    restitution: float | None
    noise: Noise
    rate_hz: float
    flights: Mapping[str, FlightFacts]
    tosses: Sequence[Toss]

    @property
    def fitted_flight(self) -> FlightFacts:
        """Facts of free flight of the half on which contacts are fitted."""
        return self.flights[FIT]

    @property
    def height_m(self) -> float:
        """Median height of the centre at rest, in lengths of the record [m]."""
        return float(np.median([toss.height_m for toss in self.tosses]))

    @property
    def half_edge_mm(self) -> float:
        """Half of the body's height, of a body that is as high on every side [mm]."""
        return 500.0 * min(self.size)

    @property
    def is_cube(self) -> bool:
        """Whether all sides are equal."""
        return len({*self.size}) == 1


ALL = "all"


class RecordUnit(Asked[Recorded], what="recorded motion", version=VERSION):
    """A record, looked at without any engine; the seed draws its halves."""

    record: Record
    seed: int
    made_by: Mapping[str, str]

    def describe(self, part: int) -> str:
        """Description for messages."""
        return f"record {self.record.digest}"

    def measure(self) -> Recorded:
        """Derive its facts."""
        trials, profile = self.record.here(), self.record.profile
        body = trials[0].body
        assert body.size is not None, "looked at when the record was opened"
        assert body.mass is not None, "likewise"
        own = halves([trial.name for trial in trials], self.seed)
        try:
            flights = {ALL: _facts(trials)} | {
                half: _facts(self.record.of(half, self.seed)) for half in (FIT, MEASURED)
            }
            tosses = [_toss(trial, own[trial.name], flights[FIT]) for trial in trials]
        except MotionError as error:
            raise MotionError(f"{self.record.file}: {error}") from None
        spans = np.concatenate([np.diff(trial.times) for trial in trials])
        return Recorded(
            profile.body,
            profile.source,
            body.size,
            body.mass,
            body.inertia,
            body.friction,
            body.restitution,
            profile.noise,
            float(1.0 / np.median(spans)),
            flights,
            tosses,
        )


def _facts(trials: Sequence[Trial]) -> FlightFacts:
    """Facts of free flight, if they are those of a body under gravity."""
    found, size = flight_facts(trials), trials[0].body.size
    assert size is not None, "looked at when the record was opened"
    if not GRAVITY / HEAVIER <= found.gravity.value <= GRAVITY * HEAVIER:
        raise MotionError(
            f"bodies fall at {found.gravity.value:.3g} m/s2 in free flight; allowed: "
            f"{GRAVITY / HEAVIER:g} to {GRAVITY * HEAVIER:g}, with lengths in m, times in s, z up"
        )
    if any(abs(part) >= 0.5 * side for part, side in zip(found.offset, size, strict=True)):
        x, y, z = found.offset
        raise MotionError(
            f"by free flight the centre of mass is at ({x:.3g}, {y:.3g}, {z:.3g}) m from the "
            "middle; allowed: inside the body, with quaternions w, x, y, z from the axes of the "
            "body to those of the world"
        )
    return found


def _toss(trial: Trial, half: str, flight: FlightFacts) -> Toss:
    rest, height = time_to_rest(trial), resting_height(trial)
    assert rest is not None, "looked at when the record was opened"
    assert height is not None, "likewise"
    moved = trial.positions[-1, :2] - trial.positions[0, :2]
    true = scaled(trial, flight.scale)
    start = release(trial)
    assert trial.body.size is not None, "likewise"
    return Toss(
        name=trial.name,
        half=half,
        frames=len(trial),
        seconds=float(trial.times[-1] - trial.times[0]),
        face=face_down(trial.attitudes[-1]).name,
        height_m=height,
        rest_s=rest,
        impacts=len(impacts(trial)),
        travel_m=float(lengths(moved)),
        turn_deg=degrees_apart(trial.attitudes[0], trial.attitudes[-1]),
        departure_m=departure(true, release(true, flight.offset), flight.offset),
        as_released=_guess(trial, start),
        as_landed=_guess(trial, landed(start, trial.body.size)),
    )


def _guess(trial: Trial, end: Release) -> Guess:
    """The end of a body that stays as it is in some state."""
    face = face_down(end.attitude).name
    return Guess(
        face,
        face == face_down(trial.attitudes[-1]).name,
        float(np.linalg.norm(end.mass_centre[:2] - trial.positions[-1, :2])),
        degrees_apart(end.attitude, trial.attitudes[-1]),
    )
