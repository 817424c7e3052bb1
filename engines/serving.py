"""The child process of an engine that runs in one of its own: it holds scenes, and imports nothing
of ours.

So it runs under any Python that has the engine. Its arguments are the file number of a connection
and the file that has the class ``Scene``. It answers one request after the other, and ends with
its parent. A request is a tuple: its name, the number of a world, and

* ``build``: gravity [m/s2], the fields of :class:`Body` of every box, further options of the scene;
* ``advance``: states to start from or None to go on, number of substeps, their length [s];
* ``drop``: nothing.

A state is w, x, y, z of the attitude, the centre of mass [m], the angular velocity [rad/s] and
the velocity of the centre of mass [m/s], all in world axes: 13 numbers a free box. The answer is
``(None, states)``, with states of None except to ``advance``, or ``(message, None)``. States travel
as lists: arrays of one version of numpy are not read by all others.
"""

from __future__ import annotations

import importlib.util
import signal
import sys
from collections.abc import Sequence
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np


class Body(NamedTuple):
    """A box as a scene takes it: SI units, the shape about the centre of mass."""

    size: tuple[float, float, float]
    mass: float
    inertia: tuple[float, float, float]
    mass_centre: tuple[float, float, float]
    attitude: tuple[float, float, float, float]
    shape_centre: tuple[float, float, float]
    fixed: bool


class Scene(Protocol):
    """Boxes on the floor, as an engine has them."""

    def __init__(
        self, gravity: tuple[float, float, float], bodies: Sequence[Body], **options: Any
    ) -> None: ...

    def advance(self, states: np.ndarray | None, substeps: int, length: float) -> np.ndarray:
        """Simulate from ``states``, or from where it is; returns the new states."""
        ...


def scene_class(file: Path) -> type[Scene]:
    """The class ``Scene`` of a file, which may import its neighbours by their names alone."""
    sys.path.append(str(file.parent))  # last, so that nothing else is taken from there
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.Scene


def serve(connection: Connection, make: type[Scene]) -> None:
    """Answer requests until the other end is closed."""
    scenes: dict[int, Scene] = {}
    while True:
        try:
            name, world, *values = connection.recv()
        except EOFError:
            return
        try:
            connection.send((None, _answer(scenes, make, name, world, values)))
        except (RuntimeError, ValueError) as error:
            scenes.pop(world, None)
            connection.send((str(error), None))


def _answer(
    scenes: dict[int, Scene], make: type[Scene], name: str, world: int, values: list[Any]
) -> list[list[float]] | None:
    scene = scenes.pop(world, None)
    if name == "build":
        gravity, bodies, options = values
        scenes[world] = make(gravity, [Body(*fields) for fields in bodies], **options)
    elif name == "advance":
        assert scene is not None, "a world is built before it is advanced"
        scenes[world] = scene
        states, substeps, length = values
        start = None if states is None else np.array(states, dtype=float).reshape(-1, 13)
        return scene.advance(start, substeps, length).tolist()
    return None


if __name__ == "__main__":
    # The parent decides when this process ends, also when its user presses Ctrl-C.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    serve(Connection(int(sys.argv[1])), scene_class(Path(sys.argv[2])))
