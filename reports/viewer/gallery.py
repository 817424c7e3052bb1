"""The page that shows many layouts as cards with pictures, each of which opens its player.

It is one HTML file that needs nothing else. What all players share stands in it once: a card has a
page with marks in the places of the shared texts, and the browser fills it in when the card is
opened. Pictures stand in it as SVG, all of them packed in one text, so that they print.
"""

from __future__ import annotations

import json
from collections import Counter

from steadyload.reports.html import packed, rendered, template_text
from steadyload.reports.viewer.page import packed_shared_texts
from steadyload.reports.viewer.picture import load_svg
from steadyload.reports.viewer.records import Gallery


def gallery_html(gallery: Gallery) -> str:
    """The page as text; the same gallery gives the same text.

    Raises:
        ThreeJsError: see :func:`steadyload.reports.viewer.three_js.three_js`.
    """
    kinds = Counter(card.kind for card in gallery.cards)
    pictures = [card.picture and load_svg(card.picture) for card in gallery.cards]
    return rendered(
        "viewer/gallery.html.j2",
        gallery=gallery,
        counts={kind: kinds[kind] for kind in gallery.kinds if kinds[kind]},
        badges=Counter(badge for card in gallery.cards for badge in card.badges),
        style="\n".join(
            map(
                template_text,
                ("base.css", "viewer/gallery.css", "viewer/dialog.css", "viewer/print.css"),
            )
        ),
        script="\n".join(
            map(template_text, ("viewer/unpack.js", "viewer/dialog.js", "viewer/gallery.js"))
        ),
        shared=packed_shared_texts(),
        pictures=packed(json.dumps(pictures)),
        players=[packed(card.player) if card.player else "" for card in gallery.cards],
        repaired=[packed(card.repaired) if card.repaired else "" for card in gallery.cards],
    )
