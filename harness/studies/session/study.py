"""Cost of judging a load while it is planned, and the gain for packing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study

if TYPE_CHECKING:
    from steadyload.studies.session.showing import Found


class Session(Study["Found"]):
    """Cost of sessions, and their gain for packing heuristics."""

    answers = "What does judging while packing cost, and what does it gain?"
    about = "pack with and without rejecting what is not stable; what a placement costs"
    workers = None

    def run(self, lab: Lab) -> Found:
        """Costs of placements, and gains of packing heuristics."""
        from steadyload.methods.registry import make_method
        from steadyload.studies.session.packing_gains import JUDGE, packing_gains
        from steadyload.studies.session.placing import session_curves
        from steadyload.studies.session.showing import Found

        make_method(JUDGE).prepare()  # before minutes of work
        curves, made_with = session_curves(lab)
        return Found(curves, packing_gains(lab), made_with)
