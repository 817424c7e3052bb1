"""Compiled functions over arrays: contacts, static rules, equilibrium and its motion model.

A layout is handed over as read-only, C-contiguous arrays: ``lower`` and ``upper`` (J, 3) [cm],
``weights`` (J,) [kg], ``offsets`` (J, 3) [cm], as :class:`~steadyload.layouts.model.layout.Layout`
has, and ``floor`` (5,): the corners x0, z0, x1, z1 of what carries [cm], infinite for a plane, and
its height above the ground [cm], 0 for a plane. A batch has the items of all layouts one after the
other, ``starts`` (L + 1,) with the first item of each, and ``floors`` (L, 5).

``statics.kernels.balance`` and the others are imported where they are first used: numba takes half
a second to import, and more to load compiled code, which a command that refuses its input need not
wait for.
"""

import importlib
import importlib.util
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # so that editors know what each holds
    from steadyload.statics.kernels import balance as balance
    from steadyload.statics.kernels import base_support as base_support
    from steadyload.statics.kernels import carrying as carrying
    from steadyload.statics.kernels import cells as cells
    from steadyload.statics.kernels import constants as constants
    from steadyload.statics.kernels import contacts as contacts
    from steadyload.statics.kernels import convex_hull as convex_hull
    from steadyload.statics.kernels import free_places as free_places
    from steadyload.statics.kernels import group_forces as group_forces
    from steadyload.statics.kernels import growing as growing
    from steadyload.statics.kernels import least_energy as least_energy
    from steadyload.statics.kernels import least_squares as least_squares
    from steadyload.statics.kernels import loading as loading
    from steadyload.statics.kernels import local_balance as local_balance
    from steadyload.statics.kernels import margin as margin
    from steadyload.statics.kernels import motion as motion
    from steadyload.statics.kernels import pendulums as pendulums
    from steadyload.statics.kernels import placing as placing
    from steadyload.statics.kernels import sme as sme
    from steadyload.statics.kernels import spreading as spreading
    from steadyload.statics.kernels import timed_balance as timed_balance
    from steadyload.statics.kernels import touching as touching


def __getattr__(name: str) -> ModuleType:
    full = f"{__name__}.{name}"
    if importlib.util.find_spec(full) is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return importlib.import_module(full)
