"""A template becomes the page that it says, block by block, and rows become tables."""

import re
from collections.abc import Mapping
from types import SimpleNamespace

import pytest
from matplotlib.figure import Figure

from steadyload.reports.charts.rows import ChartError
from steadyload.reports.columns import (
    TableError,
    column,
    columns_of,
    fixed,
    percent,
    row,
    table,
)
from steadyload.reports.pages.composing import TemplateError, composed
from steadyload.reports.pages.page import Picture
from steadyload.reports.pages.writing import write_page
from steadyload.reports.table import Table
from steadyload.statistics.estimate import Estimate


@row
class Time:
    cpu_s: float = column("CPU s", fixed)
    note: str = ""


@row
class Method:
    name: str = column("method")
    right: Estimate = column("right %", percent)
    time: Time | None = column()
    by_case: Mapping[str, int] = column("{}: n", notable=True)

    @property
    def length(self) -> int:
        return len(self.name)


METHODS = [
    Method("sme", Estimate(0.5, 0.25, 0.75, 4), None, {"a": 1}),
    Method("fbs", Estimate(0.25, 0.0, 0.5, 4), Time(2.0), {"b": 2}),
]


@pytest.fixture
def made(tmp_path):
    def make(text, **values):
        (tmp_path / "page.md.j2").write_text(text)
        return composed(tmp_path / "page.md.j2", values, {"made": "here"})

    return make


def lines(made_table):
    return [re.sub(r" +", " ", line) for line in str(made_table).splitlines()]


def test_a_template_becomes_title_summary_and_sections(made):
    page = made(
        "# A title\n\nOne\nsentence.\n\nAnother {{ word }}.\n\n"
        "{% for name in ['First', 'Second'] %}\n## {{ name }}\n\nText\nof {{ name }}.\n\n"
        "- one\n  and more\n- two\n\n```\ncode\nstays\n```\n{% endfor %}\n",
        word="word",
    )
    assert (page.title, page.summary) == ("A title", "One sentence.\n\nAnother word.")
    assert page.manifest == {"made": "here"}
    assert [section.title for section in page.sections] == ["First", "Second"]
    assert page.sections[1].blocks == [
        "Text of Second.\n\n- one and more\n- two\n\n```\ncode\nstays\n```"
    ]


def test_blocks_stand_where_the_template_places_them(made):
    page = made(
        "# T\nS.\n## One\nBefore.\n{% call table(rows, 'name right') %}\nThe\ncaption.\n"
        "{% endcall %}\nBetween.\n{{ table([]) }}{{ table(rows, 'name', {'name': 'who'}) }}\n"
        "{% call figure('drawn', drawing) %}A\npicture.{% endcall %}\nAfter.\n",
        rows=METHODS,
        drawing=Figure(),
    )
    first, captioned, between, plain, picture, last = page.sections[0].blocks
    assert (first, between, last) == ("Before.", "Between.", "After.")
    assert isinstance(captioned, Table)
    assert captioned.caption == "The caption."
    assert lines(plain) == ["| who |", "| --- |", "| sme |", "| fbs |"]
    assert isinstance(picture, Picture)
    assert (picture.name, picture.caption) == ("drawn", "A picture.")


def test_a_table_of_the_summary_stands_in_its_text(made):
    page = made("# T\nSo it\nis.\n\n{{ table(rows, 'name') }}\nMore.\n## One\n", rows=METHODS)
    assert re.sub(" +", " ", page.summary) == (
        "So it is.\n\n| method |\n| ------ |\n| sme |\n| fbs |\n\nMore."
    )


def test_the_chart_of_the_summary_is_the_figure_of_the_page(made):
    chart = "{% call figure('f', drawing) %}So.{% endcall %}\n"
    page = made(f"# T\nThe\nanswer.\n\n{chart}\nMethod.\n## One\nText.\n", drawing=Figure())
    assert page.parts_of_summary == ("The answer.", "Method.")
    assert (page.figure.name, page.figure.caption) == ("f", "So.")
    with pytest.raises(TemplateError, match="2 charts in the summary; allowed: one"):
        made(f"# T\nS.\n{chart}{chart}", drawing=Figure())


def test_sections_below_the_line_of_details_are_those_of_the_details(made):
    page = made("# T\nS.\n## One\nText.\n# Details\n## Two\n{{ table(rows) }}\n", rows=METHODS)
    assert [section.title for section in page.sections] == ["One"]
    (two,) = page.details
    assert (two.title, [type(block) for block in two.blocks]) == ("Two", [Table])


def test_a_kind_of_chart_is_drawn_where_it_stands_with_its_caption(made):
    page = made(
        "# T\nS.\n## One\n{% call curves('c', rows, 'length', 'right', title='name') %}"
        "Letters\nand {{ what }}.{% endcall %}\n",
        rows=METHODS,
        what="accuracy",
    )
    (picture,) = page.sections[0].drawn
    assert (picture.name, picture.caption) == ("c", "Letters and accuracy.")
    assert picture.figure.axes


