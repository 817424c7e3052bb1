"""Tuning of simulations: search spaces, trials of genotypes, and algorithms.

A *genotype* is a parameter set of a simulation on one engine; its *genes* are the parameters. It is
judged on labelled layouts for accuracy, and for its cost by what it makes the engine do.
"""

from steadyload.errors import UserError


class TuningError(UserError):
    """A search that is impossible: says what was requested and what is allowed."""
