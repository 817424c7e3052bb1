"""YAML that is small and costs much, or states what cannot be: one sentence, soon and cheaply."""

from pathlib import Path

import pytest

from steadyload.cli import main
from steadyload.layouts.files.limits import MAX_DEPTH
from steadyload.layouts.files.plain_yaml import parse_plain_yaml
from steadyload.layouts.files.record import FormatError
from steadyload.layouts.formats import read_layouts

HANDED = Path(__file__).resolve().parents[3] / "shared" / "repro"

PIECES = "{pieces: {p1: {weight: 10}}}"
SCHEDULE = """\
segments:
  S1:
    shipments: SHIPMENTS
    built_ulds:
      U1:
        uld_type: ake
        loaded:
          - {shipment: 0, piece: p1, start_lat: X, start_height: 0, start_lng: 0,
             lat: 40, height: 30, lng: 40}
"""


def bomb(first, other, levels):
    lines = [f"  l0: &l0 {first}"]
    lines += [f"  l{n}: &l{n} {other.replace('*', f'*l{n - 1}')}" for n in range(1, levels)]
    return "segments:\n" + "\n".join(lines) + "\n"


COSTLY = {
    "aliases": (bomb("[x,x]", "[*,*,*,*,*,*,*,*,*,*]", 10), "the alias *l0 at line 3; allowed: "),
    "merges": (bomb("{a: 1}", "{<<: [*, *]}", 24), "the merge key << at line 3; allowed: "),
    "lists": ("segments:\n  a: " + "[" * 50_000, "nested too deeply at line 2; allowed: 32 "),
    "objects": ("segments:\n  a: " + "{a: " * 50_000, "nested too deeply at line 2; allowed: 32 "),
    "dashes": ("segments:\n  " + "- " * 50_000, "nested too deeply at line 2; allowed: 32 "),
}

ODD = {
    "bool": ('segments:\n  a: !!bool "foo"\n', "none at line 2: 'foo' is no bool; allowed: "),
    "int": ('segments:\n  a: !!int ""\n', "none at line 2: '' is no int; allowed: "),
    "float": ('segments:\n  a: !!float ""\n', "none at line 2: '' is no float; allowed: "),
    "time": ('segments:\n  a: !!timestamp "foo"\n', "line 2: 'foo' is no timestamp; allowed: "),
    "zone": ("segments:\n  a: 2001-01-01T00:00:00+99:00\n", "is no timestamp; allowed: "),
    "sixties": ("segments:\n  a: " + "1:" * 250 + "1.5\n", "line 2: '1:1:1"),
    "merge": ("segments:\n  a: {!!merge x: {b: 1}}\n", "the merge key << at line 2; allowed: "),
    "object": ("segments:\n  a: !!python/none x\n", "none at line 2; allowed: texts, "),
    "key": ("segments:\n  ? {a: 1}\n  : 1\n", "none at line 2; allowed: texts, "),
    "hexadecimal": (
        SCHEDULE.replace("SHIPMENTS", f"[{PIECES}]").replace("X", f"[0x{'f' * 8000}]"),
        "none at line 8: '0xfff",
    ),
    "index": (
        SCHEDULE.replace("SHIPMENTS", "[]").replace("X", "0"),
        "states no weight for shipment 0, piece 'p1'",
    ),
}


@pytest.mark.parametrize("name", COSTLY)
def test_a_small_file_costs_little(name, tmp_path, ended, cost_of_version):
    path = tmp_path / "schedule.yaml"
    content, message = COSTLY[name]
    path.write_text(content)
    status, out, said, cpu, memory = ended("score", str(path), "-m", "fbs")
    assert (status, out) == (2, "")
    assert said.startswith(f"steadyload: {path}: ")
    assert message in said
    assert said.count("\n") == 1
    assert cpu - cost_of_version < 2.0
    assert memory < 500


@pytest.mark.parametrize("name", ODD)
def test_a_value_that_cannot_be_is_named_with_its_line(name, tmp_path, capsys):
    path = tmp_path / "schedule.yaml"
    content, message = ODD[name]
    path.write_text(content)
    assert main(["score", str(path), "-m", "fbs"]) == 2
    said = capsys.readouterr().err
    assert str(path) in said
    assert message in said
    assert said.count("\n") == 1


def test_plain_values_are_read_as_ever():
    text = "a: [1, 2.5, yes, 2015-11-27, ~, '<<', &anchor x]\nb: {c: 0x1f, d: 1_000, e: 1:30}\n"
    values = parse_plain_yaml(text)
    assert values["a"][:3] == [1, 2.5, True]
    assert values["a"][3].year == 2015
    assert values["a"][4:] == [None, "<<", "x"]
    assert values["b"] == {"c": 31, "d": 1000, "e": 90}


def test_depth_is_allowed_up_to_its_limit():
    parse_plain_yaml("[" * MAX_DEPTH + "]" * MAX_DEPTH)
    with pytest.raises(FormatError, match="nested too deeply at line 1; allowed: 32 levels"):
        parse_plain_yaml("[" * (MAX_DEPTH + 1) + "]" * (MAX_DEPTH + 1))
    # Depth is what is open at one time.
    parse_plain_yaml("[" + "[], {}," * 100 + "]")


def test_inputs_that_broke_readers_are_refused():
    files = sorted(HANDED.glob("*.yaml"))
    if not files:
        pytest.skip("the inputs are not beside the project (../shared/repro)")
    for path in files:
        with pytest.raises(ValueError, match=r"; allowed: |; is it cut off") as caught:
            read_layouts(path)
        assert str(path) in str(caught.value)
