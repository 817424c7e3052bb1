"""Measurements of real bodies: recorded motion. See ``docs/measured.md``."""

from steadyload.measured.bodies import Body
from steadyload.measured.errors import MotionError
from steadyload.measured.motion import Trial
from steadyload.measured.motion_files import read_motion, write_motion

__all__ = ["Body", "MotionError", "Trial", "read_motion", "write_motion"]
