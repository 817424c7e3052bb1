"""The picture of a load that stands still, as SVG: on cards, in notebooks and in the docs."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

import numpy as np
from numpy.typing import NDArray

Triple = tuple[float, float, float]

WIDTH, HEIGHT = 440, 330
"""Of a picture [px]."""

_EDGE = 12.0
"""Left empty on every side [px]."""

RAMP = ("#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39")
"""Colours of boxes, from the first to the last one loaded."""

MARKED, AMBER, WOOD, OUTLINE = "#e31a1c", "#ff9f1c", "#c9b997", "#10151f"
"""Colours of the marked box, of one that is crushed or was moved, of the deck, and of edges."""

_SIDES = (((4, 5, 7, 6), 1.0), ((1, 3, 7, 5), 0.72), ((2, 3, 7, 6), 0.86))
"""Faces seen from high x, y and z, and how light each is: top, high x, high z. The corner
``x + 2 * z + 4 * y`` is at the low (0) or high (1) end of every axis."""

_WAYS = np.array(((0.866, 0.5), (0.0, -1.0), (-0.866, 0.5)))
"""Directions of x, y and z as they are seen: to the right, and down."""

_ARROW, _LETTERS = 30.0, 20
"""Length of the arrows of axes, and size of their names [px]."""


@dataclass(frozen=True, slots=True)
class LoadPicture:
    """A load to be drawn.

    Attributes:
        pallet: width, height and depth [cm].
        boxes: lower corners and sizes in the order of loading [cm], y up, shape (boxes, 6).
        marked: number of the box at fault; None for none.
        mark: its colour.
        moved: numbers of boxes that are amber: those that a repair put elsewhere.
        axes: names of x, y and z at their arrows.
        caption: in words, for those who do not see it.
    """

    pallet: Triple
    boxes: NDArray[np.float64]
    marked: int | None = None
    mark: str = MARKED
    moved: frozenset[int] = frozenset()
    axes: tuple[str, str, str] = ("x", "y", "z")
    caption: str = ""


def load_svg(*pictures: LoadPicture) -> str:
    """Loads as SVG beside each other, at one scale, seen from the side of high x and z.

    Colours are the order of loading. The marked box shines through where others stand before it;
    moved ones are amber. Arrows below the load are the axes.

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
        faces.append(_arrows(picture, place))
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
        colour = AMBER if box in picture.moved else RAMP[len(RAMP) * box // len(corners)]
        colour = picture.mark if box == picture.marked else colour
        faces += [
            _polygon(corners[box, list(of)], shade)
            for (of, _), shade in zip(_SIDES, shades(colour), strict=True)
        ]
    if picture.marked is not None:
        shown = corners[picture.marked]
        faces += [_shining(shown[list(of)], picture.mark) for of, _ in _SIDES]
    return faces


def _arrows(picture: LoadPicture, place: int) -> str:
    """The axes, in the lower corner of a picture that the deck leaves free."""
    width, _, depth = picture.pallet
    aside = 2.0 * _ARROW
    origin = (place * WIDTH + (aside if width >= depth else WIDTH - aside), HEIGHT - 0.75 * aside)
    drawn = []
    for name, way in zip(picture.axes, _WAYS, strict=True):
        across = np.array((-way[1], way[0]))
        tip, neck = origin + _ARROW * way, origin + 0.7 * _ARROW * way
        head = " ".join(f"{x:.1f},{y:.1f}" for x, y in (neck + 5 * across, tip, neck - 5 * across))
        line = f"M{origin[0]:.1f},{origin[1]:.1f} {tip[0]:.1f},{tip[1]:.1f}M{head}"
        x, y = origin + (_ARROW + 0.7 * _LETTERS) * way + (0.0, 0.35 * _LETTERS)
        drawn.append((line, f'<text x="{x:.1f}" y="{y:.1f}" stroke="none">+{escape(name)}</text>'))
    lines = "".join(line for line, _ in drawn)
    return (
        f'<g fill="none" font-family="sans-serif" font-size="{_LETTERS}" font-weight="bold" '
        'text-anchor="middle" stroke-opacity="1" stroke-linecap="round">'
        f'<path d="{lines}" stroke="#ffffff" stroke-width="6"/>'
        f'<path d="{lines}" stroke-width="2.5"/>'
        f'<g fill="{OUTLINE}">{"".join(text for _, text in drawn)}</g></g>'
    )


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


def _shining(points: NDArray[np.float64], colour: str) -> str:
    return (
        f'<path d="{_outline(points)}" fill="{colour}" fill-opacity="0.5" stroke="{colour}" '
        'stroke-opacity="1" stroke-width="1.5" stroke-dasharray="4 3"/>'
    )


def _outline(points: NDArray[np.float64]) -> str:
    return "M" + " ".join(f"{x:.1f},{y:.1f}" for x, y in points) + "Z"
