"""Templates of pages name what there is, in every branch, and are made into the page they say."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import pytest
from template_names import faults_of, wrong_names

from steadyload.reports.columns import column, row
from steadyload.reports.pages.composing import page_environment
from steadyload.studies.registry import STUDIES, study
from steadyload.studies.uncertain.comparing import Found

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("template", sorted((ROOT / "harness").rglob("page.md.j2")), ids=str)
def test_a_template_names_what_there_is(template):
    name = template.parent.name
    assert name in STUDIES, "a template stands beside the class of a registered study"
    assert faults_of(study(name), page_environment) == []


INCLUDED = {"reliability.md.j2": Found}
"""Parts of pages of several studies -> what they call ``found``."""

MACROS = {"how_to_read.md.j2", "methods.md.j2"}
"""Macros of several pages: what they are given has no type that can be checked."""


@pytest.mark.parametrize("name", INCLUDED)
def test_a_part_of_several_pages_names_what_there_is(name):
    folder = ROOT / "harness/studies"
    text = (folder / name).read_text()
    assert wrong_names(text, page_environment(folder, []), found=INCLUDED[name]) == []


def test_every_part_of_several_pages_is_listed():
    found = {path.name for path in (ROOT / "harness/studies").glob("*.md.j2")}
    assert found == INCLUDED.keys() | MACROS


@row
class Part:
    length_cm: float = column()
    parent: str | None = column()


@row
class Whole:
    name: str = column()
    part: Part = column()
    parts: Sequence[Part] = column()
    by_name: Mapping[str, Part] = column("{}")

    @property
    def longest(self) -> Part:
        return self.parts[0]


@dataclass(frozen=True)
class Results:
    wholes: Sequence[Whole]
    best: Whole | None
    pair: tuple[Whole, Part]


@pytest.mark.parametrize(
    ("template", "fault"),
    [
        ("{{ found.wholes[0].part.length_cm }}", ""),
        ("{{ found.wholes[0].part.length }}", "line 1: Part has no length"),
        ("{{ found.whole }}", "line 1: Results has no whole"),
        ("{% if no %}{{ found.best.name }}{% endif %}", "nothing is named no"),
        ("{% if found.best %}{{ found.best.names }}{% endif %}", "line 1: Whole has no names"),
        ("{{ found.best.longest.lengths }}", "line 1: Part has no lengths"),
        ("{{ found.pair[1].name }}", "line 1: Part has no name"),
        ("{% set w = found.wholes|last %}\n{{ w.title }}", "line 2: Whole has no title"),
        ("{% for w in found.wholes|sort(attribute='part.size') %}{% endfor %}",
         "line 1: Part has no size"),
        ("{% for w in found.wholes if w.parts %}{{ w.x }}{% endfor %}", "line 1: Whole has no x"),
        ("{% for w in [] %}{% else %}{{ found.x }}{% endfor %}", "line 1: Results has no x"),
        ("{% for n, p in found.wholes[0].by_name.items() %}{{ p.x }}{% endfor %}",
         "line 1: Part has no x"),
        ("{{ found.wholes[0].by_name['a'].x }}", "line 1: Part has no x"),
        ("{{ found.wholes|map(attribute='nam')|list }}", "line 1: Whole has no nam"),
        ("{{ table(found.wholes, 'name size') }}", "line 1: Whole has no size"),
        ("{{ table(found.wholes[1:], 'name', titles={'nam': 'x'}) }}", "line 1: Whole has no nam"),
        ("{% call table(found.wholes + [0], 'x') %}{% endcall %}", "line 1: Whole has no x"),
        ("{{ forest('f', found.wholes, 'part.length_cm', title='name', x_label='') }}", ""),
        ("{{ forest('f', found.wholes, 'part.size', title='name', x_label='') }}",
         "line 1: Part has no size"),
        ("{{ forest('f', found.wholes, 'part.length_cm', x_label='') }}",
         "line 1: Whole has no title"),
        ("{{ curves('f', found.wholes, ('length_cm', 'size'), 'name', title='name', "
         "within='parts') }}", "line 1: Part has no size"),
        ("{{ bars('f', found.wholes, {'widths': 'wide'}, title='name', x_label='') }}",
         "line 1: Whole has no widths"),
        ("{{ 'x' if found.best }}", "line 1: if without else writes an undefined value"),
        ("{{ found|percentage }}", "line 1: No filter named 'percentage'."),
        ("{% if %}", "line 1: Expected an expression, got 'end of statement block'"),
    ],
)  # fmt: skip
def test_a_wrong_name_is_found(template, fault):
    faults = wrong_names(template, page_environment(ROOT, []), found=Results)
    assert faults == ([fault] if fault else [])


@pytest.mark.parametrize(
    ("template", "fault"),
    [
        ("{{ table(found.rows, 'title right.n boxes_right:*') }}", ""),
        ("{{ table(found.rows, 'title rihgt') }}", "line 1: no column rihgt"),
        ("{{ table(found.rows, 'title ' ~ ('cpu' if found.x else 'boxes_rigth:* ') ~ 'lost') }}",
         "line 1: no column boxes_rigth:*"),
    ],
)  # fmt: skip
def test_a_column_that_no_frame_has_is_found(template, fault):
    faults = wrong_names(template, page_environment(ROOT, []), found=SimpleNamespace)
    assert faults == ([fault] if fault else [])
