"""Complete loads on the road: accelerations, rules, and the largest acceleration that is held.

Items are rigid boxes on a deck. There is no wrap, no strap and no anti-slip mat.
"""

from steadyload.transport.errors import TransportError
from steadyload.transport.limits import Limit, limits
from steadyload.transport.rules import Rule, rules

__all__ = ["Limit", "Rule", "TransportError", "limits", "rules"]
