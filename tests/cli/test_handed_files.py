"""Files that turned a verdict or cost too much once: the right answer, or one sentence.

Each lies beside the project; the same faults are tested on small inputs of their own in the tests
of the packages that they concern.
"""

import json
from pathlib import Path

import pytest

from steadyload.cli import main
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.files.dialect import Dialect
from steadyload.layouts.formats import Format, read_layouts, write_layouts
from steadyload.methods import make_method
from steadyload.methods.session.session import LoadingSession
from steadyload.statics.bearing.crushing import first_crushed

HANDED = Path(__file__).resolve().parents[3] / "shared" / "repro" / "2"
SCRIPTS = {"README.md", "crush.py", "gap01.py", "report_undo_traversal.sh", "weights_bomb.py"}
"""What they do is done by tests of bearing, tolerances, run folders and weights."""

FILES = {
    "eq_time_session_1.json", "eq_time_session_2.json", "eq_time_session_3.json", "gap01.csv",
    "long_history.csv", "one500.json", "tab_in_message.csv",
}  # fmt: skip

pytestmark = pytest.mark.skipif(
    not HANDED.is_dir(), reason="the inputs are not beside the project (../shared/repro)"
)


def test_every_handed_file_has_a_test_here():
    assert {path.name for path in HANDED.iterdir()} == FILES | SCRIPTS


@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_session_and_the_whole_layout_have_one_verdict(number):
    [layout] = read_layouts(HANDED / f"eq_time_session_{number}.json")
    method = make_method("equilibrium:time=0.3")
    session = LoadingSession(layout.pallet, method)
    answers = [session.try_place(item) for item in layout.items]
    assert [answer.stable for answer in answers] == [True] * len(layout)
    assert method.judge(layout).stable


@pytest.mark.parametrize("method", ["fbs", "sme", "equilibrium"])
def test_a_gap_of_exactly_the_tolerance_is_closed_at_every_height(method):
    layouts = read_layouts(HANDED / "gap01.csv", dialect=Dialect(units="mm"))
    judge = make_method(method)
    assert len(layouts) == 1000
    assert all(judge.judge(layout).stable for layout in layouts)


def test_a_minute_far_past_the_limit_slides(tmp_path, capsys):
    path = tmp_path / "one.json"
    box = Item(0, (40.0, 0.0, 20.0), (40.0, 20.0, 40.0), 5.0)
    write_layouts(path, [Layout("A", Pallet(120.0, 160.0, 80.0), (box,))], Format.NATIVE)
    words = ["transport", str(path), "-m", "label@mujoco", "--json"]
    main([*words, "--history", str(HANDED / "long_history.csv")])
    out, err = capsys.readouterr()
    assert "diverged" not in out + err
    assert {row["mode"] for row in json.loads(out)} == {"slides"}


def test_one_limit_among_500_boxes_is_answered():
    [layout] = read_layouts(HANDED / "one500.json")
    crushed = first_crushed(layout)
    assert (crushed.step, crushed.item, crushed.allowed_kg) == (499, 259, 0.5)
    assert crushed.bears_kg == pytest.approx(1.0, rel=1e-6)


def test_a_tab_is_escaped_in_a_message(capsys):
    assert main(["check", str(HANDED / "tab_in_message.csv")]) == 2
    out, err = capsys.readouterr()
    assert out == "" or "bad input" in out
    assert err[:-1].isprintable()
    assert "'\\t' expected after" in err
