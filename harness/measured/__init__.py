"""Measurements of real bodies and loads: recorded motion, and field tests of whole stacks.

See ``docs/measured.md`` and ``docs/field-test.md``.
"""

from steadyload.measured.bodies import Body
from steadyload.measured.errors import FieldTestError, MotionError
from steadyload.measured.field_files import FieldTests, read_field_tests, write_field_tests
from steadyload.measured.field_predictions import Agreement, Prediction, agreements, predictions
from steadyload.measured.field_tests import Done, FieldTest
from steadyload.measured.motion import Trial
from steadyload.measured.motion_files import read_motion, write_motion
from steadyload.measured.profiles import MotionProfile, motion_profile

__all__ = [
    "Agreement",
    "Body",
    "Done",
    "FieldTest",
    "FieldTestError",
    "FieldTests",
    "MotionError",
    "MotionProfile",
    "Prediction",
    "Trial",
    "agreements",
    "motion_profile",
    "predictions",
    "read_field_tests",
    "read_motion",
    "write_field_tests",
    "write_motion",
]
