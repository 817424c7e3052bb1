"""Writing boxes into a cached model is the same, to the bit, as compiling a model for them."""

import numpy as np
import pytest

from steadyload.engines.world import Box, WorldSettings

mujoco = pytest.importorskip("mujoco")

BOXES = [
    Box((0.10, 0.12, 0.08), 1.5, (0.0, 0.0, 0.04), (0.0, 0.0, 0.0)),
    Box((0.30, 0.10, 0.05), 0.7, (0.05, 0.01, 0.105), (0.06, 0.0, -0.01)),
    Box((0.05, 0.05, 0.20), 2.2, (0.13, 0.02, 0.23), (0.01, -0.02, 0.05)),
    Box((0.20, 0.20, 0.10), 4.0, (0.40, 0.30, 0.05), (-0.05, 0.0, 0.0)),
]
SETTINGS = WorldSettings(friction=0.45, linear_damping=0.06, angular_damping=0.01)
H = 1 / 240


def compiled(boxes, solimp="0.95 0.99 0.001"):
    """A model made the ordinary way: XML, real numbers, MuJoCo's own compiler."""

    def numbers(values):
        return " ".join(repr(float(v)) for v in values)

    bodies = "".join(
        f"""<body pos="{numbers(np.add(b.centre, b.mass_offset))}"><freejoint/>
        <inertial pos="0 0 0" mass="{b.mass!r}" diaginertia="{numbers(b.inertia)}"/>
        <geom type="box" size="{numbers(np.divide(b.size, 2))}"
        pos="{numbers(np.negative(b.mass_offset))}"/></body>"""
        for b in boxes
    )
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{H!r}" cone="elliptic" gravity="0 0 -9.8">
        <flag midphase="disable"/></option>
        <default><geom friction="0.45" solimp="{solimp}" solref="{2 * H!r} 1"/></default>
        <worldbody><geom type="box" size="1000 1000 10" pos="0 0 -10"/>{bodies}</worldbody>
        </mujoco>"""
    )
    for index, box in enumerate(boxes):
        model.dof_damping[6 * index : 6 * index + 3] = -np.log1p(-0.06) * box.mass
        model.dof_damping[6 * index + 3 : 6 * index + 6] = -np.log1p(-0.01) * np.array(box.inertia)
    return model, mujoco.MjData(model)


@pytest.mark.exact("equal to the last bit to a model that is made from planned boxes")
def test_the_ladder_equals_recompiling_at_every_step():
    from steadyload.engines.with_mujoco import MujocoWorld

    # Another layout first, so that the rungs are not fresh.
    with MujocoWorld(WorldSettings(friction=0.9, margin=0.01)) as earlier:
        for box in reversed(BOXES):
            earlier.add_box(Box(box.size, 9.0, (*box.centre[:2], box.centre[2] + 1.0)))
            earlier.stepSimulation(0.1, 100, 1 / 100)
    with MujocoWorld(SETTINGS) as world:
        state = None
        for count, box in enumerate(BOXES, start=1):
            world.add_box(box)
            world.stepSimulation(72 * H, 1000, H)
            model, data = compiled(BOXES[:count])
            if state is not None:
                before = 7 * (count - 1)
                data.qpos[:before], data.qvel[: 6 * (count - 1)] = state[0], state[1]
                data.qacc_warmstart[: 6 * (count - 1)] = state[2]
            mujoco.mj_step(model, data, nstep=72)
            state = data.qpos.copy(), data.qvel.copy(), data.qacc_warmstart.copy()
            rung = world._rung
            assert rung is not None
            assert (rung.data.qpos == data.qpos).all()
            assert (rung.data.qvel == data.qvel).all()
            for name in (
                "body_mass", "body_inertia", "body_invweight0", "dof_invweight0", "dof_M0",
                "dof_damping", "geom_size", "geom_pos", "geom_rbound", "geom_aabb",
                "body_subtreemass",
            ):  # fmt: skip
                assert getattr(rung.model, name) == pytest.approx(getattr(model, name)), name
            assert rung.model.stat.meaninertia == pytest.approx(model.stat.meaninertia)


@pytest.mark.exact("equal to the last bit to a model that is made from planned boxes")
def test_impedance_reaches_the_contacts_of_every_rung():
    from steadyload.engines.mujoco_options import MujocoOptions
    from steadyload.engines.with_mujoco import MujocoWorld

    # The same boxes under other options first, so that the rungs are not fresh.
    sinking = {}
    for impedance in ((0.99, 0.999, 1e-4), (0.95, 0.99, 0.001)):
        settings = WorldSettings(
            friction=0.45, linear_damping=0.06, angular_damping=0.01,
            options=MujocoOptions(*impedance),
        )  # fmt: skip
        with MujocoWorld(settings) as world:
            for box in BOXES:
                world.add_box(box)
            world.stepSimulation(72 * H, 1000, H)
            model, data = compiled(BOXES, " ".join(map(str, impedance)))
            mujoco.mj_step(model, data, nstep=72)
            assert world._rung is not None
            assert (world._rung.data.qpos == data.qpos).all()
            sinking[impedance[0]] = BOXES[3].centre[2] - world.poses().centres[3, 2]
    assert 0.0 < sinking[0.99] < 0.2 * sinking[0.95]


def test_options_of_another_engine_are_refused():
    from steadyload.engines.with_mujoco import MujocoWorld

    with pytest.raises(TypeError, match="options are 'soft'; allowed: MujocoOptions"):
        MujocoWorld(WorldSettings(options="soft"))


@pytest.mark.parametrize("value", [0.0, 1.0, float("nan")])
def test_options_are_checked_wherever_they_come_from(value):
    from steadyload.engines.mujoco_options import MujocoOptions

    with pytest.raises(ValueError, match=r"impedance_deep is .*; allowed: 0.0001 to 0.9999"):
        MujocoOptions(impedance_deep=value)
