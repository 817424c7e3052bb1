"""Contact forces of loads at rest, and the loads that boxes bear."""

from steadyload.bearing.crushing import Crushed as Crushed
from steadyload.bearing.crushing import first_crushed as first_crushed
from steadyload.bearing.forces import ContactForces as ContactForces
from steadyload.bearing.forces import contact_forces as contact_forces
from steadyload.bearing.loads import Loads as Loads
from steadyload.bearing.loads import loads as loads
from steadyload.bearing.loads import payload as payload
