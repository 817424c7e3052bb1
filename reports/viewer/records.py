"""Records of a page that plays a loading."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from steadyload.reports.viewer.picture import AMBER, LoadPicture, Triple


@dataclass(frozen=True, slots=True)
class Units:
    """Units in which a page says lengths and weights.

    Attributes:
        length, weight: their names.
        cm, kg: centimetres and kilograms in them.
        decimals: of a length.
    """

    length: str = "cm"
    cm: float = 1.0
    decimals: int = 1
    weight: str = "kg"
    kg: float = 1.0


@dataclass(frozen=True, slots=True)
class ViewedItem:
    """An item as planned: size, geometric centre and offset of the centre of mass [cm], y up, and
    its weight with its unit. ``name``: its id, empty without one; ``label``: what messages call it.
    """

    size: Triple
    centre: Triple
    mass_offset: Triple
    weight: str
    name: str
    label: str


@dataclass(frozen=True, slots=True)
class Movement:
    """The item that moved most by a frame: displacement [cm], rotation [degrees]."""

    item: int
    displacement: float
    rotation: float


@dataclass(frozen=True, slots=True)
class ViewedStep:
    """Motion after a placement.

    Attributes:
        times: of the frames, since the placement [s]; empty where nothing was simulated.
        centres, quaternions: by frame and item placed by then, shapes (frames, step + 1, 3 and 4);
            [cm], and w, x, y, z.
        movements: by frame.
        judged: how many frames lie before the verdict or at it.
    """

    times: NDArray[np.float64]
    centres: NDArray[np.float64]
    quaternions: NDArray[np.float64]
    movements: tuple[Movement, ...]
    judged: int


@dataclass(frozen=True, slots=True)
class ViewedLoading:
    """One method's verdict, and the motion it rests on.

    Attributes:
        method: spec string.
        status: how the judgement ended; only ``done`` has a score.
        score: share of items placed safely.
        failing_step, moved_item, displacement [cm], rotation [degrees], reason: of the verdict.
        seconds: CPU time of the judgement.
        ignored: settings that the engine ignored.
        simulates: the method moves items; False: it only looks at the plan.
        reseats: every step begins with all items at their planned poses.
        planned: centres as the method was given them [cm], shape (items, 3).
        steps: up to the last that was simulated.
        headline: in place of the verdict's step and score, where the last step shows what the
            complete load does on the road, or where a box is crushed; else empty.
        crushed: the moved item is a box that bears more than it may.
    """

    method: str
    status: str
    score: float | None
    failing_step: int | None
    moved_item: int | None
    displacement: float | None
    rotation: float | None
    reason: str
    seconds: float
    ignored: tuple[str, ...]
    simulates: bool
    reseats: bool
    planned: NDArray[np.float64]
    steps: tuple[ViewedStep, ...]
    headline: str = ""
    crushed: bool = False


@dataclass(frozen=True, slots=True)
class View:
    """A layout, the loadings to play side by side, and the provenance of the page.

    ``weight`` is that of all items, with its unit. ``deck`` is the height above the ground of a
    deck with edges [cm], 0 for a plane without. ``forces`` are the contact forces of the complete
    load, upwards, one a contact: where they act (x, y, z) [cm] and how large they are [kg], shape
    (k, 4); none where they are not known. ``reasons`` say how the boxes at fault stand in the plan,
    ``changes`` how a repaired plan differs from the one before, and ``moved`` which of its boxes
    are at another place. ``gap_note`` is a sentence on the largest gap below a box that has nothing
    under it, and ``hovering`` says whether it is larger than is allowed. ``axes`` are names of x, y
    and z, and ``units`` those of all that is said.
    """

    name: str
    weight: str
    pallet: Triple
    deck: float
    items: tuple[ViewedItem, ...]
    loadings: tuple[ViewedLoading, ...]
    manifest: Mapping[str, str]
    forces: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 4)))
    reasons: tuple[str, ...] = ()
    changes: tuple[str, ...] = ()
    moved: frozenset[int] = frozenset()
    gap_note: str = ""
    hovering: bool = False
    axes: tuple[str, str, str] = ("x", "y", "z")
    units: Units = Units()


@dataclass(frozen=True, slots=True)
class Card:
    """A layout among others: its picture, the answer, and the page that plays it.

    Attributes:
        name: of the layout.
        kind: ``stands``, ``fails``, or another one; the gallery counts and filters by it.
        answer: in a few words.
        facts: what else is known, each in a few words.
        picture: of the load; None where there is nothing to draw.
        badges: what else is wrong, each in a word or two; the gallery filters by them, too.
        player: page of :func:`steadyload.reports.viewer.page.player_html` with the marks of
            :data:`steadyload.reports.viewer.page.MARKS`; empty where nothing can be played.
        repaired: the same of the repaired plan; empty where there is none.
    """

    name: str
    kind: str
    answer: str
    facts: tuple[str, ...] = ()
    picture: LoadPicture | None = None
    badges: tuple[str, ...] = ()
    player: str = ""
    repaired: str = ""

    @property
    def amber(self) -> bool:
        """The marked box is amber instead of red: it is crushed, or moves only on the road."""
        return self.picture is not None and self.picture.mark == AMBER


@dataclass(frozen=True, slots=True)
class Gallery:
    """Layouts as cards.

    Attributes:
        title: of the page.
        summary: of all answers, a sentence.
        kinds: of cards, in the order of the filter.
        cards: in their order.
        notes: sentences below the cards.
        manifest: provenance.
    """

    title: str
    summary: str
    kinds: tuple[str, ...]
    cards: tuple[Card, ...]
    notes: tuple[str, ...]
    manifest: Mapping[str, str]
