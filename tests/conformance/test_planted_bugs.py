"""The suite is worth something only if it catches an adapter that is wrong."""

import dataclasses
import math

import numpy as np
import pytest

from steadyload.engines.attitudes import rotate
from steadyload.engines.box import UPRIGHT
from steadyload.engines.checks.conformance import CHECKS, NotApplicable
from steadyload.engines.registry import world_class
from steadyload.engines.world import Box, Velocities


def passing_checks(world, among):
    """Those of the named checks that pass; skips where the engine declares to be without all."""
    passing, declined = set(), set()
    for name in among:
        try:
            CHECKS[name](world)
        except NotApplicable:
            declined.add(name)
        except Exception:  # a wrong world may also fail before the check can say so
            continue
        else:
            passing.add(name)
    if declined == set(among):
        pytest.skip(f"not applicable: {', '.join(sorted(declined))}")
    return passing


def with_offset_ignored(base):
    class OffsetIgnored(base):
        def add_box(self, box):
            return super().add_box(dataclasses.replace(box, mass_offset=(0.0, 0.0, 0.0)))

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


def with_attitudes_conjugated(base):
    class AttitudesConjugated(base):
        def _poses(self):
            poses = super()._poses()
            return poses._replace(quaternions=poses.quaternions * (1.0, -1.0, -1.0, -1.0))

    return AttitudesConjugated


def with_spin_negated(base):
    class SpinNegated(base):
        def _velocities(self):
            velocities = super()._velocities()
            return velocities._replace(angular=-velocities.angular)

    return SpinNegated


def with_inertia_doubled(base):
    class _Heavy(Box):
        @property
        def inertia(self):
            return tuple(2.0 * i for i in Box(self.size, self.mass, self.centre).inertia)

    class InertiaDoubled(base):
        def add_box(self, box):
            values = {f.name: getattr(box, f.name) for f in dataclasses.fields(box)}
            return super().add_box(_Heavy(**values))

    return InertiaDoubled


def with_moments_ignored(base):
    class MomentsIgnored(base):
        def add_box(self, box):
            return super().add_box(dataclasses.replace(box, moments=None))

    return MomentsIgnored


def with_thin_fixed_boxes(base):
    class ThinFixedBoxes(base):
        """Not too thick ones: an engine may hold what penetrates, and never push it apart."""

        def add_box(self, box):
            if box.fixed:
                x, y, z = box.size
                box = dataclasses.replace(box, size=(x, y, 0.9 * z))
            return super().add_box(box)

    return ThinFixedBoxes


def with_half_a_substep_kept(base):
    class HalfASubstepKept(base):
        def reset_poses(self, only=None):
            clock = self._clock
            super().reset_poses(only)
            self._clock = clock

    return HalfASubstepKept


def with_reset_in_motion(base):
    class ResetInMotion(base):
        """Resetting does nothing but tell where the boxes should be."""

        def _reset(self):
            pass

    return ResetInMotion


def with_velocities_set_in_body_axes(base):
    class SetInBodyAxes(base):
        def _set_velocities(self, velocities):
            attitudes = self._poses().quaternions
            super()._set_velocities(Velocities(*(rotate(attitudes, v) for v in velocities)))

    return SetInBodyAxes


def with_velocities_set_at_the_middle(base):
    class SetAtTheMiddle(base):
        """The linear velocity becomes that of the geometric centre."""

        def _set_velocities(self, velocities):
            offsets = np.array([b.mass_offset for b in self.boxes])
            arms = rotate(self._poses().quaternions, offsets)
            linear = velocities.linear + np.cross(velocities.angular, arms)
            super()._set_velocities(velocities._replace(linear=linear))

    return SetAtTheMiddle


def with_velocities_only_remembered(base):
    class OnlyRemembered(base):
        """They are read back and move nothing."""

        remembered = None

        def _set_velocities(self, velocities):
            self.remembered = velocities

        def _velocities(self):
            return self.remembered or super()._velocities()

        def _reset(self):
            self.remembered = None
            super()._reset()

    return OnlyRemembered


def with_gravity_only_remembered(base):
    class GravityOnlyRemembered(base):
        """It is told, and the world moves under the gravity that it was made with."""

        def set_gravity(self, gravity):
            self._check_open()

    return GravityOnlyRemembered


