"""Compiled code beside the sources: nothing old is kept, and it works where nothing can be kept."""

import importlib.util
import shutil
from pathlib import Path

from steadyload.engines.reference import compiled


def imported(folder):
    """The module, imported from a folder of its own."""
    shutil.copy(compiled.__file__, folder / "compiled.py")
    spec = importlib.util.spec_from_file_location("elsewhere", folder / "compiled.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


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
    assert compiled.compiled(scope["twice"])(21.0) == 42.0
    assert not list(Path(compiled.__file__).parent.glob("__pycache__/*twice*"))
