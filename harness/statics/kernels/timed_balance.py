"""Loading step by step, where items that lose their balance are followed for some time.

A step is looked at only as far as it changes something. Where the new weight is passed down to
items at rest, and nothing of the group is out of balance, the step is stable. Where something of
the group is, its motion is asked for; the answer is kept until another group joins it, until a new
weight is passed down to what moves or to what that leans on, or until a new item touches what moves
or stands where it came along.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from steadyload.statics.kernels.balance import joined, passed_down, patches_above
from steadyload.statics.kernels.compiled import compiled
from steadyload.statics.kernels.constants import (
    BALANCED,
    TIE,
    TOLERANCE,
    UNBALANCED,
    UNDECIDED,
    UNRESOLVED,
)
from steadyload.statics.kernels.contacts import Contacts, contacts_of
from steadyload.statics.kernels.local_balance import balance_group
from steadyload.statics.kernels.motion import motion_of

_KEPT, _ASKED = 0, 1


class Loading(NamedTuple):
    """A loading, and what is known of it so far.

    Attributes:
        lower, upper, weights, floor: see :mod:`steadyload.statics.kernels`.
        centres: of mass (x, y, z) [cm], (J, 3).
        contacts: of the whole layout.
        meets: of :func:`~steadyload.statics.kernels.balance.patches_above`.
        presses: vertical forces and their moments at patches, (P, 3).
        corners: of patches that pressed when forces were solved for last, (P, 4).
        pushes: of :func:`~steadyload.statics.kernels.motion.motion_of`, (J + 1, J + 1).
        changed, room: for forces and loads at patches, (P, 3) and (P, 6).
        moves: items that vertical forces do not balance, (J,).
        answers: number of the last motion asked for of the item's group, 0 where there is none or
            something has come in its way, (J,).
        solved: items that moved then, or were solved for, (J,).
        leans: items at rest that carried something of those, (J,).
        most: how far corners of those came along every axis [cm], (J, 3, 2).
        beyond: how far something of the item's group got then, in units of its threshold, (J,).
        counts: steps at which the last motion was kept, and at which it was asked for, (2,).
        work: that motions have taken, see :func:`~steadyload.statics.kernels.motion.motion_of`, and
            that they may take; the latter may be set, (2,).
    """

    lower: Any
    upper: Any
    weights: Any
    floor: Any
    centres: Any
    contacts: Contacts
    meets: Any
    presses: Any
    corners: Any
    pushes: Any
    changed: Any
    room: Any
    moves: Any
    answers: Any
    solved: Any
    leans: Any
    most: Any
    beyond: Any
    counts: Any
    work: Any


@compiled
def begin(lower: Any, upper: Any, weights: Any, offsets: Any, floor: Any) -> Loading:
    """A loading of which nothing is placed yet.

    Args:
        lower: see :mod:`steadyload.statics.kernels`.
        upper: likewise.
        weights: likewise.
        offsets: likewise.
        floor: likewise, shape (5,).
    """
    count = len(lower)
    contacts = contacts_of(lower, upper, floor)
    patches = len(contacts.below)
    return Loading(
        lower, upper, weights, floor, 0.5 * (lower + upper) + offsets, contacts,
        patches_above(contacts), np.zeros((patches, 3)), np.zeros((patches, 4), dtype=np.bool_),
        np.zeros((count + 1, count + 1), dtype=np.int64), np.zeros((patches, 3)),
        np.zeros((patches, 6)), np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.int64),
        np.zeros(count, dtype=np.bool_), np.zeros(count, dtype=np.bool_), np.zeros((count, 3, 2)),
        np.zeros(count), np.zeros(2, dtype=np.int64), np.array([0.0, np.inf]),
    )  # fmt: skip


@compiled
def place(
    step: int, loading: Loading, friction: float, gravity: float, seconds: float, eps_t: float,
    eps_r: float,
) -> Any:  # fmt: skip
    """Place an item; all before it must have been placed.

    Args:
        step: the item.
        loading: what is known so far, which is brought up to date.
        friction: of tops and bases; sides have none.
        gravity: [cm/s2].
        seconds: how long items that lost their balance are followed.
        eps_t: displacement that counts as moved [cm].
        eps_r: angle that counts as moved [degrees].

    Returns:
        How it ended; the item that comes farthest, how far its left-bottom-back corner comes along
        an axis [cm], the angle it turns by [degrees] and the larger of the two in units of its
        threshold; -1 and zeros where nothing moves or the last motion was kept.
    """
    nothing = -1, 0.0, 0.0, 0.0
    ended, kept, group = moving_group(step, loading)
    if ended != UNBALANCED:
        return (ended, *nothing)
    if kept:
        loading.counts[_KEPT] += 1
        return (BALANCED, *nothing)
    return moved(step, group, loading, friction, gravity, seconds, eps_t, eps_r)


@compiled
def moving_group(step: int, loading: Loading) -> Any:
    """Place an item, and tell whether anything of its group is out of balance then.

    Args:
        step: the item; all before it must have been placed.
        loading: what is known so far; its forces, and the items that move, are brought up to date.

    Returns:
        How it ended; whether the last motion of the group is that with the new item, too; and the
        group, empty where nothing of it moves.
    """
    nobody = np.empty(0, dtype=np.int64)
    contacts = loading.contacts
    for item in range(step):
        # Whatever stands in the way of what moved, on the floor or in another group, too.
        if loading.solved[item] and _meets(item, step, loading):
            loading.answers[item] = 0
    if contacts.on_floor[step]:
        return BALANCED, False, nobody
    loading.changed[:] = 0.0
    first = contacts.above_starts[step]
    passed = (
        first == contacts.above_ends[step] or contacts.above[first] > step
    ) and passed_down(
        step, contacts, loading.meets, loading.centres, loading.weights, loading.lower,
        loading.moves, loading.presses, loading.changed,
    )  # fmt: skip
    if passed and not loading.moves[: step + 1].any():
        return BALANCED, False, nobody
    group = joined(step, contacts)
    kept = False
    if passed:
        if not loading.moves[group].any():
            return BALANCED, False, nobody
        kept = _is_kept(step, group, loading)
        if kept:
            loading.answers[step] = loading.answers[group].max()
    else:
        ended, _ = balance_group(
            step, group, contacts, loading.meets, loading.centres, loading.weights, loading.lower,
            loading.upper, loading.presses, loading.presses, loading.corners, loading.moves,
            loading.room, False,
        )  # fmt: skip
        if ended != UNBALANCED:
            return ended, False, nobody
    return UNBALANCED, kept, group


@compiled
def moved(
    step: int, group: Any, loading: Loading, friction: float, gravity: float, seconds: float,
    eps_t: float, eps_r: float,
) -> Any:  # fmt: skip
    """Ask for the motion of a group that :func:`moving_group` found.

    Args:
        step: see :func:`place`, as are the others.
        group: of the item.
        loading: see :func:`place`.
        friction: likewise.
        gravity: likewise.
        seconds: likewise.
        eps_t: likewise.
        eps_r: likewise.

    Returns:
        See :func:`place`; ``UNDECIDED`` where it takes more work than is allowed.
    """
    lower, upper, centres = loading.lower, loading.upper, loading.centres
    # How far a corner can come before its item counts as moved.
    turned = 2.0 * np.sin(0.5 * np.radians(min(eps_r, 180.0)))
    widest = 0.0
    for item in group:
        widest = max(widest, ((upper[item] - lower[item]) ** 2).sum())
    motion = motion_of(
        step, group, eps_t + turned * np.sqrt(widest), friction, gravity, seconds,
        loading.contacts, loading.meets, centres, loading.weights, lower, upper, loading.floor,
        loading.presses, loading.moves, loading.room, loading.pushes, loading.work,
    )  # fmt: skip
    loading.counts[_ASKED] += 1
    if not motion.ended:
        spent, allowed = loading.work
        return (UNDECIDED if spent > allowed else UNRESOLVED), -1, 0.0, 0.0, 0.0
    worst, shift, turn, most = -1, 0.0, 0.0, -1.0
    answer = loading.answers.max() + 1
    for item in group:  # of items that come equally far the first is named
        loading.answers[item] = answer
        loading.solved[item] = motion.role[item] != 0
        loading.leans[item] = motion.leans[item]
        loading.most[item] = motion.most[item]
        x, y, z = lower[item] - centres[item]
        a, b, c = motion.way[item, 3:]
        dx = abs(motion.way[item, 0] + b * z - c * y)
        dy = abs(motion.way[item, 1] + c * x - a * z)
        dz = abs(motion.way[item, 2] + a * y - b * x)
        far, angle = max(dx, dy, dz), np.degrees(max(abs(a), abs(b), abs(c)))
        beyond = max(far / max(eps_t, 1e-12), angle / max(eps_r, 1e-12))
        if beyond * (1.0 - TIE) > most:
            worst, shift, turn, most = item, far, min(angle, 180.0), beyond
    loading.beyond[group] = most
    return UNBALANCED, worst, shift, turn, most


@compiled
def _is_kept(step: int, group: Any, loading: Loading) -> bool:
    """Whether the last motion of a group is that of the group with its new item, too."""
    answer = 0
    for item in group:
        if item != step:
            if answer == 0:
                answer = loading.answers[item]
            if loading.answers[item] != answer or answer == 0:
                return False  # groups that were not joined then
        if (loading.leans[item] or loading.solved[item]) and _is_loaded(item, loading):
            return False
    return True


@compiled
def _is_loaded(item: int, loading: Loading) -> bool:
    """Whether the new weight is passed down by an item."""
    contacts = loading.contacts
    own = loading.changed[contacts.starts[item] : contacts.ends[item], 0]
    return bool((own != 0.0).any())


@compiled
def _meets(item: int, new: int, loading: Loading) -> bool:
    """Whether an item that moved touches the new one, or came as far as that."""
    lower, upper = loading.lower, loading.upper
    for axis in range(3):
        b, c = (axis + 1) % 3, (axis + 2) % 3
        if (
            min(upper[item, b], upper[new, b]) - max(lower[item, b], lower[new, b]) > TOLERANCE
            and min(upper[item, c], upper[new, c]) - max(lower[item, c], lower[new, c]) > TOLERANCE
        ):
            ahead, behind = (
                lower[new, axis] - upper[item, axis],
                lower[item, axis] - upper[new, axis],
            )
            if -TOLERANCE <= ahead <= loading.most[item, axis, 0] + 3.0 * TOLERANCE:
                return True
            if -TOLERANCE <= behind <= loading.most[item, axis, 1] + 3.0 * TOLERANCE:
                return True
    return False


@compiled
def first_moved(
    loading: Loading, first: int, end: int, friction: float, gravity: float, seconds: float,
    eps_t: float, eps_r: float,
) -> Any:  # fmt: skip
    """Place items until one comes too far.

    Args:
        loading: see :func:`place`, as are the others.
        first: the first item to place.
        end: the one not to place any more.
        friction: see :func:`place`.
        gravity: likewise.
        seconds: likewise.
        eps_t: likewise.
        eps_r: likewise.

    Returns:
        How the search ended (``BALANCED`` where nothing comes too far), the step (``end`` then),
        the item, its displacement [cm] and angle [degrees].
    """
    for step in range(first, end):
        ended, item, shift, turn, beyond = place(
            step, loading, friction, gravity, seconds, eps_t, eps_r
        )
        if ended in (UNRESOLVED, UNDECIDED) or beyond > 1.0:
            return ended, step, item, shift, turn
    return BALANCED, end, -1, 0.0, 0.0


@compiled
def first_moved_of(
    lower: Any, upper: Any, weights: Any, offsets: Any, floor: Any, work: float, friction: float,
    gravity: float, seconds: float, eps_t: float, eps_r: float,
) -> Any:  # fmt: skip
    """:func:`first_moved` of a whole layout, whose arrays :func:`begin` describes, with no more
    work on motions than is allowed.
    """
    loading = begin(lower, upper, weights, offsets, floor)
    loading.work[1] = work
    return first_moved(loading, 0, len(lower), friction, gravity, seconds, eps_t, eps_r)


@compiled
def first_moved_of_many(
    lower: Any, upper: Any, weights: Any, offsets: Any, floors: Any, starts: Any, work: float,
    friction: float, gravity: float, seconds: float, eps_t: float, eps_r: float,
) -> Any:  # fmt: skip
    """How :func:`first_moved` ended for every layout of a batch, the step, the displacement [cm]
    and the angle [degrees], (L,) each.
    """
    count = len(starts) - 1
    ended, steps = np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    shifts, turns = np.empty(count), np.empty(count)
    for k in range(count):
        part = slice(starts[k], starts[k + 1])
        ended[k], steps[k], _, shifts[k], turns[k] = first_moved_of(
            lower[part], upper[part], weights[part], offsets[part], floors[k], work, friction,
            gravity, seconds, eps_t, eps_r,
        )  # fmt: skip
    return ended, steps, shifts, turns
