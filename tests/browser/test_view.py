"""The page that plays a loading, in a real browser: it draws, plays, and needs no network."""

import io
import re
from dataclasses import replace

import matplotlib.image
import numpy as np
import pytest

from steadyload.app.viewing import riding, write_view
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.model.frame import Frame
from steadyload.layouts.model.layout import replace_items
from steadyload.methods.registry import make_method
from steadyload.reports.viewer import three_js

BOXES = "player.panes[{}].stage.boxes"
FAILING = 2


def leaning():
    """Three boxes in a column, the third too far out, and one that is never placed."""
    spots = [(40.0, 0.0), (43.0, 10.0), (49.0, 20.0), (10.0, 0.0)]
    items = [Item(n, (x, y, 40.0), (10, 10, 10), 1.0) for n, (x, y) in enumerate(spots)]
    return Layout("leaning <b>", Pallet(100, 60, 100), tuple(items))


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    return write_view(leaning(), ["label@mujoco"], tmp_path_factory.mktemp("view") / "view.html")


@pytest.fixture(scope="module")
def beside(tmp_path_factory):
    page = tmp_path_factory.mktemp("view") / "view.html"
    return write_view(leaning(), ["label@mujoco", "sme"], page)


def shown(browser, pane=0):
    """How many boxes can be seen."""
    return browser.value(f"{BOXES.format(pane)}.filter(b => b.visible).length")


def place(browser, item, pane=0):
    """Where a box is drawn: centre, and quaternion x, y, z, w."""
    box = f"{BOXES.format(pane)}[{item}]"
    return np.array(browser.value(f"[...{box}.position.toArray(), ...{box}.quaternion.toArray()]"))


def now(browser, pane=0):
    return browser.value(f"document.querySelectorAll('.now')[{pane}].textContent")


def test_boxes_are_named_by_their_ids(browser, tmp_path):
    layout = leaning()
    named = [replace(item, name=f"SKU-<b>{item.sequence}") for item in layout.items]
    page = write_view(replace_items(layout, tuple(named)), ["fbs"], tmp_path / "view.html")
    browser.open(page)
    assert browser.errors == []
    assert browser.value("document.querySelector('.chip').textContent") == (
        "fails at box SKU-<b>1 (2nd of 4)"
    )
    assert now(browser) == "box SKU-<b>1 (2nd of 4) would not stand"
    assert browser.value("player.box(3)") == "box SKU-<b>3 (4th of 4)"


def test_it_loads_without_a_complaint_or_the_network(browser, alone):
    browser.open(alone)
    assert browser.errors == []
    assert browser.requests == [alone.resolve().as_uri()]
    assert not re.search(r"""(src|href)=["']?(https?:)?//""", alone.read_text())
    assert browser.value("document.querySelector('h1').textContent") == "leaning <b>"
    assert browser.value(f"{BOXES.format(0)}.length") == 4


def test_a_deck_is_a_slab_below_the_boxes(browser, tmp_path):
    layout = leaning()
    over = replace(layout.items[0], position=(-4.0, 0.0, 0.0), sequence=0)
    slabs = (
        "player.panes[0].stage.scene.children"
        ".filter(o => o.isMesh && o.geometry.type === 'BoxGeometry')"
    )
    for floor, found in (("deck", [[100, 14.4, 100]]), ("infinite", [])):
        page = tmp_path / f"{floor}.html"
        write_view(Layout("over", layout.pallet, (over,)).on(floor), ["sme"], page)
        browser.open(page)
        assert browser.errors == []
        sizes = f"{slabs}.map(o => o.geometry.parameters).map(p => [p.width, p.height, p.depth])"
        boxes = browser.value(sizes)
        assert [size for size in boxes if size != [10, 10, 10]] == found


def test_it_opens_at_the_verdict_with_its_numbers(browser, alone):
    browser.open(alone)
    said = make_method("label@mujoco").judge(leaning())
    assert said.failing_step == FAILING
    assert shown(browser) == FAILING + 1
    moved = f"box {said.moved_item + 1} of 4 moved {said.displacement:.1f} cm, {said.rotation:.1f}°"
    assert now(browser).startswith(moved)
    assert "too far" in now(browser)
    red = f"{BOXES.format(0)}.filter(b => !b.body.material.color.equals(b.own)).map(b => b.item)"
    assert browser.value(red) == [said.moved_item]
    chip = browser.value("document.querySelector('.chip').textContent")
    assert chip == "fails at box 3 of 4"


