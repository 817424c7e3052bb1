"""One word for one idea: docstrings say what a thing is, names and prose keep to the glossary."""

import ast
import dataclasses
import re
from functools import cache
from pathlib import Path

import pytest

from steadyload.cli.commands import TOPICS, commands

ROOT = Path(__file__).parents[1]
FOLDERS = ("engines", "harness", "learners", "reports")

NAMED = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@cache
def sources():
    return [
        (path.relative_to(ROOT), ast.parse(path.read_text()))
        for folder in FOLDERS
        for path in sorted((ROOT / folder).rglob("*.py"))
    ]


@pytest.fixture(autouse=True, scope="module")
def forgotten():
    """Trees of all modules are not kept for other tests: they make collecting garbage slow."""
    yield
    sources.cache_clear()


def first_lines(tree):
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, *NAMED)):
            yield (ast.get_docstring(node) or "").partition("\n")[0]


def words(name):
    return [word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+", name)]


def forbidden_names(glossary):
    """Words no name may have, and names that no module may have, from the table of the glossary."""
    table = glossary.partition("## Words not to use")[2].partition("\n## ")[0]
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


def phrases_not_to_use(glossary):
    """An expression that finds any phrase of the last column of the table of the glossary."""
    table = glossary.partition("## Phrases not to use")[2]
    rows = re.findall(r"^\|[^|]+\|[^|]+\|([^|]+)\|$", table, re.MULTILINE)[2:]
    phrases = [phrase for row in rows for phrase in re.findall("`([^`]+)`", row)]
    spaced = "|".join(phrase.replace(" ", r"\s+") for phrase in phrases)
    return re.compile(rf"\b(?:{spaced})\b", re.IGNORECASE)


PHRASES = phrases_not_to_use((ROOT / "docs" / "glossary.md").read_text())

PROSE = [
    *sorted((ROOT / "docs").glob("*.md")),
    ROOT / "README.md",
    ROOT / "CHANGELOG.md",
    *(path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.md.j2"))),
]


def said(text):
    """Text without code blocks and the tables of the glossary."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    return text.partition("## Words not to use")[0]


@pytest.mark.parametrize("path", PROSE, ids=lambda path: str(path.relative_to(ROOT)))
def test_prose_is_plain(path):
    assert PHRASES.findall(said(path.read_text())) == []


def helps():
    """Command -> its summary and the help of its flags; and topic -> its summary."""
    for words, command in commands().items():
        fields = dataclasses.fields(command.load())
        yield words, " ".join([command.about, *(one.metadata.get("about", "") for one in fields)])
    yield from ((topic, about) for topic, (about, _) in TOPICS.items())


def test_helps_are_plain():
    texts = dict(helps())
    assert len(texts) > 40
    found = {words: PHRASES.findall(text) for words, text in texts.items()}
    assert {words: phrases for words, phrases in found.items() if phrases} == {}


def test_a_phrase_is_found():
    assert PHRASES.findall(said("It hangs\non this.\n```\ntold\n```\nDART is Asked.")) == [
        "hangs\non", "is Asked",
    ]  # fmt: skip
