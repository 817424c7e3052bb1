"""A page as one HTML file that needs nothing else: the same sections, to sort, filter and ask.

Tables and charts are our own few hundred lines. Libraries were weighed as they would stand in a
page, compressed: Vega with Vega-Lite and its embedding 0.36 MB, Tabulator 0.13 MB, Plotly's basic
bundle 0.39 MB. None of them brings the list of cases on which two methods differ, and none has a
Python package that ships its script alone.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from functools import cache
from typing import Any

from markdown_it import MarkdownIt
from markupsafe import Markup

from steadyload.reports.html import packed, rendered, template_text
from steadyload.reports.pages.page import Page, Picture
from steadyload.reports.viewer.page import packed_shared_texts

_TYPES = {".svg": "image/svg+xml", ".png": "image/png"}
_SCRIPTS = (
    "viewer/unpack.js", "viewer/dialog.js", "report/tables.js", "report/cost.js",
    "report/answers.js", "report/report.js",
)  # fmt: skip
_STYLES = ("base.css", "viewer/dialog.css", "report/report.css")


def report_html(page: Page, images: Mapping[str, tuple[str, bytes]]) -> str:
    """The page as text; the same page gives the same text.

    Args:
        page: what it shows.
        images: ending and bytes of the file of every picture, by its name.

    Raises:
        ThreeJsError: see :func:`steadyload.reports.viewer.three_js.three_js`.
    """
    charts = {p.name: p.interactive for p in page.drawn if p.interactive}
    players = {name: chart.players for name, chart in charts.items() if chart.players}
    answer, method = page.parts_of_summary
    return rendered(
        "report/report.html.j2",
        page=page,
        sections=[*page.sections, *page.details],
        answer=_html(answer),
        method=_html(method),
        html=_html,
        source=lambda picture: _source(*images[picture.name]),
        plain=_plain,
        caption=_caption,
        style="\n".join(map(template_text, _STYLES)),
        script="\n".join(map(template_text, _SCRIPTS)),
        players=packed(json.dumps(players)) if players else "",
        shared=packed_shared_texts() if players else "",
    )


def _caption(picture: Picture) -> Markup:
    """The caption of what stands in the page: the picture, or the chart in its place."""
    chart = picture.interactive
    return _inline(picture.caption if chart is None else chart.caption or picture.caption)


def _plain(picture: Picture) -> Markup:
    """The data of a chart, for a script element."""
    assert picture.interactive is not None, "asked of charts alone"
    text: Any = json.dumps(picture.interactive.data(), separators=(",", ":"), allow_nan=False)
    return Markup(packed(text))  # noqa: S704 - base64


def _source(ending: str, drawn: bytes) -> str:
    return f"data:{_TYPES[ending]};base64,{base64.b64encode(drawn).decode()}"


def _html(text: object) -> Markup:
    """Markdown, or what prints as such, as HTML; HTML in it is text."""
    return Markup(_parser().render(str(text)))  # noqa: S704 - the parser escapes


def _inline(text: str) -> Markup:
    return Markup(_parser().renderInline(text))  # noqa: S704 - the parser escapes


@cache
def _parser() -> MarkdownIt:
    return MarkdownIt("commonmark", {"html": False}).enable("table")
