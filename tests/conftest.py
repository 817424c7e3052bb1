"""What all tests share: engines, small layouts, and real data where it is there."""

from collections.abc import Callable
from pathlib import Path

import pytest

from steadyload.engines.registry import engine_names, engines, world_class
from steadyload.engines.world import EngineNotInstalledError
from steadyload.layouts import Item, Layout, Pallet

ACLPP = Path(__file__).resolve().parents[2] / "shared" / "data" / "aclpp"


@pytest.fixture(params=engine_names())
def engine(request: pytest.FixtureRequest) -> str:
    """Every engine that is compared unasked, one after the other."""
    return request.param


@pytest.fixture(params=engines())
def any_engine(request: pytest.FixtureRequest) -> str:
    """Every registered engine; an optional one that is not installed is skipped."""
    if engines()[request.param].extra:
        try:
            world_class(request.param)
        except EngineNotInstalledError as error:
            pytest.skip(str(error))
    return request.param


@pytest.fixture
def aclpp_files() -> list[Path]:
    files = sorted(ACLPP.glob("*.yaml"))
    if not files:
        pytest.skip("the ACLPP schedules are not beside the project (../shared/data/aclpp)")
    return files


@pytest.fixture
def stack() -> Callable[..., Layout]:
    """Makes a column of 10 cm cubes; ``shifts`` are their x positions."""

    def make(*shifts: float, offset: float = 0.0, weight: float = 1.0) -> Layout:
        items = tuple(
            Item(
                step,
                (40.0 + shift, 10.0 * step, 40.0),
                (10.0, 10.0, 10.0),
                weight,
                (offset, 0.0, 0.0) if step == len(shifts) - 1 else (0.0, 0.0, 0.0),
            )
            for step, shift in enumerate(shifts)
        )
        return Layout("stack", Pallet(100.0, 100.0, 100.0), items)

    return make


@pytest.fixture
def plate() -> Callable[[float], Layout]:
    """Makes a plate on posts at two opposite corners; ``offset_z`` shifts its centre of mass.

    Contacts (0..1, 0..1) and (9..10, 9..10). Their hull's edge from (0, 1) to (9, 10) passes
    x = 4.5, where the centre of mass lies, at z = 5.5: an offset of 0.5.
    """

    def make(offset_z: float) -> Layout:
        items = (
            Item(0, (0.0, 0.0, 0.0), (1.0, 5.0, 1.0), 1.0),
            Item(1, (9.0, 0.0, 9.0), (1.0, 5.0, 1.0), 1.0),
            Item(2, (0.0, 5.0, 0.0), (10.0, 1.0, 10.0), 1.0, (-0.5, 0.0, offset_z)),
        )
        return Layout("plate", Pallet(100.0, 100.0, 100.0), items)

    return make
