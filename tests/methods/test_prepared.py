"""A prepared method has loaded all that it judges with."""

import subprocess
import sys

import pytest

CODE = """
import sys
from steadyload.layouts import Item, Layout, Pallet
from steadyload.methods.registry import make_method

size = (9.0, 9.0, 9.0)
boxes = (Item(0, (0.0, 0.0, 0.0), size, 1.0), Item(1, (6.0, 9.0, 0.0), size, 1.0))
layout = Layout("leans", Pallet(100.0, 100.0, 100.0), boxes)
method = make_method(sys.argv[1])
method.prepare()
before = {*sys.modules}
assert not method.judge(layout).stable
print(sorted({*sys.modules} - before))
"""


def printed(*words):
    done = subprocess.run([sys.executable, "-c", *words], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("spec", ["sme", "fbs", "equilibrium", "equilibrium:time=0.3", "lstm_1"])
def test_the_first_judgement_of_a_static_or_learned_method_imports_nothing(spec):
    assert printed(CODE, spec) == "[]\n"
