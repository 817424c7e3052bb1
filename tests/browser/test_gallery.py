"""The page of a check in a real browser: cards, pictures, filters, and the player of each."""

import io

import matplotlib.colors
import matplotlib.image
import numpy as np
import pytest

import steadyload as sl
from steadyload.app.check_defaults import default_method
from steadyload.app.checked_page import write_checked
from steadyload.app.checking import Answer, check_all
from steadyload.app.viewing import pick_layouts, write_views
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.formats import Format, write_layouts
from steadyload.reports.viewer.picture import AMBER, MARKED, RAMP, shades
from steadyload.runs.scoring import read_entries

PALLET = Pallet(100, 60, 100)


def column(name, *shifts):
    """Boxes of 10 cm above each other, shifted along x [cm]."""
    return Layout(
        name,
        PALLET,
        tuple(Item(n, (40.0 + x, 10.0 * n, 40.0), (10, 10, 10), 1.0) for n, x in enumerate(shifts)),
    )


LAYOUTS = [
    column("stands", 0.0, 3.0, 0.0),
    column("</script><b>falls</b><!--style-->", 0.0, 3.0, 9.0, 9.0),
    column("also stands", 0.0, 1.0),
]


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("check")
    file = folder / "pallets.json"
    write_layouts(file, LAYOUTS, Format.NATIVE)
    header = (
        "layout,pallet_width,pallet_height,pallet_depth,sequence,x,y,z,width,height,depth,weight"
    )
    (folder / "bad.csv").write_text(f"{header}\nbad,100,60,100,0,0,0,0,10,-1,10,1\n")
    entries = read_entries((file, folder / "bad.csv"))
    found = check_all(entries, workers=0)
    assert [one.answer for one in found] == [
        Answer.STANDS, Answer.FAILS, Answer.STANDS, Answer.BAD_INPUT,
    ]  # fmt: skip
    return write_checked(entries, found, folder / "out", workers=0)


@pytest.fixture
def page(browser, checked):
    browser.errors.clear()
    browser.requests.clear()
    browser("Emulation.setDeviceMetricsOverride", width=1000, height=700, deviceScaleFactor=1,
            mobile=False)  # fmt: skip
    browser("Page.navigate", url=checked.resolve().as_uri())
    waits(browser, "window.ready === true")
    yield browser
    assert not browser.errors
    assert all(url.startswith(("file:", "data:", "blob:", "about:")) for url in browser.requests)


def waits(browser, condition):
    """Wait until a condition holds in the page."""
    said = browser.value(
        f"new Promise(r => {{let n = 0; const t = () => ({condition}) ? r('') : ++n > 500 ? "
        "r('it never held') : setTimeout(t, 20); t();})"
    )
    assert said == "", condition


def fills(picture, colour):
    """How many shapes of a picture have a colour, as JavaScript."""
    return f"{picture}.querySelectorAll('[fill=\"{colour}\"]').length"


def names(browser):
    return browser.value(
        "[...document.querySelectorAll('#cards li:not([hidden]) .name')].map(n => n.textContent)"
    )


def test_a_card_for_every_pallet_with_its_answer(page):
    assert names(page) == [*(layout.name for layout in LAYOUTS), "bad"]
    text = page.value("document.body.innerText")
    assert "4 pallets: 2 stand, 1 fail, 1 bad input." in text
    assert "fails at box 3 of 4: box 3" in text
    assert "height" in page.value("document.querySelector('.bad-input.card').textContent")


def test_pictures_are_drawn_and_the_failing_box_is_red(page):
    red = page.value(f"[...document.querySelectorAll('.picture')].map(p => {fills('p', MARKED)})")
    assert [count > 0 for count in red] == [False, True, False, False]
    assert red[1] == 1 + 3, "the top of the box, which has the colour itself, and all sides through"
    drawn = page.value("[...document.querySelectorAll('.picture')].map(p => p.textContent)")
    assert drawn == ["+x+y+z"] * 3 + [""], "the axes of each that has a plan"
    seen = matplotlib.image.imread(io.BytesIO(page.screenshot()), format="png")[..., :3]
    assert coloured(seen)[0] > 500


def coloured(image):
    """Numbers of points of an image that have the colour of a marked box, and of other boxes."""
    red, green, blue = np.moveaxis(image, -1, 0)
    marked = (red > 0.6) & (green < 0.35) & (blue < 0.4)
    return marked.sum(), (~marked & (image.max(axis=-1) - image.min(axis=-1) > 0.2)).sum()


def boxed(image):
    """Number of points of an image that have the colour of a box: no text and no line has it."""
    ramp = np.array([matplotlib.colors.to_rgb(shades(colour)[0]) for colour in RAMP])
    return (np.abs(image[..., None, :] - ramp).max(axis=-1) < 0.02).any(axis=-1).sum()


