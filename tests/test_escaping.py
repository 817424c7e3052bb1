"""Texts of users where they are shown: nothing in them is markup, a tag, a link or a command."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest

from steadyload.cli import main
from steadyload.cli.terminal import print_table, say, study_progress
from steadyload.config import ConfigError, bind
from steadyload.errors import UserError
from steadyload.escaping import markdown, printable, shown
from steadyload.layouts import LayoutError
from steadyload.reports.table import markdown_table


@dataclass(frozen=True)
class _Levels:
    levels: Mapping[str, float]


HANDED = Path(__file__).resolve().parents[2] / "shared" / "repro"


def test_control_characters_are_shown_as_escapes():
    assert printable("\x1b]0;x\x07a\u202eb\nc") == r"\x1b]0;x\x07a\u202eb\nc"
    assert printable("Käse 漢字 \U0001f600") == "Käse 漢字 \U0001f600"
    assert printable("a" * 50, 10) == "aaaaaaa..."


@pytest.mark.parametrize("more", [0, 1])
def test_a_value_is_cut_where_it_is_longer_than_shown_and_not_before(more):
    text = "a" * (20 - 2 + more)  # in quotation marks
    assert shown(text, 20) == (f"'{text[:16]}..." if more else f"'{text}'")


def test_commands_show_no_control_characters(capsys):
    say("a name: \x1b[2J\nanother line")
    print_table(("layout",), [("\x1b[31mred",)])
    out, err = capsys.readouterr()
    assert err == "a name: \\x1b[2J\nanother line\n"
    assert "\\x1b[31mred" in out


def test_brackets_in_a_name_are_no_markup_of_progress():
    with study_progress() as show:
        show("judging [/x] [red]")


def test_an_error_shows_names_without_control_characters_and_cut():
    said = str(LayoutError("is wrong", layout="\x1b[2J" + "a" * 5000, item="\x1b[3J"))
    assert said.isprintable()
    assert len(said) < 300


@pytest.mark.parametrize("text", ["a" * 5000, "\x1b" * 5000, "\x1b" * 1900, "a\n" * 2500])
def test_a_sentence_has_a_limited_length_also_after_its_characters_were_escaped(text):
    said = str(UserError(f"begins {text} allowed: 1"))
    assert said.isprintable()
    assert len(said) <= 2000
    assert said.startswith("begins ")
    assert said.endswith(" allowed: 1")


def test_a_key_is_cut_where_a_value_is_refused():
    with pytest.raises(ConfigError, match=r"^there: levels\[a{37}\.\.\.\] is 'x'; allowed: "):
        bind(_Levels, {"levels": {"a" * 3000: "x"}}, "there")


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("<script>x</script>", r"\<script\>x\</script\>"),
        ("[l](javascript:alert)", r"\[l\](javascript:alert)"),
        ("![t](http://evil/t.png)", r"\!\[t\](http:\//evil/t.png)"),
        ("**b** `c` _d_", r"\*\*b\*\* \`c\` \_d\_"),
        ("H1_Class_3", "H1_Class_3"),
        ("&lt; www.x.org a@b.c", r"\&lt; www\.x.org a\@b.c"),
        ("\x1b[2J", r"\\x1b\[2J"),
    ],
)
def test_markdown_of_a_name_is_its_characters(text, shown):
    assert markdown(text) == shown


@pytest.mark.parametrize("name", ["a|b", r"a\|b", r"a\\|b", r"a\\\|b", "|"])
def test_a_bar_in_a_name_ends_no_cell(name):
    row = markdown_table(("layout",), [(markdown(name),)]).splitlines()[2]
    inner = row.strip()[1:-1]
    # A cell ends at a bar before which an even number of backslashes stands.
    for place in (k for k, c in enumerate(inner) if c == "|"):
        before = len(inner[:place]) - len(inner[:place].rstrip("\\"))
        assert before % 2 == 1


def test_markup_in_names_does_not_reach_a_report(tmp_path, in_this_process):
    path = HANDED / "inj2.json"
    if not path.exists():
        pytest.skip("the inputs are not beside the project (../shared/repro)")
    (tmp_path / "study.toml").write_text(
        f'layouts = [{json.dumps(str(path))}]\nmethods = ["fbs", "sme"]\n'
    )
    assert main(["study", "run", str(tmp_path / "study.toml"), "-o", str(tmp_path / "run")]) == 0
    assert main(["study", "report", str(tmp_path / "run")]) == 0
    report = (tmp_path / "run" / "report.md").read_text()
    assert "Where they disagree" in report
    assert r"\<script\>" in report
    for harm in ("<script", "[l](", "![t](", "<img", "http://evil"):
        assert harm not in report.replace("\\" + harm[0], ""), harm
