"""Each property catches something; five of them in ``test_planted_bugs``, on every engine."""

import dataclasses
import itertools
import sys
import types

import pytest

from steadyload.engines import registry as engine_registry
from steadyload.engines.registry import EngineEntry, world_class
from steadyload.engines.world import Velocities
from steadyload.methods import registry as method_registry
from steadyload.methods.contract.method import STABLE, Finding
from steadyload.methods.rules.base_support import FullBaseSupport, PartialBaseSupport
from steadyload.methods.session import session
from steadyload.properties.property import MethodUnderTest
from steadyload.properties.registry import PROPERTIES
from steadyload.properties.search import search
from steadyload.statics.bearing.crushing import crushed_by_now

MUJOCO = world_class("mujoco")
WORLDS = itertools.count(1)


class Tilted(MUJOCO):
    """Gravity points aside."""

    def __init__(self, settings):
        super().__init__(dataclasses.replace(settings, gravity=(7.0, 0.0, -7.0)))


class Frozen(MUJOCO):
    """Nothing moves."""

    def _advance(self, substeps, length):
        pass


class Restless(MUJOCO):
    """Speeds grow by themselves."""

    def _advance(self, substeps, length):
        super()._advance(substeps, length)
        before = self.velocities()
        self.set_velocities(Velocities(2.0 * before.linear, 2.0 * before.angular))


def driven_where(condition):
    """Some boxes set off by themselves."""

    class Driven(MUJOCO):
        def _advance(self, substeps, length):
            linear, angular = self.velocities()
            linear[[condition(box) for box in self.boxes], 0] = 5.0
            self.set_velocities(Velocities(linear, angular))
            super()._advance(substeps, length)

    return Driven


class Rough(MUJOCO):
    """Friction is twice what was asked for."""

    def __init__(self, settings):
        super().__init__(dataclasses.replace(settings, friction=2.0 * settings.friction))


class Moody(driven_where(lambda box: True)):
    """Every other world lets nothing set off."""

    def _add(self, box):
        super()._add(dataclasses.replace(box, fixed=self.calm))

    def __init__(self, settings):
        super().__init__(settings)
        self.calm = next(WORLDS) % 2 == 0


ENGINES = {
    "tower": Tilted,
    "carton tower": Tilted,
    "accelerated column": Rough,
    "accelerated pile": Rough,
    "floor": Tilted,
    "balanced stays": Tilted,
    "unbalanced moves": Frozen,
    "energy": Restless,
    "repeat": Moody,
    "translation": driven_where(lambda box: box.centre[0] > 0.6),
    "quarter turn": driven_where(lambda box: box.size[0] > 1.5 * box.size[1]),
    "masses": driven_where(lambda box: box.mass > 2.0),
}


@pytest.mark.parametrize("name", ENGINES)
def test_a_property_catches_an_engine_that_is_wrong(name, monkeypatch):
    module = types.ModuleType("planted")
    module.World = ENGINES[name]
    monkeypatch.setitem(sys.modules, "planted", module)
    options = engine_registry.engines()["mujoco"].options
    entry = EngineEntry("planted:World", (), options)
    monkeypatch.setitem(engine_registry.ENGINES, "planted", entry)
    tested = MethodUnderTest("label@planted")
    assert PROPERTIES[name].applies(tested)
    found = search(PROPERTIES[name], tested, examples=60, seed=1, shrink=False)
    assert "Error" not in found.counterexample.found


class LooksAhead(FullBaseSupport):
    """The last of two items or more is always refused."""

    def _judge(self, layout, watch):
        return Finding(failing_step=len(layout) - 1) if len(layout) > 1 else STABLE


class LateMover(FullBaseSupport):
    """The item that moves has not been placed yet."""

    def _judge(self, layout, watch):
        return Finding(failing_step=0, moved_item=len(layout) - 1)


class WantsMore(PartialBaseSupport):
    """Whoever asks for little support gets nowhere."""

    def _judge(self, layout, watch):
        return Finding(failing_step=0) if self._alpha < 0.8 else super()._judge(layout, watch)


METHODS = {
    "prefix": LooksAhead,
    "far item": LooksAhead,
    "score": LateMover,
    "full implies partial": WantsMore,
    "monotone in alpha": WantsMore,
}


@pytest.mark.parametrize("name", METHODS)
def test_a_property_catches_a_method_that_is_wrong(name, monkeypatch):
    monkeypatch.setitem(sys.modules, "planted", types.SimpleNamespace(Judge=METHODS[name]))
    monkeypatch.setitem(method_registry.METHODS, "planted", "planted:Judge")
    tested = MethodUnderTest("planted")
    assert PROPERTIES[name].applies(tested)
    found = search(PROPERTIES[name], tested, examples=60, seed=1)
    assert "Error" not in found.counterexample.found


def never(layout, items, check_time):
    """No box is ever crushed."""


def weakest(layout, items, check_time):
    """A box bears half of what it may."""
    halved = [item if item.max_load is None else halved_load(item) for item in items]
    return crushed_by_now(layout, halved, check_time)


def halved_load(item):
    return dataclasses.replace(item, max_load=0.5 * item.max_load)


def named_wrong(layout, items, check_time):
    """The box that came last is named, not the one that is crushed."""
    found = crushed_by_now(layout, items, check_time)
    return found and dataclasses.replace(found, item=len(items) - 1)


LOOKS = [
    ("crushed column", never),
    ("crushed column", weakest),
    ("crushed column", named_wrong),
    ("whole load borne", weakest),
]


@pytest.mark.parametrize(("name", "look"), LOOKS)
@pytest.mark.parametrize("spec", ["sme", "ps_opt@rapier"])
def test_a_property_catches_a_session_that_is_wrong(name, look, spec, monkeypatch):
    monkeypatch.setattr(session, "crushed_by_now", look)
    tested = MethodUnderTest(spec)
    assert PROPERTIES[name].applies(tested)
    found = search(PROPERTIES[name], tested, examples=60, seed=1, shrink=False)
    assert "Error" not in found.counterexample.found


def test_every_property_has_something_to_catch():
    elsewhere = {"past the edge", "inside the edge", "mirror", "free fall", "sliding"}
    of_sessions = {name for name, _ in LOOKS}
    assert {*ENGINES, *METHODS, *of_sessions, *elsewhere} == set(PROPERTIES)


def test_first_parts_are_fewer_items_than_all():
    """All items alone are the whole layout, and say nothing."""
    outcome = search(PROPERTIES["prefix"], MethodUnderTest("fbs"), examples=60, seed=1)
    assert 0 < outcome.asked < outcome.examples


def test_partial_support_is_compared_on_layouts_that_full_support_refuses_too():
    outcome = search(
        PROPERTIES["full implies partial"], MethodUnderTest("pbs"), examples=60, seed=1
    )
    assert outcome.asked == outcome.examples


@pytest.mark.parametrize("engine", ["chipmunk", "mujoco"])
def test_what_is_out_of_balance_is_not_left_to_chance(engine):
    outcome = search(
        PROPERTIES["unbalanced moves"], MethodUnderTest(f"label@{engine}"), examples=60, seed=1
    )
    assert 3 * outcome.asked >= outcome.examples
