"""Methods by which this process judges: each is made once, however many units of work name it.

A method reads the files that it names, such as weights, once, and does not change else, so that all
units can share it. Units carry its spec, since processes beside this one make their own.
"""

from __future__ import annotations

from collections.abc import Iterable

from steadyload.methods.contract.method import Method
from steadyload.methods.registry import make_method

_HERE: dict[str, Method] = {}


def use_methods(methods: Iterable[Method]) -> None:
    """Judge by these from now on: those before them may have read files that have changed since."""
    found = {str(method.spec): method for method in methods}
    _HERE.clear()
    _HERE.update(found)


def method_named(spec: str) -> Method:
    """The method of a spec; made where no run of this process and no unit has named it yet.

    Args:
        spec: a canonical one.

    Raises:
        SpecError: see :func:`steadyload.methods.registry.make_method`.
    """
    if spec not in _HERE:
        _HERE[spec] = make_method(spec)
    return _HERE[spec]
