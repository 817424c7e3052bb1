"""What a page shows of a cascade, as small typed records. Shares are from 0 to 1, times in ms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from steadyload.methods.naming import MethodKey
from steadyload.statistics.estimate import Estimate


@dataclass(frozen=True, slots=True)
class HeldAgainst:
    """A method on the same cases as the cascade.

    ``ahead``: accuracy of the cascade minus that of the method, case by case; ``cost``: CPU time of
    the cascade over that of the method; both None for the cascade itself. ``substeps``: of
    an engine, mean a layout, the same on every machine. ``simulation``: it runs on an engine and is
    no cascade. ``budget``: that of a cascade [points], None for other methods.
    """

    method: MethodKey
    accuracy: Estimate
    over: Estimate
    under: Estimate
    cpu: Estimate
    ahead: Estimate | None
    cost: Estimate | None
    substeps: float
    simulation: bool
    budget: float | None


@dataclass(frozen=True, slots=True)
class StageShare:
    """What one stage decided.

    ``low``, ``high``: risks below and above which it is sure; None: it never is, and both None for
    the last one, which decides the rest. ``steps``: share of all steps that it decided; ``right``:
    share of these that are right, where a label speaks of them. ``layouts``: share of layouts that
    needed it and no later one; ``layouts_right``: share of these with the right verdict.
    """

    method: MethodKey
    low: float | None
    high: float | None
    steps: Estimate
    right: Estimate
    layouts: Estimate
    layouts_right: Estimate


@dataclass(frozen=True, slots=True)
class Decided:
    """Steps that a stage decided where thresholds were fitted, how many wrongly, and lost cases."""

    method: str
    steps: int
    wrong: int
    lost: int


@dataclass(frozen=True, slots=True)
class Held:
    """A stage that learnt nothing from labels, asked of every step of other cases."""

    method: str
    cases: int
    item_lists: int
    steps: int
    decided: int
    wrong: int


@dataclass(frozen=True, slots=True)
class FittedLadder:
    """Thresholds as they were fitted, for one budget [points of accuracy].

    ``stages``: (method, low, high). ``allowed``: cases that could be lost, ``lost``: that are,
    where the last method alone is right; ``gained`` the other way round. ``bound``: of the share of
    lost cases, at the confidence that was asked for; ``sure_bound`` at 95 %. ``left_out``: lost,
    and cases, where every item list is judged by thresholds fitted without it. ``cost``,
    ``cost_alone``: of the ladder and of its last method, from the times of single steps.
    """

    budget: float
    stages: tuple[tuple[str, float | None, float | None], ...]
    last: str
    cases: int
    item_lists: int
    independent: float
    allowed: int
    lost: int
    gained: int
    bound: float
    sure_bound: float
    left_out: tuple[int, int]
    accuracy: float
    accuracy_alone: float
    cost: float
    cost_alone: float
    decided: tuple[Decided, ...]
    elsewhere: tuple[Held, ...]


@dataclass(frozen=True, slots=True)
class CascadeStudy:
    """A cascade on a part of a labelled set, beside other methods.

    ``cascade`` is the first of ``methods``. ``load``: processes that wanted to run while times were
    taken, one of them ours; None where it is not known. ``confidence``: of the bounds of the fit.
    ``made_by``: what thresholds were fitted with.
    """

    part: str
    cases: int
    item_lists: int
    methods: tuple[HeldAgainst, ...]
    stages: tuple[StageShare, ...]
    steps_a_layout: float
    ladders: tuple[FittedLadder, ...]
    confidence: float
    load: float | None
    made_by: Mapping[str, str]

    @property
    def cascade(self) -> HeldAgainst:
        """The cascade that all others are held against."""
        return self.methods[0]
