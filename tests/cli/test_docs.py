"""What README and docs tell to type is what the command takes."""

import re
import shlex
from pathlib import Path

import pytest

import steadyload as sl
from steadyload.cli.running import command_of
from steadyload.methods.registry import make_method

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"(?:\.venv/bin/)?steadyload (.+)")
COUNT = {"N": "3", "J": "3", "TIME": "5m"}
"""Placeholders that stand for numbers."""


def commands(page):
    for _, block in FENCE.findall(page.read_text()):
        for line in block.replace("\\\n", " ").splitlines():
            found = COMMAND.match(line.strip())
            if found:
                yield found[1]


def arguments(command):
    """Words of a command line; those in square brackets may be left out, and are not."""
    words = shlex.split(command.replace("[", "").replace("]", ""), comments=True)
    return [COUNT.get(word, word) for word in words]


TOLD = [(page.name, command) for page in PAGES for command in commands(page)]


@pytest.mark.parametrize(("page", "command"), TOLD)
def test_a_command_is_one_that_is_taken(page, command):
    command_of(arguments(command))


def test_commands_are_found_in_most_pages():
    assert len(TOLD) > 60
    assert len({page for page, _ in TOLD}) > 10


def test_methods_that_are_told_exist():
    specs = {
        spec
        for _, command in TOLD
        for spec in re.findall(r"(?:-m|--method|--beside) (\S+)", command)
        if "weights=" not in spec
    }
    assert len(specs) > 8
    for spec in specs:
        make_method(spec)


@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("tour.md", 1),
        ("api.md", 10),
        ("check.md", 1),
        ("repair.md", 1),
        ("session.md", 4),
        ("packers.md", 1),
    ],
)
def test_examples_print_what_stands_below_them(name, count, tmp_path, monkeypatch, capsys):
    """One after the other, as a reader would type them, beside the file that the page shows."""
    text = (ROOT / "docs" / name).read_text()
    if "sl.from_py3dbp" in text:
        pytest.importorskip("py3dbp")
    for file, content in re.findall(r"`([\w.]+)`:\n\n```\n(.*?)```", text, re.DOTALL):
        (tmp_path / file).write_text(content)
    monkeypatch.chdir(tmp_path)
    examples = re.findall(r"```python\n(.*?)```(?:\n\n```\n(.*?)```)?", text, re.DOTALL)
    names = {}
    for code, printed in examples:
        exec(compile(code, name, "exec"), names)
        assert capsys.readouterr().out == printed
    assert len(examples) == count


def test_the_page_of_the_interface_names_all_of_it():
    text = (ROOT / "docs" / "api.md").read_text()
    assert {name for name in sl.__all__ if f"`{name}" not in text} == set()
