"""An environment of Gymnasium for packing online, whose placements have to stand.

Importing this package registers ``steadyload/OnlinePacking-v0``. It needs the extra ``gym``::

    import gymnasium
    import steadyload.gym

    env = gymnasium.make("steadyload/OnlinePacking-v0", method="equilibrium")
"""

from steadyload.gym.environment import OnlinePacking, OnlinePackingError
from steadyload.gym.library import GymnasiumNotInstalledError, gymnasium

__all__ = ["GymnasiumNotInstalledError", "OnlinePacking", "OnlinePackingError"]

gymnasium.register(
    "steadyload/OnlinePacking-v0", entry_point="steadyload.gym.environment:OnlinePacking"
)
