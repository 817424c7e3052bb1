"""Cost of judging a load while it is planned, and the gain for packing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, methods_option, option

if TYPE_CHECKING:
    from steadyload.studies.session.showing import Found

PARTS = ("cost", "gain")


class Session(Study["Found"]):
    """Cost of sessions, and their gain for packing heuristics."""

    question = "What does judging while packing cost, and what does it gain?"
    about = "pack with and without rejecting what is not stable; what a placement costs"
    workers = None

    parts: tuple[str, ...] = option(
        (), "only this; may be repeated", names=("--part",), choices=PARTS
    )
    methods: tuple[str, ...] = methods_option(
        "measure only this; may be repeated (default: those of the published page)"
    )
    judge: str = option(
        "label@reference", "judges what was packed (default: label@reference)", metavar="SPEC"
    )
    lists: int = option(5, "item lists of each class that are packed (default: 5)", least=1)
    most_items: int = option(
        200, "items that are loaded where cost is measured (default: 200)", least=40, metavar="J"
    )

    def run(self, lab: Lab) -> Found:
        """Costs of placements, and gains of packing heuristics; parts not asked for are empty."""
        from steadyload.methods.registry import make_method
        from steadyload.runs.provenance import provenance_lines
        from steadyload.studies.session.packing_gains import REJECTING, packing_gains
        from steadyload.studies.session.placing import COSTED, session_curves
        from steadyload.studies.session.showing import Found

        parts = self.parts or PARTS
        if "gain" in parts:
            make_method(self.judge).prepare()
        curves, made_with = (
            session_curves(lab, self.methods or COSTED, count=self.most_items)
            if "cost" in parts
            else ([], provenance_lines())
        )
        tasks = (
            packing_gains(lab, self.methods or REJECTING, judge=self.judge, instances=self.lists)
            if "gain" in parts
            else []
        )
        return Found(curves, tasks, made_with)
