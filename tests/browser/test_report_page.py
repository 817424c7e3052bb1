"""The page of a study in a real browser: tables, charts, and the way from a case to its player."""

import pytest

from steadyload.app.recommend.kept import SPATIAL
from steadyload.layouts.benchmark import load_benchmark
from steadyload.reports.pages.page import Page, Section
from steadyload.reports.pages.writing import write_page
from steadyload.runs import answers
from steadyload.runs.definition import StudyDefinition
from steadyload.runs.results import load_results
from steadyload.runs.runner import run_study
from steadyload.studies.evaluation.study import Evaluation
from steadyload.studies.kit import Lab
from steadyload.studies.report.comparing import compare
from steadyload.studies.report.study import RunReport

METHODS = ("fbs", "pbs0.5", "sme", "equilibrium", "ps3@mujoco")
MEGABYTES = 5.0


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    study = StudyDefinition(name="few", methods=METHODS, benchmark="test", limit=4, shard_size=60)
    run_study(study, folder, workers=0)
    return write_page(RunReport(directory=folder).page(compare(folder)), folder).with_suffix(
        ".html"
    )


@pytest.fixture(scope="module")
def evaluation(tmp_path_factory):
    folder = tmp_path_factory.mktemp("evaluation")
    study = Evaluation(methods=METHODS, limit=4)
    return write_page(study.page(study.run(Lab(folder, 0))), folder / "page").with_suffix(".html")


@pytest.fixture
def opened(browser):
    def open_page(path, width=1000):
        browser.errors.clear()
        browser.requests.clear()
        browser("Emulation.setDeviceMetricsOverride", width=width, height=800,
                deviceScaleFactor=1, mobile=False)  # fmt: skip
        browser("Page.navigate", url=path.resolve().as_uri())
        waits(browser, "window.ready === true")
        return browser

    yield open_page
    assert not browser.errors
    assert all(url.startswith(("file:", "data:", "blob:", "about:")) for url in browser.requests)


def waits(browser, condition):
    """Wait until a condition holds."""
    browser.value(
        "new Promise(r => {const t = () => {let now = false; try {now = " + condition + "} "
        "catch {} return now ? r() : setTimeout(t, 20)}; t()})"
    )


def column(browser, table, title):
    """Cells of the rows of a table that are shown, by a column's title."""
    return browser.value(
        f"(() => {{const t = document.querySelectorAll('section table')[{table}], at = "
        f"[...t.tHead.rows[0].cells].findIndex(c => c.textContent === {title!r});"
        "return [...t.tBodies[0].rows].filter(r => !r.hidden).map(r => "
        "r.cells[at].textContent)})()"
    )


def press_header(browser, title):
    browser.value(
        f"[...document.querySelectorAll('section table')[0].tHead.rows[0].cells].find("
        f"c => c.textContent === {title!r}).querySelector('button').click()"
    )


@pytest.mark.parametrize("kind", ["run", "evaluation"])
def test_a_page_needs_nothing_else_and_answers_first(kind, opened, request):
    path = request.getfixturevalue(kind)
    assert path.stat().st_size < MEGABYTES * 1e6
    page = opened(path)
    told = page.value("document.querySelector('.answer').textContent")
    assert told.startswith("The most accurate method is ")
    assert page.value("document.querySelector('.answer').getBoundingClientRect().bottom") < 400
    made = "document.querySelector('footer details')"
    assert page.value(f"{made}.open") is False
    assert "steadyload" in page.value(f"{made}.textContent")


def test_a_table_is_sorted_by_its_headers(opened, run):
    page = opened(run)
    for way in ("descending", "ascending"):
        press_header(page, "accuracy %")
        found = [float(cell.split()[0]) for cell in column(page, 0, "accuracy %")]
        assert found == sorted(found, reverse=way == "descending")
        assert len(found) == len(METHODS)
        sorted_by = page.value(
            "[...document.querySelectorAll('section table')[0].tHead.rows[0].cells].map(c => "
            "c.getAttribute('aria-sort')).filter(Boolean)"
        )
        assert sorted_by == [way]
    press_header(page, "method")
    names = column(page, 0, "method")
    assert names == sorted(names, key=str.lower)


def test_a_long_table_is_filtered_and_shows_few_columns_first(opened, tmp_path):
    rows = "\n".join(
        f"| case {n} | {n} | {'-' if n == 3 else n * n} | a | b | c | d | e |" for n in range(12)
    )
    table = f"| name | n | square | 1 | 2 | 3 | 4 | 5 |\n|-|-:|-:|-|-|-|-|-|\n{rows}"
    sections = [Section("One", "", [table])]
    page = opened(write_page(Page("Many", "So.", sections, {}), tmp_path).with_suffix(".html"))
    press_header(page, "square")
    assert column(page, 0, "square") == [
        *(str(n * n) for n in range(11, -1, -1) if n != 3), "-",
    ]  # fmt: skip
    page.value(
        "(() => {const i = document.querySelector('section input'); i.value = 'CASE 1'; "
        "i.dispatchEvent(new Event('input'))})()"
    )
    assert sorted(column(page, 0, "name")) == ["case 1", "case 10", "case 11"]
    assert page.value("document.querySelector('.count').textContent") == "3 of 12 rows"
    shown = "[...document.querySelectorAll('th')].filter(c => c.offsetParent).length"
    assert page.value(shown) == 5
    page.value(
        "[...document.querySelectorAll('.tools button')].find(b => "
        "b.textContent.startsWith('show all 8')).click()"
    )
    assert page.value(shown) == 8
    csv = page.value("csvOf(document.querySelector('section table'))").splitlines()
    assert csv[0] == '"name","n","square","1","2","3","4","5"'
    assert len(csv) == 13


