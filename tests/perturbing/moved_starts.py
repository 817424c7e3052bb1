"""Every start of a simulation is moved by less than rounding moves it: ``pytest --perturb SEED``.

A processor of another kind rounds otherwise, and a verdict that depends on rounding is another one
there. Such a verdict shows itself when starts are moved by as much: by up to :data:`SHARE` of a
box's own lengths, in a direction that the seed and the box choose. So the same box starts at the
same place in every world of a run, in new worlds and used ones, in this process and in others.
"""

import hashlib
import importlib.util
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib.abc import MetaPathFinder
from types import ModuleType

SHARE = 1e-7
"""Of a box's length along an axis: what it is moved by at most. Single precision holds so much."""

VARIABLE = "STEADYLOAD_TESTS_PERTURB"
"""Environment variable that holds the seed; processes that tests start inherit it."""

_WORLD = "steadyload.engines.world"


def moved(box, seed: str):
    """A box beside where it is planned; one that no world would take is left as it is."""
    what = repr((seed, box.size, box.mass, box.centre, box.mass_offset))
    drawn = hashlib.blake2b(what.encode(), digest_size=12).digest()
    try:
        centre = tuple(
            at + SHARE * length * (int.from_bytes(drawn[4 * axis :][:4]) / 2**31 - 1.0)
            for axis, (at, length) in enumerate(zip(box.centre, box.size, strict=True))
        )
    except (TypeError, ValueError):
        return box
    return replace(box, centre=centre)


def begin(seed: str) -> None:
    """Move starts from now on, in this process and in those that it starts."""
    folder = os.path.dirname(__file__)  # noqa: PTH120 - beside every start of an interpreter
    paths = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    os.environ["PYTHONPATH"] = os.pathsep.join(
        [folder, *(p for p in paths if p not in ("", folder))]
    )
    set_seed(seed)
    install()


def set_seed(seed: str | None) -> None:
    """Move starts by another seed, or no longer."""
    if seed is None:
        os.environ.pop(VARIABLE, None)
    else:
        os.environ[VARIABLE] = seed


@contextmanager
def by(seed: str | None) -> Iterator[None]:
    """Context in which starts are moved by a seed, or by none; for worlds of this process."""
    before = os.environ.get(VARIABLE)
    install()
    set_seed(seed)
    try:
        yield
    finally:
        set_seed(before)


def install() -> None:
    """Let worlds add boxes where :func:`moved` says; at once, or when their module is imported."""
    if _WORLD in sys.modules:
        _patch(sys.modules[_WORLD])
    else:
        sys.meta_path.insert(0, _AfterImport())


def _patch(module: ModuleType) -> None:
    kind = module.FixedStepWorld
    add_box: Callable[..., int] = kind.add_box
    if hasattr(add_box, "moves"):
        return

    def adding(self, box):
        seed = os.environ.get(VARIABLE)
        return add_box(self, box if seed is None else moved(box, seed))

    adding.moves = True
    kind.add_box = adding


class _AfterImport(MetaPathFinder):
    """Patches the module of worlds as soon as it has been executed."""

    def find_spec(self, name, path, target=None):
        if name != _WORLD:
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(name)
        execute = spec.loader.exec_module

        def executing(module):
            execute(module)
            _patch(module)

        spec.loader.exec_module = executing
        return spec
