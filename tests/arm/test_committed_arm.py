"""The committed models are those that the code writes, and their keyframes hold."""

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

from handsim.arm.arm_file import READY, ready_postures
from handsim.arm.reaching_arm import ReachingArm
from handsim.files import data_folder
from handsim.types import SIDES, HandSize

FOLDER = data_folder("models") / "arm"
NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")


NAMES = (
    *(name.format(side) for name in ("{}_arm", "keyframes_{}", "scene_{}") for side in SIDES),
    "keyframes_both",
    "scene_both",
    "trunk",
)


@pytest.fixture(scope="module")
def made(script, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("arm")
    script("models/arm/make.py").main(folder)
    return folder


def test_nothing_but_what_the_code_writes_is_committed(made) -> None:
    kept = sorted(path.stem for path in FOLDER.glob("*.xml"))
    assert kept == sorted(path.stem for path in made.glob("*.xml")) == sorted(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_committed_models_are_those_the_code_writes(made, name) -> None:
    texts = [(folder / f"{name}.xml").read_text() for folder in (made, FOLDER)]
    assert NUMBER.sub("#", texts[0]) == NUMBER.sub("#", texts[1])
    numbers = [np.array(NUMBER.findall(text), dtype=float) for text in texts]
    # MuJoCo writes six digits, the last of which may round the other way.
    assert numbers[0] == pytest.approx(numbers[1], 2e-5, 1e-6)
    assert ("<position " in texts[1]) == name.endswith("_arm")


def test_the_trunk_between_two_arms_is_the_one_of_either() -> None:
    both, one = (
        mujoco.MjModel.from_xml_path(str(FOLDER / f"scene_{which}.xml"))
        for which in ("both", "right")
    )
    shown = [[model.geom(i).name for i in range(model.ngeom)] for model in (both, one)]
    chest = [name for name in shown[0] if not name.startswith(("right_", "left_"))]
    assert len(chest) > 5
    assert set(chest) == {
        name
        for name in shown[1]
        if one.body(one.geom(name).bodyid[0]).name in ("trunk", "world") and "other" not in name
    }
    for name in chest:
        assert both.geom(name).size == pytest.approx(one.geom(name).size)


@pytest.mark.parametrize("which", [*SIDES, "both"])
def test_scenes_load_and_their_keyframes_stay(which) -> None:
    model = mujoco.MjModel.from_xml_path(str(FOLDER / f"scene_{which}.xml"))
    assert model.nu == (54 if which == "both" else 27)
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
