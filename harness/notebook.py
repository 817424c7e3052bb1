"""Objects that show themselves in a notebook, with a picture.

Layouts and verdicts lie below the code that draws, so that the function which draws them is named
here as a text, and imported when a notebook asks for it.
"""

from __future__ import annotations

import importlib

_DRAWN_BY = "steadyload.app.notebook_figures:notebook_html"


class ShownInNotebook:
    """Base of what a notebook shows as HTML: a line, a few values with units, and a picture."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        module, _, name = _DRAWN_BY.partition(":")
        html: str = getattr(importlib.import_module(module), name)(self)
        return html
