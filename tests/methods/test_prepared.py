"""A prepared method has compiled, or loaded, all that it judges with."""

import subprocess
import sys

CODE = """
from steadyload.statics.kernels import balance, base_support, sme
from steadyload.methods.registry import make_method

kernels = (sme.first_unsupported, base_support.first_with_little_support, balance.first_unbalanced)
assert not any(kernel.signatures for kernel in kernels)
for spec in ("sme", "fbs", "equilibrium"):
    make_method(spec).prepare()
print(*(len(kernel.signatures) for kernel in kernels))
"""


def test_the_first_judgement_of_a_static_method_does_not_wait_for_compilation():
    done = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True)
    assert done.stdout == "1 1 1\n", done.stderr