def test_keys_step_through_the_loading(browser, alone):
    browser.open(alone)
    browser.press("Home")
    assert shown(browser) == 1
    seen = []
    for _ in range(3):
        browser.press("ArrowRight")
        seen.append((shown(browser), browser.value("step.textContent")))
    assert seen == [(1, "box 1 of 4"), (2, "box 2 of 4"), (3, "box 3 of 4")]
    planned = leaning().items[2]
    fallen = place(browser, 2)
    assert fallen[1] < planned.position[1] + planned.size[1] / 2 - 3.0
    browser.press("ArrowLeft")
    assert shown(browser) == 2
    browser.press("End")
    np.testing.assert_array_equal(place(browser, 2), fallen)
    assert "after the verdict" in now(browser)
    assert browser.value("live.textContent").startswith("label@mujoco: box 3 of 4 moved")


def test_space_plays_and_pauses(browser, alone):
    browser.open(alone)
    browser.press("Home")
    browser.press(" ")
    assert browser.value("play.getAttribute('aria-label')") == "Pause"
    later = "new Promise(r => {const t = () => player.position > 0.05 ? r(true) : " \
        "requestAnimationFrame(t); t();})"  # fmt: skip
    assert browser.value(later)
    browser.press(" ")
    assert browser.value("play.getAttribute('aria-label')") == "Play"
    halted = browser.value("player.position")
    browser.value("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")
    assert browser.value("player.position") == halted


def test_the_slider_goes_from_box_to_box(browser, alone):
    browser.open(alone)
    slider = "[Number(scrub.value), Number(scrub.min), Number(scrub.max), scrub.ariaValueText]"
    assert browser.value(slider) == [3, 1, 4, "box 3 of 4"]
    for value, seen in ((1, 1), (2, 2), (3, 3), (4, 3)):
        browser.value(f"scrub.value = {value}; scrub.dispatchEvent(new Event('input'))")
        assert shown(browser) == seen
        assert browser.value(slider) == [seen, 1, 4, f"box {seen} of 4"]
    left = browser.value(
        "(([m, r]) => (m.left + m.width / 2 - r.left - 8) / (r.width - 16))([document.querySelector"
        "('.marks i'), scrub].map(e => e.getBoundingClientRect()))"
    )
    assert left == pytest.approx(2 / 3, abs=0.02), "the mark stands where the slider has box 3 of 4"


def test_what_falls_moves_through_its_step(browser, alone):
    browser.open(alone)
    heights = []
    for position in (2.3, 2.6, 2.8, 3.0):
        browser.value(f"player.jump({position})")
        heights.append(place(browser, 2)[1])
    assert heights[0] == pytest.approx(25.0, abs=0.01)
    assert heights == sorted(heights, reverse=True)
    assert heights[0] - heights[-1] > 3.0


def test_a_second_method_stands_beside_it_under_the_same_camera(browser, beside):
    browser.open(beside, width=1400)
    assert browser.errors == []
    assert [shown(browser, pane) for pane in (0, 1)] == [3, 3]
    assert now(browser, 1) == "box 3 of 4 would not stand"
    np.testing.assert_allclose(place(browser, 2, pane=1), [54, 25, 45, 0, 0, 0, 1])
    cameras = "player.panes.map(p => p.stage.camera.matrixWorld.toArray())"
    before = browser.value(cameras)
    browser.press("d")
    first, second = browser.value(cameras)
    assert first == second
    assert first != before[0]


@pytest.mark.parametrize(
    ("width", "height", "dark"), [(1280, 800, False), (1280, 800, True), (390, 800, False)]
)
def test_a_screenshot_shows_boxes_of_several_colours(browser, beside, width, height, dark):
    browser.open(beside, width=width, height=height, dark=dark)
    image = matplotlib.image.imread(io.BytesIO(browser.screenshot()), format="png")[..., :3]
    assert image.shape[:2] == (height, width)
    red = (image[..., 0] > 0.5) & (image[..., 1] < 0.35) & (image[..., 2] < 0.45)
    blue = (image[..., 2] > 1.3 * image[..., 0]) & (image[..., 2] > 0.3)
    assert red.mean() > 0.001
    assert blue.mean() > 0.004
    assert (image[:20, :20].mean() < 0.3) == dark
    assert browser.value("document.documentElement.scrollWidth") <= width
    across, down = browser.value(
        "(([a, b]) => [b.left - a.left, b.top - a.top])"
        "([...document.querySelectorAll('.pane')].map(p => p.getBoundingClientRect()))"
    )
    assert (across > 300, down > 200) == (width > 760, width <= 760)


@pytest.mark.parametrize("width", [500, 1280])
def test_it_prints_its_pictures_with_the_whole_load(beside, on_paper, width):
    [sheet] = on_paper(beside.resolve().as_uri(), width)
    red = (sheet[..., 0] > 0.5) & (sheet[..., 1] < 0.35) & (sheet[..., 2] < 0.45)
    blue = (sheet[..., 2] > 1.3 * sheet[..., 0]) & (sheet[..., 2] > 0.3)
    middle = sheet.shape[1] // 2
    for half in (np.s_[:, :middle], np.s_[:, middle:]):
        assert red[half].sum() > 100
        assert blue[half].sum() > 200


