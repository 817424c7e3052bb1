"""One import name for people, editors and type checkers: links of an editable install."""

import json
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import steadyload.reports.style
import steadyload.statics.bearing

ROOT = Path(__file__).parents[1]
LINKS = ROOT / ".src" / "steadyload"
BESIDE = {"engines", "learners", "reports"}


def children(root):
    """What is to be linked in a clone: children of ``harness`` and the folders beside it."""
    return BESIDE | {
        child.name
        for child in (root / "harness").iterdir()
        if not child.name.startswith((".", "__pycache__"))
    }


def linked(root):
    """Names of the links that lead somewhere, each to its own file."""
    found = (root / ".src" / "steadyload").glob("*")
    return {
        link.name
        for link in found
        if link.is_symlink() and link.resolve() in {root / link.name, root / "harness" / link.name}
    }


def test_every_package_is_linked():
    stale = sorted(linked(ROOT) ^ children(ROOT))
    assert not stale, f"{', '.join(stale)}: links in .src are out of date; run `make .venv/.ready`"


def test_packages_are_imported_through_the_links():
    for module in (steadyload, steadyload.statics.bearing, steadyload.reports.style):
        assert Path(module.__file__).is_relative_to(LINKS)


USE = """\
import steadyload as sl
from steadyload.engines.registry import engine_names
from steadyload.learners.weights import SHIPPED
from steadyload.methods import make_method
from steadyload.reports.table import plain_percent

print(engine_names(), SHIPPED.name, plain_percent(0.5))
method = make_method("sme")
for layout in sl.read("pallets.csv"):
    verdict = sl.check(layout)
    print(verdict.to_dict(), method.judge(layout).failing_step, method.traits)
"""

WRONG = {
    "verdict.failing_stop": 'Cannot access attribute "failing_stop" for class "Check"',
    "sl.chek": '"chek" is not a known attribute of module "steadyload"',
    "method.judge('one')": '"Literal[\'one\']" is not assignable to "Layout"',
}


@pytest.mark.parametrize("wrong", [None, *WRONG])
def test_an_editor_outside_the_clone_finds_the_package(tmp_path, wrong):
    """By Pyright, which editors run, in a folder that knows nothing but the interpreter."""
    pytest.importorskip("pyright", reason="the tools of `make .venv/.ready` are not installed")
    (tmp_path / "use.py").write_text(USE + (f"    print({wrong})\n" if wrong else ""))
    done = subprocess.run(
        [sys.executable, "-m", "pyright", "--outputjson", "--pythonpath", sys.executable, "use.py"],
        capture_output=True, text=True, cwd=tmp_path,
    )  # fmt: skip
    found = json.loads(done.stdout)["generalDiagnostics"]
    lines = {one["range"]["start"]["line"] for one in found}
    assert lines == ({USE.count("\n")} if wrong else set()), found
    if wrong:
        assert WRONG[wrong] in found[0]["message"]


@pytest.fixture
def small(tmp_path):
    """A clone with packages of a file each."""
    clone = tmp_path.resolve() / "clone"
    for folder in ("harness/methods", *BESIDE):
        (clone / folder).mkdir(parents=True)
        (clone / folder / "__init__.py").touch()
    (clone / "harness" / "__init__.py").touch()
    for name in ("setup.py", "backend.py", "pyproject.toml", "Makefile", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, clone)
    return clone


def link(clone):
    command = [sys.executable, "setup.py", "--quiet", "links"]
    subprocess.run(command, cwd=clone, check=True)


def test_links_follow_what_is_added_and_removed(small):
    link(small)
    assert linked(small) == children(small) == {"__init__.py", "methods", *BESIDE}
    kept = (small / ".src" / "steadyload" / "methods").lstat()
    (small / "harness" / "__init__.py").unlink()
    (small / "harness" / "app").mkdir()
    link(small)
    assert {path.name for path in (small / ".src" / "steadyload").iterdir()} == children(small)
    assert linked(small) == {"app", "methods", *BESIDE}
    assert (small / ".src" / "steadyload" / "methods").lstat() == kept, "nothing is linked anew"


def test_make_links_a_new_child(small):
    (small / ".venv").mkdir()
    link(small)
    for stamp in (".venv/.judging", ".src/.linked"):
        (small / stamp).touch()

    def planned():
        command = ["make", "--dry-run", "--old-file=.venv/.judging", ".src/.linked"]
        done = subprocess.run(command, cwd=small, capture_output=True, text=True, check=True)
        return "setup.py --quiet links" in done.stdout

    assert not planned()
    (small / "harness" / "methods" / "rule.py").touch()
    assert not planned(), "a file of a package is there at once"
    (small / "harness" / "app.py").touch()
    assert planned()


@pytest.mark.parametrize("possible", [True, False])
def test_an_editable_install_is_one_line_or_where_links_cannot_be_a_finder(small, possible):
    if not possible:
        (small / ".src").touch()
    command = [sys.executable, "setup.py", "--quiet", "editable_wheel", "--dist-dir", "wheels"]
    subprocess.run(command, cwd=small, check=True, capture_output=True)
    [wheel] = (small / "wheels").glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if "dist-info" not in name}
        [line] = [archive.read(name).decode() for name in names if name.endswith(".pth")]
    if possible:
        assert (line, len(names)) == (f"{small / '.src'}\n", 1)
    else:
        assert line.startswith("import __editable__")
        assert len(names) == 2
