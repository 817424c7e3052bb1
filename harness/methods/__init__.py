"""Methods: each turns a layout into a verdict."""

from steadyload.methods.contract.method import Method, Status, Verdict
from steadyload.methods.registry import make_method

__all__ = ["Method", "Status", "Verdict", "make_method"]
