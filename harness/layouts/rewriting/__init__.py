"""A changed plan in the form of the file that it was read from."""

from steadyload.layouts.rewriting.plans import Replanned, rewrite

__all__ = ["Replanned", "rewrite"]
