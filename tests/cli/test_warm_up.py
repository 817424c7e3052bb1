"""``steadyload warm-up``, and the line on what is compiled: once, and on stderr."""

import importlib
import logging
import subprocess
import sys

import pytest

from steadyload.cli import main
from steadyload.engines.reference import compilation, warming

PACKAGE = """
from steadyload.engines.reference.compilation import Compilation

compiled = Compilation("the tiny ones", 1, "0123456789ab")

@compiled
def twice(x):
    return x + x

def warm_up():
    twice(2)
    twice(2.0)
"""


@pytest.fixture
def tiny(tmp_path, monkeypatch):
    """A module in place of the reference; returns how a new process begins."""
    (tmp_path / "tiny_part.py").write_text(PACKAGE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(
        logging.getLogger("steadyload.engines.reference.compilation"), "disabled", False
    )

    def begins():
        sys.modules.pop("tiny_part", None)
        tiny_part = importlib.import_module("tiny_part")
        monkeypatch.setattr(compilation, "compiled", tiny_part.compiled)
        monkeypatch.setattr(warming, "warm_up", tiny_part.warm_up)

    begins()
    yield begins
    sys.modules.pop("tiny_part", None)


def test_what_is_missing_is_compiled_with_one_line_on_stderr_and_then_it_is_ready(
    tiny, capsys, tmp_path
):
    assert main(["warm-up"]) == 0
    out, err = capsys.readouterr()
    assert err == "steadyload: compiling the tiny ones (up to about 1 s, once)\n"
    assert "the tiny ones  compiled" in out
    assert str(tmp_path / "__pycache__") in out
    tiny()
    assert main(["warm-up"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "the tiny ones  ready" in out


def test_what_is_not_kept_is_said_with_status_1(tiny, capsys, monkeypatch):
    monkeypatch.setattr("steadyload.engines.reference.compilation.config.DISABLE_JIT", 1)
    tiny()
    assert main(["warm-up"]) == 1
    out, err = capsys.readouterr()
    assert "the tiny ones  not compiled" in out
    assert "NUMBA_DISABLE_JIT" in err


def test_the_library_by_itself_and_its_workers_compile_without_a_word(tiny, tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", "import tiny_part; tiny_part.warm_up(); print('done')"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert (done.stdout, done.stderr) == ("done\n", "")
