"""The committed models are those that the code writes, and their keyframes hold."""

import re

import mujoco
import numpy as np
import pytest

from handsim.arm.arm_file import READY, ready_postures, write_arm
from handsim.arm.reaching_arm import ReachingArm
from handsim.files import data_folder
from handsim.types import SIDES, HandSize

FOLDER = data_folder("models") / "arm"
NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")


@pytest.mark.parametrize("side", SIDES)
def test_committed_models_are_those_the_code_writes(side, tmp_path) -> None:
    made = write_arm(HandSize(side=side), tmp_path / "new").read_text()
    kept = (FOLDER / f"{side}_arm.xml").read_text()
    assert NUMBER.sub("#", made) == NUMBER.sub("#", kept)
    numbers = [np.array(NUMBER.findall(text), dtype=float) for text in (made, kept)]
    # MuJoCo writes six digits, the last of which may round the other way.
    assert numbers[0] == pytest.approx(numbers[1], 2e-5, 1e-6)
    assert "<position " in kept


def test_the_scene_loads_and_its_keyframes_stay() -> None:
    model = mujoco.MjModel.from_xml_path(str(FOLDER / "scene.xml"))
    assert [model.key(i).name for i in range(model.nkey)] == ["hanging", *READY]
    data = mujoco.MjData(model)
    for i in range(model.nkey):
        mujoco.mj_resetDataKeyframe(model, data, i)
        start = data.qpos.copy()
        mujoco.mj_step(model, data, 300)
        assert np.abs(data.qpos - start).max() < 0.01, model.key(i).name


def test_left_keyframes_are_the_same_angles_and_others_are_in_proportion() -> None:
    right, left = (ready_postures(HandSize(side=side)) for side in SIDES)
    for name, angles in right.items():
        assert left[name] == pytest.approx(angles, abs=1e-9)
    small = HandSize(0.165, 0.072)
    arm, q = ReachingArm(small), ready_postures(small)["raised"]
    pos = arm.palm(q[:5], q[5:])[0]
    assert pos == pytest.approx(np.array(READY["raised"][0]) * 0.165 / 0.1933)
