"""Drake: hydroelastic contact under its error-controlled integrator, in a process of its own.

Drake ends the process on some layouts (a failed invariant where faces touch exactly), so it runs
in a child (:mod:`steadyload.engines.child`).
"""

from __future__ import annotations

import sys
from typing import Any

from steadyload.engines.box import drawn_in, shrink_of
from steadyload.engines.child import CHANGING_GRAVITY, Children, ChildWorld, Shape
from steadyload.engines.world import (
    Box,
    Capabilities,
    FailureKind,
    KnownFailure,
    SettingSupport,
    Support,
    declare,
)

_SHRINK = 5e-5
"""Sideways shrink of each side face [m]: Drake fails on 5 of 100 packed layouts without it."""

_UNEVENNESS = 0.2
"""Shapes stand aside by up to half this part of the shrink, each box by another amount. Where edges
of two meshes align, Drake's contact surface has faces without area and normal, and it divides zero
by zero: on 1 of 300 layouts when all stand as planned, on none of them so."""

_IRRATIONAL = (0.7548776662466927, 0.5698402909980532)
"""Multiples of these two fill the unit square evenly."""

_MOST_BUILDS = 1000
"""Each scene loses 0.1 to 0.4 MiB of the child's memory for good."""


class DrakeWorld(ChildWorld):
    """A Drake world.

    Raises:
        EngineError: Drake's process died, took too long, or refused to go on.
    """

    children = Children("Drake", sys.executable, "drake_worker.py", _MOST_BUILDS)
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
        changing_gravity=CHANGING_GRAVITY,
        in_flight=SettingSupport(Support.HONOURED),
        notes="An independent check, installed with `pip install -e '.[drake]'` and part of "
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

    def _shape(self, box: Box) -> Shape:
        shrink = shrink_of(box.size, _SHRINK)
        p, q = (shrink * _UNEVENNESS * (len(self.boxes) * f % 1.0 - 0.5) for f in _IRRATIONAL)
        return Shape(drawn_in(box.size, shrink), (p, q, 0.0))

    def _scene_options(self) -> dict[str, Any]:
        return {"friction": self.settings.friction}
