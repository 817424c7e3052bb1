"""Engines of the quick tests: of every installation, and that which the extra ``test`` brings."""

from steadyload.engines.registry import engine_names

TESTED = (*engine_names(), "reference")
