"""Planted faults: what is drawn, and that a fault is caught where a test looks at its line."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
import mutants
from faults import Fault, drawn, faults_in, source_files

ROOT = Path(__file__).resolve().parents[2]
SOURCE = '''\
"""Text: 1 < 2."""
import math

def first(a: int, b, key=None):
    if a < b and not key:
        return 100.0 * a - b[0]
    return max(swapped(b, a), a)

def record(a, b):
    raise ValueError(f"{a} < {b}: 3 not 4")
    return {"a": a, "b": b, "c": None}

print(record(a=1.5, b=True), -2, first.mean)
'''


def test_every_kind_of_fault_is_found_where_it_can_be():
    found = {
        (fault.kind, fault.line, fault.before, fault.after) for fault in faults_in("m", SOURCE)
    }
    assert found >= {
        ("comparison", 5, "<", "<="), ("logic", 5, "and", "or"), ("logic", 5, "not", ""),
        ("condition", 5, "a < b and not key", "(not (a < b and not key))"),
        ("unit", 6, "100.0 * a", "a"), ("sign", 6, "-", "+"), ("sign", 6, "*", "/"),
        ("off by one", 6, "0", "1"), ("name", 7, "max", "min"), ("swap", 7, "b, a", "a, b"),
        ("field", 11, '"a": a,', ""), ("field", 11, '"b": b,', ""), ("argument", 13, "a=1.5,", ""),
        ("number", 13, "1.5", "1.7500000000000002"), ("truth", 13, "True", "False"),
        ("sign", 13, "-", ""), ("name", 13, "mean", "median"),
    }  # fmt: skip
    assert not {line for _, line, *_ in found} & {1, 2, 4, 10}


@pytest.mark.parametrize("room", [room for room in mutants.ROOMS if not room.endswith(".c")])
def test_a_fault_changes_one_line_of_valid_python(room):
    files = dict(source_files(ROOT, room))
    faults = drawn([*files.items()], 12, 3)
    assert len(faults) == 12
    assert len({fault.kind for fault in faults}) >= 9
    for fault in faults:
        before, planted = files[fault.path], fault.planted(files[fault.path])
        ast.parse(planted)
        changed = [
            k for k, (old, new) in enumerate(
                zip(before.split("\n"), planted.split("\n"), strict=True), 1
            ) if old != new
        ]  # fmt: skip
        assert changed == [fault.line]


IN_C = """\
/* a < b */
#include "a.h"
static const double HALF = 0.5;

static bool first(const double *lower, int32_t count)
{
    double half = 0.5 * lower[0] - count; /* 1 < 2 */
    if (count < 3 && !(half > 0.0)) return true;
    return other(lower, count);
}
"""


def test_every_kind_of_fault_is_found_in_c():
    found = {
        (fault.line, fault.kind, fault.before, fault.after) for fault in faults_in("m.c", IN_C)
    }
    assert found == {
        (7, "number", "0.5", "0.65"), (7, "sign", " * ", " / "), (7, "sign", " - ", " + "),
        (7, "off by one", "0", "1"), (7, "name", "lower", "upper"),
        (8, "comparison", " < ", " <= "), (8, "off by one", "3", "4"), (8, "logic", "!", ""),
        (8, "logic", " && ", " || "), (8, "comparison", " > ", " >= "),
        (8, "number", "0.0", "0.1"), (8, "truth", "true", "false"),
        (8, "condition", "count < 3 && !(half > 0.0)", "!(count < 3 && !(half > 0.0))"),
        (9, "swap", "lower, count", "count, lower"), (9, "name", "lower", "upper"),
    }  # fmt: skip
    assert all(fault.planted(IN_C) != IN_C for fault in faults_in("m.c", IN_C))


def test_the_same_seed_draws_the_same_faults():
    files = source_files(ROOT, "harness/statistics")
    assert drawn(files, 10, 1) == drawn(files, 10, 1) != drawn(files, 10, 2)
    assert len(drawn(files, 10**6, 1)) == sum(len([*faults_in(*file)]) for file in files)


def test_what_is_replaced_has_to_stand_there():
    with pytest.raises(ValueError, match="does not stand there"):
        Fault("m", 5, 0, "sign", "-", "+").planted(SOURCE)


def test_every_room_of_the_project_has_tests_that_exist():
    for room, tests in mutants.ROOMS.items():
        assert source_files(ROOT, room), room
        for test in tests:
            assert (ROOT / test).exists(), test
    for package in (ROOT / "harness").iterdir():
        if package.is_dir() and [*package.rglob("*.py")]:
            assert f"harness/{package.name}" in mutants.ROOMS


def test_a_fault_is_caught_by_the_test_that_sees_it(tmp_path, monkeypatch):
    """In a small project: one line is tested, the other is not, and a test fails anyhow."""
    copy = tmp_path / "project"
    (copy / ".src").mkdir(parents=True)
    (copy / "room").mkdir()
    source = "def half(n):\n    return n / 2\n\n\ndef other(n):\n    return n / 2\n"
    (copy / "room" / "module.py").write_text(source)
    (copy / "tests").mkdir()
    test = "from module import half\n\n\ndef test_odd():\n    assert half(3) == 1\n\n\n"
    test += "def test_half():\n    assert half(4) == 2\n"
    (copy / "tests" / "test_module.py").write_text(test)
    monkeypatch.setitem(mutants.ROOMS, "room", ("tests",))
    monkeypatch.setenv("PYTHONPATH", str(copy / "room"))
    faults = [f for f in faults_in("room/module.py", source) if f.kind == "sign"]
    seen, unseen = (mutants.tried("room", fault, copy) for fault in faults)
    assert (seen.is_caught, seen.by) == (True, "tests/test_module.py::test_half")
    assert not unseen.is_caught
    assert seen.seconds > 0.0
    assert (copy / "room" / "module.py").read_text() == source
    text = mutants.report([seen, unseen], 0)
    assert "| room | 2 | 1 | 50 |" in text
    assert "- `room/module.py:6` sign: `/` -> `*`" in text


BUILDER = """
from pathlib import Path

