"""The exact limit against compas_cra: rigid blocks in equilibrium, written by others.

It detects the contacts itself, states balance and friction, and solves by IPOPT. For a load under
an acceleration it is given one that is turned: the sum of gravity and acceleration points down.
"""

import math

import numpy as np
import pytest

from steadyload.layouts.benchmark import load_benchmark
from steadyload.layouts.model.layout import Item, Layout, Pallet
from steadyload.statics.friction import Sides
from steadyload.transport.balance import BalanceProgramme

pytest.importorskip("compas_cra", reason="compas_cra is not installed")

from compas.geometry import Frame, Point
from compas_assembly.datastructures import Block, Interface
from compas_cra.algorithms import assembly_interfaces_numpy
from compas_cra.datastructures import CRA_Assembly
from compas_cra.equilibrium import cra_solve, rbe_problem, rbe_solve
from compas_cra.nlp import solve_nlp

FRICTION = 0.5
RESOLUTION = 1e-4
"""Width of the interval that a limit of compas_cra is known in [g]."""

TOLERANCE = 1e-3
"""Between limits [g]; pyramids of 64 edges inside cones take 0.0006 g from what slides."""

TENSION = 1e-4
"""Sum of tensions up to which a load counts as balanced, in weights of its lightest box."""

INSIDE = FRICTION * math.cos(math.pi / 8.0)
"""The coefficient whose octagons in compas_cra have their edges on the cones of the other."""

COPIES = 8
"""Of a contact: eight octagons with their edges on a cone add up to a pyramid of 64."""

HEAVY = 10.0
"""Unit of weight for ``cra_solve``, in mean boxes: it seldom finds forces that are large."""

METRE = 0.01
CORNERS = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def load(*boxes):
    """A layout of boxes (corner, size, weight[, shift of the centre of mass])."""
    items = tuple(Item(k, *box) for k, box in enumerate(boxes))
    return Layout("load", Pallet(120.0, 200.0, 80.0), items)


SIMPLE = {
    "flat": load(((40.0, 0.0, 30.0), (20.0, 10.0, 30.0), 7.0)),
    "tall": load(((40.0, 0.0, 30.0), (10.0, 40.0, 24.0), 7.0)),
    "shifted": load(((40.0, 0.0, 30.0), (15.0, 30.0, 20.0), 7.0, (1.5, -3.0, 2.0))),
    "column": load(*(((40.0, 12.0 * k, 30.0), (20.0, 12.0, 20.0), 5.0) for k in range(3))),
    "overhang": load(
        ((40.0, 0.0, 30.0), (20.0, 10.0, 20.0), 5.0),
        ((47.0, 10.0, 33.0), (20.0, 15.0, 20.0), 8.0),
    ),
    "bridge": load(
        ((20.0, 0.0, 30.0), (15.0, 20.0, 20.0), 4.0),
        ((55.0, 0.0, 30.0), (15.0, 20.0, 20.0), 6.0),
        ((25.0, 20.0, 32.0), (40.0, 12.0, 18.0), 9.0),
    ),
    "pyramid": load(
        ((20.0, 0.0, 30.0), (20.0, 20.0, 15.0), 5.0),
        ((40.0, 0.0, 30.0), (20.0, 20.0, 15.0), 5.0),
        ((30.0, 20.0, 30.0), (20.0, 20.0, 15.0), 5.0),
    ),
    "neighbour": load(
        ((40.0, 0.0, 30.0), (10.0, 60.0, 20.0), 2.0), ((50.0, 0.0, 20.0), (40.0, 60.0, 40.0), 80.0)
    ),
    "wall": load(
        ((20.0, 0.0, 30.0), (30.0, 15.0, 15.0), 6.0),
        ((50.0, 0.0, 30.0), (30.0, 15.0, 15.0), 6.0),
        ((20.0, 15.0, 30.0), (15.0, 15.0, 15.0), 3.0),
        ((35.0, 15.0, 30.0), (30.0, 15.0, 15.0), 6.0),
        ((65.0, 15.0, 30.0), (15.0, 15.0, 15.0), 3.0),
        ((20.0, 30.0, 30.0), (30.0, 15.0, 15.0), 6.0),
        ((50.0, 30.0, 30.0), (30.0, 15.0, 15.0), 6.0),
    ),
}

LABELLED = (
    "H66_Class_3_Instance_33_ULD_0",
    "H25_Class_3_Instance_37_ULD_1",
    "H133_Class_3_Instance_30_ULD_1",
    "H79_Class_1_Instance_46_ULD_1",
    "H42_Class_3_Instance_23_ULD_4",
)
"""Loads of the labelled set, of five to eight boxes, that balance at rest."""


