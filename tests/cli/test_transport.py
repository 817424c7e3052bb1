"""``steadyload transport``, from files to records and exit statuses."""

import json
from contextlib import nullcontext
from dataclasses import replace

import pytest

from steadyload.cli import main
from steadyload.layouts.formats import Format, write_layouts
from steadyload.layouts.model.layout import Item, Layout, Pallet

PALLET = Pallet(120.0, 200.0, 80.0)


@pytest.fixture
def file(tmp_path):
    flat = Layout("flat", PALLET, (Item(0, (40.0, 0.0, 30.0), (30.0, 10.0, 30.0), 8.0),))
    tall = Layout("tall", PALLET, (Item(0, (40.0, 0.0, 30.0), (12.0, 40.0, 30.0), 8.0),))
    path = tmp_path / "loads.json"
    write_layouts(path, [flat, tall], Format.NATIVE)
    return path


def records(capsys, *words):
    status = main(["transport", *map(str, words), "--json"])
    return status, json.loads(capsys.readouterr().out)


def test_limits_of_every_load_in_every_direction(file, capsys):
    status, found = records(capsys, file, "--directions", 4)
    assert status == 0
    assert [(one["layout"], one["direction_deg"]) for one in found] == [
        (name, direction) for name in ("flat", "tall") for direction in (0.0, 90.0, 180.0, 270.0)
    ]
    assert [one["limit_g"] for one in found] == pytest.approx([0.5] * 4 + [0.3, 0.5] * 2, abs=1e-6)
    assert [one["mode"] for one in found][4:] == ["tips", "slides"] * 2


def test_a_rule_that_one_load_does_not_hold_ends_with_status_1(file, capsys):
    method = "equilibrium:sides=frictionless,friction=0.9"
    status, found = records(capsys, file, "--rule", "en12195", "-m", method)
    assert status == 1
    assert [one["held"] for one in found] == [True] * 4 + [False, True, False, True]
    assert [one["level_g"] for one in found][:4] == [0.8, 0.5, 0.5, 0.5]
    assert main(["transport", str(file), "--rule", "en12195", "-m", method, "--limit", "1"]) == 0
    printed = capsys.readouterr().out
    assert "Rigid boxes, without wrap" in printed
    assert [line.split() for line in printed.splitlines() if line.startswith("flat")] == [
        ["flat", direction, "yes", "-", "-", "-"] for direction in ("0", "90", "180", "270")
    ]


def test_a_box_that_moves_is_named_by_its_id(tmp_path, capsys):
    box = Item(0, (40.0, 0.0, 30.0), (12.0, 40.0, 30.0), 8.0, name="SKU-7")
    file = tmp_path / "named.json"
    write_layouts(file, [Layout("one", PALLET, (box,))], Format.NATIVE)
    _, found = records(capsys, file, "--directions", 1)
    assert (found[0]["moved_item"], found[0]["moved_box"]) == (0, "SKU-7")
    assert main(["transport", str(file), "--directions", "1"]) == 0
    assert " SKU-7 " in capsys.readouterr().out
    write_layouts(file, [Layout("one", PALLET, (replace(box, name=""),))], Format.NATIVE)
    assert main(["transport", str(file), "--directions", "1"]) == 0
    row = capsys.readouterr().out.splitlines()[1].split()
    assert row[3] == "1", "people count boxes from 1"


def test_a_history_of_ones_own(file, tmp_path, capsys):
    history = tmp_path / "braking.csv"
    history.write_text("time_s,acceleration_g\n0,0\n0.2,0.4\n1,0.4\n")
    words = "--history", history, "-m", "label@mujoco", "--directions", 2
    status, found = records(capsys, file, *words)
    assert status == 1
    assert [one["held"] for one in found] == [True, True, False, False]
    assert found[2]["rotation_deg"] > 10.0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("-m", "sme"), "does not know friction; allowed: equilibrium:sides=frictionless"),
        (("-m", "label@chipmunk"), "has two dimensions; allowed: one of three"),
        (("--rule", "en1219"), "did you mean 'en12195'"),
        (("--rule", "tilt", "--directions", "4"), "--directions: not allowed with --rule"),
        (("--history", "none.csv", "-m", "label@mujoco"), "none.csv: cannot be read"),
        (("--directions", "500"), "500 directions; allowed: 1 to 360"),
    ],
)
def test_what_cannot_be_asked_is_told_before_an_answer(file, capsys, words, message):
    assert main(["transport", str(file), *words]) == 2
    told = capsys.readouterr()
    assert message in told.err
    assert told.out == ""


def test_a_load_that_is_not_valid_is_named_and_the_others_are_judged(tmp_path, file, capsys):
    content = json.loads(file.read_text())
    content["layouts"][0]["items"][0]["weight"] = -1
    bad = tmp_path / "bad.json"
    bad.write_text(json.dumps(content))
    assert main(["transport", str(bad), "--directions", "1", "--json"]) == 2
    told = capsys.readouterr()
    assert "flat" in told.err
    assert [one["layout"] for one in json.loads(told.out)] == ["tall"]


def test_progress_counts_loads(file, capsys, monkeypatch):
    told = []
    monkeypatch.setattr(
        "steadyload.cli.transport.progress_bar",
        lambda label: nullcontext(lambda *at: told.append(at)),
    )
    records(capsys, file, "--directions", 1)
    assert told == [(1, 2), (2, 2)]