@pytest.mark.parametrize("value", ["\ue0000\ue001", "\ue0005\ue001", "\ue000"])
def test_a_value_takes_the_place_of_no_block(made, value):
    template = "# T\nS.\n## One\n{{ value }}\n{{ table(rows, 'name') }}"
    page = made(template, value=value, rows=METHODS)
    *text, placed = page.sections[0].blocks
    assert text == ([value.strip("\ue000\ue001")] if len(value) > 1 else [])
    assert isinstance(placed, Table)


def test_lines_of_a_value_stay_apart_where_it_is_verbatim(made):
    text = "# Page\n\n## One\n\nIt says\n{{ why|verbatim }}\nand\nends."
    [section] = made(text, why="two\nlines\ue0000\ue001\n## no heading").sections
    assert section.blocks == ["It says two\nlines0\n## no heading and ends."]


def test_a_template_includes_those_of_the_folder_above(tmp_path):
    (tmp_path / "page").mkdir()
    (tmp_path / "shared.md.j2").write_text("## {{ title }}\nText.")
    (tmp_path / "page/page.md.j2").write_text("# Page\n\n{% include 'shared.md.j2' %}")
    page = composed(tmp_path / "page/page.md.j2", {"title": "One"}, {})
    assert [(one.title, one.blocks) for one in page.sections] == [("One", ["Text."])]


def test_what_is_not_there_is_an_error(made):
    for text in ("{{ found.x }}", "{{ found.x.y }}", "{{ nothing }}", "{{ 'a' if no }}"):
        with pytest.raises(TemplateError, match=r"page\.md\.j2, line 1: "):
            made(text, found=METHODS[0])


WRONG = {
    "{{ 1|percnt }}": (TemplateError, "No filter named 'percnt'"),
    "{% call heat('h' %}": (TemplateError, "unexpected '}'"),
    "{% call bars('b', rows) %}x{% endcall %}": (ChartError, "missing .*'parts'; allowed: rows, "),
    "{% call bars('b', rows, {}, x_label='x', wide=1) %}x{% endcall %}": (
        ChartError, "unexpected .*'wide'",
    ),
    "{% call heat('h', rows, 'nme', 'name', 'right', label='x') %}x{% endcall %}": (
        ChartError, "no field 'nme'; did you mean 'name'?",
    ),
    "{% call front('f', rows, 'right', 'right', method='name') %}x{% endcall %}": (
        ChartError, "field 'name' is 'sme'; allowed: a method",
    ),
    "{{ bars('b', rows, {}, x_label='x') }}": (ChartError, "no caption; allowed: a call block"),
    "{{ table(rows, 'nme') }}": (TableError, "no field 'nme'; did you mean 'name'?"),
}  # fmt: skip


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_in_a_template_is_one_sentence_with_its_line(made, text):
    error, said = WRONG[text]
    with pytest.raises(error, match=said) as caught:
        made(f"# T\nS.\n## One\n{text}", rows=METHODS)
    told = " ".join((str(caught.value), *getattr(caught.value, "__notes__", ())))
    assert "page.md.j2, line 4" in told


def test_wide_tables_of_a_template_stand_whole_beside_its_page(made, tmp_path):
    rows = [SimpleNamespace(**{f"a{k}": 10 * n + k for k in range(8)}) for n in range(2)]
    page = made("# T\nS.\n## One\nText.\n{{ table(rows, 'a0 a1 a2 a3 a4 a5 a6 a7') }}", rows=rows)
    text = write_page(page, tmp_path / "out").read_text()
    (details,) = (tmp_path / "out").glob("report-details.*.md")
    assert f"[All 8 columns]({details.name}#table-1)" in text
    assert "|  a7 |" in details.read_text()
    assert "|  a7 |" not in text


def test_rows_are_shown_as_they_declare():
    assert lines(table(METHODS)) == [
        "| method | right % | time: CPU s | a: n | b: n |",
        "| ------ | ----------------: | ----------: | ---: | ---: |",
        "| sme | 50.0 [25.0, 75.0] | - | 1 | - |",
        "| fbs | 25.0 [0.0, 50.0] | 2 | - | 2 |",
    ]
    assert lines(table(METHODS, "length name", titles={"length": "letters"}))[:1] == [
        "| letters | method |"
    ]
    assert lines(table(METHODS, "name right.n time.cpu_s", titles={"right.n": "cases"})) == [
        "| method | cases | CPU s |",
        "| ------ | ----: | ----: |",
        "| sme | 4 | - |",
        "| fbs | 4 | 2 |",
    ]
    assert table([]) is None
    assert [lines(Table(METHODS, [columns_of(Method)[name]]))[2] for name in ("name", "right")] == [
        "| sme |", "| 50.0 [25.0, 75.0] |",
    ]  # fmt: skip


def test_a_name_that_rows_do_not_have_is_an_error():
    with pytest.raises(TableError, match="nam"):
        str(table(METHODS, "nam"))
    with pytest.raises(TableError, match=r"no field 'time.cpu'; did you mean 'cpu_s'"):
        table(METHODS, "time.cpu")


def test_a_template_takes_macros_from_the_folder_above(made, tmp_path):
    (tmp_path.parent / "shared.md.j2").write_text(
        "{% macro twice(x) %}{{ x }}{{ x }}{% endmacro %}"
    )
    page = made("{% from 'shared.md.j2' import twice %}# T\nIt is {{ twice(name) }}.", name="so")
    assert page.summary == "It is soso."