def test_every_control_has_a_name_and_can_be_reached(browser, alone):
    browser.open(alone)
    names = browser.value(
        "[...document.querySelectorAll('button, input, select, canvas')].map(e => "
        "e.getAttribute('aria-label') || e.labels?.[0]?.textContent.trim() || e.textContent)"
    )
    assert len(names) == 12
    assert all(names)
    assert browser.value("getComputedStyle(document.querySelector('canvas')).cursor") == "grab"


def test_the_same_view_gives_the_same_page_and_a_small_one(alone):
    assert alone.stat().st_size < 400_000
    assert len(three_js.three_js()) > 500_000


def test_dots_do_not_show_through_and_the_pointer_names_an_item(browser, tmp_path):
    spots = [(x, y, z) for y in (0.0, 20.0) for x in (30.0, 50.0) for z in (10.0, 30.0)]
    items = [
        Item(n, spot, (20, 20, 20), 2.5, mass_offset=(1.5, 0.0, -2.0))
        for n, spot in enumerate(spots)
    ]
    page = write_view(
        Layout("cube", Pallet(100, 60, 100), tuple(items)), ["sme"], tmp_path / "view.html"
    )
    browser.open(page)
    assert shown(browser) == 8
    dots = browser.value(f"{BOXES.format(0)}.map(b => b.mass.visible)")
    assert (dots[0], dots[7]) == (False, True)  # seen from high x, y and z
    browser.value(
        "(() => { const { stage, tip } = player.panes[0], a = stage.canvas.getBoundingClientRect();"
        " const p = stage.boxes[7].position.clone().project(stage.camera);"
        " player.point({ clientX: a.left + a.width * (1 + p.x) / 2,"
        " clientY: a.top + a.height * (1 - p.y) / 2 }, stage, tip); })()"
    )
    assert browser.value("player.panes[0].tip.textContent") == (
        "box 8 of 8: 20 × 20 × 20 cm, 2.5 kg, centre of mass +1.5 cm in x, −2 cm in z"
    )
    assert browser.errors == []


def test_all_that_is_said_has_the_axes_and_units_of_the_file(browser, tmp_path):
    box = Item(0, (0, 0, 0), (20, 30, 40), 2.5, mass_offset=(1.5, 0.0, -2.0), name="A")
    boxes = (box, replace(box, sequence=1, position=(60, 40, 0)))
    layout = Layout("one", Pallet(100, 80, 120), boxes)
    frame = Frame(("y", "z", "x"), "mm", "g")
    browser.open(write_view(layout, ["label@mujoco"], tmp_path / "view.html", frame=frame))
    said = make_method("label@mujoco").judge(layout)
    moved = f"{10.0 * said.displacement:.0f} mm, {said.rotation:.1f}°"
    assert now(browser).startswith(f"box A (2nd of 2) moved {moved}")
    browser.value(
        "(() => { const { stage, tip } = player.panes[0]; stage.itemAt = () => 0;"
        " player.point({ clientX: 1, clientY: 1 }, stage, tip); })()"
    )
    assert browser.value("player.panes[0].tip.textContent") == (
        "box A (1st of 2): 400 × 200 × 300 mm, 2.5 kg, centre of mass −20 mm in x, +15 mm in y"
    )
    assert browser.errors == []


def test_the_axes_of_the_file_are_arrows_beside_the_pallet(browser, tmp_path):
    frame = Frame(("y", "z", "x"), "mm", "g")
    browser.open(write_view(leaning(), ["sme"], tmp_path / "view.html", frame=frame))
    arrows = (
        "player.panes[0].stage.axes.children.map(a => [a.children[2].name, "
        "...a.children[2].getWorldPosition(new THREE.Vector3()).sub(a.parent.position)"
        ".normalize().toArray().map(Math.round)])"
    )
    assert browser.value(arrows) == [["+y", 1, 0, 0], ["+z", 0, 1, 0], ["+x", 0, 0, 1]]
    image = matplotlib.image.imread(io.BytesIO(browser.screenshot()), format="png")[..., :3]
    stage = image[100:600, 300:640]  # left of the load, without buttons
    blue = (stage[..., 2] > 0.7) & (stage[..., 0] < 0.25) & (stage[..., 1] < 0.45)
    assert blue.sum() > 300


