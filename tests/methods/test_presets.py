"""The named tunings give the right answer where there is no doubt about it."""

import pytest

from steadyload.methods import make_method

TUNINGS = ("ps3", "ps5", "ps_opt-paper")


@pytest.mark.parametrize("tuning", TUNINGS)
def test_a_tower_stands_and_an_overhang_falls(engine, tuning, stack):
    """Eight cubes stand; one whose centre of mass lies 2 cm outside its support falls."""
    method = make_method(f"{tuning}@{engine}")
    assert method.judge(stack(*[0.0] * 8)).failing_step is None
    assert method.judge(stack(0.0, 7.0)).failing_step == 1
    assert method.judge(stack(0.0, 4.0, offset=3.0)).failing_step == 1
    assert method.judge(stack(0.0, 3.0)).failing_step is None


def test_the_paper_s_values_on_restitution_are_said_to_be_ignored_or_met(engine, stack):
    from steadyload.engines.registry import world_class

    verdict = make_method(f"ps3@{engine}").judge(stack(0.0))
    honoured = world_class(engine).capabilities.settings["restitution"].support == "honoured"
    assert ("restitution" in verdict.ignored) is not honoured
