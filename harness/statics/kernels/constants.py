"""Constants that kernels and what calls them share, under their names there."""

from steadyload.core.constants import AT_REST as AT_REST
from steadyload.core.constants import EDGE as EDGE
from steadyload.core.constants import EVENTS as EVENTS
from steadyload.core.constants import FAILS as FAILS
from steadyload.core.constants import FAR as FAR
from steadyload.core.constants import FLOOR as FLOOR
from steadyload.core.constants import NOISE as NOISE
from steadyload.core.constants import OUTSIDE as OUTSIDE
from steadyload.core.constants import OVERLAPS as OVERLAPS
from steadyload.core.constants import RESIDUE as RESIDUE
from steadyload.core.constants import ROUNDING as ROUNDING
from steadyload.core.constants import SAMPLES as SAMPLES
from steadyload.core.constants import STANDS as STANDS
from steadyload.core.constants import STATED_TOLERANCE as STATED_TOLERANCE
from steadyload.core.constants import TIE as TIE
from steadyload.core.constants import TOLERANCE as TOLERANCE
from steadyload.core.constants import TOUCH as TOUCH
from steadyload.core.constants import UNRESOLVED as UNRESOLVED

BALANCED, UNBALANCED = STANDS, FAILS
"""Ends of a search for balance, with :data:`UNRESOLVED`."""

FULL, UNDECIDED = 5, 6
"""How a placement ended for which the arrays have no more room, and a step whose motion takes more
work than is allowed."""
