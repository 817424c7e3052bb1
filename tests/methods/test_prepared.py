"""What judges by statics has nothing to compile: a first judgement costs what a later one does."""

import subprocess
import sys

CODE = """
import sys
from steadyload.layouts import Item, Layout, Pallet
from steadyload.methods.registry import make_method

boxes = (Item(0, (0, 0, 0), (10, 10, 10), 1.0), Item(1, (8, 10, 0), (10, 10, 10), 1.0))
leaning = Layout("leaning", Pallet(100.0, 100.0, 100.0), boxes)
for spec in ("sme", "fbs", "equilibrium", "equilibrium:time=0.3"):
    method = make_method(spec)
    method.prepare()
    print(method.judge(leaning).failing_step)
assert "numba" not in sys.modules
"""


def test_the_first_judgement_of_a_static_method_does_not_wait_for_compilation():
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("1\n1\n1\n1\n", "")
