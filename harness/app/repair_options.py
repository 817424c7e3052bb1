"""Options of repairs."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

from steadyload.app.check_defaults import GAPS_CM
from steadyload.app.checking import Check, answer_on
from steadyload.errors import UserError, nearest
from steadyload.escaping import shown
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import Layout
from steadyload.methods.contract.method import Method
from steadyload.numbers import number_within, seconds_above_zero
from steadyload.repairing.plan import Kind
from steadyload.statics.load_margin import MOST

ALLOWED = (Kind.ORDER, Kind.DROP, Kind.SHIFT, Kind.TURN, Kind.MOVE)
"""What may change unless it is stated: all but leaving boxes out."""

SHIFT_CM = 30.0
"""How far a box that is shifted may move sideways [cm], where it may not move anywhere."""

SECONDS = 10.0
"""CPU seconds that the search may take unless another limit is given."""

MARGIN_CM = 2.0
"""Margin of balance that all boxes of a repaired plan have unless another is given [cm]."""

_LEAST_CM = 0.25
"""The smallest margin that is tried before the search asks for none [cm]."""


class RepairError(UserError):
    """An option of a repair that is not allowed: says which, and what is."""


@dataclass(frozen=True, kw_only=True)
class RepairOptions:
    """How plans are repaired.

    Attributes:
        allow: what may change, words of :class:`Kind`.
        method: that confirms what stands, or its spec; None as of :func:`steadyload.check`.
        shift_cm: how far ``shift`` may move a box sideways [cm], 0 or more.
        margin_cm: by how much all contacts of the plan that is found may be smaller on every side
            with every step still in balance [cm], 0 or more; where no plan has it, half of it is
            looked for, and so on; a box that is narrower than twice that has what it can have.
        seconds: CPU time that may be taken, above 0; the best plan that was confirmed by then
            counts. So it does after Ctrl-C.
        seed: of random choices, 0 or more: the same one finds the same plan, unless the time ends
            the search.
        gaps_cm: see :func:`steadyload.check`; where ``drop`` is allowed, boxes that drop by less
            are put down where nothing else helps.
        frame: axes and unit of the sentences.

    Raises:
        RepairError: there is no such change, or a number is not allowed.
        NumberError: the time is no finite number above 0.
        SpecError: there is no such method.
    """

    allow: Collection[Kind | str] = ALLOWED
    method: str | Method | None = None
    shift_cm: float = SHIFT_CM
    margin_cm: float = MARGIN_CM
    seconds: float = SECONDS
    seed: int = 0
    gaps_cm: float | None = GAPS_CM
    frame: Frame = Frame()

    def __post_init__(self) -> None:
        object.__setattr__(self, "allow", _kinds(self.allow))
        number_within("shift_cm", self.shift_cm, 0.0, unit="[cm]", error=RepairError)
        number_within("margin_cm", self.margin_cm, 0.0, MOST, unit="[cm]", error=RepairError)
        seconds_above_zero("seconds", self.seconds)
        if type(self.seed) is not int or self.seed < 0:
            raise RepairError(f"seed is {shown(self.seed)}; allowed: 0, 1, 2, ...")

    @property
    def margins_cm(self) -> Iterator[float]:
        """The margins that are looked for, one after the other [cm]."""
        margin = self.margin_cm
        while margin >= _LEAST_CM:
            yield margin
            margin *= 0.5
        yield 0.0

    @property
    def kinds(self) -> frozenset[Kind]:
        """Changes that may be made."""
        return _kinds(self.allow)

    def judge(self, layout: Layout) -> Check:
        """The answer of the method that confirms."""
        return answer_on(layout, self.method, gaps_cm=self.gaps_cm, frame=self.frame)


def _kinds(allow: Collection[Kind | str]) -> frozenset[Kind]:
    """The changes that words name.

    Raises:
        RepairError: there is no such change, or none is allowed.
    """
    if isinstance(allow, str) or not isinstance(allow, Collection) or len(allow) == 0:
        raise RepairError(f"allow is {shown(allow)}; allowed: one or more of {', '.join(Kind)}")
    for word in allow:
        if not isinstance(word, str) or word not in list(Kind):
            raise RepairError(f"allow has {shown(word)}; {nearest(str(word), list(Kind))}")
    return frozenset(map(Kind, allow))