def test_lengths_are_shown_on_demand_of_the_pallet_and_of_a_box(browser, alone):
    browser.open(alone)
    stage = "player.panes[0].stage"
    texts = f"[...{stage}.lengths.children, ...({stage}.sides?.children ?? [])].length"
    assert browser.value(f"{stage}.lengths.visible") is False
    assert browser.value(f"{stage}.sides") is None
    browser.press("m")
    assert browser.value(f"{stage}.lengths.visible") is True
    assert browser.value(f"{stage}.sides.item") == FAILING
    assert browser.value(texts) == 12, "three lines with their texts, twice"
    lengths = f"{stage}.sides.children.filter(c => c.isLine).map(c => " \
        "{const p = c.geometry.attributes.position.array; return Math.hypot(p[3] - p[0], " \
        "p[4] - p[1], p[5] - p[2])})"  # fmt: skip
    assert browser.value(lengths) == [10, 10, 10]
    browser.value("player.jump(1)")
    browser.press("ArrowLeft")
    assert browser.value(f"{stage}.sides.item") == 0
    browser.value("document.getElementById('lengths').click()")
    browser.press("Shift")
    assert browser.value(f"{stage}.sides") is None


@pytest.mark.parametrize("width", [500, 1280])
def test_scenes_beside_each_other_are_aligned_and_left_free_by_the_controls(browser, beside, width):
    browser.open(beside, width=width, height=900)
    one, other = browser.value(
        "[...document.querySelectorAll('canvas')].map(c => {const r = c.getBoundingClientRect(); "
        "return [r.left, r.top, r.width, r.height]})"
    )
    assert one[2:] == pytest.approx(other[2:], abs=1.0)
    same = 0 if width == 500 else 1
    assert one[same] == pytest.approx(other[same], abs=1.0)
    assert one[3] >= 180.0
    controls = browser.value("document.querySelector('.controls').getBoundingClientRect().top")
    assert controls >= other[1] + other[3]


def test_a_ride_is_played_in_its_own_time(browser, tmp_path):
    tall = Item(0, (40.0, 0.0, 40.0), (10.0, 40.0, 10.0), 1.0, name="TALL")
    layout = Layout("tall", Pallet(100, 60, 100), (tall,))
    page = write_view(
        layout, ["label@mujoco"], tmp_path / "ride.html", record=riding("eumos40509", 90.0)
    )
    browser.open(page)
    assert browser.errors == []
    assert browser.value("document.querySelector('.chip').textContent") == (
        "eumos40509, 0.5 g at 90 degrees: box TALL (1st of 1) tips"
    )
    assert "score" not in browser.value("document.querySelector('main, body').innerText")
    assert 0.8 < browser.value("player.seconds()") < 0.9  # 50 ms, 0.3 s and 0.5 s of watching
    browser.press("End")
    x, _, z, *turn = place(browser, 0)
    assert z > 45.0 + 5.0  # thrown along the depth
    assert x == pytest.approx(45.0, abs=0.5)
    assert abs(turn[0]) > 0.3
    assert "moved" in now(browser)
    assert "loading ended" not in now(browser)


def test_badge_and_motion_of_a_ride_name_one_box(browser, tmp_path):
    """The low box has turned too far while the high one has moved further without."""
    low = Item(0, (10.0, 0.0, 45.0), (4.0, 12.0, 4.0), 1.0, name="LOW")
    high = Item(1, (60.0, 0.0, 40.0), (16.0, 80.0, 16.0), 5.0, name="HIGH")
    page = write_view(
        Layout("two", Pallet(100, 120, 100), (low, high)), ["label@mujoco"],
        tmp_path / "ride.html", record=riding("eumos40509", 90.0),
    )  # fmt: skip
    browser.open(page)
    chip = browser.value("document.querySelector('.chip').textContent")
    assert chip == "eumos40509, 0.5 g at 90 degrees: box LOW (1st of 2) tips"
    assert "box LOW (1st of 2) moved at most" in browser.value(
        "document.querySelector('dl').textContent"
    )
    assert now(browser).startswith("box LOW (1st of 2) moved")
    assert "too far" in now(browser)


def test_forces_of_the_complete_load_are_arrows(browser, tmp_path):
    boxes = [Item(n, (40.0, 10.0 * n, 40.0), (10, 10, 10), 2.0) for n in range(3)]
    layout = Layout("column", Pallet(100, 60, 100), tuple(boxes))
    browser.open(write_view(layout, ["sme"], tmp_path / "view.html"))
    arrows = "player.panes[0].stage.forces"
    assert browser.value(f"{arrows}.visible") is False
    browser.press("End")
    browser.value("document.getElementById('forces').click()")
    browser.press("End")
    assert browser.errors == []
    assert browser.value(f"{arrows}.visible") is True
    found = browser.value("player.data.forces")
    assert np.array(found) == pytest.approx(
        np.array([[45.0, y, 45.0, kg] for y, kg in ((0, 6.0), (10, 4.0), (20, 2.0))]), abs=1e-3
    )
    browser.press("Home")
    assert browser.value(f"{arrows}.visible") is False


def test_a_load_that_falls_shows_no_forces(browser, alone):
    browser.open(alone)
    assert browser.value("document.getElementById('forces') === null") is True
