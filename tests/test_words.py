"""One word for one idea: docstrings say what a thing is, and names keep to docs/glossary.md."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = ("engines", "harness", "learners", "reports")

NOT_YET = ("harness/runs", "harness/studies", "harness/cli")
"""Packages whose words have not been put right."""

NAMED = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def sources():
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            where = path.relative_to(ROOT)
            if not any(where.is_relative_to(package) for package in NOT_YET):
                yield where, ast.parse(path.read_text())


def first_lines(tree):
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, *NAMED)):
            yield (ast.get_docstring(node) or "").partition("\n")[0]


def words(name):
    return [word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+", name)]


def forbidden_names(glossary):
    """Words no name may have, and names that no module may have, from the table of the glossary."""
    table = glossary.partition("## Words not to use")[2]
    anywhere, modules = set(), set()
    for row in re.findall(r"^\|[^|]+\|[^|]+\|([^|]+)\|$", table, re.MULTILINE)[2:]:
        names = re.findall(r"`(\w+)`", row)
        (modules if "modules" in row else anywhere).update(name.lower() for name in names)
    return anywhere, modules


ANYWHERE, MODULES = forbidden_names((ROOT / "docs" / "glossary.md").read_text())


def offences(where, tree, anywhere, modules):
    """Names in a module, its own among them, that are in words of the table."""
    own = where.stem
    if own in modules or anywhere & set(words(own)):
        yield own
    for node in ast.walk(tree):
        # ``judge`` is what a method does; a class of that name would be a method.
        verbs = set() if isinstance(node, ast.ClassDef) else {"judge"}
        if isinstance(node, NAMED) and (anywhere - verbs) & set(words(node.name)):
            yield node.name


def test_docstrings_say_what_a_thing_is():
    found = [f"{where}: {x}" for where, tree in sources() for x in first_lines(tree)]
    assert len(found) > 1000
    assert not [line for line in found if re.search(r": What\b", line)]


def test_names_keep_to_the_glossary():
    assert not [
        f"{where}: {name}"
        for where, tree in sources()
        for name in offences(where, tree, ANYWHERE, MODULES)
    ]


def test_the_table_is_read():
    assert {"opinion", "sheet", "judge", "outlook"} <= ANYWHERE
    assert {"plane", "moved", "clear"} == MODULES


@pytest.mark.parametrize(
    ("where", "code", "found"),
    [
        ("learners/methods.py", "class LearnedJudge: ...", ["LearnedJudge"]),
        ("learners/methods.py", "def judge_many(): ...", []),
        ("harness/tuning/trial.py", "def crashed_sheet(): ...", ["crashed_sheet"]),
        ("harness/methods/plane.py", "def in_plane(): ...", ["plane"]),
    ],
)
def test_an_offence_is_found(where, code, found):
    assert list(offences(Path(where), ast.parse(code), ANYWHERE, MODULES)) == found


def test_packages_not_done_yet_exist():
    assert all((ROOT / package).is_dir() for package in NOT_YET)
