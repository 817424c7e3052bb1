"""Why a load fails: where it loses its balance in the plan, and what a simulation adds to that."""

from __future__ import annotations

from dataclasses import dataclass

from steadyload.layouts.model.footing import Footing, footing
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout
from steadyload.layouts.model.naming import label_in
from steadyload.methods.contract.spec import parse_spec
from steadyload.methods.contract.verdict import Verdict
from steadyload.statics.balance_lost import BalanceLost, balance_lost
from steadyload.statics.resolution import UnresolvedError


@dataclass(frozen=True, slots=True)
class Fault:
    """The facts behind a load that fails.

    Attributes:
        step: at which the method says that it fails.
        simulation: name and engine of the simulation that saw the box at fault move, the method or
            a stage of it: "ps_opt@rapier"; empty where the step was not simulated.
        footing: in the plan, of the box that moves too far; of the box that is placed at the step,
            where none is known to move.
        lost: the first step at which contact forces do not balance the plan; None where they
            balance every box.
        resolved: False where rounding hides whether they do.
    """

    step: int
    simulation: str
    footing: Footing
    lost: BalanceLost | None
    resolved: bool = True

    def sentence(self, layout: Layout, frame: Frame | None = None) -> str:
        """Why the load fails: first what equilibrium says of the plan, then what the method adds.

        Args:
            layout: the plan.
            frame: axes and unit of the sentence; None for ours.
        """
        own = self.footing.sentence(layout, frame)
        if not self.resolved:
            return f"{own}; rounding hides whether contact forces balance the plan"
        lost, box = self.lost, label_in(layout.items, self.footing.item)
        placed = f"when {label_in(layout.items, self.step)} is placed"
        is_another = self.footing.item != self.step
        if lost is None or lost.step > self.step:
            boxes = "the first box" if self.step == 0 else f"the first {self.step + 1} boxes"
            later = "" if lost is None else f", up to {label_in(layout.items, lost.step)}"
            moves = "the method alone calls the load unstable"
            if self.simulation:
                moves = f"only in the simulation of {self.simulation} does it move too far"
            when = f" {placed}" if is_another else ""
            return f"{own}; contact forces balance {boxes}{later}, and {moves}{when}"
        said = lost.sentence(layout, frame)
        if lost.step < self.step:
            moves = f", and then {box} moves too far" if is_another else ""
            tells = self.footing.edge is not None or self.footing.gap is not None
            detail = f": {own}" if tells and self.footing.item != lost.item else ""
            return f"{said}; the method sees the load fail only {placed}{moves}{detail}"
        if self.simulation and lost.item != self.footing.item:
            return f"{said}; in the simulation of {self.simulation} {box} moves too far first"
        return said


def fault_of(layout: Layout, verdict: Verdict, method: str) -> Fault | None:
    """The facts behind a load that fails; None for one that does not.

    Args:
        layout: the plan.
        verdict: on it.
        method: spec of the method whose verdict it is.
    """
    item, step = verdict.item_at_fault, verdict.failing_step
    if item is None or step is None:
        return None
    lost, resolved = None, True
    try:
        lost = balance_lost(layout)
    except UnresolvedError:
        resolved = False
    decided = parse_spec(verdict.stage or method)
    seen = verdict.displacement is not None and decided.engine is not None
    simulation = f"{decided.name}@{decided.engine}" if seen else ""
    return Fault(step, simulation, footing(layout, item), lost, resolved)
