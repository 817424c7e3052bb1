"""Drake: hydroelastic contact under its error-controlled integrator, in a process of its own.

Drake ends the process on some layouts (a failed invariant where faces touch exactly), so it runs
in a child, which all worlds of this process share and which is started again when it has died. A
world keeps its state here; what the child holds is a copy that can be rebuilt at any time.
"""

from __future__ import annotations

import contextlib
import itertools
import multiprocessing
import os
import subprocess
import sys
import tempfile
import threading
import weakref
from multiprocessing.connection import Connection
from pathlib import Path
from typing import IO, Any

import numpy as np

from steadyload.engines.attitudes import centres_from_mass_centres
from steadyload.engines.world import (
    Box,
    Capabilities,
    EngineError,
    FailureKind,
    FixedStepWorld,
    FloatArray,
    KnownFailure,
    Poses,
    SettingSupport,
    Support,
    Velocities,
    WorldSettings,
    declare,
    planned_poses,
)

_SHRINK = 5e-5
"""Sideways shrink of each side face [m]: Drake fails on 5 of 100 packed layouts without it."""

_UNEVENNESS = 0.2
"""Shapes stand aside by up to half this part of the shrink, each box by another amount. Where edges
of two meshes align, Drake's contact surface has faces without area and normal, and it divides zero
by zero: on 1 of 300 layouts when all stand as planned, on none of them so."""

_IRRATIONAL = (0.7548776662466927, 0.5698402909980532)
"""Multiples of these two fill the unit square evenly."""

_PATIENCE = 600.0
"""Seconds for one answer of the child, after which it is ended."""

_MOST_BUILDS = 1000
"""Scenes built before a new child takes over: each loses 0.1 to 0.4 MiB of its memory for good."""

_LAST_WORDS = 10.0
"""Seconds for a child that has closed its line to end by itself."""

_WORKER = Path(__file__).with_name("drake_worker.py")


class _Worker:
    """The child process and the line to it; the child ends with this object, or with us."""

    def __init__(self) -> None:
        self._owner = os.getpid()
        self._lock = threading.Lock()
        self._builds = 0
        self._connection, theirs = multiprocessing.Pipe()
        # Drake says why it aborts on the standard error; nobody else reads that of the child.
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - it lives as long as the child
        self._process = subprocess.Popen(
            [sys.executable, "-P", str(_WORKER), str(theirs.fileno())],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
            pass_fds=[theirs.fileno()],
        )
        theirs.close()
        self.end = weakref.finalize(
            self, _end, self._owner, self._connection, self._process, self._errors
        )

    def usable(self) -> bool:
        """True if the child lives and belongs to this process, not to one this was forked from."""
        return self.end.alive and self._owner == os.getpid()

    def build(self, *values: Any) -> None:
        """See :mod:`steadyload.engines.drake_worker`."""
        self._builds += 1
        self.ask("build", *values)

    def is_worn_out(self) -> bool:
        """True once the memory that Drake loses with every build has become too much."""
        return self._builds >= _MOST_BUILDS

    def ask(self, *request: Any) -> FloatArray:
        """The child's answer.

        Raises:
            EngineError: Drake refused, the child died, or it took too long.
        """
        with self._lock:
            try:
                self._connection.send(request)
                if not self._connection.poll(_PATIENCE):
                    raise EngineError(f"Drake gave no answer within {_PATIENCE:g} s")
                failure, states = self._connection.recv()
            except (EOFError, OSError) as error:
                raise EngineError(self._error_output()) from error
            except BaseException:
                # Also on an interrupt: a late answer would pass for that to the next request.
                self.end()
                raise
        if failure is not None:
            raise EngineError(f"Drake: {failure}")
        return states

    def _error_output(self) -> str:
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(_LAST_WORDS)
        code = self._process.returncode
        self._errors.seek(0)
        lines = self._errors.read().decode(errors="replace").strip().splitlines()
        self.end()
        return f"Drake's process ended ({code}): {lines[-1] if lines else 'it said nothing'}"


def _end(
    owner: int, connection: Connection, process: subprocess.Popen[bytes], errors: IO[bytes]
) -> None:
    connection.close()
    if owner == os.getpid():
        process.kill()
        process.wait()
    errors.close()


_shared: _Worker | None = None
_numbers = itertools.count()


def _worker() -> _Worker:
    """The child for new scenes; an older one lives as long as a world that was built in it."""
    global _shared
    if _shared is None or not _shared.usable() or _shared.is_worn_out():
        _shared = _Worker()
    return _shared


