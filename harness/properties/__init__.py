"""Property tests: strategies that build layouts, what must hold of them, and the search.

Everything but this file needs the extra ``properties`` (hypothesis).
"""

from steadyload.errors import UserError


class PropertyError(UserError):
    """A property, engine or package that is not there."""
