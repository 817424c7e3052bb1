"""Layouts, verdicts and answers as a notebook shows them, where it runs and styles nothing."""

import base64
import pickle
import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest

import steadyload as sl
from steadyload.app.demo import demo_pallets
from steadyload.reports.viewer.picture import AMBER, HEIGHT, MARKED, WIDTH, WOOD, behind_first


def column(name, *shifts):
    """Boxes of 10 cm above each other, shifted along x [cm]."""
    items = tuple(
        sl.Item(n, (40.0 + x, 10.0 * n, 40.0), (10, 10, 10), 2.5) for n, x in enumerate(shifts)
    )
    return sl.Layout(name, sl.Pallet(100, 60, 80), items)


class Parts(HTMLParser):
    """Tags of a piece of HTML, its words, and its picture."""

    def __init__(self, html):
        super().__init__()
        self.tags, self.words, self.picture, self.caption = set(), "", None, ""
        self.feed(html)

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        if tag == "img":
            attributes = dict(attrs)
            head, _, content = attributes["src"].partition(",")
            assert head == "data:image/svg+xml;base64"
            self.picture = ElementTree.fromstring(base64.b64decode(content))
            self.caption = attributes["alt"]

    def handle_data(self, data):
        self.words += data + " "


def shown(thing):
    return Parts(thing._repr_html_())


def shapes(picture):
    """Numbers of shapes in a picture: all, the red ones, and those that shine through. The axes are
    the last one."""
    assert not picture.get("viewBox").startswith("nan")
    assert "".join(picture[-1].itertext()) == "+x+y+z"
    picture = picture[:-1]
    red = [shape for shape in picture if "fill-opacity" in shape.attrib]
    return len(picture), sum(shape.get("fill") == MARKED for shape in picture), len(red)


def test_a_layout_shows_what_it_holds():
    found = shown(column("three", 0.0, 1.0, 0.0))
    assert " ".join(found.words.split()) == (
        "three: 3 boxes boxes 3 weight 7.5 kg height of the load 30.0 cm of 60 cm "
        "pallet, width × depth 100 × 80 cm floor infinite"
    )
    assert shapes(found.picture) == (1 + 3 * 3, 0, 0)  # a deck, and three faces a box
    assert found.caption == "three: 3 of 3 boxes"


def test_a_verdict_shows_its_line_its_values_and_where_it_fails():
    layout = column("four", 0.0, 3.0, 9.0, 9.0)
    verdict = sl.make_method("ps_opt@mujoco").judge(layout)
    found = shown(verdict)
    assert verdict.failing_step == 2
    assert f"four: {verdict}" in found.words
    assert "0.500 (2 of 4 boxes placed safely)" in found.words
    assert f"displacement {verdict.displacement:.1f} cm" in " ".join(found.words.split())
    assert f"{verdict.rotation:.1f} degrees" in found.words
    assert re.search(r"CPU time\s*[\d.]+ m?s", found.words)
    assert shapes(found.picture) == (1 + 3 * 3 + 3, 6 - 2, 3)  # the last one is not loaded any more
    assert found.caption == f"four: 3 of 4 boxes, box {verdict.item_at_fault + 1} of 4 in red"


def test_an_answer_shows_what_it_says_and_how_sure_it_is():
    check = sl.check(column("falls", 0.0, 9.0))
    found = shown(check)
    assert f"falls: {check.sentence}" in found.words
    assert check.method in found.words
    assert re.search(r"accuracy on \d+ similar labelled pallets\s+[\d.]+ %", found.words)
    assert shapes(found.picture)[2] == 3


