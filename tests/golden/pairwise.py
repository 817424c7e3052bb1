"""Rows of values such that any two values of any two factors meet in one of them."""

import itertools
import random
from collections.abc import Callable, Mapping, Sequence

Row = dict[str, str]
Pair = frozenset[tuple[str, str]]

_CANDIDATES = 300
"""Rows that are drawn before the one with the most new pairs is taken."""


def pairwise(
    factors: Mapping[str, Sequence[str]], allowed: Callable[[Row], bool], seed: int = 0
) -> list[Row]:
    """Rows that cover all pairs that any allowed row can have, found greedily.

    Args:
        factors: the values of each.
        allowed: whether a row of all factors can be.
        seed: of the candidates.
    """
    draw = random.Random(seed)
    missing = {
        frozenset(((one, a), (other, b)))
        for one, other in itertools.combinations(factors, 2)
        for a in factors[one]
        for b in factors[other]
    }
    rows: list[Row] = []
    while missing:
        wanted = min(missing, key=sorted)
        candidates = [_drawn(factors, dict(wanted), draw) for _ in range(_CANDIDATES)]
        possible = [row for row in candidates if allowed(row)]
        if not possible:  # no row can have this pair
            missing.remove(wanted)
            continue
        best = max(possible, key=lambda row: len(missing & pairs(row)))
        rows.append(best)
        missing -= pairs(best)
    return rows


def pairs(row: Row) -> set[Pair]:
    """All pairs of values that a row has."""
    return {frozenset(two) for two in itertools.combinations(row.items(), 2)}


def _drawn(factors: Mapping[str, Sequence[str]], fixed: Row, draw: random.Random) -> Row:
    return {name: fixed.get(name) or draw.choice(values) for name, values in factors.items()}