Path("harness/core/built").write_text(Path("harness/core/half.c").read_text())
"""


def test_a_fault_in_c_is_built_and_then_built_out_of_the_copy_again(tmp_path, monkeypatch):
    core = tmp_path / "harness" / "core"
    core.mkdir(parents=True)
    (tmp_path / ".src").mkdir()
    (core / "building.py").write_text(BUILDER)
    source = "double half(double n)\n{\n    return n / 2.0;\n}\n"
    (core / "half.c").write_text(source)
    (tmp_path / "tests").mkdir()
    test = f"def test_it():\n    assert open('harness/core/built').read() == {source!r}\n"
    (tmp_path / "tests" / "test_half.py").write_text(test)
    monkeypatch.setitem(mutants.ROOMS, "harness/core/*.c", ("tests",))
    fault = next(f for f in faults_in("harness/core/half.c", source) if f.kind == "sign")
    outcome = mutants.tried("harness/core/*.c", fault, tmp_path)
    assert (outcome.is_caught, outcome.by) == (True, "tests/test_half.py::test_it")
    assert (core / "built").read_text() == source


def test_a_copy_that_does_not_work_counts_nothing(tmp_path):
    (tmp_path / ".src" / "steadyload").mkdir(parents=True)
    (tmp_path / ".src" / "steadyload" / "__init__.py").write_text("raise OSError('no library')")
    with pytest.raises(RuntimeError, match="does not work without a fault"):
        mutants.tried("harness/gym", Fault("a.py", 1, 0, "sign", "-", "+"), tmp_path)


def test_what_is_known_is_not_tried_again_and_what_changes_nothing_is_left_out(
    tmp_path, monkeypatch
):
    tried = []

    def one(room, fault, copy):
        tried.append(fault)
        return mutants.Outcome(room, fault, True, "t", 1.0, 0.0)

    monkeypatch.setattr(mutants, "tried", one)
    monkeypatch.setattr(mutants, "KEPT", tmp_path)
    monkeypatch.setattr(mutants, "copy_of_the_project", lambda folder: folder)
    outcomes = mutants.run(["harness/statistics"], 5, 0, 1)
    assert len(outcomes) == len(tried) == 5
    assert mutants.run(["harness/statistics"], 5, 0, 1) == outcomes
    assert len(tried) == 5
    listed = tmp_path / "unchanging.toml"
    listed.write_text(f"[unchanging]\n'{tried[0].key}' = 'why'\n")
    monkeypatch.setattr(mutants, "_UNCHANGING", listed)
    assert len(mutants.planned(["harness/statistics"], 5, 0)) == 4


def test_the_list_of_faults_that_change_nothing_has_reasons():
    import tomllib

    listed = tomllib.loads(mutants._UNCHANGING.read_text())["unchanging"]
    assert all(isinstance(why, str) and len(why) > 10 for why in listed.values())


def test_the_command_tells_its_options():
    said = subprocess.run(
        [sys.executable, str(ROOT / "tests/mutants/mutants.py"), "--help"],
        capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip
    assert "--seed" in said
