"""Compiled code beside the sources: none old, none mixed up, none where none can be kept."""

import importlib.util
import logging
import shutil
from pathlib import Path

import pytest

from steadyload.engines.reference import compilation
from steadyload.engines.reference.compilation import Compilation


def imported(folder):
    """The module, imported from a folder of its own."""
    shutil.copy(compilation.__file__, folder / "compilation.py")
    return module_of(folder / "compilation.py")


def module_of(file):
    """A module of its own, whatever was imported from the file before."""
    spec = importlib.util.spec_from_file_location("elsewhere", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def process():
    """The compilation of a new process."""
    return Compilation("ratios", 5, "0123456789ab")


def of_a_process(file, compiled=None):
    """The function of a file named ratio.py, as a new process has it."""
    return (compiled or process())(module_of(file).ratio)


@pytest.fixture
def ratio_file(tmp_path):
    (tmp_path / "ratio.py").write_text("def ratio(x, y):\n    return x / y\n")
    return tmp_path / "ratio.py"


@pytest.fixture
def told(caplog, monkeypatch):
    """The log of what is compiled, where somebody listens."""
    monkeypatch.setattr(
        logging.getLogger("steadyload.engines.reference.compilation"), "disabled", False
    )
    caplog.set_level(logging.INFO, "steadyload.engines.reference.compilation")
    return caplog


def test_a_part_is_told_once_when_it_is_compiled_and_not_when_it_is_loaded(ratio_file, told):
    first, second = process(), process()
    compiling = of_a_process(ratio_file, first)
    assert not told.messages
    compiling(7, 2)
    compiling(7.5, 2.0)
    assert told.messages == ["compiling ratios (up to about 5 s, once)"]
    assert first.count == 2
    loading = of_a_process(ratio_file, second)
    assert (loading(7, 2), loading(7.5, 2.0)) == (3.5, 3.75)
    assert len(told.messages) == 1
    assert second.count == 0
    assert first.folder == second.folder == ratio_file.parent / "__pycache__"


def test_what_cannot_be_kept_is_not_said_to_be_compiled_once(told):
    scope, compiled = {}, process()
    exec("def thrice(x):\n    return 3.0 * x\n", scope)
    assert compiled(scope["thrice"])(7.0) == 21.0
    [sentence] = told.messages
    assert "anew in every process" in sentence
    assert compiled.folder is None


def test_what_other_sources_compiled_goes(tmp_path):
    digest = imported(tmp_path)._SOURCES
    cache = tmp_path / "__pycache__"
    cache.mkdir(exist_ok=True)
    kept, stale = cache / f"law.force_{digest}-1.nbi", cache / "law.force_0123456789ab-1.nbc"
    other = cache / "law.cpython-311.pyc"
    for file in (kept, stale, other):
        file.touch()
    imported(tmp_path)
    assert (kept.exists(), stale.exists(), other.exists()) == (True, False, True)


def test_a_change_of_any_source_changes_all_names(tmp_path):
    before = imported(tmp_path)._SOURCES
    (tmp_path / "law.py").write_text("G = 1\n")
    assert before != imported(tmp_path)._SOURCES


def test_a_function_that_cannot_be_kept_is_compiled_all_the_same():
    """A function from no file has no place for a cache."""
    scope = {}
    exec("def twice(x):\n    return 2.0 * x\n", scope)
    assert compilation.compiled(scope["twice"])(21.0) == 42.0
    assert not list(Path(compilation.__file__).parent.glob("__pycache__/*twice*"))


def test_signatures_that_two_processes_compile_at_once_are_kept_apart(ratio_file, monkeypatch):
    """Both read the index before the other writes it, and the first one's code is written last."""
    first, second = of_a_process(ratio_file), of_a_process(ratio_file)
    slow, fast = (process._cache._cache_file for process in (first, second))
    write, write_index, written_last = slow._save_data, fast._save_index, []

    def after_the_other(index):
        first(7, 2)
        write_index(index)

    monkeypatch.setattr(slow, "_save_data", lambda *data: written_last.append(data))
    monkeypatch.setattr(fast, "_save_index", after_the_other)
    second(7.5, 2.0)
    for data in written_last:
        write(*data)
    assert of_a_process(ratio_file)(7.5, 2.0) == 3.75


def test_no_file_is_written_again_after_another_process_has_replaced_the_index(ratio_file):
    first, second = of_a_process(ratio_file), of_a_process(ratio_file)
    first(7, 2)
    index = second._cache._cache_file._load_index()
    first._cache._cache_file._save_index({})
    first(7.5, 2.0)
    second._cache._cache_file._save_index(index)
    assert of_a_process(ratio_file)(7, 2) == 3.5
    assert len(list((ratio_file.parent / "__pycache__").glob("ratio.ratio*.nbc"))) == 2
