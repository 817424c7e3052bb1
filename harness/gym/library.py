"""Gymnasium, or one sentence that says which extra brings it."""

from steadyload.errors import UserError


class GymnasiumNotInstalledError(UserError, ImportError):
    """The library Gymnasium is missing; says which extra installs it."""


try:
    import gymnasium as gymnasium
except ImportError as error:
    raise GymnasiumNotInstalledError(
        "steadyload.gym needs Gymnasium: pip install 'steadyload[gym]'"
    ) from error
