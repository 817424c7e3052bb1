"""The notebooks of docs, run cell by cell in a fresh process, as a notebook does."""

import itertools
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import steadyload as sl

FOLDER = Path(__file__).parents[2] / "docs" / "notebooks"

RUN = """
import ast, json, sys

def show(value):
    if value is not None:
        print(value._repr_html_() if hasattr(value, "_repr_html_") else repr(value))

names, sys.displayhook = {}, show
for cell in json.load(open(sys.argv[1], encoding="utf-8"))["cells"]:
    if cell["cell_type"] == "code":
        *first, last = ast.parse("".join(cell["source"])).body
        exec(compile(ast.Module(first, []), cell["id"], "exec"), names)
        exec(compile(ast.Interactive([last]), cell["id"], "single"), names)
"""
"""A cell's last expression is shown, as HTML where the value has some."""


def run(name, folder):
    """What a notebook shows when it is run in an empty folder."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", RUN, str(FOLDER / name)], cwd=folder,
        capture_output=True, text=True, env=os.environ | {"MPLBACKEND": "agg"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("file", sorted(FOLDER.glob("*.ipynb")), ids=lambda file: file.stem)
def test_a_cell_has_a_sentence_before_it_and_no_output(file):
    cells = json.loads(file.read_text())["cells"]
    for before, cell in itertools.pairwise(cells):
        if cell["cell_type"] == "code":
            assert before["cell_type"] == "markdown"
            assert (cell["outputs"], cell["execution_count"]) == ([], None)


def test_a_run_becomes_a_figure(tmp_path, assert_drawn):
    shown = run("from-a-run-to-a-figure.ipynb", tmp_path)
    assert shown.count("<table") == 3
    assert "equilibrium" in shown
    assert_drawn(tmp_path / "accuracy.svg")


def test_a_packer_that_asks_gets_a_load_that_stands(tmp_path):
    shown = run("packing-with-a-session.ipynb", tmp_path)
    assert shown.count("data:image/svg+xml") == 3
    assert "careless: fails at box" in shown
    assert "careful: stands" in shown
    assert (tmp_path / "packed.json").exists()


def test_a_packers_plans_are_repaired(tmp_path):
    pytest.importorskip("py3dbp")
    shown = run("repairing-a-packers-plans.ipynb", tmp_path)
    assert shown.count("data:image/svg+xml") == 2
    assert shown.count(" -> stands, by ") == 4
    layouts = sl.read(tmp_path / "standing.json")
    assert len(layouts) == 4
    assert all(sl.check(layout).stands for layout in layouts)