class DrakeWorld(FixedStepWorld):
    """A Drake world.

    Raises:
        EngineError: Drake's process died, took too long, or refused to go on.
    """

    capabilities = Capabilities(
        title="Drake",
        dimensions=3,
        settings=declare(
            friction=SettingSupport(Support.HONOURED, "static and dynamic alike"),
            restitution=SettingSupport(
                Support.IGNORED, "contacts are damped: what arrives at 2 m/s leaves at 0.02 m/s"
            ),
            linear_damping=SettingSupport(Support.IGNORED, "Drake has none for a free body"),
            angular_damping=SettingSupport(Support.IGNORED, "Drake has none for a free body"),
            margin=SettingSupport(Support.IGNORED, "its pressure begins where boxes touch"),
            broad_phase=SettingSupport(Support.IGNORED, "Drake offers no choice"),
            solver_iterations=SettingSupport(Support.IGNORED, "it iterates to a tolerance"),
        ),
        changing_gravity=SettingSupport(
            Support.HONOURED, "the scene is built anew, and takes the state over"
        ),
        in_flight=SettingSupport(Support.HONOURED),
        notes="An independent check, installed with `pip install '.[drake]'` and part of "
        "no comparison unless named. Contact is a field of pressure, steps are controlled by their "
        "error, and a substep is the longest. It runs in a process of its own, whose CPU time is "
        "not counted: read wall time. Side faces are drawn in by 0.05 mm, and shapes stand up to "
        "5 um aside, because Drake fails on some layouts whose edges align; where it still does, "
        "the layout ends with status `error`.",
        known_failures=(
            KnownFailure(
                "a_fast_slide",
                FailureKind.NEVER,
                "contacts are too stiff for friction at this speed: a softer one slides right, and "
                "tips a box near an edge too early",
                "a cube of 20 cm that slides at 3 m/s at friction 0.5 tips or leaps by up to 40 "
                "mm, and its middle stops after 0.41 to 0.66 m instead of 0.918 m (480 to 1920 "
                "Hz); at a dissipation of 1 or 5 s/m after 0.69 to 0.92 m, and tips at some "
                "frequencies; at a modulus of 1e8 Pa instead of 1e10 it stays upright, and stops "
                "after 0.905 m at 480 Hz and 0.917 m at 1920 Hz",
            ),
            KnownFailure(
                "edge_of_a_deck",
                FailureKind.NEVER,
                "pressure needs a width: near an edge a box tips before its centre of mass is past",
                "a box of 30 x 30 x 40 cm and 10 kg stands from 2 mm inside the edge on, of 100 kg "
                "from 4 mm on",
            ),
        ),
    )

    def __init__(self, settings: WorldSettings) -> None:
        super().__init__(settings)
        self._number = next(_numbers)
        self._bodies: list[tuple[Any, ...]] = []
        self._free: list[int] = []
        self._states = self._starts = np.zeros((0, 13))
        # The child that has these boxes, and whether the state is still to be sent to it.
        self._holder: _Worker | None = None
        self._set_here = True

    @classmethod
    def warm_up(cls, box_count: int) -> None:
        """Start the child process and wait until it has imported Drake."""
        _worker().ask("drop", next(_numbers))

    def _add(self, box: Box) -> None:
        x, y, z = box.size
        shrink = min(_SHRINK, 1e-3 * x, 1e-3 * y)
        size = (x - 2.0 * shrink, y - 2.0 * shrink, z)
        aside = [shrink * _UNEVENNESS * (len(self.boxes) * f % 1.0 - 0.5) for f in _IRRATIONAL]
        mass_centre, attitude = tuple(map(float, box.mass_centre)), box.unit_attitude
        p, q, r = box.mass_offset
        shape_centre = (aside[0] - p, aside[1] - q, -r)
        self._bodies.append(
            (size, box.mass, box.inertia, mass_centre, attitude, shape_centre, box.fixed)
        )
        if not box.fixed:
            self._free.append(len(self.boxes))
            start = np.array([[*attitude, *mass_centre, *box.angular_velocity, *box.velocity]])
            self._starts = np.vstack((self._starts, start))
            self._states = np.vstack((self._states, start))
        self._holder = None

    def _prepare(self) -> None:
        if self._holder is None or not self._holder.usable():
            settings, worker = self.settings, _worker()
            worker.build(self._number, self.gravity, settings.friction, self._bodies)
            self._holder, self._set_here = worker, True

    def _advance(self, substeps: int, length: float) -> None:
        self._prepare()
        assert self._holder is not None
        try:
            states = self._states if self._set_here else None
            seconds = substeps * length
            self._states = self._holder.ask("advance", self._number, states, seconds, length)
        except BaseException:
            self._holder = None
            raise
        self._set_here = False

    def _set_gravity(self) -> None:
        self._holder = None

    def _poses(self) -> Poses:
        offsets = np.array([self.boxes[i].mass_offset for i in self._free]).reshape(-1, 3)
        quaternions = self._states[:, :4].copy()
        moved = centres_from_mass_centres(self._states[:, 4:7].copy(), quaternions, offsets)
        poses = planned_poses(self.boxes)
        poses.centres[self._free], poses.quaternions[self._free] = moved, quaternions
        return poses

    def _velocities(self) -> Velocities:
        linear, angular = np.zeros((2, len(self.boxes), 3))
        angular[self._free], linear[self._free] = self._states[:, 7:10], self._states[:, 10:]
        return Velocities(linear, angular)

    def _set_velocities(self, velocities: Velocities) -> None:
        self._states = self._states.copy()
        self._states[:, 7:10] = velocities.angular[self._free]
        self._states[:, 10:] = velocities.linear[self._free]
        self._set_here = True

    def _reset(self) -> None:
        self._states, self._set_here = self._starts, True

    def _close(self) -> None:
        holder, self._holder = self._holder, None
        if holder is not None and holder.usable():
            with contextlib.suppress(EngineError):
                holder.ask("drop", self._number)
