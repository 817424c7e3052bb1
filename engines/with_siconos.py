"""Siconos: contacts without any compliance, under Moreau and Jean's time stepping.

It is packaged for the system's Python alone, and runs in a child (:mod:`steadyload.engines.child`).
"""

from __future__ import annotations

from typing import Any

from steadyload.engines.box import drawn_in, shrink_of
from steadyload.engines.child import CHANGING_GRAVITY, Children, ChildWorld, Shape
from steadyload.engines.system_python import PYTHON
from steadyload.engines.world import (
    Box,
    Capabilities,
    FailureKind,
    KnownFailure,
    SettingSupport,
    Support,
    declare,
)

_SHRINK = 1e-5
"""Sideways shrink of each side face [m], so that touching neighbours have no contacts in common."""

_MOST_BUILDS = 10_000
"""Each scene loses some 0.3 KiB of the child's memory for good, for each box."""


class SiconosWorld(ChildWorld):
    """A Siconos world.

    Raises:
        EngineError: Siconos's process died, took too long, or refused to go on.
    """

    children = Children("Siconos", PYTHON, "siconos_worker.py", _MOST_BUILDS)
    capabilities = Capabilities(
        title="Siconos",
        dimensions=3,
        settings=declare(
            friction=SettingSupport(Support.HONOURED),
            restitution=SettingSupport(Support.HONOURED, "Newton's law of impact at every contact"),
            linear_damping=SettingSupport(Support.IGNORED, "Siconos has none for a free body"),
            angular_damping=SettingSupport(Support.IGNORED, "Siconos has none for a free body"),
            margin=SettingSupport(Support.IGNORED, "contacts are found by the adapter, exactly"),
            broad_phase=SettingSupport(Support.IGNORED, "the adapter has one, of all pairs"),
            solver_iterations=SettingSupport(
                Support.HONOURED, "sweeps over all contacts, default 1000 at most"
            ),
        ),
        changing_gravity=CHANGING_GRAVITY,
        in_flight=SettingSupport(Support.HONOURED),
        notes="An independent check, part of no comparison unless named, for the system's "
        "Python of Debian 12: `apt-get install python3-siconos`. Contacts have no compliance: "
        "impulses obey Coulomb's law of friction and Newton's law of impact, of all contacts of a "
        "substep at once (Moreau and Jean's time stepping, nonsmooth Gauss-Seidel). It runs in a "
        "process of its own, whose CPU time is not counted: read wall time. The adapter finds "
        "contacts, in double precision, and divides a substep in which one closes. Side faces are "
        "drawn in by 0.01 mm. Figures, and why Siconos's own contacts are not used: "
        "[siconos.md](siconos.md).",
        known_failures=(
            KnownFailure(
                "momentum",
                FailureKind.NEVER,
                "impulses act on velocities alone: boxes that penetrate each other at the start "
                "are held, and never pushed apart",
                "two cubes of 10 cm in flight that overlap by 1 mm do so after 0.1 s; the momentum "
                "of both is right to 1e-9",
            ),
        ),
    )

    def _shape(self, box: Box) -> Shape:
        return Shape(drawn_in(box.size, shrink_of(box.size, _SHRINK)))

    def _scene_options(self) -> dict[str, Any]:
        return {
            "friction": self.settings.friction,
            "restitution": self.settings.restitution,
            "iterations": self.settings.solver_iterations,
        }