def test_a_repair_shows_the_plan_before_and_after_it_at_one_scale():
    plan = sl.Layout("falls", sl.Pallet(30, 60, 30), (
        sl.Item(0, (0, 0, 0), (10, 10, 10), 2.5), sl.Item(1, (0, 50, 0), (10, 10, 10), 2.5),
        sl.Item(2, (0, 10, 0), (10, 10, 10), 2.5),
    ))  # fmt: skip
    repair = sl.repair(plan, ["drop", "move"])
    assert repair.layout.upper[:, 1].max() < 60.0
    found = shown(repair)
    [told] = repair.sentences
    assert " ".join(found.words.split()) == (
        f"falls: stands, by 5.0 cm: 1 box moved confirmed by {repair.judged_by} before "
        f"{repair.before.sentence} changes {told}"
    )
    assert found.caption == "falls as planned, box 2 of 3 in red; repaired, moved boxes in amber"
    assert found.picture.get("viewBox") == f"0 0 {2 * WIDTH} {HEIGHT}"
    fills = [shape.get("fill") for shape in found.picture if shape.tag.endswith("path")]
    assert len(fills) == 2 * (1 + 3 * 3) + 3
    assert fills.count(MARKED) == 1 + 3
    assert fills[1 + 3 * 3 + 3 :].count(AMBER) == 1
    decks = [widths(shape.get("d")) for shape in found.picture if shape.get("fill") == WOOD]
    assert decks[0] == pytest.approx(decks[1], abs=0.2)


def widths(path):
    """Of a shape, to the right and down."""
    points = np.array([tuple(map(float, p.split(","))) for p in path[1:-1].split()])
    return points.max(0) - points.min(0)


def test_a_repair_of_a_plan_that_stands_or_is_not_repaired_shows_the_plan_alone():
    for plan, kinds in ((column("stands", 0.0), ["shift"]), (column("falls", 0, 9.0), ["order"])):
        repair = sl.repair(plan, kinds)
        found = shown(repair)
        assert f"{plan.name}: {repair.sentence}" in found.words
        assert found.picture.get("viewBox") == f"0 0 {WIDTH} {HEIGHT}"


def test_it_shows_where_scripts_are_stripped_and_without_a_network():
    falls = column("two", 0.0, 9.0)
    for thing in (column("one", 0.0), sl.check(falls), sl.repair(falls)):
        assert shown(thing).tags <= {"p", "table", "tbody", "tr", "th", "td", "img"}
        assert not re.search(r"https?://|url\(", thing._repr_html_())


def test_names_are_text():
    found = shown(column('<script>"&', 0.0))
    assert "script" not in found.tags
    assert '<script>"&: 1 box' in found.words
    assert found.caption == '<script>"&: 1 of 1 boxes'


def test_a_verdict_without_its_layout_has_no_picture():
    found = shown(sl.Verdict(20, failing_step=5, reason="item 4 tips"))
    assert found.picture is None
    assert "fails at box 6 of 20 (score 0.25): box 5 of 20 tips" in found.words


def test_the_layout_of_a_verdict_is_no_part_of_what_is_compared():
    layout = column("two", 0.0, 9.0)
    verdict = sl.make_method("fbs").judge(layout)
    assert verdict.layout is layout
    again = pickle.loads(pickle.dumps(verdict))
    assert again == verdict
    assert again.layout is not layout
    assert "layout" not in repr(verdict)
    assert "layout" not in verdict.to_dict()


@pytest.mark.parametrize("layout", demo_pallets(4), ids=lambda layout: layout.name)
def test_what_stands_before_others_is_drawn_after_them(layout):
    """Against lines of sight: of the boxes that one meets, the nearest has to be drawn last."""
    boxes = np.hstack((layout.lower, layout.sizes))
    turn = np.empty(len(boxes), dtype=int)
    turn[behind_first(boxes)] = np.arange(len(boxes))
    eyes = np.random.default_rng(7).uniform(layout.lower.min(0), layout.upper.max(0), (3000, 3))
    # From (1, 1, 1) a line meets a box where it has entered along every axis, and left along none.
    enters = (layout.lower + 0.2 - eyes[:, None]).max(axis=2)
    leaves = (layout.upper - 0.2 - eyes[:, None]).min(axis=2)
    met = enters < leaves
    nearest = np.where(met, leaves, -np.inf).argmax(axis=1)
    last = np.where(met, turn, -1).argmax(axis=1)
    several = met.sum(axis=1) > 1
    assert several.sum() > 1000
    assert (nearest == last)[several].all()
