"""Cost of judging a load while it is planned, and the gain for packing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from steadyload.studies.kit import Lab, Study, option

if TYPE_CHECKING:
    from steadyload.studies.session.showing import Found


class Session(Study["Found"]):
    """Cost of sessions, and their gain for packing heuristics."""

    answers = "What does judging while packing cost, and what does it gain?"
    about = "pack with and without rejecting what is not stable; what a placement costs"
    workers = None

    limit: int | None = option(
        None, "only N item lists of each class, and loads of 40 boxes (default: 5, and 200)",
        least=1, metavar="N",
    )  # fmt: skip

    def run(self, lab: Lab) -> Found:
        """Costs of placements, and gains of packing heuristics."""
        from steadyload.methods.registry import make_method
        from steadyload.studies.session.packing_gains import ITEM_LISTS, JUDGE, packing_gains
        from steadyload.studies.session.placing import ITEMS, SHOWN, session_curves
        from steadyload.studies.session.showing import shown

        make_method(JUDGE).prepare()  # before minutes of work
        lists, boxes = (ITEM_LISTS, ITEMS) if self.limit is None else (self.limit, SHOWN[0])
        curves, made_with = session_curves(lab, count=boxes)
        return shown(curves, packing_gains(lab, instances=lists), made_with)
