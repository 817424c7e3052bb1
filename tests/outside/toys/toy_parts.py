"""Parts of another distribution, each a class and one line: an engine, and a method."""

import dataclasses

from steadyload.engines.with_mujoco import MujocoWorld
from steadyload.methods.contract.method import STABLE, Method
from steadyload.methods.contract.spec import NoParameters


class ToyWorld(MujocoWorld):
    """MuJoCo by another name."""

    capabilities = dataclasses.replace(MujocoWorld.capabilities, title="Toy engine")


class Optimist(Method):
    """Finds every layout stable."""

    title = "Optimist"
    Parameters = NoParameters

    def _judge(self, layout, watch):
        return STABLE
