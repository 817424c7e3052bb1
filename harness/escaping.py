"""Names and other texts of users, made harmless where they are shown: one home for all ways."""

from __future__ import annotations

import re

_MARKUP = re.compile(r"[\\`*\[\]<>|!#&~@]|(?<!\w)_|_(?!\w)|(?<=:)/(?=/)|(?<=www)\.")


def printable(text: str, most: int | None = None) -> str:
    """A text for a terminal: of control characters and the like their escapes.

    Args:
        text: any.
        most: number of characters of it that are shown; None for all.
    """
    cut = text if most is None or len(text) <= most else f"{text[: most - 3]}..."
    if cut.isprintable():
        return cut
    return "".join(one if one.isprintable() else ascii(one)[1:-1] for one in cut)


def markdown(text: str) -> str:
    """A text for Markdown, and for HTML made of it: characters, and no markup, tag or link."""
    return _MARKUP.sub(r"\\\g<0>", printable(text))