@pytest.mark.parametrize("kind", ["run", "evaluation"])
@pytest.mark.parametrize("width", [500, 1440])
def test_a_chart_names_methods_and_shows_a_group_or_an_engine(kind, width, opened, request):
    page = opened(request.getfixturevalue(kind), width)
    points = "[...document.querySelectorAll('figure.chart g.point')]"
    assert page.value(f"{points}.length") == len(METHODS)
    page.value(f"{points}.find(p => p.ariaLabel.startsWith('SME')).onmouseenter()")
    tip = "document.querySelector('.tip')"
    assert page.value(f"{tip}.hidden") is False
    assert page.value(f"{tip}.querySelector('b').textContent") == "SME"
    assert "n = 12" in page.value(f"{tip}.textContent")
    page.value(f"{points}.find(p => !p.ariaLabel.startsWith('SME')).focus()")
    assert page.value(f"{tip}.querySelector('b').textContent") != "SME"
    choose = "(() => {{const s = document.querySelectorAll('figure.chart select')[{}]; s.value = " \
        "[...s.options].find(o => o.text === {!r}).value; s.onchange()}})()"  # fmt: skip
    page.value(choose.format(1, "mujoco"))
    assert page.value(f"{points}.map(p => p.ariaLabel.split(':')[0])") == ["PS_3 @ mujoco"]
    page.value(choose.format(1, "all"))
    page.value(choose.format(0, "S1"))
    assert "n = 4" in page.value(f"{points}[0].ariaLabel")
    assert page.value("document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize("kind", ["run", "evaluation"])
def test_cases_on_which_two_methods_differ_open_their_player(kind, opened, request):
    path = request.getfixturevalue(kind)
    page = opened(path)
    page.value(
        "[...document.querySelectorAll('.matrix button')].find(b => "
        "b.title.startsWith('FBS and SME')).click()"
    )
    told = page.value("document.querySelector('[aria-live] p').textContent")
    folder = path.parent if kind == "run" else path.parents[1] / SPATIAL
    said = (
        load_results(folder)
        .pivot(index=["layout", "scenario"], columns="method", values="failing_step")
        .fillna(-1)
    )
    differ = said[said["fbs"] != said["sme"]]
    assert told == f"FBS and SME differ on {len(differ)} of {len(said)} cases."
    listed = page.value(
        "[...document.querySelectorAll('.cases tbody tr')].map(r => "
        "[...r.cells].slice(0, 2).map(c => c.textContent))"
    )
    assert {tuple(case) for case in listed} == {*differ.index}
    rows = (
        "[...document.querySelector('.cases tbody tr').cells].slice(2, 4).map(c => c.textContent)"
    )
    steps = said.loc[tuple(listed[0]), ["fbs", "sme"]]
    told = [(f"box {int(step) + 1}" if step >= 0 else "stable") for step in steps]
    assert page.value(rows) == told
    page.value("document.querySelector('.cases td button').click()")
    inside = "document.querySelector('dialog iframe').contentWindow"
    waits(page, f"{inside}.player && {inside}.player.frames > 1")
    assert listed[0][0] in page.value("document.getElementById('playing').textContent")
    items = len(load_benchmark().layout(*listed[0]).items)
    assert f"{items} box" in page.value(f"{inside}.document.querySelector('header').textContent")
    page.value("document.getElementById('close').click()")
    waits(page, "!document.querySelector('dialog iframe')")


def test_names_and_texts_are_text(opened, tmp_path, undrawn):
    harmful = "<img src=x onerror=alert(1)>"
    section = Section(harmful, harmful, [f"| {harmful} |\n|-|\n| {harmful} |"])
    page = opened(
        write_page(Page(harmful, harmful, [section], {harmful: harmful}), tmp_path).with_suffix(
            ".html"
        )
    )
    assert page.value("document.querySelectorAll('img').length") == 0
    assert page.value("document.querySelector('h1').textContent") == harmful
    assert page.value("document.querySelector('td').textContent") == harmful


def test_a_run_of_more_cases_than_a_page_lists_has_the_picture_alone(run, tmp_path, monkeypatch):
    monkeypatch.setattr(answers, "MOST_LISTED", 11)
    found = compare(run.parent)
    assert found.cases == 12
    assert found.answer_chart is None
    page = (
        write_page(RunReport(directory=tmp_path).page(found), tmp_path)
        .with_suffix(".html")
        .read_text()
    )
    assert 'data-name="accuracy"' in page
    assert 'data-name="agreement"' not in page
    assert 'id="players"' not in page
