"""The page that shows many layouts as cards with pictures, each of which opens its player.

It is one HTML file that needs nothing else. What all players share stands in it once: a card has a
page with marks in the places of the shared texts, and the browser fills it in when the card is
opened. Pictures are drawn by the browser when a card comes into sight.
"""

from __future__ import annotations

import json
from collections import Counter
from typing import Any

import numpy as np

from steadyload.reports.html import packed, rendered, template_text
from steadyload.reports.viewer.page import packed_shared_texts
from steadyload.reports.viewer.picture import (
    AMBER,
    MARKED,
    OUTLINE,
    RAMP,
    WOOD,
    behind_first,
    shades,
)
from steadyload.reports.viewer.records import Card, Gallery

_PER_CM = 10
"""Pictures are drawn to the millimetre."""


def gallery_html(gallery: Gallery) -> str:
    """The page as text; the same gallery gives the same text.

    Raises:
        ThreeJsError: see :func:`steadyload.reports.viewer.three_js.three_js`.
    """
    kinds = Counter(card.kind for card in gallery.cards)
    return rendered(
        "viewer/gallery.html.j2",
        gallery=gallery,
        counts={kind: kinds[kind] for kind in gallery.kinds if kinds[kind]},
        badges=Counter(badge for card in gallery.cards for badge in card.badges),
        style="\n".join(
            map(template_text, ("base.css", "viewer/gallery.css", "viewer/dialog.css"))
        ),
        script="\n".join(
            map(template_text, ("viewer/unpack.js", "viewer/dialog.js", "viewer/gallery.js"))
        ),
        shared=packed_shared_texts(),
        pictures=packed(json.dumps(_pictures(gallery), separators=(",", ":"))),
        players=[packed(card.player) if card.player else "" for card in gallery.cards],
        repaired=[packed(card.repaired) if card.repaired else "" for card in gallery.cards],
    )


def _pictures(gallery: Gallery) -> dict[str, Any]:
    """Colours of the faces that are seen, and the boxes of every card, for the browser to draw."""
    return {
        "ramp": [shades(colour) for colour in RAMP],
        "red": shades(MARKED),
        "amber": shades(AMBER),
        "wood": WOOD,
        "edge": OUTLINE,
        "cards": [_picture(card) for card in gallery.cards],
    }


def _picture(card: Card) -> dict[str, Any]:
    return {
        "pallet": [round(_PER_CM * side) for side in card.pallet],
        "boxes": np.rint(_PER_CM * card.boxes).astype(int).ravel().tolist(),
        "order": behind_first(card.boxes),
        "marked": card.marked,
        "amber": card.amber,
    }
