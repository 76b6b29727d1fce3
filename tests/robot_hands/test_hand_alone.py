"""A hand in a scene of a benchmark is read alone: nothing of the room comes with it."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from handsim.hand.export import write_hand
from handsim.joints import FINGERS
from handsim.retargeting.robot_hand import RobotHand
from handsim.types import MEDIAN_HAND

PADS = {finger: f"{finger}_pad" for finger in FINGERS}


@pytest.fixture(scope="module")
def hand_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_hand(MEDIAN_HAND, tmp_path_factory.mktemp("hand") / "hand")


@pytest.fixture(scope="module")
def in_a_room(hand_file: Path) -> Path:
    """The hand over a floor, beside a ball and a table, bound to a body that would lead it."""
    spec = mujoco.MjSpec.from_file(str(hand_file))
    (forearm,) = (b for b in spec.worldbody.bodies if b.find_all(mujoco.mjtObj.mjOBJ_JOINT))
    spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 1])
    for name in ("table", "ball"):
        body = spec.worldbody.add_body(name=name, pos=[0, 0, 0.5])
        body.add_geom(size=[0.05, 0, 0])
    spec.body("ball").add_freejoint()
    spec.worldbody.add_body(name="leader", mocap=True)
    weld = spec.add_equality(type=mujoco.mjtEq.mjEQ_WELD, objtype=mujoco.mjtObj.mjOBJ_BODY)
    weld.name1, weld.name2 = "leader", forearm.name
    spec.worldbody.add_light(pos=[0, 0, 1])
    spec.option.iterations = 7
    room = hand_file.with_name("room.xml")
    room.write_text(spec.to_xml())
    return room


def test_the_room_is_left_out_and_that_is_said(hand_file: Path, in_a_room: Path) -> None:
    alone, found = RobotHand(hand_file, "palm", PADS), RobotHand(in_a_room, "palm", PADS)
    model = found.model
    assert (model.nq, model.nu, model.nmocap) == (alone.model.nq, alone.model.nu, 0)
    assert (model.nbody, model.ngeom, model.nlight) == (alone.model.nbody, alone.model.ngeom, 0)
    assert not (model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE.value).any()
    assert model.neq == alone.model.neq
    (said,) = (line for line in found.notes if "beside the hand" in line)
    assert said.startswith("4 things beside the hand are left out, the first '")
    assert not any("beside the hand" in line for line in alone.notes)
    x = np.full(len(alone.reference), 0.3)
    np.testing.assert_allclose(found.forward(x).points, alone.forward(x).points, atol=1e-9)


def test_of_a_palm_that_is_the_world_itself_planes_alone_are_left_out(tmp_path: Path) -> None:
    fingers = "".join(
        f'<body name="f{i}" pos="0.05 {0.03 * i} 0"><joint axis="0 1 0" range="0 1.5"/>'
        f'<geom type="capsule" size="0.01" fromto="0 0 0 0.05 0 0"/></body>'
        for i in range(2)
    )
    path = tmp_path / "hand.xml"
    path.write_text(
        '<mujoco><worldbody><geom name="floor" type="plane" size="1 1 1" pos="0 0 -0.1"/>'
        f'<geom name="base" size="0.03"/>{fingers}</worldbody></mujoco>'
    )
    robot = RobotHand(path, "world", {"thumb": "f0", "index": "f1"})
    assert robot.model.geom(0).name == "base"
    assert robot.model.nbody == 3


def test_a_spec_that_is_given_stays_as_it_is(in_a_room: Path) -> None:
    spec = mujoco.MjSpec.from_file(str(in_a_room))
    robot = RobotHand(spec, "palm", PADS)
    assert spec.body("table") is not None and robot.spec.body("table") is None
