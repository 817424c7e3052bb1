"""Who may import whom. No arrow runs back up."""

import ast
from pathlib import Path

import pytest

from steadyload.engines.registry import ENGINES

ROOT = Path(__file__).parents[2]

# Package -> what of ours it may import. The longest matching prefix counts.
ALLOWED = {
    "engines": {"engines"},
    "reports": {"reports"},
    "steadyload.atomic": set(),
    "steadyload.layouts": {"steadyload.layouts", "steadyload.atomic"},
    "steadyload.methods": {"steadyload.methods", "steadyload.layouts", "steadyload.atomic", "engines"},
    "steadyload.studies": {
        "steadyload.studies", "steadyload.methods", "steadyload.layouts", "steadyload.atomic", "engines",
        "reports",
    },
    "steadyload.properties": {
        "steadyload.properties", "steadyload.studies", "steadyload.methods", "steadyload.layouts",
        "steadyload.atomic", "engines", "reports",
    },
    "steadyload.tuning": {
        "steadyload.tuning", "steadyload.studies", "steadyload.methods", "steadyload.layouts",
        "steadyload.atomic", "engines", "reports",
    },
    "learners": {
        "learners", "steadyload.studies", "steadyload.methods", "steadyload.layouts", "steadyload.atomic",
        "engines", "reports",
    },
    "steadyload.cli": {"harness", "engines", "learners", "reports"},
}  # fmt: skip
OURS = ("harness", "engines", "learners", "reports")
FILES = [p for package in OURS for p in (ROOT / package).rglob("*.py")]


def module_name(path):
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def imports(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield str(node.module)


def below(name, prefix):
    return name == prefix or name.startswith(f"{prefix}.")


@pytest.mark.parametrize("path", FILES, ids=module_name)
def test_imports_point_down(path):
    name = module_name(path)
    floors = [floor for floor in ALLOWED if below(name, floor)]
    if name == "harness":
        return
    allowed = ALLOWED[max(floors, key=len)]
    for target in imports(path):
        if target.split(".")[0] in OURS:
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
