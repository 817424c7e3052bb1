"""Contact forces of loads at rest, and the loads that boxes bear."""

from steadyload.statics.bearing.crushing import Crushed as Crushed
from steadyload.statics.bearing.crushing import first_crushed as first_crushed
from steadyload.statics.bearing.forces import ContactForces as ContactForces
from steadyload.statics.bearing.forces import contact_forces as contact_forces
from steadyload.statics.bearing.loads import Loads as Loads
from steadyload.statics.bearing.loads import loads as loads
from steadyload.statics.bearing.loads import payload as payload