def test_every_picture_of_a_page_is_on_paper(on_paper, tmp_path):
    """Also those below the first screen, to which nobody has scrolled."""
    found = []
    for count in (1, 18):
        box = Item(0, (0, 0, 0), (90, 50, 90), 5.0)
        cards = [Layout(f"{n}", PALLET, (box,)) for n in range(count)]
        path = write_views(cards, ["sme"], tmp_path / f"{count}.html")
        found.append(sum(map(boxed, on_paper(path.resolve().as_uri()))))
    one, all_of_them = found
    assert one > 100
    assert all_of_them == pytest.approx(18 * one, rel=0.1)


def test_a_player_that_is_open_is_on_paper_with_its_picture(checked, on_paper):
    [sheet] = on_paper(checked.resolve().as_uri() + "#1")
    marked, others = coloured(sheet[sheet.shape[0] // 4 :])  # below what is written
    assert marked > 300
    assert others > 300


def test_it_filters_by_answer_and_by_words_and_sorts(page):
    page.value("document.querySelector('[data-kind=stands]').click()")
    assert names(page) == ["stands", "also stands"]
    page.value("search.value = 'ALSO'; search.oninput()")
    assert names(page) == ["also stands"]
    assert page.value("shown.textContent") == "1 of 4 shown"
    page.value("document.querySelector('[data-kind=fails]').click()")
    assert names(page) == []
    assert page.value("none.hidden") is False
    page.value("search.value = ''; document.querySelector('[data-kind=\"\"]').click()")
    page.value("order.value = 'kind'; order.onchange()")
    assert names(page)[:2] == [LAYOUTS[1].name, "bad"]


def test_a_card_opens_the_player_of_its_loading(page):
    page.value("document.querySelector('button.card.fails').click()")
    frame = "document.querySelector('dialog iframe')"
    waits(page, f"{frame}?.contentWindow.player?.frames > 1")
    inside = f"{frame}.contentWindow"
    assert page.value(f"{inside}.document.querySelector('h1').textContent") == LAYOUTS[1].name
    assert page.value(f"{inside}.player.data.loadings[0].failing") == 2
    assert page.value(f"{inside}.player.data.loadings[0].steps[2].times.length") > 10
    first, small = page.value(
        f"[...{inside}.document.querySelectorAll('.chip, .notes')].map(e => e.textContent)"
    )
    assert first == "fails at box 3 of 4"
    assert small.startswith(f"{default_method(len(LAYOUTS[1]))}; score 0.500 (2 of 4 placed)")
    assert page.value(f"{inside}.document.querySelector('.now.bad').textContent")
    page.value("later.click()")
    waits(page, f"{inside}?.player?.data.items.length === 2")
    assert page.value(f"{inside}.player.data.loadings[0].simulates") is False
    page.value("document.getElementById('close').click()")
    waits(page, "!dialog.open && !document.querySelector('iframe')")


def test_an_address_opens_its_pallet(page, checked):
    page("Page.navigate", url="about:blank")
    page("Page.navigate", url=checked.resolve().as_uri() + "#1")
    waits(page, "document.querySelector('dialog iframe')?.contentWindow.player?.frames > 1")


def test_a_bad_pallet_cannot_be_played(page):
    assert page.value("document.querySelector('.bad-input.card').tagName") == "DIV"


def test_several_layouts_are_one_page_whose_cards_play(browser, tmp_path):
    write_layouts(tmp_path / "two.json", LAYOUTS[:2], Format.NATIVE)
    entries = pick_layouts(tmp_path / "two.json")
    path = write_views(entries, ["sme", "label@mujoco"], tmp_path / "view.html")
    browser.errors.clear()
    browser("Page.navigate", url=path.resolve().as_uri())
    waits(browser, "window.ready === true")
    answers = "[...document.querySelectorAll('.answer')].map(e => e.textContent)"
    stands, falls = browser.value(answers)
    assert stands == str(sl.make_method("sme").judge(LAYOUTS[0]))
    assert falls.startswith(
        "fails at box 3 of 4 (score 0.5): the centre of mass of box 3 of 4 lies"
    )
    browser.value("document.querySelectorAll('button.card')[1].click()")
    inside = "document.querySelector('dialog iframe')?.contentWindow"
    waits(browser, f"{inside}?.player?.panes.length === 2")
    assert not browser.errors


@pytest.fixture(scope="module")
def badged(tmp_path_factory):
    """A load of which a box is crushed, one that stands and falls on the road, one that holds."""
    folder = tmp_path_factory.mktemp("badged")
    crushed = tuple(
        Item(
            n,
            (40.0, 10.0 * n, 40.0),
            (10, 10, 10),
            2.0,
            name="ART",
            max_load=3.0 if n == 1 else None,
        )
        for n in range(5)
    )
    flat = Item(0, (0, 0, 0), (90, 10, 90), 5.0)
    tower = column("tower", 0.0, 0.0, 0.0, 0.0, 0.0)
    layouts = [Layout("crushed", PALLET, crushed), tower, Layout("flat", PALLET, (flat,))]
    write_layouts(folder / "loads.json", layouts, Format.NATIVE)
    entries = read_entries((folder / "loads.json",))
    found = check_all(entries, transport="eumos40509", workers=0)
    assert found[0].crushed.step == 3
    assert [one.transport.held for one in found] == [False, False, True]
    return write_checked(entries, found, folder / "out", workers=0)


def test_a_crushed_box_and_a_load_that_fails_on_the_road_have_badges(browser, badged):
    browser.errors.clear()
    browser("Page.navigate", url=badged.resolve().as_uri())
    waits(browser, "window.ready === true")
    badges = browser.value(
        "[...document.querySelectorAll('#cards li')].map(c => "
        "[...c.querySelectorAll('.badges em')].map(b => b.textContent))"
    )
    assert badges == [["crushed", "road: no"], ["road: no"], []]
    browser.value("document.querySelector('[data-kind=crushed]').click()")
    assert names(browser) == ["crushed"]
    answer = browser.value("document.querySelector('#cards .answer').textContent")
    assert answer == "crushed when the 4th box is placed: box ART (2nd of 5) bears 4 kg of 3"
    amber, red = (
        browser.value(f"[...document.querySelectorAll('.picture')].map(p => {fills('p', colour)})")
        for colour in (AMBER, MARKED)
    )
    assert amber == [4, 4, 0]
    assert red == [0, 0, 0]
    shapes = browser.value(
        "document.querySelector('.picture').querySelectorAll('svg > path').length"
    )
    assert shapes == 1 + 3 * 4 + 3
    browser.value("document.querySelector('#cards button.card').click()")
    frame = "document.querySelector('dialog iframe')"
    waits(browser, f"{frame}?.contentWindow.player?.frames > 1")
    inside = f"{frame}.contentWindow"
    assert browser.value(f"{inside}.document.querySelector('.chip').textContent") == answer
    assert browser.value(f"{inside}.document.querySelector('.pane').className") == "pane crushed"
    assert browser.value(f"{inside}.document.getElementById('step').textContent") == "box 4 of 5"
    now = browser.value(f"{inside}.document.querySelector('.now.bad').textContent")
    assert now == "box ART (2nd of 5) bears more than it may"
    amber = (
        f"{inside}.player.panes[0].stage.boxes.filter("
        "b => !b.body.material.color.equals(b.own)).map(b => b.item)"
    )
    assert browser.value(amber) == [1]
    assert browser.errors == []


def test_a_card_plays_the_plan_and_its_repair(browser, tmp_path):
    write_layouts(tmp_path / "two.json", LAYOUTS[:2], Format.NATIVE)
    entries = read_entries((tmp_path / "two.json",))
    repair = sl.repair(LAYOUTS[1])
    path = write_checked(entries, check_all(entries, workers=0), tmp_path / "out",
                         repairs={1: repair}, workers=0)  # fmt: skip
    browser.errors.clear()
    browser("Page.navigate", url=path.resolve().as_uri())
    waits(browser, "window.ready === true")
    facts = browser.value("document.querySelectorAll('.facts')[1].textContent")
    assert "repair: stands, by " in facts
    frame = "document.querySelector('dialog iframe')"
    inside = f"{frame}?.contentWindow"
    browser.value("document.querySelectorAll('button.card')[1].click()")
    waits(browser, f"{inside}?.player?.frames > 1")
    shown = "[planned, repaired].map(b => [b.hidden, b.getAttribute('aria-pressed')])"
    assert browser.value(shown) == [[False, "true"], [False, "false"]]
    centre = f"{inside}.player.data.loadings[0].planned[2][0]"
    assert browser.value(f"{inside}.player.data.loadings[0].failing") == 2
    assert browser.value(centre) == pytest.approx(54.0)
    browser.value("document.getElementById('repaired').click()")
    waits(
        browser,
        f"{inside}?.player?.frames > 1 && {inside}.player.data.loadings[0].failing === null",
    )
    moved = repair.layout.items[repair.origins.index(2)]
    assert browser.value(f"{inside}.player.data.loadings[0].planned[{moved.sequence}][0]") == (
        pytest.approx(moved.position[0] + 5.0)
    )
    amber = (
        f"{inside}.player.panes[0].stage.boxes.filter("
        f"b => b.body.material.color.equals(new b.body.material.color.constructor('{AMBER}')))"
        ".map(b => b.item)"
    )
    assert browser.value(amber) == [one.new_step for one in repair.changes if one.moved] != []
    told = f"[...{inside}.document.querySelectorAll('header li')].map(c => c.textContent)"
    assert browser.value(told) == repair.sentences
    assert browser.value("playing.textContent").endswith(": repaired")
    assert browser.value(shown) == [[False, "false"], [False, "true"]]
    browser.value("planned.click()")
    waits(
        browser, f"{inside}?.player?.frames > 1 && {inside}.player.data.loadings[0].failing === 2"
    )
    browser.value("earlier.click()")
    waits(browser, f"{inside}?.player?.frames > 1 && {inside}.player.data.items.length === 3")
    assert browser.value("[planned.hidden, repaired.hidden]") == [True, True]
    assert not browser.errors
