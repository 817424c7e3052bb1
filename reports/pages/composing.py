"""A template and values become a page: a title, a summary, and sections of blocks."""

from __future__ import annotations

import inspect
import math
import re
import traceback
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import jinja2
import pandas as pd
from matplotlib.figure import Figure

from steadyload.errors import UserError
from steadyload.escaping import markdown
from steadyload.reports import columns, frames, table
from steadyload.reports.charts.drawing import Chart
from steadyload.reports.charts.kinds import KINDS
from steadyload.reports.charts.rows import ChartError
from steadyload.reports.interactive import Interactive
from steadyload.reports.pages.page import Block, Page, Picture, Section

FORMS: Mapping[str, Callable[..., str]] = {
    "percent": table.percent,
    "plain_percent": table.plain_percent,
    "least_shown": table.least_shown,
    "ms": table.milliseconds,
    "decimal": table.decimal,
    "factor": table.factor,
    "significant": table.significant,
    "compact": table.compact,
    "fixed": table.fixed,
    "general": table.general,
    "duration": table.duration,
    "brief_time": table.brief_time,
    "names": table.names,
    "counts": table.counts,
    "yes_no": table.yes_no,
    "markdown": markdown,
    "count": lambda value: f"{value:,}",
    "sentence": lambda text: f"{text[:1].upper()}{text[1:]}." if text else table.MISSING,
}
"""Filters of templates: how a value reads."""

_BLOCK = re.compile("\ue000([0-9]+)\ue001")
_END_OF_LINE = "\ue002"
"""Stands for the end of a line that is not joined with the next one."""

_RESERVED = re.compile("[\ue000-\ue002]")
_WRAPPED = re.compile(r"(?<=\S)\n *(?![-*+] |\d+[.)] |[#|>\n\ue000]|```)")


class TemplateError(UserError):
    """A template is no valid Jinja2, or names what is not there."""


class _Place(str):
    """Text in the place of a block, or with places of its own."""


def composed(template: Path, values: Mapping[str, Any], made_with: Mapping[str, str]) -> Page:
    """The page of a template.

    The text before the first section is the title and the summary, where tables are whole and one
    chart may stand. Sections below a line ``# Details`` are those of the file of details. Lines of
    a paragraph are joined, but for those of a value that is given through
    ``verbatim``.
    In a template stand, each where its block is to be, and with the caption as the body of its
    ``call`` block:

    * ``table(rows, chosen, titles)`` of :func:`steadyload.reports.columns.table`, or of a frame, of
      :func:`steadyload.reports.frames.table`, with or without;
    * ``KIND(name, ...)`` for a kind of :data:`steadyload.reports.charts.kinds.KINDS`, with the name
      of its file, and what the kind takes;
    * ``as_it_is(text)`` for Markdown that comes with the results, whose lines stay;
    * ``figure(name, figure, interactive=None)`` for a figure that is drawn already.

    Args:
        template: file of Markdown with Jinja2.
        values: what it names.
        made_with: provenance of the page.

    Raises:
        TemplateError: it is no valid Jinja2, names what is not there, or has a second chart in its
            summary.
        ChartError: see the kinds of charts.
        TableError: see :func:`steadyload.reports.columns.table`.
    """
    blocks: list[Block] = []
    try:
        text = page_environment(template.parent, blocks).get_template(template.name).render(values)
    except jinja2.TemplateError as error:
        raise TemplateError(f"{_place(template, error)}: {error.message}") from error
    except UserError as error:
        error.add_note(f"({_place(template, error)})")
        raise
    text, *details = re.split(r"^# Details$", text, maxsplit=1, flags=re.M)
    (head, *sections), (_, *detailed) = (
        re.split(r"^## ", part, flags=re.M) for part in (text, *(details or [""]))
    )
    title, _, summary = head.strip().partition("\n")
    first = _section(f"\n{summary}", blocks).blocks
    figures = [block for block in first if isinstance(block, Picture)]
    if figures[1:]:
        raise TemplateError(f"{template}: {len(figures)} charts in the summary; allowed: one")
    return Page(
        title.removeprefix("# "),
        "\n\n".join(str(block) for block in first if not isinstance(block, Picture)),
        [_section(part, blocks) for part in sections],
        made_with,
        figures[0] if figures else None,
        [_section(part, blocks) for part in detailed],
    )


