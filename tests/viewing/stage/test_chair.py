from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

from handsim.arm.arm_geometry import ArmGeometry
from handsim.grasping.rollout_file import read_rollout
from handsim.tasks.scene import build_scene
from handsim.tasks.table_one import task_by_name
from handsim.types import HandSize
from handsim.viewing.film.clip import Clip
from handsim.viewing.film.clip_player import Player
from handsim.viewing.film.offscreen import open_offscreen
from handsim.viewing.film.rollout_clips import rollout_clip
from handsim.viewing.stage.camera import Camera, direction_deg, eyes_of

SCHEMAS = Path(__file__).parents[2] / "data" / "schemas"
HAND = ("palm", "thumb", "index", "middle", "ring", "little")


def bodies_seen(clip: Clip, camera: str, time: float) -> tuple[npt.NDArray[np.str_], float]:
    """Name of the body in each pixel, row after row, and how far the camera is from the hand."""
    with open_offscreen(160, 120) as offscreen:
        player = Player(clip, offscreen, camera)
        flags = player.scene._scene.flags
        for flag in (mujoco.mjtRndFlag.mjRND_SEGMENT, mujoco.mjtRndFlag.mjRND_IDCOLOR):
            flags[flag.value] = 1
        frame = player.draw_all(time)[0].astype(int)
        numbers = frame @ [1, 256, 65536] - 1
        scene, names = player.scene._scene, np.full(numbers.shape, "", dtype="<U32")
        for i in range(scene.ngeom):
            geom = scene.geoms[i]
            if geom.objtype == mujoco.mjtObj.mjOBJ_GEOM.value:
                body = clip.model.geom_bodyid[geom.objid]
                names[numbers == geom.segid] = clip.model.body(body).name
        return names, player.cameras[0].view.distance


def without_overlays(clip: Clip) -> Clip:
    return Clip(clip.model, clip.time, clip.qpos)


@pytest.fixture(scope="module")
def grasp() -> Clip:
    """A cube that an arm raises, in twelve states."""
    return without_overlays(rollout_clip(read_rollout(SCHEMAS / "rollout-2.npz")))


@pytest.fixture(scope="module")
def old_grasp() -> Clip:
    """The same by a free hand, recorded by an earlier version."""
    return without_overlays(rollout_clip(read_rollout(SCHEMAS / "rollout-1.npz")))


def share_of_hand(names: npt.NDArray[np.str_]) -> float:
    return float(np.isin(np.char.partition(names, "_")[..., 0], HAND).mean())


def test_the_hand_fills_the_view_from_the_chair(rendering: str, grasp: Clip) -> None:
    usual = []
    for time in np.linspace(0, grasp.duration, 5):
        names, _ = bodies_seen(grasp, "chair", time)
        assert 0.09 < share_of_hand(names) < 0.4, time
        rows, columns = np.nonzero(np.isin(np.char.partition(names, "_")[..., 0], HAND))
        assert np.ptp(columns) > 0.3 * 160
        assert rows.min() > 5, "nothing of it is cut off at the top"
        assert columns.min() > 5
        assert not (names == "trunk").any(), "the person's chest is not in the way"
        usual.append(share_of_hand(bodies_seen(grasp, "view", time)[0]))
    assert min(usual) > 0.05, "nor is it small in the usual view"


def test_the_person_is_seen_beside_the_hand(rendering: str, grasp: Clip) -> None:
    for camera, least, of_trunk in (("view", 0.001, 0.05), ("side", 0.02, 0.01)):
        names, _ = bodies_seen(grasp, camera, 0.3 * grasp.duration)
        assert np.isin(names, ("lower_arm", "forearm")).mean() > least, camera
        assert (names == "upper_arm").mean() > 0.03, camera
        assert (names == "trunk").mean() > of_trunk, camera


def test_old_rollouts_are_seen_from_the_chair(rendering: str, old_grasp: Clip) -> None:
    names, _ = bodies_seen(old_grasp, "chair", old_grasp.duration)
    assert 0.05 < share_of_hand(names) < 0.4


@pytest.mark.parametrize("side", ["right", "left"])
def test_eyes_are_above_the_middle_of_the_shoulders(side: str) -> None:
    size = HandSize(0.18, 0.08, side)
    model = build_scene(task_by_name("cup-drink"), size).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    person = ArmGeometry(size)
    shoulder = person.shoulder()
    eyes = eyes_of(model, data)
    assert eyes[:2] == pytest.approx([shoulder[0], 0.0], abs=1e-9)
    assert eyes[2] - shoulder[2] == pytest.approx(0.118 * person.stature)


def test_a_hand_without_a_person_is_seen_from_where_one_would_sit() -> None:
    model = build_scene("cube", base="free").compile()
    seated = build_scene("cube").compile()
    found = []
    for each in (model, seated):
        data = mujoco.MjData(each)
        mujoco.mj_kinematics(each, data)
        found.append(eyes_of(each, data))
    np.testing.assert_allclose(found[0], found[1], atol=0.06)


def test_the_line_of_sight_goes_from_the_eyes_to_the_hand(grasp: Clip) -> None:
    data = mujoco.MjData(grasp.model)
    for qpos in grasp.qpos[[0, -1]]:
        data.qpos[:] = qpos
        mujoco.mj_kinematics(grasp.model, data)
        camera = Camera(grasp.model, data, "chair")
        camera.aim(grasp.model, data, 0.0)
        azimuth, elevation = np.deg2rad([camera.view.azimuth, camera.view.elevation])
        forward = np.array(
            [
                np.cos(azimuth) * np.cos(elevation),
                np.sin(azimuth) * np.cos(elevation),
                np.sin(elevation),
            ]
        )
        eyes = eyes_of(grasp.model, data)
        across = np.cross(forward, camera.view.lookat - eyes)
        assert np.linalg.norm(across) < 1e-6
        assert np.linalg.norm(camera.view.lookat - data.body("middle_proximal").xpos) < 0.08
        far = np.linalg.norm(camera.view.lookat - eyes)
        assert 0.22 < camera.view.distance < far, "between the eyes and the hand"


def test_directions() -> None:
    assert direction_deg(np.zeros(3), np.array([1.0, 0, 0])) == pytest.approx((0, 0))
    assert direction_deg(np.zeros(3), np.array([0, 1.0, -1.0])) == pytest.approx((90, -45))


def test_a_hand_alone_has_a_view_from_the_chair(ball: mujoco.MjModel) -> None:
    data = mujoco.MjData(ball)
    mujoco.mj_kinematics(ball, data)
    camera = Camera(ball, data, "chair")
    camera.aim(ball, data, 1.0)
    assert (camera.view.azimuth, camera.view.elevation) == (0.0, -35.0)
