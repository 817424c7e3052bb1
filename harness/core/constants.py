"""Constants of the C library that Python uses, too.

Their home is the headers. They are stated once more here, for readers and type checkers; when
:mod:`steadyload.core.library` loads the library, it compares all of this file with what was
compiled, which ``constants.c`` lists.
"""

VERSION = 1
"""Version of the library, a part of what stored verdicts depend on: raised by hand when a number
that it computes changes."""

STANDS, FAILS, UNRESOLVED, OUTSIDE, OVERLAPS, MEMORY, REFUSED, UNDECIDED, LOOK = range(9)
"""How a call ended: every box stands; one does not; rounding hides which; a placement is outside
the contour, or overlaps another box; there is no memory; the arguments are none; a motion takes
more work than is allowed; a box was put on, and it is to be said whether it stays."""

SUPPORTED, CARRIED, BALANCED = range(3)
"""Rules: a share of every base is supported; static mechanical equilibrium holds; vertical forces
balance all boxes."""

FLOOR = -1
"""In place of a box that carries: the floor."""

STATED_TOLERANCE = 0.01
"""The tolerance [cm] as documents and messages state it: a tenth of a millimetre, the usual
resolution of exported plans."""

TOLERANCE = STATED_TOLERANCE + 1e-6
"""Lengths [cm] that differ by no more count as equal: how far two boxes may overlap, how far a box
may stand out of the pallet's contour, and how far a top face may miss the base it carries.

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
"""Share of the loads on a box that counts as rounding: see :mod:`steadyload.statics.resolution`."""

NOISE = 1e3 * 2.0**-52
"""Relative error of a solution, in the norm in which masses count by their roots: far above what
was seen in groups of a hundred boxes."""

TIE = 1e-9
"""Motions that differ by less than this share are equal: then the first box is named."""

TOUCH = 2.0 * TOLERANCE
"""[cm]: a gap below this is closed while boxes move."""

EVENTS = 40
"""Gaps that close, after which a motion is not followed any more."""

SAMPLES = 60
"""Times between two events at which it is looked whether a gap has closed."""

FAR = 25.0
"""Keeps a light pendulum watched for long from overflowing; it has tipped anyway."""

AT_REST = 1e-12
"""Share of the largest energy of motion below which a box counts as at rest."""

LEFT_OUT, AS_PLANNED, TURNED = -1.0, 0.0, 1.0
"""Last number of a place: the box is left out, as planned, or turned by a quarter."""

PLAIN, SUPPORT, QUANTITIES = 14, 43, 6
"""Columns of plain features, of support and of quantities, as learned.h numbers them."""
