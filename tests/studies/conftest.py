"""Helpers of these tests can be imported; an engine breaks; the structure of a page is checked."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

from steadyload.engines.registry import world_class
from steadyload.engines.world import EngineError
from steadyload.reports.pages.page import Picture
from steadyload.reports.pages.writing import write_page
from steadyload.reports.table import Table

sys.path.insert(0, str(Path(__file__).parent))

_NO_TEXT = re.compile(r"Estimate\(value=| object at 0x|\bnan\b")
"""Of values that a template writes without a form."""


@pytest.fixture
def assert_shown(tmp_path, assert_drawn):
    """Renders the page of results, and asserts its structure; what its sentences say is free.

    Arguments: ``study`` and ``found``; ``answer``, numbers of the first paragraph, as they read;
    ``tables``, the rows of all its tables where these are no frames, and ``charts``, the names of
    all its pictures, in any order; ``drawn``, whether pictures and files are written and looked at.
    Returns the text.
    """

    def check(study, found, *, answer=(), tables=None, charts=(), drawn=True):
        page = study.page(found)
        first, _ = page.parts_of_summary
        assert page.title
        assert first
        for number in map(str, answer):
            assert re.search(rf"(?<![\d.]){re.escape(number)}(?!\.?\d)", first), (number, first)
        sections = [*page.sections, *page.details]
        assert not [section.title for section in sections if not section.blocks]
        blocks = [page.figure] if page.figure else []
        blocks += [block for section in sections for block in section.blocks]
        shown = [list(block.rows) for block in blocks if isinstance(block, Table)]
        if tables is not None:
            expected = [list(rows) for rows in tables if rows]
            assert not [rows for rows in expected if rows not in shown]
            assert not [rows for rows in shown if rows not in expected]
            assert len(shown) == len(expected)
        pictures = [block for block in blocks if isinstance(block, Picture)]
        assert sorted(picture.name for picture in pictures) == sorted(charts)
        assert all(picture.caption for picture in pictures)
        texts = [page.summary, *(b.caption if isinstance(b, Picture) else str(b) for b in blocks)]
        text = "\n\n".join(texts)
        assert not _NO_TEXT.search(text)
        if drawn:
            write_page(page, tmp_path / "page")
            for picture in (tmp_path / "page" / "figures").glob("*"):
                assert_drawn(picture)
        return text

    return check


@pytest.fixture(params=["diverged", "error: no more contacts"])
def broken_bullet(request, monkeypatch):
    """Bullet ends in this way from here on."""
    base = world_class("bullet")

    class Broken(base):
        def _advance(self, substeps, length):
            if request.param != "diverged":
                raise EngineError("no more contacts")
            super()._advance(substeps, length)

        def _poses(self):
            poses = super()._poses()
            poses.centres[:] = np.nan
            return poses

    monkeypatch.setattr("steadyload.engines.with_bullet.BulletWorld", Broken)
    return request.param
