"""``steadyload view``: what it refuses, and what a page holds of a recording."""

import base64
import gzip
import json
import re
from dataclasses import replace
from importlib import metadata

import numpy as np
import pytest

from steadyload.app.viewing import ViewError, pick_layouts, write_view, write_views
from steadyload.cli import main
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.frame import Frame
from steadyload.methods.contract.method import Status
from steadyload.methods.registry import make_method
from steadyload.methods.session.recording import record_loading
from steadyload.reports.viewer.three_js import ThreeJsError, three_js


@pytest.fixture
def layout_file(tmp_path, stack):
    layouts = [stack(0.0, 3.0).renamed("stands"), stack(0.0, 7.0).renamed("falls")]
    write_layouts(tmp_path / "layouts.json", layouts, Format.NATIVE)
    return tmp_path / "layouts.json"


def data_of(page):
    packed = re.search(r'id="data">([^<]*)<', page.read_text()).group(1)
    return json.loads(gzip.decompress(base64.b64decode(packed)))


@pytest.fixture
def view(monkeypatch, capfd):
    """Runs the command in a folder; its status, output and errors."""

    def run(*arguments, cwd):
        monkeypatch.chdir(cwd)
        return main(["view", *arguments]), *capfd.readouterr()

    return run


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--layout", "fals"), "holds no layout 'fals'; did you mean 'falls'?"),
        (("--layout", "falls", "-m", "smee"), "unknown method 'smee'"),
        (("--layout", "falls", "-m", "sme", "-o", "no/such/x.html"), "no/such/x.html"),
        (("--layout", "falls", "-m", "sme", "--beside", "ps3@jolt"), "jolt"),
    ],
)
def test_wrong_input_is_one_sentence(layout_file, view, arguments, message):
    status, output, errors = view("layouts.json", *arguments, cwd=layout_file.parent)
    assert (status, output) == (2, "")
    assert message in errors
    assert errors.count("\n") == 1
    assert [p.name for p in layout_file.parent.iterdir()] == ["layouts.json"]


def test_a_method_that_refuses_says_why(tmp_path, view, plate):
    write_layouts(tmp_path / "plate.json", [plate(0.0)], Format.NATIVE)
    status, _, errors = view("plate.json", "-m", "label@chipmunk", cwd=tmp_path)
    assert status == 2
    assert "refuses layout 'plate': the layout is not planar" in errors


def test_the_command_writes_a_page(layout_file, view):
    arguments = ("--layout", "falls", "-m", "label@mujoco", "--beside", "sme")
    status, output, errors = view("layouts.json", *arguments, cwd=layout_file.parent)
    assert (status, output) == (0, "view.html\n"), errors
    text = (layout_file.parent / "view.html").read_text()
    assert "fails at box 2 of 2" in text
    assert "mujoco" in text.partition("Made with steadyload")[2]


@pytest.mark.parametrize("way", ["", ":between_steps=carry,criterion=paper,early_exit=0"])
def test_the_page_holds_every_recorded_pose(tmp_path, way):
    """The second item drops by 3 cm, which is allowed, and the third by far more."""
    spots = ((0, 0, 0), (40, 3, 40), (70, 60, 70))
    items = tuple(Item(n, spot, (10, 10, 10), 1.0) for n, spot in enumerate(spots))
    layout, spec = Layout("drops", Pallet(100, 100, 100), items), f"label@mujoco{way}"
    seen = record_loading(layout, make_method(spec))
    data = data_of(write_view(layout, [spec], tmp_path / "view.html"))
    (loading,), planned = data["loadings"], np.array(data["loadings"][0]["planned"])
    assert loading["failing"] == seen.verdict.failing_step == 2
    tracks, before = 0, planned.copy()
    for step, recorded in zip(loading["steps"], seen.steps, strict=True):
        for item in range(recorded.poses.centres.shape[1]):
            track = step["tracks"].get(str(item))
            expected = recorded.poses.centres[:, item]
            if track is None:
                np.testing.assert_allclose(expected, [planned[item]] * len(expected), atol=0.02)
                continue
            poses = np.array(track).reshape(-1, 7) / ([1000] * 3 + [10_000] * 4)
            if len(poses) > 1:
                assert len(poses) == len(step["times"]) == len(expected) + 1
                tracks += 1
                start = before[item] if way else planned[item]
                np.testing.assert_allclose(poses[0, :3], start, atol=0.02)
                poses = poses[1:]
            np.testing.assert_allclose(
                np.broadcast_to(poses[:, :3], expected.shape), expected, atol=0.02
            )
        before[: len(recorded.poses.centres[-1])] = recorded.poses.centres[-1]
    assert tracks
    moved = loading["steps"][2]["moved"][loading["steps"][2]["judged"] - 1]
    said = seen.verdict
    assert moved == [said.moved_item, round(said.displacement, 1), round(said.rotation, 1)]


def test_the_page_shows_a_deck_with_edges(tmp_path, stack):
    over = stack(-43.0, -43.0)
    write_view(over, ["simulation@bullet"], tmp_path / "deck.html")
    write_view(over.on("infinite"), ["simulation@bullet"], tmp_path / "plane.html")
    deck, plane = (data_of(tmp_path / f"{name}.html") for name in ("deck", "plane"))
    assert (deck["deck"], plane["deck"]) == (14.4, 0.0)
    assert deck["loadings"][0]["planned"] == plane["loadings"][0]["planned"]
    text = "on a pallet of 100 × 100 cm loaded up to 100 cm, its deck 14.4 cm above the ground"
    assert text in (tmp_path / "deck.html").read_text()
    assert "above the ground" not in (tmp_path / "plane.html").read_text()


