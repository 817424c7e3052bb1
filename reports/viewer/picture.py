"""The picture of a load that stands still: what is drawn, in which order and colours, and as SVG.

A page of many loads draws its pictures in the browser, in the same order and colours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steadyload.reports.viewer.records import Triple

WIDTH, HEIGHT = 440, 330
"""Of a picture [px]."""

_EDGE = 12.0
"""Left empty on every side [px]."""

RAMP = ("#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39")
"""Colours of boxes, from the first to the last one loaded."""

MARKED, AMBER, WOOD, OUTLINE = "#e31a1c", "#ff9f1c", "#c9b997", "#10151f"
"""Colours of the marked box, of one that is crushed, of the deck, and of edges."""

_SIDES = (((4, 5, 7, 6), 1.0), ((1, 3, 7, 5), 0.72), ((2, 3, 7, 6), 0.86))
"""Faces seen from high x, y and z, and how light each is: top, high x, high z. The corner
``x + 2 * z + 4 * y`` is at the low (0) or high (1) end of every axis."""


@dataclass(frozen=True, slots=True)
class LoadPicture:
    """A load to be drawn.

    Attributes:
        pallet: width, height and depth [cm].
        boxes: lower corners and sizes in the order of loading [cm], y up, shape (boxes, 6).
        marked: number of the box that is red; None for none.
        moved: numbers of boxes that are amber: those that a repair put elsewhere.
        caption: in words, for those who do not see it.
    """

    pallet: Triple
    boxes: NDArray[np.float64]
    marked: int | None = None
    moved: frozenset[int] = frozenset()
    caption: str = ""


def load_svg(*pictures: LoadPicture) -> str:
    """Loads as SVG beside each other, at one scale, seen from the side of high x and z.

    Colours are the order of loading. The marked box is red, and shines through where others stand
    before it; moved ones are amber.

    Args:
        pictures: one or more.
    """
    drawn = [_seen(picture) for picture in pictures]
    ends = [_ends(deck, corners) for deck, corners in drawn]
    room = np.array((WIDTH, HEIGHT))
    most = np.max([high - low for low, high in ends], axis=0)
    scale = ((room - 2.0 * _EDGE) / np.maximum(most, 1e-9)).min()
    faces = []
    for place, (picture, (deck, corners)) in enumerate(zip(pictures, drawn, strict=True)):
        low, high = ends[place]
        shift = 0.5 * (room - scale * (low + high)) + (place * WIDTH, 0.0)
        faces += _faces(picture, scale * deck + shift, scale * corners + shift)
    width = len(pictures) * WIDTH
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{HEIGHT}" '
        f'viewBox="0 0 {width} {HEIGHT}" stroke="{OUTLINE}" stroke-opacity="0.6" '
        f'stroke-linejoin="round">{"".join(faces)}</svg>'
    )


def _seen(picture: LoadPicture) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners of the deck and of boxes as they are seen, shapes (4, 2) and (boxes, 8, 2)."""
    width, _, depth = picture.pallet
    deck = _flat(np.array([(0, 0, 0), (width, 0, 0), (width, 0, depth), (0, 0, depth)], float))
    return deck, _flat(_corners(np.asarray(picture.boxes, dtype=float).reshape(-1, 6)))


def _ends(
    deck: NDArray[np.float64], corners: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    points = np.concatenate((deck, corners.reshape(-1, 2)))
    return points.min(axis=0), points.max(axis=0)


def _faces(
    picture: LoadPicture, deck: NDArray[np.float64], corners: NDArray[np.float64]
) -> list[str]:
    """Faces of a load, those behind first, from corners [px]."""
    faces = [_polygon(deck, WOOD)]
    for box in behind_first(np.asarray(picture.boxes, dtype=float).reshape(-1, 6)):
        colour = MARKED if box == picture.marked else RAMP[len(RAMP) * box // len(corners)]
        colour = AMBER if box in picture.moved else colour
        faces += [
            _polygon(corners[box, list(of)], shade)
            for (of, _), shade in zip(_SIDES, shades(colour), strict=True)
        ]
    if picture.marked is not None:
        faces += [_shining(corners[picture.marked, list(of)]) for of, _ in _SIDES]
    return faces


def behind_first(boxes: NDArray[np.float64]) -> list[int]:
    """Numbers of boxes from the farthest to the nearest one, seen from high x, y and z.

    Boxes that stand behind each other in a circle come in the order of loading.

    Args:
        boxes: see :class:`LoadPicture`; they overlap by less than a millimetre.
    """
    low = np.rint(10.0 * boxes[:, :3])
    high = np.rint(10.0 * (boxes[:, :3] + boxes[:, 3:]))
    behind = (high[:, None] <= low[None]).any(axis=2)
    behind &= ~behind.T & _overlapping(low, high)
    waits, order = behind.sum(axis=0), []
    for _ in range(len(boxes)):
        box = int(waits.argmin())
        order.append(box)
        waits -= behind[box]
        waits[box] = 2 * len(boxes)  # never again
    return order


def _overlapping(low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether boxes cover each other as they are seen, shape (boxes, boxes).

    Seen along (1, 1, 1) a box is a hexagon, bounded by x - y, y - z and z - x.
    """
    after = np.roll(low, -1, axis=1), np.roll(high, -1, axis=1)
    least, most = low - after[1], high - after[0]
    meet = (most[:, None] > least[None]).all(axis=2)
    return np.asarray(meet & meet.T)


def shades(colour: str) -> list[str]:
    """A colour as the top of a box has it, its side at high x, and that at high z."""
    parts = [int(colour[at : at + 2], 16) for at in (1, 3, 5)]
    return ["#" + "".join(f"{round(light * p):02x}" for p in parts) for _, light in _SIDES]


def _corners(boxes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Corners of boxes [cm], shape (boxes, 8, 3)."""
    ends = np.array([(k & 1, k >> 2 & 1, k >> 1 & 1) for k in range(8)])
    return boxes[:, None, :3] + ends * boxes[:, None, 3:]


def _flat(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points as they are seen: to the right, and down."""
    x, y, z = np.moveaxis(points, -1, 0)
    return np.stack(((x - z) * 0.866, (x + z) * 0.5 - y), axis=-1)


def _polygon(points: NDArray[np.float64], colour: str) -> str:
    return f'<path d="{_outline(points)}" fill="{colour}"/>'


def _shining(points: NDArray[np.float64]) -> str:
    return (
        f'<path d="{_outline(points)}" fill="{MARKED}" fill-opacity="0.5" stroke="{MARKED}" '
        'stroke-opacity="1" stroke-width="1.5" stroke-dasharray="4 3"/>'
    )


def _outline(points: NDArray[np.float64]) -> str:
    return "M" + " ".join(f"{x:.1f},{y:.1f}" for x, y in points) + "Z"
