"""Ways of changing a plan until it stands, and the row that each makes of a plan."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache

from steadyload.app.checking import answer_on
from steadyload.app.repairs import ALLOWED, Outcome, repair
from steadyload.engines.registry import package_versions
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.layouts.packers.packed import packer_versions
from steadyload.methods.registry import make_method
from steadyload.repairing.changes import changes_between
from steadyload.repairing.plan import Kind
from steadyload.runs.provenance import made_by
from steadyload.studies.kit import Asked
from steadyload.studies.repair.one_pass import METHOD, one_pass
from steadyload.studies.repair.packing_again import packed_again

VERSION = 5
"""Version of all ways: raised when one of them comes to other plans."""

SEED = 0
"""Of random choices of the search."""


class Way(StrEnum):
    """A way of changing a plan, by its title."""

    LEAVE = "repair, boxes may be left out"
    KEEP = "repair, all boxes kept"
    ORDER = "repair, another order alone"
    ONCE = "one pass without a search"
    AGAIN = "packed again, 75 % supported"


ALLOWED_BY: Mapping[Way, Sequence[Kind]] = {
    Way.LEAVE: (*ALLOWED, Kind.LEAVE),
    Way.KEEP: ALLOWED,
    Way.ORDER: (Kind.ORDER,),
}
"""What the repair may change, by way."""

_OTHERS: Mapping[Way, Callable[[Layout], tuple[Layout, tuple[int, ...]]]] = {
    Way.ONCE: one_pass,
    Way.AGAIN: packed_again,
}

Box = tuple[float, float, float, float, float, float, float]
"""Lower corner (x, y, z) and size [cm], and weight [kg]."""


@dataclass(frozen=True, slots=True)
class Changed:
    """Outcome of a way on a plan.

    Attributes:
        way: word of :class:`Way`.
        plan: name of the layout.
        outcome: word of :class:`Outcome`, by the judge.
        judge: spec of the method that says so.
        step_before: at which the plan fails by the judge, from 0; None where that is not known.
        left_out: boxes that are left out.
        volume_left_out: share of the volume of all boxes, 0 to 1.
        moved: boxes at another place; None where it is not known which box is which.
        distance_cm: that these are moved, all together; likewise.
        retimed: boxes that are loaded at another time; likewise.
        seconds: CPU time of the process, with what the judge takes.
        stopped: what ended the search; empty for none.
        boxes: of the changed plan, in the order of loading; empty where none was confirmed.
    """

    way: str
    plan: str
    outcome: str
    judge: str
    step_before: int | None
    left_out: int
    volume_left_out: float
    moved: int | None
    distance_cm: float | None
    retimed: int | None
    seconds: float
    stopped: str
    boxes: Sequence[Box]

    @property
    def stands(self) -> bool:
        """Whether there is a changed plan that the judge confirms."""
        return self.outcome == Outcome.REPAIRED

    @property
    def by_order_alone(self) -> bool:
        """Whether another order of loading is all that differs."""
        return self.stands and not self.left_out and self.moved == 0

    def layout(self, pallet: Pallet) -> Layout:
        """The changed plan."""
        items = tuple(
            Item(step, (x, y, z), (width, height, depth), weight)
            for step, (x, y, z, width, height, depth, weight) in enumerate(self.boxes)
        )
        return Layout(self.plan, pallet, items)


class ChangeUnit(
    Asked[Changed],
    what="repair of a plan",
    version=VERSION,
    seed=SEED,
):
    """A plan that is changed in a way.

    Attributes:
        plan: centres of mass in the middle of its boxes; the overhang of its pallet is not used.
        way: word of :class:`Way`.
        judge: spec of the method that confirms.
        limit: CPU seconds of a search.
        made_by: versions of that method and of what else the way rests on.
    """

    plan: Layout
    way: str
    judge: str
    limit: float
    made_by: Mapping[str, str]

    def describe(self, part: int) -> str:
        """Description of the change for messages."""
        return f"{self.way}: {self.plan.name}"

    def measure(self) -> Changed:
        """Change the plan; what is compiled or imported first is not timed."""
        _warm_up(self.way, self.judge)
        return changed_by(Way(self.way), in_its_bin(self.plan), self.judge, self.limit)


def in_its_bin(plan: Layout) -> Layout:
    """A plan on a pallet over which boxes may stand out no further than they do: a container has
    walls.
    """
    pallet = plan.pallet
    before, behind = plan.lower[:, ::2].min(), plan.upper[:, ::2].max(axis=0)
    overhang = max(0.0, -before, *(behind - (pallet.width, pallet.depth)))
    return Layout(plan.name, replace(pallet, overhang=float(overhang)), plan.items)


def rests_on(way: Way, judge: str) -> dict[str, str]:
    """Everything besides the plan that changed plans depend on."""
    made = {f"judge: {name}": value for name, value in made_by(make_method(judge)).items()}
    if way is Way.ONCE:
        one_by_one = made_by(make_method(METHOD))
        made |= {f"pass: {name}": value for name, value in one_by_one.items()}
    if way is Way.AGAIN:
        made |= {"packvium": packer_versions()["packvium"]}
    return made | package_versions(("numpy",))


def changed_by(way: Way, plan: Layout, judge: str, limit: float) -> Changed:
    """The outcome of a way on a plan."""
    begun = time.process_time()
    if way not in ALLOWED_BY:
        changed, origins = _OTHERS[way](plan)
        after = answer_on(changed, judge)
        seconds, before = time.process_time() - begun, answer_on(plan, judge)
        outcome = Outcome.REPAIRED if after.stands else Outcome.NOT_REPAIRED
        stopped = ""
    else:
        found = repair(plan, ALLOWED_BY[way], method=judge, seconds=limit, seed=SEED)
        seconds = time.process_time() - begun
        assert found.layout is not None, "the plan is valid"
        assert found.before is not None, "and was judged"
        changed, origins, before = found.layout, found.origins, found.before
        outcome, stopped = found.outcome, str(found.stopped)
    stands = outcome is Outcome.REPAIRED
    kept = set(origins)
    volumes = plan.sizes.prod(axis=1)
    left = [step for step in range(len(plan)) if step not in kept]
    changes = changes_between(plan, changed, origins) if stands and way is not Way.AGAIN else None
    return Changed(
        way=str(way),
        plan=plan.name,
        outcome=str(outcome),
        judge=judge,
        step_before=None if before.verdict is None else before.verdict.failing_step,
        left_out=len(left) if stands else 0,
        volume_left_out=float(volumes[left].sum() / volumes.sum()) if stands else 0.0,
        moved=None if changes is None else sum(each.moved for each in changes),
        distance_cm=None if changes is None else sum(each.distance_cm for each in changes),
        retimed=None
        if changes is None
        else sum(bool(each.before or each.after) for each in changes),
        seconds=seconds,
        stopped=stopped,
        boxes=[(*each.position, *each.size, each.weight) for each in changed.items]
        if stands
        else [],
    )


@cache
def _warm_up(way: str, judge: str) -> None:
    """Change a small plan of which a box hangs over."""
    side = (20.0, 20.0, 20.0)
    boxes = (Item(0, (0.0, 0.0, 0.0), side, 5.0), Item(1, (15.0, 20.0, 0.0), side, 5.0))
    plan = Layout("small", Pallet(100.0, 100.0, 100.0), boxes)
    make_method(judge).prepare(len(plan))
    changed_by(Way(way), plan, judge, 10.0)