@pytest.fixture(scope="module")
def loads():
    benchmark = load_benchmark("lists")
    return SIMPLE | {name: benchmark.layout(name, "S1") for name in LABELLED}


class Weighed(Block):
    """A block whose centre of mass is told."""

    mass_centre = (0.0, 0.0, 0.0)

    def center(self):
        return Point(*self.mass_centre)


class Turned:
    """A load on its deck as compas_cra sees it, with weights in units of the lightest box.

    Its cones of friction are octagons that touch the round ones from outside, where the force is
    along an axis of the layout or at 45 degrees. With several ``copies`` of a contact, the tangents
    of each turned by as much, their octagons add up to a polygon of so many more edges.
    """

    def __init__(self, layout, sides, copies=1, unit=None):
        lower, upper = METRE * layout.lower, METRE * layout.upper
        deck = lower.min(axis=0) - 0.1, upper.max(axis=0) + 0.1
        deck[0][1], deck[1][1] = -0.1, 0.0
        boxes = [*zip(lower, upper, strict=True), deck]
        self.assembly = CRA_Assembly()
        self.blocks = []
        for k, box in enumerate(boxes):
            corners = [[float(box[corner[a]][a]) for a in range(3)] for corner in CORNERS]
            self.blocks.append(Weighed.from_vertices_and_faces(corners, FACES))
            self.assembly.add_block(self.blocks[-1], node=k)
        self.assembly.set_boundary_condition(len(layout))
        weights = layout.weights / (unit or layout.weights.min())
        for block, weight in zip(self.blocks, weights, strict=False):
            block.attributes["density"] = float(weight) / block.volume()
        self.centres = np.array([0.5 * (low + high) for low, high in boxes])
        self.centres[:-1] += METRE * layout.mass_offsets
        assembly_interfaces_numpy(self.assembly, nmax=len(boxes), amin=1e-8)
        self.contacts = []  # each with its points, origin and tangents before it is turned
        self.pushing = []  # points without friction
        points = 0
        graph = self.assembly.graph
        for edge in graph.edges():
            own = []
            for found in graph.edge_attribute(edge, "interfaces"):
                rubs = abs(found.frame.zaxis[1]) > 0.5 or sides is Sides.FRICTION
                for k in range(copies if rubs else 1):
                    own.append(self._copied(found, 0.25 * math.pi * k / copies))
                    if not rubs:
                        self.pushing += range(points, points + len(found.points))
                    points += len(found.points)
            graph.edge_attribute(edge, "interfaces", own)

    def _copied(self, found, angle):
        first, second = np.array(found.frame.xaxis), np.array(found.frame.yaxis)
        tangents = (
            math.cos(angle) * first + math.sin(angle) * second,
            math.cos(angle) * second - math.sin(angle) * first,
        )
        copy = Interface(points=found.points, frame=found.frame, size=found.size)
        frame = np.array((found.frame.point, *tangents))
        self.contacts.append((copy, np.array(found.points), frame))
        return copy

    def turn(self, level, direction_deg):
        angle = math.radians(direction_deg)
        up = np.array([-level * math.cos(angle), 1.0, -level * math.sin(angle)])
        up /= np.linalg.norm(up)
        first = np.cross(up, (0.0, 0.0, 1.0))
        first /= np.linalg.norm(first)
        turn = np.array([first, np.cross(up, first), up]).T
        for contact, points, frame in self.contacts:
            contact.points = (points @ turn).tolist()
            contact._frame = Frame(*(frame @ turn).tolist())
        for block, centre in zip(self.blocks, self.centres @ turn, strict=True):
            block.mass_centre = centre.tolist()

    def least_tension(self, level, direction_deg, friction):
        """Sum of the tensions without which nothing balances.

        By the constraints of ``rbe_solve``, but points that only push have no friction, and tension
        alone is made least: where it is weighed against squares of all other forces, as there, some
        is left near the limit when points are many.
        """
        self.turn(level, direction_deg)
        problem, _ = rbe_problem(self.assembly, mu=friction)
        for tangent in (2, 3):
            forces = 4 * np.array(self.pushing, dtype=int) + tangent
            problem.x_l[forces] = problem.x_u[forces] = 0.0
        tensions = np.zeros(problem.n)
        tensions[1::4] = 1.0
        nothing = np.zeros(len(problem.hess_rows))
        problem.objective = lambda forces: float(tensions @ forces)
        problem.gradient = lambda forces: tensions
        problem.hessian = lambda forces, sigma, multipliers: nothing
        solution = solve_nlp(problem)
        assert solution.success, solution
        return solution.x[1::4].sum()

    def penalised_tension(self, level, direction_deg, friction):
        """Sum of the tensions that ``rbe_solve`` answers."""
        self.turn(level, direction_deg)
        rbe_solve(self.assembly, mu=friction)
        contacts = [contact for contact, _, _ in self.contacts]
        return sum(force["c_nn"] for contact in contacts for force in contact.forces)

    def is_coupled(self, level, direction_deg, friction):
        """Whether ``cra_solve`` finds forces that a motion could produce."""
        self.turn(level, direction_deg)
        try:
            cra_solve(self.assembly, mu=friction)
        except ValueError:
            return False
        return True


