"""Options that only DART has."""

from __future__ import annotations

from dataclasses import dataclass

from steadyload.engines.quantities import check_ranges, quantity


@dataclass(frozen=True)
class DartOptions:
    """How contacts of large piles are solved.

    DART writes the contacts that hang together as one linear complementarity problem, and solves it
    by Dantzig's method, whose cost grows with the cube of their number. From some number of rows on
    it can solve them by projected Gauss-Seidel without writing the matrix (DART 6.20, "matrix-free
    contact solver"); where that does not converge, Dantzig's method is used after all. Penetration
    is pushed out by impulses of their own ("split impulse"), which are solved a second time,
    or by those of the contacts: where contacts are solved by iteration, a pile of 108 boxes then
    takes an eighth of the time.

    Raises:
        ValueError: a value outside its range.
    """

    matrix_free_rows: int = quantity(
        0,
        "contacts that hang together and have so many rows, three each, are solved by iteration; "
        "0: none",
        least=0,
        most=1_000_000,
        later=True,
    )
    matrix_free_tolerance: float = quantity(
        1e-4,
        "change of forces in a sweep, in shares of them, at which these have converged",
        least=1e-9,
        most=0.1,
        later=True,
    )
    split_impulse: int = quantity(
        1,
        "1: penetration is pushed out by impulses of their own, which leave no velocity; 0: by "
        "those of the contacts",
        least=0,
        most=1,
        later=True,
    )

    def __post_init__(self) -> None:
        check_ranges(self)