def with_gravity_at_the_middle(base):
    class GravityAtTheMiddle(base):
        """Another gravity comes with the spin of a force at the geometric centre."""

        def _advance(self, substeps, length):
            more = np.subtract(self.gravity, self.settings.gravity)
            super()._advance(substeps, length)
            velocities = self._velocities()
            for box, spin in zip(self.boxes, velocities.angular, strict=True):
                torque = np.cross(np.negative(box.mass_offset), box.mass * more)
                spin += substeps * length * torque / box.inertia
            self._set_velocities(velocities)

    return GravityAtTheMiddle


def with_gravity_kept(base):
    class GravityKept(base):
        """A reset leaves the gravity that was set."""

        def reset_poses(self, only=None):
            gravity = self.gravity
            super().reset_poses(only)
            self.set_gravity(gravity)

    return GravityKept


def with_slow_boxes_asleep(base):
    class SlowBoxesAsleep(base):
        """What moves slowly is stopped, whether it is in balance or not."""

        def _advance(self, substeps, length):
            for _ in range(substeps):
                super()._advance(1, length)
                velocities = self._velocities()
                for moved, turned in zip(velocities.linear, velocities.angular, strict=True):
                    if np.abs(moved).max() < 0.02 and np.abs(turned).max() < 0.2:
                        moved[:], turned[:] = 0.0, 0.0
                self._set_velocities(velocities)

    return SlowBoxesAsleep


def with_boxes_unseen(base):
    class BoxesUnseen(base):
        def add_box(self, box):
            self._check_open()
            self._add(box)
            self.boxes.append(box)
            return len(self.boxes) - 1

    return BoxesUnseen


def with_boxes_put_upright(base):
    class PutUpright(base):
        def add_box(self, box):
            return super().add_box(dataclasses.replace(box, attitude=UPRIGHT))

    return PutUpright


def with_boxes_stopped_by_a_reset(base):
    class StoppedByAReset(base):
        def reset_poses(self, only=None):
            super().reset_poses(only)
            still = np.zeros((len(self.boxes), 3))
            self.set_velocities(Velocities(still, still))

    return StoppedByAReset


def with_launches_at_the_middle(base):
    class LaunchedAtTheMiddle(base):
        """A centre of mass starts where it would if its box were upright."""

        def add_box(self, box):
            shift = np.subtract(np.add(box.centre, box.mass_offset), box.mass_centre)
            centre = tuple(np.add(box.centre, shift).tolist())
            return super().add_box(dataclasses.replace(box, centre=centre))

    return LaunchedAtTheMiddle


def with_bounces(base):
    class Bounces(base):
        """What stops a fall throws up, too."""

        def _advance(self, substeps, length):
            for _ in range(substeps):
                before = self._velocities()
                super()._advance(1, length)
                after = self._velocities()
                pushed = after.linear[:, 2] - before.linear[:, 2]
                struck = pushed > 0.01
                if struck.any():
                    after.linear[struck, 2] += 1.5 * pushed[struck]
                    self._set_velocities(after)

    return Bounces