def _place(template: Path, error: Exception) -> str:
    """The template and the line of it at which an error arose."""
    if isinstance(error, jinja2.TemplateSyntaxError):
        line: int | None = error.lineno
    else:
        frames = traceback.extract_tb(error.__traceback__)
        line = next((one.lineno for one in frames if one.filename == str(template)), None)
    return f"{template}" + f", line {line}" * (line is not None)


def page_environment(folder: Path, blocks: list[Block]) -> jinja2.Environment:
    """The filters, tests and functions of templates of pages.

    Args:
        folder: of the templates; they may include those of the folder above it.
        blocks: filled with the blocks of a page in the order in which its template places them.
    """

    def placed(block: Block | None) -> str:
        if block is None:
            return ""
        blocks.append(block)
        return _Place(f"\n\n\ue000{len(blocks) - 1}\ue001\n\n")

    def tabulated(
        rows: Sequence[Any] | pd.DataFrame,
        chosen: str = "",
        titles: Mapping[str, str] | None = None,
        caller: Callable[[], str] = str,
    ) -> str:
        caption = _flowing(caller())
        if isinstance(rows, pd.DataFrame):
            return placed(frames.table(rows, chosen, caption, titles))
        return placed(columns.table(rows, chosen, caption, titles))

    def chart(
        name: str,
        figure: Figure,
        interactive: Interactive | None = None,
        *,
        caller: Callable[[], str],
    ) -> str:
        return placed(Picture(name, figure, _flowing(caller()), interactive))

    def drawing(kind: Callable[..., Chart]) -> Callable[..., str]:
        taken = inspect.signature(kind)

        def place(
            name: str, *data: Any, caller: Callable[[], str] | None = None, **more: Any
        ) -> str:
            if caller is None:
                raise ChartError(f"chart {kind.__name__}: no caption; allowed: a call block")
            try:
                taken.bind(*data, **more)
            except TypeError as error:
                options = ", ".join(taken.parameters)
                raise ChartError(f"chart {kind.__name__}: {error}; allowed: {options}") from None
            return chart(name, *kind(*data, **more), caller=caller)

        return place

    environment = jinja2.Environment(  # noqa: S701 - Markdown is written, not HTML
        loader=jinja2.FileSystemLoader([folder, folder.parent]),
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
        finalize=_said,
    )
    environment.filters |= FORMS
    environment.filters["verbatim"] = _verbatim
    environment.tests["known"] = lambda value: value is not None and not math.isnan(value)
    environment.globals |= {kind: drawing(draw) for kind, draw in KINDS.items()}
    environment.globals |= {"table": tabulated, "figure": chart, "as_it_is": placed}
    return environment


def _verbatim(text: str) -> str:
    """Text whose lines are not joined, and which holds no block."""
    return _Place(_RESERVED.sub("", text).replace("\n", _END_OF_LINE))


def _said(value: object) -> object:
    """A value as a template writes it: without the characters that stand for blocks."""
    return _RESERVED.sub("", value) if type(value) is str else value


def _section(part: str, blocks: Sequence[Block]) -> Section:
    heading, _, body = part.partition("\n")
    texts = _BLOCK.split(body)  # text, number, text, ...
    placed: list[Block] = []
    for k, text in enumerate(texts):
        block = blocks[int(text)] if k % 2 else _flowing(text)
        if block and isinstance(block, str) and placed and isinstance(placed[-1], str):
            block = f"{placed.pop()}\n\n{block}"
        placed += [block] if block else []
    return Section(heading.strip(), placed=placed)


def _flowing(text: str) -> str:
    """Text without empty lines at its ends, or more than one between, and a line a paragraph."""
    parts = re.split(r"(^```.*?^```$)", text.strip(), flags=re.M | re.S)  # code stays as it is
    parts[::2] = [re.sub(r"\n{3,}", "\n\n", _WRAPPED.sub(" ", part)) for part in parts[::2]]
    return "".join(parts).replace(_END_OF_LINE, "\n")
