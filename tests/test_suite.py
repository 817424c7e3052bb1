"""What is said of the suite itself: deep tests exist, and skips need an allowed reason."""

import shutil
import tomllib
from pathlib import Path

import pytest

TESTS = Path(__file__).parent


def test_what_is_listed_as_deep_is_a_test_and_has_a_reason(request):
    listed = {
        (place, name): why
        for place, names in tomllib.loads((TESTS / "deep.toml").read_text()).items()
        for name, why in names.items()
    }
    assert all(isinstance(why, str) and why for why in listed.values())
    if request.config.files == set(TESTS.rglob("test_*.py")):
        assert listed.keys() == request.config.deep


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
    for name in ("conftest.py", "allowed_skips.toml", "deep.toml"):
        shutil.copy(TESTS / name, pytester.path)
    file = pytester.makepyfile(SKIPPING)
    result = pytester.runpytest_inprocess(f"{file}{chosen}", *options)
    assert result.ret == code
    result.stdout.fnmatch_lines([f"*{said.replace('[', '[[]')}"])


def test_shares_of_the_tests_are_apart_and_all_of_them(pytester):
    for name in ("conftest.py", "allowed_skips.toml", "deep.toml"):
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


def test_a_test_a_case_a_file_and_a_folder_can_be_deep(pytester):
    shutil.copy(TESTS / "conftest.py", pytester.path)
    (pytester.path / "allowed_skips.toml").write_text("reasons = []")
    (pytester.path / "deep.toml").write_text(
        """["test_some.py"]\ntest_slow = "long"\n"test_cases[2]" = "long"\n"""
        """["test_all.py"]\nall = "long"\n["folder"]\nall = "long"\n"""
    )
    file = """
import pytest
def test_slow(): pass
def test_slower(): pass
@pytest.mark.parametrize("n", [1, 2])
def test_cases(n): pass
"""
    (pytester.path / "folder").mkdir()
    for name in ("test_some.py", "test_all.py", "folder/test_deeper.py"):
        (pytester.path / name).write_text(file)
    ran, _, _ = pytester.inline_run("-m", "not deep").listoutcomes()
    assert [report.nodeid for report in ran] == [
        "test_some.py::test_slower", "test_some.py::test_cases[1]",
    ]  # fmt: skip


def test_a_deep_test_without_a_reason_is_refused(pytester):
    for name in ("conftest.py", "allowed_skips.toml", "deep.toml"):
        shutil.copy(TESTS / name, pytester.path)
    file = pytester.makepyfile("import pytest\n@pytest.mark.deep\ndef test_it(): pass\n")
    result = pytester.runpytest_inprocess(file)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["*::test_it: deep takes one reason"])
