"""Constants that kernels and what calls them share."""

FLOOR = -1
"""In place of an item that carries: the floor."""

STATED_TOLERANCE = 0.01
"""The tolerance [cm] as documents and messages state it: a tenth of a millimetre, the usual
resolution of exported plans."""

TOLERANCE = STATED_TOLERANCE + 1e-6
"""Lengths [cm] that differ by no more count as equal: how far two items may overlap, how far an
item may stand out of the pallet's contour, and how far a top face may miss the base it carries.

All comparisons are with this number. It is a little more than the stated one, so that what differs
by exactly that is within it, wherever it stands and whatever unit it was written in. The difference
is far above what rounding does to a length (about 1e-10 cm at a kilometre, the longest allowed) and
far below what plans resolve (1e-4 cm, a micrometre, at the finest).
"""

ROUNDING = 1e-9
"""Shares of a base, and lengths [cm] of static mechanical equilibrium, that count as rounding."""

EDGE = 1e-5
"""A patch counts as this much wider on every side [cm] for equilibrium: a centre of mass exactly
above an edge is balanced, whatever rounding did to it."""

RESIDUE = 1e-9
"""Share of the loads on an item that counts as rounding: see
:mod:`steadyload.statics.resolution`.
"""

NOISE = 1e3 * 2.0**-52
"""Relative error of a solution, in the norm in which masses count by their roots: far above what
was seen in groups of a hundred items."""

TIE = 1e-9
"""Motions that differ by less than this share are equal: then the first item is named."""

BALANCED, UNBALANCED, UNRESOLVED = 0, 1, 2
"""How a search for balance ended: every item is carried, one is not, or rounding hides which."""

UNDECIDED = 6
"""How a step ended whose motion takes more work than is allowed."""

STANDS, FAILS = BALANCED, UNBALANCED
OUTSIDE, OVERLAPS, FULL = 3, 4, 5
"""How a placement on a growing layout ended: as those of balance, or the item cannot be there, or
the arrays have no more room.
"""

TOUCH = 2.0 * TOLERANCE
"""[cm]: a gap below this is closed while items move."""

EVENTS = 40
"""Gaps that close, after which a motion is not followed any more."""

SAMPLES = 60
"""Times between two events at which it is looked whether a gap has closed."""

FAR = 25.0
"""Keeps a light pendulum watched for long from overflowing; it has tipped anyway."""

AT_REST = 1e-12
"""Share of the largest energy of motion below which an item counts as at rest."""
