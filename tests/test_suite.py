"""What is said of the suite itself: deep tests are listed, and skips need an allowed reason."""

import re
import shutil
from pathlib import Path

import pytest

TESTS = Path(__file__).parent
PAGE = TESTS.parent / "docs" / "testing.md"


def test_the_page_lists_deep_tests_with_their_reasons(request):
    """Both ways, where all tests were collected; one sentence there covers optional engines."""
    page = PAGE.read_text().partition("## Deep tests")[2]
    rows = re.findall(r"^\| `(tests/[^`]+::[^`]+)` \| (.+?) \|$", page, re.MULTILINE)
    deep = {
        test: reason
        for test, reason in request.config.deep.items()
        if not reason.startswith(("needs the extra ", "needs the package "))
    }
    listed = dict(rows)
    assert {test: listed.get(test) for test in deep} == deep
    if request.config.files == set(TESTS.rglob("test_*.py")):
        assert listed == deep


def test_the_page_lists_what_holds_to_the_last_bit_with_its_reasons(request):
    """Both ways, where all tests were collected; cases of a test are listed as one."""
    page = PAGE.read_text().partition("## Moved starts")[2].partition("\n## ")[0]
    listed = dict(re.findall(r"^\| `(tests/[^`]+)` \| (.+?) \|$", page, re.MULTILINE))
    exact = {test.partition("[")[0]: reason for test, reason in request.config.exact.items()}
    assert {test: listed.get(test) for test in exact} == exact
    if request.config.files == set(TESTS.rglob("test_*.py")):
        assert listed == exact


SKIPPING = """
import pytest

def test_allowed():
    pytest.skip("there is a GPU")

def test_other():
    pytest.skip("nobody is here")
"""


@pytest.mark.parametrize(
    ("chosen", "options", "code", "said"),
    [
        ("", ["--strict-skips"], 1, "1 nobody is here (NOT ALLOWED)"),
        ("", [], 0, "1 nobody is here (NOT ALLOWED)"),
        ("", ["--strict-skips", "--may-skip", "nobody"], 0, "1 nobody is here"),
        ("::test_allowed", ["--strict-skips"], 0, "1 there is a GPU"),
    ],
)
def test_a_strict_run_fails_by_a_skip_without_an_allowed_reason(
    pytester, chosen, options, code, said
):
    for name in ("conftest.py", "allowed_skips.toml"):
        shutil.copy(TESTS / name, pytester.path)
    file = pytester.makepyfile(SKIPPING)
    result = pytester.runpytest_inprocess(f"{file}{chosen}", *options)
    assert result.ret == code
    result.stdout.fnmatch_lines([f"*{said.replace('[', '[[]')}"])


def test_shares_of_the_tests_are_apart_and_all_of_them(pytester):
    for name in ("conftest.py", "allowed_skips.toml"):
        shutil.copy(TESTS / name, pytester.path)
    names = [f"test_{k}" for k in range(12)]
    pytester.makepyfile(**{name: f"def test_it():\n    assert {name!r}" for name in names})
    ran = []
    for share in ("1/3", "2/3", "3/3"):
        passed, *_ = pytester.inline_run("--share", share).listoutcomes()
        assert 0 < len(passed) < len(names)
        ran += [report.nodeid.partition(".")[0] for report in passed]
    assert sorted(ran) == sorted(names)
    refused = pytester.runpytest_inprocess("--share", "4/3")
    assert refused.ret == pytest.ExitCode.USAGE_ERROR
    refused.stderr.fnmatch_lines(["*--share is '4/3'; allowed: K/N, K from 1 to N*"])


def test_a_deep_test_without_a_reason_is_refused(pytester):
    for name in ("conftest.py", "allowed_skips.toml"):
        shutil.copy(TESTS / name, pytester.path)
    file = pytester.makepyfile("import pytest\n@pytest.mark.deep\ndef test_it(): pass\n")
    result = pytester.runpytest_inprocess(file)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["*::test_it: deep takes one reason"])
