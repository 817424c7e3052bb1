"""``steadyload warm-up``, and the line on what is compiled: once, and on stderr."""

import logging
import subprocess
import sys

import pytest

from steadyload.cli import main, warm_up

PACKAGE = """
from steadyload.engines.reference import compilation

PART = compilation.Part("the tiny ones", 1, "tiny_part:warm_up")

def twice(x):
    return x + x

twice = compilation.compile_kept(twice, "0123456789ab", PART)

def warm_up():
    twice(2)
    twice(2.0)
"""


@pytest.fixture
def tiny(tmp_path, monkeypatch):
    """A package whose one part is all that there is; returns how a new process begins."""
    (tmp_path / "tiny_part.py").write_text(PACKAGE)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(warm_up, "PART", "tiny_part:PART")
    monkeypatch.setattr(
        logging.getLogger("steadyload.engines.reference.compilation"), "disabled", False
    )

    def begins():
        monkeypatch.delitem(sys.modules, "tiny_part", raising=False)

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
