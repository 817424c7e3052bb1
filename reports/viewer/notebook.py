"""HTML that a notebook shows of a load: a line, values with units, and a picture that is still.

Nothing runs in it, and no style is needed, so that it also shows where scripts and styles are
stripped. The picture stands in it as SVG.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping

from steadyload.reports.html import rendered
from steadyload.reports.viewer.picture import HEIGHT, WIDTH, LoadPicture, load_svg


def shown_html(line: str, facts: Mapping[str, str], *pictures: LoadPicture) -> str:
    """The HTML; all texts are escaped.

    Args:
        line: what there is to say, in a sentence.
        facts: values with units, by name.
        pictures: beside each other, in one; none where there is nothing to draw.
    """
    drawn = base64.b64encode(load_svg(*pictures).encode()).decode() if pictures else ""
    return rendered(
        "viewer/notebook.html.j2",
        line=line,
        facts=facts,
        drawn=drawn,
        caption="; ".join(picture.caption for picture in pictures),
        width=len(pictures) * WIDTH,
        height=HEIGHT,
    )
