"""The suite is worth something only if it catches an adapter that is wrong."""

import dataclasses
import math

import pytest

from engines.conformance import CHECKS, NotApplicable
from engines.registry import world_class

# These need the class to be importable in another process, or only cost time.
LEFT_OUT = {"repeat_in_a_fresh_process", "many_worlds_leave_no_memory"}


def failing_checks(world):
    failed = set()
    for name, check in CHECKS.items():
        if name in LEFT_OUT:
            continue
        try:
            check(world)
        except NotApplicable:
            continue
        except AssertionError:
            failed.add(name)
    return failed


def with_offset_ignored(base):
    class OffsetIgnored(base):
        def _add(self, box):
            super()._add(dataclasses.replace(box, mass_offset=(0.0, 0.0, 0.0)))

    return OffsetIgnored


def with_friction_product(base):
    class FrictionProduct(base):
        """The pair's coefficient becomes the product of two bodies' values."""

        def __init__(self, settings):
            super().__init__(dataclasses.replace(settings, friction=settings.friction**2))

    return FrictionProduct


def with_a_substep_lost(base):
    class SubstepLost(base):
        """One substep of 27, 31, 54, 62, ... is lost, as by a count in floating point."""

        def _advance(self, substeps, length):
            found = int(substeps * length / (substeps * length / substeps))
            lost = found < substeps or substeps in (27, 31, 54, 62)
            super()._advance(substeps - 1 if lost and substeps > 1 else substeps, length)

    return SubstepLost


@pytest.mark.parametrize(
    ("plant", "caught_by"),
    [
        (with_offset_ignored, {"tipping_rate_of_a_shifted_mass", "two_block_overhang"}),
        (with_friction_product, {"sliding_threshold", "friction_is_that_of_the_contact"}),
        (with_a_substep_lost, {"free_fall"}),
    ],
)
def test_a_planted_bug_is_caught_in_every_adapter(engine, plant, caught_by):
    healthy = world_class(engine)
    assert failing_checks(healthy) <= {f.check for f in healthy.capabilities.known_failures}
    assert caught_by <= failing_checks(plant(healthy))


def test_a_remainder_that_is_dropped_is_caught(engine):
    base = world_class(engine)

    class RemainderDropped(base):
        def stepSimulation(self, timeStep, maxSubSteps, fixedTimeStep):  # noqa: N802, N803
            whole = math.floor(timeStep / fixedTimeStep + 1e-9) * fixedTimeStep
            return super().stepSimulation(whole, maxSubSteps, fixedTimeStep)

    assert "step_counting" in failing_checks(RemainderDropped)
