"""An installation without numba judges; what needs the reference ends with one sentence."""

import subprocess
import sys

import pytest

from steadyload.cli import main
from steadyload.engines import registry
from steadyload.layouts.formats import Format, write_layouts
from steadyload.learners.generation import GenerationOptions, generate_labelled

NEEDS = "engine 'reference' needs the package numba: pip install 'steadyload[reference]'"

ABSENT = """
import sys
from steadyload.engines import registry
sys.modules["numba"] = sys.modules["llvmlite"] = None  # an import of them fails
here = registry._is_installed
registry._is_installed = lambda package: package != "numba" and here(package)
from steadyload.cli import main
"""


@pytest.fixture
def place(tmp_path, monkeypatch, stack):
    """A folder with a layout; nothing may be made in it."""
    write_layouts(tmp_path / "one.json", [stack(0.0, 4.0)], Format.NATIVE)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def absent(monkeypatch):
    here = registry._is_installed
    monkeypatch.setattr(registry, "_is_installed", lambda p: p != "numba" and here(p))


@pytest.mark.parametrize(
    "words",
    [
        "score one.json -m label@reference",
        "view one.json -m label@reference -o v.html",
        "repair one.json -m label@reference -o fixed.json",
        "transport one.json -m label@reference",
        "benchmark judge set",
        "study convergence",
        "study families",
        "study reality --reference",
        "study repair --reference",
        "study sensitivity",
        "study session",
        "study transport --limit 5",
    ],
)
def test_what_needs_the_reference_says_so_before_any_work(words, place, absent, capsys):
    assert main(words.split()) == 2
    assert capsys.readouterr().err == f"steadyload: {NEEDS}\n"
    made = {path.name for path in place.rglob("*") if path.is_file()}
    assert made - {".lock"} == {"one.json"}


def test_so_do_labels_to_learn_from(tmp_path, absent):
    with pytest.raises(registry.EngineNotInstalledError) as caught:
        generate_labelled(GenerationOptions(1), tmp_path / "set")
    assert str(caught.value) == NEEDS


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("check one.json", "1 pallet: 1 stand"),
        ("methods label@reference", "rebound"),
        ("engines", "reference"),
        ("study speed --limit 1", "report.md"),
        ("warm-up", f"nothing is compiled: {NEEDS}\n"),
    ],
)
def test_all_else_imports_no_numba(words, said, place):
    code = f"{ABSENT}sys.exit(main(sys.argv[1:]))"
    done = subprocess.run(
        [sys.executable, "-c", code, *words.split()], capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert said in done.stdout
