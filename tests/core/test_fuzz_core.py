"""The C library under sanitizers, with any numbers: for longer, `fuzz 60` as built here."""

import subprocess
from pathlib import Path

import pytest

from steadyload.core import building

HERE = Path(__file__).parent
SANITIZERS = ("-fsanitize=undefined,address", "-fno-sanitize-recover=all")


def _build(into: Path, *sources: Path) -> subprocess.CompletedProcess[str]:
    compiler = building.found()
    if not compiler:
        pytest.skip("there is no C compiler")
    how = [*building.FLAGS, "-O0", "-g", *SANITIZERS, "-DSL_EACH", "-iquote", str(building.HERE)]
    command = [*compiler, *how, *map(str, sources), "-o", str(into), "-lm"]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def fuzz(tmp_path_factory):
    """The driver, built with the library and with sanitizers."""
    folder = tmp_path_factory.mktemp("fuzz")
    empty = folder / "empty.c"
    empty.write_text("int main(void) { return 0; }\n")
    tried = _build(folder / "empty", empty)
    if tried.returncode or subprocess.run([folder / "empty"], check=False).returncode:
        pytest.skip("the C compiler has no sanitizers")
    built = _build(folder / "fuzz", HERE / "fuzz.c", *sorted(building.HERE.glob("*.c")))
    assert built.returncode == 0, built.stderr
    return folder / "fuzz"


def test_any_numbers_get_an_answer_and_touch_no_memory_of_others(fuzz):
    ran = subprocess.run([fuzz, "2"], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    layouts, *_ = ran.stdout.split()
    assert int(layouts) > 100
    ended = [int(number) for number in ran.stdout.rsplit("ended:", 1)[1].split()]
    stands, fails, _, outside, overlaps, memory, refused, undecided, looked_at = ended
    assert all((stands, fails, outside, overlaps, undecided, looked_at))
    assert not memory
    assert not refused
