"""HTML that a notebook shows of a load: a line, values with units, and a picture that is still.

Nothing runs in it, and no style is needed, so that it also shows where scripts and styles are
stripped. The picture stands in it as SVG.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from steadyload.reports.viewer.page import rendered
from steadyload.reports.viewer.records import Triple

_WIDTH, _HEIGHT, _EDGE = 440.0, 330.0, 12.0
"""Of a picture, and the edge that is left empty [px]."""

_RAMP = ("#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39")
_MARKED, _WOOD, _OUTLINE = "#e31a1c", "#c9b997", "#10151f"

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
        caption: in words, for those who do not see it.
    """

    pallet: Triple
    boxes: NDArray[np.float64]
    marked: int | None = None
    caption: str = ""


def shown_html(line: str, facts: Mapping[str, str], picture: LoadPicture | None) -> str:
    """The HTML; all texts are escaped.

    Args:
        line: what there is to say, in a sentence.
        facts: values with units, by name.
        picture: None where there is nothing to draw.
    """
    drawn = "" if picture is None else base64.b64encode(load_svg(picture).encode()).decode()
    return rendered(
        "notebook.html.j2",
        line=line,
        facts=facts,
        drawn=drawn,
        picture=picture,
        width=round(_WIDTH),
        height=round(_HEIGHT),
    )


def load_svg(picture: LoadPicture) -> str:
    """A load as SVG, seen from the side of high x and z; colours are the order of loading.

    The marked box is red, and shines through where others stand before it.
    """
    boxes = np.asarray(picture.boxes, dtype=float).reshape(-1, 6)
    width, _, depth = picture.pallet
    deck = _flat(np.array([(0, 0, 0), (width, 0, 0), (width, 0, depth), (0, 0, depth)], float))
    corners = _flat(_corners(boxes))
    points = np.concatenate((deck, corners.reshape(-1, 2)))
    low, high = points.min(axis=0), points.max(axis=0)
    room = np.array((_WIDTH, _HEIGHT))
    scale = ((room - 2.0 * _EDGE) / np.maximum(high - low, 1e-9)).min()
    shift = 0.5 * (room - scale * (low + high))
    deck, corners = scale * deck + shift, scale * corners + shift
    faces = [_polygon(deck, _WOOD)]
    for box in behind_first(boxes):
        is_marked = box == picture.marked
        colour = _MARKED if is_marked else _RAMP[len(_RAMP) * box // len(boxes)]
        faces += [_polygon(corners[box, list(of)], _shade(colour, light)) for of, light in _SIDES]
    if picture.marked is not None:
        faces += [_shining(corners[picture.marked, list(of)]) for of, _ in _SIDES]
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH:g}" height="{_HEIGHT:g}" '
        f'viewBox="0 0 {_WIDTH:g} {_HEIGHT:g}" stroke="{_OUTLINE}" stroke-opacity="0.6" '
        f'stroke-linejoin="round">{"".join(faces)}</svg>'
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
    apart = (most[:, None] <= least[None]).any(axis=2)
    return ~(apart | apart.T)


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
        f'<path d="{_outline(points)}" fill="{_MARKED}" fill-opacity="0.3" stroke="{_MARKED}" '
        'stroke-opacity="1" stroke-width="1.5" stroke-dasharray="4 3"/>'
    )


def _outline(points: NDArray[np.float64]) -> str:
    return "M" + " ".join(f"{x:.1f},{y:.1f}" for x, y in points) + "Z"


def _shade(colour: str, light: float) -> str:
    parts = (round(light * int(colour[at : at + 2], 16)) for at in (1, 3, 5))
    return "#" + "".join(f"{part:02x}" for part in parts)
