"""Engines that run in a process of their own, which may die or belong to another Python.

All worlds of this process that are of one engine share a child, which is started again when it has
died. A world keeps its state here; what the child holds is a copy that can be rebuilt at any time.
"""

from __future__ import annotations

import contextlib
import itertools
import multiprocessing
import os
import subprocess
import tempfile
import threading
import weakref
from abc import abstractmethod
from multiprocessing.connection import Connection
from pathlib import Path
from typing import IO, Any, ClassVar, NamedTuple

import numpy as np

from steadyload.engines.attitudes import centres_from_mass_centres
from steadyload.engines.world import (
    Box,
    EngineError,
    FixedStepWorld,
    Poses,
    SettingSupport,
    Support,
    Velocities,
    WorldSettings,
    planned_poses,
)

_PATIENCE = 600.0
"""Seconds for one answer of a child, after which it is ended."""

_LAST_WORDS = 10.0
"""Seconds for a child that has closed its line to end by itself."""

_SERVING = Path(__file__).with_name("serving.py")


class Child:
    """A child process and the line to it; it ends with this object, or with us.

    Args:
        title: of the engine, for messages.
        python: that runs it.
        scenes: file with the class of the engine's scenes.
    """

    def __init__(self, title: str, python: str, scenes: Path) -> None:
        self._title = title
        self._owner = os.getpid()
        self._lock = threading.Lock()
        self.builds = 0
        """Scenes that it was told to build."""
        self._connection, theirs = multiprocessing.Pipe()
        # An engine says why it aborts on the standard error; nobody else reads that of the child.
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - it lives as long as the child
        self._process = subprocess.Popen(
            [python, "-P", str(_SERVING), str(theirs.fileno()), str(scenes)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
            # Threads for matrices as small as these cost several times what they save.
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
            pass_fds=[theirs.fileno()],
        )
        theirs.close()
        self.end = weakref.finalize(
            self, _end, self._owner, self._connection, self._process, self._errors
        )

    def usable(self) -> bool:
        """True if the child lives and belongs to this process, not to one this was forked from."""
        return self.end.alive and self._owner == os.getpid()

    def ask(self, name: str, world: int, *values: Any) -> Any:
        """The child's answer to a request of :mod:`steadyload.engines.serving`.

        Raises:
            EngineError: the engine refused, the child died, or it took too long.
        """
        self.builds += name == "build"
        with self._lock:
            try:
                self._connection.send((name, world, *values))
                if not self._connection.poll(_PATIENCE):
                    raise EngineError(f"{self._title} gave no answer within {_PATIENCE:g} s")
                failure, states = self._connection.recv()
            except (EOFError, OSError) as error:
                raise EngineError(self._error_output()) from error
            except BaseException:
                # Also on an interrupt: a late answer would pass for that to the next request.
                self.end()
                raise
        if failure is not None:
            raise EngineError(f"{self._title}: {failure}")
        return states

    def _error_output(self) -> str:
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(_LAST_WORDS)
        code = self._process.returncode
        self._errors.seek(0)
        lines = self._errors.read().decode(errors="replace").strip().splitlines()
        self.end()
        said = lines[-1] if lines else "it said nothing"
        return f"{self._title}'s process ended ({code}): {said}"


def _end(
    owner: int, connection: Connection, process: subprocess.Popen[bytes], errors: IO[bytes]
) -> None:
    connection.close()
    if owner == os.getpid():
        process.kill()
        process.wait()
    errors.close()


class Children:
    """The child for new scenes of one engine; an older one lives as long as a world in it.

    Args:
        title: of the engine, for messages.
        python: that runs it.
        scenes: file with the class of the engine's scenes, beside this one.
        most_builds: scenes that a child builds before a new one takes over, as engines lose memory.
    """

    def __init__(self, title: str, python: str, scenes: str, most_builds: int) -> None:
        self._title, self._python = title, python
        self._scenes = Path(__file__).with_name(scenes)
        self.most_builds = most_builds
        self._shared: Child | None = None

    def current(self) -> Child:
        """The child, started where there is none that is usable."""
        if self._shared is None or not self._shared.usable() or self._is_worn_out(self._shared):
            self._shared = Child(self._title, self._python, self._scenes)
        return self._shared

    def _is_worn_out(self, child: Child) -> bool:
        return child.builds >= self.most_builds


_numbers = itertools.count()


CHANGING_GRAVITY = SettingSupport(
    Support.HONOURED, "the scene is built anew, and takes the state over"
)
"""What all these engines declare: see :class:`ChildWorld`."""


class Shape(NamedTuple):
    """Shape of a box, as contacts see it.

    ``size``: edge lengths [m]. ``aside``: shift of its centre, in its own axes [m].
    """

    size: tuple[float, float, float]
    aside: tuple[float, float, float] = (0.0, 0.0, 0.0)


class ChildWorld(FixedStepWorld):
    """Base of such an engine: an adapter says what a box's shape is, and names the options.

    Raises:
        EngineError: the child died, took too long, or refused to go on.
    """

    children: ClassVar[Children]

    def __init__(self, settings: WorldSettings) -> None:
        super().__init__(settings)
        self._number = next(_numbers)
        self._bodies: list[tuple[Any, ...]] = []
        self._free: list[int] = []
        self._states = self._starts = np.zeros((0, 13))
        # The child that has these boxes, and whether the state is still to be sent to it.
        self._holder: Child | None = None
        self._set_here = True

    @classmethod
    def warm_up(cls, box_count: int) -> None:
        """Start the child process and wait until it has imported the engine."""
        cls.children.current().ask("drop", next(_numbers))

    @abstractmethod
    def _shape(self, box: Box) -> Shape:
        """The shape of a box that is about to be added."""

    @abstractmethod
    def _scene_options(self) -> dict[str, Any]:
        """Arguments of the engine's scene besides gravity and bodies, by name."""

    def _add(self, box: Box) -> None:
        shape = self._shape(box)
        attitude, mass_centre = box.unit_attitude, box.mass_centre
        shape_centre = [a - p for a, p in zip(shape.aside, box.mass_offset, strict=True)]
        # Numbers of numpy, which boxes may have, are not read by all versions of it.
        size, inertia, *places = (
            tuple(map(float, numbers))
            for numbers in (shape.size, box.inertia, mass_centre, attitude, shape_centre)
        )
        self._bodies.append((size, float(box.mass), inertia, *places, box.fixed))
        if not box.fixed:
            self._free.append(len(self.boxes))
            start = np.array([[*attitude, *mass_centre, *box.angular_velocity, *box.velocity]])
            self._starts = np.vstack((self._starts, start))
            self._states = np.vstack((self._states, start))
        self._holder = None

    def _prepare(self) -> None:
        if self._holder is None or not self._holder.usable():
            child, gravity = self.children.current(), tuple(map(float, self.gravity))
            child.ask("build", self._number, gravity, self._bodies, self._scene_options())
            self._holder, self._set_here = child, True

    def _advance(self, substeps: int, length: float) -> None:
        self._prepare()
        assert self._holder is not None
        try:
            states = self._states.tolist() if self._set_here else None
            answer = self._holder.ask("advance", self._number, states, substeps, length)
        except BaseException:
            self._holder = None
            raise
        self._states = np.array(answer).reshape(-1, 13)
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