@pytest.mark.parametrize(
    ("plant", "caught_by"),
    [
        (with_offset_ignored, {"tipping_rate_of_a_shifted_mass", "two_block_overhang"}),
        (with_friction_product, {"sliding_threshold", "friction_is_that_of_the_contact"}),
        (with_a_substep_lost, {"free_fall"}),
        (with_attitudes_conjugated, {"poses_are_of_the_geometric_centre"}),
        (with_spin_negated, {"velocities_are_rates_of_the_poses"}),
        (with_inertia_doubled, {"tipping_rate_of_a_shifted_mass"}),
        (with_moments_ignored, {"tipping_rate_of_stated_moments"}),
        (with_thin_fixed_boxes, {"fixed_boxes_carry_and_never_move"}),
        (with_boxes_unseen, {"bad_numbers_are_refused"}),
        (with_half_a_substep_kept, {"reseat_equals_a_fresh_world"}),
        (with_reset_in_motion, {"reseat_equals_a_fresh_world", "velocities_can_be_set"}),
        (with_velocities_set_in_body_axes, {"velocities_can_be_set"}),
        (with_velocities_set_at_the_middle, {"velocities_can_be_set"}),
        (with_velocities_only_remembered, {"velocities_can_be_set"}),
        (
            with_gravity_only_remembered,
            {
                "a_gravity_that_is_set_is_one_that_was_given",
                "a_pulse_gives_its_impulse",
                "a_box_slides_beyond_its_friction",
                "a_box_tips_beyond_its_lever",
                "a_gravity_of_no_number_is_refused",
            },
        ),
        (with_gravity_at_the_middle, {"a_pulse_gives_its_impulse"}),
        (with_gravity_kept, {"a_reset_restores_gravity"}),
        (with_slow_boxes_asleep, {"a_box_near_its_edge_falls"}),
        (
            with_boxes_put_upright,
            {"a_box_starts_as_it_was_added", "a_ramp_is_a_slope"},
        ),
        (with_boxes_stopped_by_a_reset, {"a_box_starts_as_it_was_added"}),
        (with_launches_at_the_middle, {"a_box_starts_as_it_was_added"}),
        (with_bounces, {"an_edge_drop_ends_on_the_nearer_face"}),
    ],
)
def test_a_planted_bug_is_caught_in_every_adapter(any_engine, plant, caught_by):
    assert passing_checks(plant(world_class(any_engine)), caught_by) == set()


def test_a_bug_out_of_the_plane_is_caught(any_engine):
    base = world_class(any_engine)
    if base.capabilities.dimensions == 2:
        pytest.skip("not applicable: all motion is in the plane")

    class AcrossIgnored(base):
        def add_box(self, box):
            x, _, z = box.mass_offset
            return super().add_box(dataclasses.replace(box, mass_offset=(x, 0.0, z)))

    assert passing_checks(AcrossIgnored, ["tipping_about_the_other_axis"]) == set()


def with_spins_in_body_axes(base):
    class InBodyAxes(base):
        def add_box(self, box):
            turn, spin = np.array([box.unit_attitude]), np.array([box.angular_velocity])
            wrong = tuple(rotate(turn, spin)[0].tolist())
            return super().add_box(dataclasses.replace(box, angular_velocity=wrong))

    return InBodyAxes


def without_gyroscopic_term(base):
    class WithoutGyroscopicTerm(base):
        """What turns freely keeps its angular velocity."""

        def _advance(self, substeps, length):
            for _ in range(substeps):
                before = self._velocities()
                super()._advance(1, length)
                self._set_velocities(before)

    return WithoutGyroscopicTerm


def with_moments_in_another_order(base):
    class InAnotherOrder(base):
        def add_box(self, box):
            moments = None if box.moments is None else box.moments[::-1]
            return super().add_box(dataclasses.replace(box, moments=moments))

    return InAnotherOrder


def with_a_cap_on_turning(base):
    class Capped(base):
        def _advance(self, substeps, length):
            super()._advance(substeps, length)
            linear, angular = self._velocities()
            self._set_velocities(Velocities(linear, np.clip(angular, -100.0, 100.0)))

    return Capped


@pytest.mark.parametrize(
    ("plant", "caught_by"),
    [
        (
            with_spins_in_body_axes,
            {"motion_in_space_is_read_back", "free_rotation"},
        ),
        (
            without_gyroscopic_term,
            {"free_rotation", "free_rotation_keeps_energy_and_momentum"},
        ),
        (with_moments_in_another_order, {"free_rotation_of_stated_moments"}),
        (with_a_cap_on_turning, {"a_fast_spin_is_kept"}),
        (with_bounces, {"a_corner_drop_ends_on_the_nearest_face"}),
    ],
)
def test_a_planted_bug_of_turning_is_caught(any_engine, plant, caught_by):
    assert passing_checks(plant(world_class(any_engine)), caught_by) == set()


def test_a_remainder_that_is_dropped_is_caught(any_engine):
    base = world_class(any_engine)

    class RemainderDropped(base):
        def stepSimulation(self, timeStep, maxSubSteps, fixedTimeStep):  # noqa: N802, N803
            whole = math.floor(timeStep / fixedTimeStep + 1e-9) * fixedTimeStep
            return super().stepSimulation(whole, maxSubSteps, fixedTimeStep)

    assert passing_checks(RemainderDropped, ["step_counting"]) == set()
