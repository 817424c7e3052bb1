"""Files that broke a reader once: one sentence, soon, in little memory; the valid ones as they are.

The command judges each in a process of its own, whose CPU time and memory have limits.
"""

import runpy
import sys
from pathlib import Path

import pytest

from steadyload.cli import main
from steadyload.layouts import Item, Layout, Pallet
from steadyload.layouts.files.record import FormatError
from steadyload.layouts.formats import read_layouts
from steadyload.layouts.writers import as_csv

HANDED = Path(__file__).resolve().parents[3] / "shared" / "repro"
MADE = ("digits.csv", "twice.json", "deep.yaml", "deep-maps.yaml", "many.json")
VALID = ("inj2.json", "ratio.json")
REFUSED = {
    "dup.json": "states 'weight' twice in one object; allowed: each name once",
    "esc1.json": r'layout "\x1b]0;PWNED\x07\x1b[2J\x1b[31mall fine": name is ',
    "esc2.json": r"item '\x1b]0;PWNED\x07\x1b[2J': position is missing",
    "laugh9.yaml": "has the alias *l0 at line 6",
    "merge21.yaml": "has the merge key << at line 6",
    "y_bool.yaml": "'foo' is no bool",
    "y_int.yaml": "'' is no int",
    "y_float.yaml": "'' is no float",
    "y_ts.yaml": "'foo' is no timestamp",
    "y_tzneg.yaml": "segments.a is datetime.datetime(1, 1, 1, 0, 0",
    "y_sexa.yaml": "is no float",
    "y_hex.yaml": "holds a YAML value that is none at line 9: '0xff",
    "y_index.yaml": "states no weight for shipment 5, piece 'p1'",
    "is_whole_crash.parquet": "cannot be read as Parquet ('utf-8' codec",
    "shard_one_bit.parquet": "lacks the column 'pallet_width'",
    "silent.parquet": "lacks the column 'pallet_width'",
    "whole_but_bad.parquet": "lacks the column 'pallet_width'",
    "twice.json": "has the unknown key 'a0'",
    "digits.csv": "line 2 has a cell of 100001 characters; allowed: 1000",
    "many.json": "has 20,000 items; allowed: at most 5,000",
    "deep.yaml": "is nested too deeply at line 2; allowed: 32 levels",
    "deep-maps.yaml": "is nested too deeply at line 2; allowed: 32 levels",
}

COMMANDS = 10
"""CPU time, in that of the command that does nothing: 2 s where that takes 0.2 s."""

MEMORY = 500
"""[MB], resident."""


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    """The larger files, which a script beside the handed ones writes."""
    script = HANDED / "make.py"
    if not script.exists():
        pytest.skip("the inputs are not beside the project (../shared/repro)")
    folder = tmp_path_factory.mktemp("made")
    before, sys.argv = sys.argv, [str(script), str(folder)]
    try:
        runpy.run_path(str(script))
    finally:
        sys.argv = before
    return folder


def handed(name, made):
    return (made if name in MADE else HANDED) / name


COSTLY = ("laugh9.yaml", "merge21.yaml", "dup.json", *MADE)
"""Those that grow without end are judged in a process of their own, the others in this one."""


def assert_one_sentence(name, path, err):
    assert err.startswith(f"steadyload: {path}: ")
    assert REFUSED[name] in err
    assert err.count("\n") == 1
    assert err[:-1].isprintable()
    assert len(err) < 500 + len(str(path))


@pytest.mark.parametrize("name", COSTLY)
def test_a_costly_file_is_refused_soon(name, made, ended, cost_of_version):
    path = handed(name, made)
    status, out, err, cpu, memory = ended("score", str(path), "-m", "fbs")
    assert (status, out) == (2, "")
    assert_one_sentence(name, path, err)
    assert cpu - cost_of_version < COMMANDS * cost_of_version
    assert memory < MEMORY


@pytest.mark.parametrize("name", [name for name in REFUSED if name not in COSTLY])
def test_a_harmful_file_is_refused_in_a_sentence(name, made, capsys):
    path = handed(name, made)
    assert main(["score", str(path), "-m", "fbs"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert_one_sentence(name, path, err)


def test_markup_in_names_is_judged_and_shown_harmlessly(made, capsys):
    assert main(["score", str(HANDED / "inj2.json"), "-m", "sme"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.replace("\n", "").isprintable()
    assert out.count("1.000") == out.count("\n") - 1


def test_weights_of_an_extreme_ratio_are_read(made, capsys):
    assert main(["score", str(HANDED / "ratio.json"), "-m", "equilibrium"]) == 0
    assert "0.500" in capsys.readouterr().out


def test_every_handed_file_is_held_here(made):
    found = [*HANDED.iterdir(), *made.iterdir()]
    files = {path.name for path in found if path.is_file()}
    assert files - {"README.md", "make.py"} == {*REFUSED, *VALID}


def test_a_tab_between_columns_is_escaped_in_a_message(tmp_path):
    path = tmp_path / "tabs.csv"
    lines = as_csv([Layout("A", Pallet(120, 160, 80), (Item(0, (0, 0, 0), (9, 9, 9), 1),))])
    path.write_text(lines.replace(",", "\t").replace("A\t", '"A"x\t', 1))
    with pytest.raises(FormatError, match=r"line 2 is not CSV \('\\t' expected after") as caught:
        read_layouts(path)
    assert str(caught.value).isprintable()


def test_memory_does_not_grow_with_the_layouts_that_are_judged(tmp_path, ended):
    header, row = as_csv(
        [Layout("A", Pallet(120, 160, 80), (Item(0, (0, 0, 0), (9, 9, 9), 1),))]
    ).splitlines()
    peaks = []
    for count in (3_000, 13_000):
        path = tmp_path / f"{count}.csv"
        path.write_text("\n".join([header, *(f"L{k}{row[1:]}" for k in range(count))]))
        judging = ("score", str(path), "-m", "sme", "--json")
        status, out, err, _, memory = ended(*judging, cpu=60)  # memory has the bound here
        assert (status, err, out.count('"layout"')) == (0, "", count)
        peaks.append(memory)
    assert peaks[1] - peaks[0] < 15.0, "MiB for 10,000 layouts"
