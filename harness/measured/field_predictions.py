"""Predictions of methods for tests of real stacks, and how often they agree with what was seen."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from steadyload.layouts.model.naming import box_id, with_ids
from steadyload.measured.errors import FieldTestError
from steadyload.measured.field_tests import Done, FieldTest
from steadyload.methods.contract.method import Method, Status, judge
from steadyload.methods.registry import make_method
from steadyload.numbers import number_within, seconds_allowed
from steadyload.progress import Progress, silent
from steadyload.statistics.estimate import Estimate
from steadyload.statistics.metrics import share
from steadyload.transport.balance import Mode
from steadyload.transport.errors import TransportError
from steadyload.transport.limits import EXACT, knows_accelerations, limits
from steadyload.transport.whole_load import whole_load_limit

DECK_FRICTION = 0.5
"""Friction at the deck of the rule of thumb, unless another is named."""

TOLERANCE_DEG, TOLERANCE_G = 2.0, 0.05
"""Differences of a predicted limit from what was seen up to which the two agree [degrees, g]."""

FEWEST = 5
"""Tests from which on a share of agreement has an interval."""


@dataclass(frozen=True)
class Prediction:
    """The prediction of a method for a test of a complete load or of its loading.

    Attributes:
        test: the test.
        method: spec of the method, or ``b/h`` with its friction, the rule of thumb.
        applies: the method is one that predicts such tests.
        failing_step: of a test by placing, the step that fails; None for a load that stands, and
            where there is no prediction.
        limit_deg: of a test by tilting, the largest angle that the load holds [degrees].
        limit_g: of a test by accelerating, the largest acceleration that it holds [g].
        moved_item: step of the box that moves first.
        mode: how it moves beyond a limit.
        agrees: it agrees with what was seen; None where there is no prediction.
        same_box: the box that moves first is the one that was seen to; None where one of them is
            not known, or none moves.
        reason: why there is no prediction, or why a step fails.
    """

    test: FieldTest
    method: str
    applies: bool = True
    failing_step: int | None = None
    limit_deg: float | None = None
    limit_g: float | None = None
    moved_item: int | None = None
    mode: Mode | None = None
    agrees: bool | None = None
    same_box: bool | None = None
    reason: str = ""

    def to_dict(self) -> dict[str, Any]:
        """A record of plain values, with units in its names: the test, then the prediction."""
        test, items = self.test, self.test.layout.items
        own = asdict(self)
        del own["test"]
        return {
            "test": test.name,
            "plan": test.plan,
            "layout": test.layout.name,
            "done": str(test.done),
            "towards_deg": test.towards_deg,
            "tilt_deg": test.tilt_deg,
            "acceleration_g": test.acceleration_g,
            "moved": test.moved,
            "seen_item": test.moved_step,
            "seen_box": box_id(items, test.moved_step),
            "seen_step": test.moved_at_step,
            "seen_deg": test.moved_at_deg,
            "seen_g": test.moved_at_g,
            **own,
            "mode": None if self.mode is None else str(self.mode),
            "moved_box": box_id(items, self.moved_item),
        }


@dataclass(frozen=True)
class Agreement:
    """How often a method agrees with what was seen.

    Attributes:
        method: spec.
        counts: what was done -> number of tests that agree, and of tests with a prediction.
        share: of all tests with a prediction that agree, with its interval; tests of one layout
            belong together.
        unanswered: tests that the method should predict, and does not.
    """

    method: str
    counts: dict[Done, tuple[int, int]]
    share: Estimate
    unanswered: int


def predictions(
    tests: Sequence[FieldTest],
    methods: Sequence[str | Method] = (EXACT,),
    *,
    deck_friction: float | None = DECK_FRICTION,
    tolerance_deg: float = TOLERANCE_DEG,
    tolerance_g: float = TOLERANCE_G,
    timeout: float | None = None,
    progress: Progress = silent,
) -> list[Prediction]:
    """Predictions of some methods for every test, test by test.

    A test by placing compares the failing step. For a complete load the limit is that of
    :func:`steadyload.transport.limits.limits` in the direction of the test. A tilt by an angle a
    is an acceleration of g tan a where gravity is g cos a, so that a limit in g is the tangent of
    one in degrees. A limit agrees with a box that moved if the two differ by the tolerance at most,
    and with a load that held if it is at least as far as the load was taken, less the tolerance.

    Args:
        tests: as :func:`steadyload.measured.field_files.read_field_tests` gives them.
        methods: themselves, or their specs.
        deck_friction: of the rule of thumb for complete loads, which comes after the methods: the
            lesser of it and of b / h of the load as one box; None for no such rule.
        tolerance_deg: of limits of tilting [degrees], 0 or more.
        tolerance_g: of limits of accelerating [g], 0 or more.
        timeout: CPU seconds that a judgement of a test by placing may take.
        progress: called with the number of finished predictions and of all.

    Raises:
        FieldTestError: a tolerance or the friction is no such number.
        NumberError: the timeout is no finite number above 0.
        SpecError, EngineNotInstalledError: see :func:`steadyload.methods.registry.make_method`.
    """
    made = [make_method(one) if isinstance(one, str) else one for one in methods]
    judging = list({str(one.spec): one for one in made}.values())
    tolerances = {
        Done.TILTED: _from_zero("tolerance_deg", tolerance_deg, "[degrees]"),
        Done.ACCELERATED: _from_zero("tolerance_g", tolerance_g, "[g]"),
    }
    if deck_friction is not None:
        deck_friction = _from_zero("deck_friction", deck_friction)
    seconds_allowed(timeout)
    for method in judging:
        method.prepare(max((len(test.layout) for test in tests), default=0))
    total = len(tests) * (len(judging) + (deck_friction is not None))
    found: list[Prediction] = []
    progress(0, total)
    for test in tests:
        for one in _of(test, judging, deck_friction, tolerances, timeout):
            found.append(one)
            progress(len(found), total)
    return found


def _from_zero(name: str, value: float, unit: str = "") -> float:
    return number_within(name, value, 0.0, 1e6, unit=unit, error=FieldTestError)


def _of(
    test: FieldTest,
    methods: Sequence[Method],
    deck_friction: float | None,
    tolerances: dict[Done, float],
    timeout: float | None,
) -> Iterator[Prediction]:
    for method in methods:
        if test.done is Done.PLACED:
            yield _loading(test, method, timeout)
        else:
            yield _complete(test, method, tolerances[test.done])
    if deck_friction is None:
        return
    name = f"b/h:friction={deck_friction:g}"
    if test.done is Done.PLACED:
        yield Prediction(test, name, applies=False, reason="predicts complete loads alone")
        return
    assert test.towards_deg is not None
    try:
        limit = whole_load_limit(test.layout, deck_friction, test.towards_deg)
    except TransportError as error:
        yield Prediction(test, name, reason=str(error))
    else:
        yield _limited(test, name, limit, tolerances[test.done])


def _loading(test: FieldTest, method: Method, timeout: float | None) -> Prediction:
    """The failing step of a load that is placed box by box."""
    verdict = judge(method, test.layout, timeout)
    reason = with_ids(verdict.reason, test.layout.items)
    if verdict.status is not Status.DONE:
        return Prediction(test, str(method.spec), reason=reason or str(verdict.status))
    return Prediction(
        test,
        str(method.spec),
        failing_step=verdict.failing_step,
        moved_item=verdict.moved_item,
        agrees=verdict.failing_step == test.moved_at_step,
        same_box=_same(test, verdict.moved_item),
        reason=reason,
    )


def _complete(test: FieldTest, method: Method, tolerance: float) -> Prediction:
    """The limit of a complete load."""
    spec = str(method.spec)
    if not knows_accelerations(method):
        return Prediction(test, spec, applies=False, reason="predicts loading alone")
    assert test.towards_deg is not None
    [found] = limits(test.layout, method, directions=[test.towards_deg])
    if found.limit_g is None:
        return Prediction(test, spec, reason=found.reason)
    return _limited(test, spec, found.limit_g, tolerance, found.moved_item, found.mode)


def _limited(
    test: FieldTest,
    method: str,
    limit_g: float,
    tolerance: float,
    moved_item: int | None = None,
    mode: Mode | None = None,
) -> Prediction:
    tilted = test.done is Done.TILTED
    limit = math.degrees(math.atan(limit_g)) if tilted else limit_g
    assert test.reached is not None
    if test.moved_at is None:
        agrees = limit >= test.reached - tolerance
    else:
        agrees = abs(limit - test.moved_at) <= tolerance
    return Prediction(
        test,
        method,
        limit_deg=limit if tilted else None,
        limit_g=None if tilted else limit,
        moved_item=moved_item,
        mode=mode,
        agrees=agrees,
        same_box=_same(test, moved_item),
    )


def _same(test: FieldTest, moved_item: int | None) -> bool | None:
    if test.moved_step is None or moved_item is None:
        return None
    return moved_item == test.moved_step


def agreements(found: Sequence[Prediction]) -> list[Agreement]:
    """How often each method agrees with what was seen, in the order of the methods.

    Args:
        found: as :func:`predictions` gives them.
    """
    return [
        _agreement(method, [one for one in found if one.method == method])
        for method in dict.fromkeys(one.method for one in found)
    ]


def _agreement(method: str, own: Sequence[Prediction]) -> Agreement:
    answered = [one for one in own if one.agrees is not None]
    counts = {}
    for done in Done:
        hits = [bool(one.agrees) for one in answered if one.test.done is done]
        if hits:
            counts[done] = (sum(hits), len(hits))
    return Agreement(
        method,
        counts,
        share(
            [bool(one.agrees) for one in answered],
            [f"{one.test.plan}\n{one.test.layout.name}" for one in answered],
        ),
        sum(one.applies and one.agrees is None for one in own),
    )
