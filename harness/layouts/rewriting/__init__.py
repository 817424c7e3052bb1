"""A changed plan in the form of the file that it was read from."""

from steadyload.layouts.rewriting.changes import Replanned
from steadyload.layouts.rewriting.plans import rewrite

__all__ = ["Replanned", "rewrite"]
