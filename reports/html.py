"""HTML pages that need nothing else, not even a network: templates, and texts packed into them."""

from __future__ import annotations

import base64
import gzip
from functools import cache
from importlib import resources
from typing import Any

import jinja2


def rendered(template: str, **values: Any) -> str:
    """A template of :mod:`steadyload.reports.templates`, filled in; values are escaped."""
    return _environment().get_template(template).render(**values)


def template_text(name: str) -> str:
    """A file among the templates."""
    return (
        resources.files("steadyload.reports.templates").joinpath(name).read_text(encoding="utf-8")
    )


def packed(text: str) -> str:
    """A text as gzip in base64, which the browser unpacks."""
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


@cache
def _environment() -> jinja2.Environment:
    return jinja2.Environment(
        loader=jinja2.FunctionLoader(template_text),
        autoescape=jinja2.select_autoescape(["html", "j2"], default=False),
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