def bisected(tension, direction_deg, friction):
    """The largest level that needs no tension; no load holds more than its friction at the deck."""
    low, high = 0.0, 1.1 * FRICTION
    assert tension(low, direction_deg, friction) < TENSION
    assert tension(high, direction_deg, friction) > TENSION
    while high - low > RESOLUTION:
        middle = 0.5 * (low + high)
        if tension(middle, direction_deg, friction) < TENSION:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def fine_differences(layout, sides, directions):
    """Limit by rigid-block equilibrium less ours, with pyramids of 64 edges inside the cones."""
    programme, turned = BalanceProgramme(layout, FRICTION, sides), Turned(layout, sides, COPIES)
    return [
        bisected(turned.least_tension, one, INSIDE) - programme.limit(one).limit_g
        for one in directions
    ]


@pytest.mark.parametrize("name", ["flat", "overhang", "pyramid"])
def test_a_few_boxes_hold_what_rigid_block_equilibrium_says(name):
    found = fine_differences(SIMPLE[name], Sides.FRICTIONLESS, (0.0, 30.0, 90.0))
    assert np.abs(found).max() < TOLERANCE


@pytest.mark.parametrize("sides", [Sides.FRICTIONLESS, Sides.FRICTION])
@pytest.mark.parametrize("name", [*SIMPLE, *LABELLED])
def test_limits_are_those_of_rigid_block_equilibrium(name, sides, loads):
    found = fine_differences(loads[name], sides, (0.0, 30.0))
    assert np.abs(found).max() < TOLERANCE


@pytest.mark.parametrize("name", [name for name in SIMPLE if name != "neighbour"])
def test_along_axes_limits_are_those_of_rbe_solve(name):
    """As it is published; a box that turns beside a neighbour meets corners of octagons."""
    layout = SIMPLE[name]
    programme = BalanceProgramme(layout, FRICTION, Sides.FRICTION)
    turned = Turned(layout, Sides.FRICTION)
    for direction in (0.0, 90.0, 180.0, 270.0):
        found = bisected(turned.penalised_tension, direction, FRICTION)
        assert found == pytest.approx(programme.limit(direction).limit_g, abs=TOLERANCE)


@pytest.mark.parametrize("name", SIMPLE)
def test_just_below_the_limit_there_are_coupled_forces_and_just_above_none(name):
    """Where few boxes slide or tip the bound is what is held: ``cra_solve`` says the same.

    A box that turns beside a neighbour meets corners of octagons, which lie outside the cones.
    """
    layout = SIMPLE[name]
    programme = BalanceProgramme(layout, FRICTION, Sides.FRICTION)
    turned = Turned(layout, Sides.FRICTION, unit=HEAVY * layout.weights.mean())
    for direction in (0.0, 90.0):
        limit = programme.limit(direction).limit_g
        assert turned.is_coupled(limit - TOLERANCE, direction, FRICTION)
        above = INSIDE if name == "neighbour" else FRICTION
        assert not turned.is_coupled(limit + TOLERANCE, direction, above)


@pytest.mark.parametrize("name", LABELLED)
def test_no_coupled_forces_hold_a_load_above_its_limit(name, loads):
    """``cra_solve`` with octagons inside the cones; it may say less: it seeks, and may not find."""
    layout = loads[name]
    programme = BalanceProgramme(layout, FRICTION, Sides.FRICTION)
    turned = Turned(layout, Sides.FRICTION, unit=HEAVY * layout.weights.mean())
    limits = {one: programme.limit(one).limit_g for one in (0.0, 90.0, 180.0)}
    below = ((part * limit, one) for part in (0.9, 0.7, 0.5) for one, limit in limits.items())
    assert any(turned.is_coupled(*level, INSIDE) for level in below)
    assert not turned.is_coupled(limits[0.0] + TOLERANCE, 0.0, INSIDE)
