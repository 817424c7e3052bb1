"""Empty maximal spaces: the largest boxes that lie inside a bin and clear of its items.

Nothing here knows which axis is up.
"""

from __future__ import annotations

from collections.abc import Sequence

Space = tuple[float, float, float, float, float, float]
"""Lower corner and upper corner along three axes [cm]."""


def volume(space: Space) -> float:
    """[cm3]."""
    return (space[3] - space[0]) * (space[4] - space[1]) * (space[5] - space[2])


def without(box: Space, spaces: Sequence[Space]) -> list[Space]:
    """Cut a box out of all spaces (difference) and drop what lies inside another (elimination).

    The order is that of creation: spaces that the box leaves whole keep their places, new ones
    follow, in the order of the spaces they were cut from and there below, then above the box along
    the first axis, the second, the third.

    Args:
        box: an item.
        spaces: maximal, in order of creation.

    Returns:
        The maximal spaces that are left, in order of creation.
    """
    # Written out by axis: this is where packing spends its time.
    a0, a1, a2, b0, b1, b2 = box
    whole: list[Space] = []
    touching: list[Space] = []
    parts: dict[Space, None] = {}
    for space in spaces:
        p0, p1, p2, q0, q1, q2 = space
        if q0 < a0 or p0 > b0 or q1 < a1 or p1 > b1 or q2 < a2 or p2 > b2:
            whole.append(space)
        elif q0 == a0 or p0 == b0 or q1 == a1 or p1 == b1 or q2 == a2 or p2 == b2:
            whole.append(space)
            touching.append(space)
        else:
            if a0 > p0:
                parts[(p0, p1, p2, a0, q1, q2)] = None
            if b0 < q0:
                parts[(b0, p1, p2, q0, q1, q2)] = None
            if a1 > p1:
                parts[(p0, p1, p2, q0, a1, q2)] = None
            if b1 < q1:
                parts[(p0, b1, p2, q0, q1, q2)] = None
            if a2 > p2:
                parts[(p0, p1, p2, q0, q1, a2)] = None
            if b2 < q2:
                parts[(p0, p1, b2, q0, q1, q2)] = None
    # A part has a face on the box. So whatever contains it is another part or touches the box;
    # and no part contains a space that was maximal before.
    larger = [*touching, *parts]
    for part in parts:
        p0, p1, p2, q0, q1, q2 = part
        for other in larger:
            if (
                other[0] <= p0
                and other[3] >= q0
                and other[1] <= p1
                and other[4] >= q1
                and other[2] <= p2
                and other[5] >= q2
                and other is not part
            ):
                break
        else:
            whole.append(part)
    return whole
