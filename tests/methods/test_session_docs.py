"""The examples of docs/session.md run, and print what stands below them."""

import re
from pathlib import Path

TEXT = (Path(__file__).parents[2] / "docs" / "session.md").read_text()
EXAMPLE = re.compile(r"```python\n(.*?)```\n\n```\n(.*?)```", re.DOTALL)


def test_the_examples_print_what_stands_below_them(capsys):
    examples = EXAMPLE.findall(TEXT)
    assert len(examples) == TEXT.count("```python")
    names = {}
    for code, printed in examples:
        exec(compile(code, "docs/session.md", "exec"), names)
        assert capsys.readouterr().out == printed