def test_a_page_says_which_box_has_nothing_under_it(tmp_path):
    boxes = (
        Item(0, (40, 0, 30), (30, 20, 20), 10.0, name="A"),
        Item(1, (45, 24, 30), (30, 20, 20), 8.0, name="B"),
    )
    hovering = Layout("hovering", Pallet(120, 150, 80), boxes)
    note = "box B (2nd of 2) has nothing under it; it drops 4.0 cm onto box A (1st of 2)"
    text = write_view(hovering, ["label@mujoco"], tmp_path / "one.html").read_text()
    assert f'<p class="hovers">{note}</p>' in text
    assert '<h2 class="chip">hovers</h2>' in text
    text = write_views([hovering], ["label@mujoco"], tmp_path / "all.html").read_text()
    assert f'<span class="answer">hovers: {note}</span>' in text
    near = Layout("near", hovering.pallet, (boxes[0], replace(boxes[1], position=(45, 21, 30))))
    text = write_view(near, ["label@mujoco"], tmp_path / "near.html").read_text()
    assert "<p>box B (2nd of 2) has nothing under it; it drops 1.0 cm" in text
    assert '<h2 class="chip">stands</h2>' in text


def test_a_page_gives_the_reason_in_numbers_of_the_load(tmp_path, stack):
    """A method that moves nothing says why by its own terms, which stand beside."""
    text = write_view(stack(0.0, 7.0), ["equilibrium"], tmp_path / "one.html").read_text()
    said = "the centre of mass of box 2 of 2 lies 2.0 cm past the edge of box 1 of 2 (+x);"
    assert f'<p class="reason">{said}' in text
    notes = re.search('<p class="notes">(.*)</p>', text)[1]
    assert notes.startswith("<code>equilibrium</code>; score 0.500 (1 of 2 placed); CPU time")
    assert "; no contact forces balance box 2 of 2" in notes
    text = write_views([stack(0.0, 7.0)], ["equilibrium"], tmp_path / "all.html").read_text()
    assert "(score 0.5): the centre of mass of box 2 of 2 lies 2.0 cm past" in text


def test_a_page_has_the_axes_and_units_of_the_file(tmp_path, stack):
    frame = Frame.of(Dialect(units="mm", up="z", weight="g"))
    load = replace(stack(0.0, 7.0), pallet=Pallet(80.0, 100.0, 120.0))
    page = write_view(load, ["label@mujoco"], tmp_path / "one.html", frame=frame)
    data, text = data_of(page), page.read_text()
    assert data["axes"] == ["y", "z", "x"]
    assert data["units"] == {"length": "mm", "cm": 0.1, "decimals": 0, "weight": "kg", "kg": 1.0}
    assert "past the edge of box 1 of 2 (+y);" in text
    assert "2 boxes, 2 kg, on a pallet of 1200 × 800 mm loaded up to 1000 mm" in text
    moved = make_method("label@mujoco").judge(load)
    said = f"{round(10.0 * moved.displacement)} mm, {moved.rotation:.1f}"
    assert f"<dt>box 2 of 2 moved</dt><dd>{said}" in text
    cards = write_views([load], ["label@mujoco"], tmp_path / "all.html", frame=frame).read_text()
    assert f"box 2 of 2 moved {said} degrees" in cards


def test_a_verdict_without_a_score_is_shown_as_none(tmp_path, monkeypatch, stack):
    from steadyload.engines.with_mujoco import MujocoWorld
    from steadyload.engines.world import Poses

    poses = MujocoWorld.poses
    monkeypatch.setattr(
        MujocoWorld, "poses", lambda w: Poses(poses(w).centres * np.nan, poses(w).quaternions)
    )
    page = write_view(stack(0.0, 1.0), ["label@mujoco"], tmp_path / "view.html")
    assert f"no verdict: {Status.DIVERGED}" in page.read_text()
    assert data_of(page)["loadings"][0]["last"] == 0


def test_a_file_of_one_layout_needs_no_name(tmp_path, stack):
    write_layouts(tmp_path / "one.json", [stack(0.0)], Format.NATIVE)
    assert [layout.name for layout in pick_layouts(tmp_path / "one.json")] == ["stack"]
    with pytest.raises(ViewError, match="holds no layout 'other'"):
        pick_layouts(tmp_path / "one.json", ["other"])


def test_a_missing_library_is_one_sentence(monkeypatch):
    assert three_js().startswith("/**\n * @license")

    def missing(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "distribution", missing)
    with pytest.raises(ThreeJsError, match="pip install trimesh"):
        three_js()


def test_a_library_that_is_not_what_it_was_is_one_sentence(monkeypatch, tmp_path):
    class Other:
        version = "9.0"

        def locate_file(self, name):
            return tmp_path / name

    monkeypatch.setattr(metadata, "distribution", lambda name: Other())
    with pytest.raises(ThreeJsError, match=r"trimesh 9\.0 ships no three\.js"):
        three_js()


def test_one_layout_is_counted_as_one(layout_file, tmp_path, capsys):
    (stands, _) = layouts = pick_layouts(layout_file)
    text = write_views([stands], ["sme"], tmp_path / "all.html").read_text()
    assert "1 layout, judged by sme" in text
    for count, told in ((1, "1 layout"), (2, "2 layouts")):
        write_layouts(layout_file, layouts[:count], Format.NATIVE)
        assert main(["convert", str(layout_file), "-o", str(tmp_path / "x.csv")]) == 0
        assert capsys.readouterr().out == f"{told} -> {tmp_path / 'x.csv'}\n"
