"""Tuning simulations: what is searched, how genotypes are judged, who searches.

A *genotype* is a parameter set of a simulation on one engine; its *genes* are the parameters. It is
judged on labelled layouts for accuracy, and for its cost by what it makes the engine do.
"""

from steadyload.errors import UserError


class TuningError(UserError):
    """A search that cannot be: says what was asked and what is allowed."""
