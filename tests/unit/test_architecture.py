"""Who may import whom. No arrow runs back up."""

import ast
from pathlib import Path

import pytest

from steadyload.engines.registry import ENGINES

ROOT = Path(__file__).parents[2]

FOLDERS = {"harness": "", "engines": ".engines", "learners": ".learners", "reports": ".reports"}
"""Folder of the repository -> where it is installed below ``steadyload``."""

_METHODS = {"methods", "layouts", "atomic", "engines"}
_STUDIES = {"studies", "reports", *_METHODS}

# Package below ``steadyload`` -> what of ours it may import. The longest matching prefix counts.
ALLOWED = {
    "engines": {"engines"},
    "reports": {"reports"},
    "atomic": set(),
    "layouts": {"layouts", "atomic"},
    "methods": _METHODS,
    "studies": _STUDIES,
    "properties": {"properties", *_STUDIES},
    "tuning": {"tuning", *_STUDIES},
    "learners": {"learners", *_STUDIES},
    "cli": {"cli", "learners", "tuning", "properties", *_STUDIES},
}
FILES = [p for folder in FOLDERS for p in (ROOT / folder).rglob("*.py")]


def module_name(path):
    folder, *parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join([f"steadyload{FOLDERS[folder]}", *parts]).removesuffix(".__init__")


def imports(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield str(node.module)


def below(name, prefix):
    prefix = f"steadyload.{prefix}"
    return name == prefix or name.startswith(f"{prefix}.")


@pytest.mark.parametrize("path", FILES, ids=module_name)
def test_imports_point_down(path):
    name = module_name(path)
    if name == "steadyload":
        return  # it names the public interface, and imports what is asked for
    allowed = ALLOWED[max((floor for floor in ALLOWED if below(name, floor)), key=len)]
    for target in imports(path):
        assert target.split(".")[0] not in FOLDERS, f"{name} imports {target}"
        if target.split(".")[0] == "steadyload":
            assert any(below(target, a) for a in allowed), f"{name} imports {target}"


@pytest.mark.parametrize("path", FILES, ids=module_name)
def test_files_are_small_and_shadow_no_library(path):
    assert len(path.read_text().splitlines()) <= 420
    assert path.stem not in {"pybullet", "mujoco", "dartpy", "pymunk", "pydrake", "torch", "utils"}


def test_engines_are_named_in_no_condition():
    for path in FILES:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Compare):
                values = [n.value for n in ast.walk(node) if isinstance(n, ast.Constant)]
                assert not set(ENGINES) & set(map(str, values)), path
