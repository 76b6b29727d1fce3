"""Contact sheets for checking models by eye: hands, keyframes, the arm, grasps, a robot hand.

``python -m handsim.viewing.contact_sheets hands|keyframes|arm|grasps|retargeting FILE.png``; the
last needs a robot hand: ``--robot FILE.xml --palm NAME --fingertips thumb=NAME index=NAME ...``.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from handsim.files import data_folder
from handsim.grasping.plan import Pose
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.rollout.forearm import Wrist
from handsim.hand.eigengrasps import eigengrasp_postures
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.hand.population import PRESETS
from handsim.hand.postures import POSTURES
from handsim.joints import JOINT_NAMES
from handsim.recordings.folder import read_recordings
from handsim.recordings.recording import Recording
from handsim.retargeting.retarget import Retargeter, human_hand
from handsim.retargeting.robot_hand import RobotHand
from handsim.tasks.scene import build_scene
from handsim.tasks.table_one import TASKS
from handsim.tasks.task import Task
from handsim.types import Array, Frame, Side
from handsim.viewing.film.offscreen import Offscreen, open_offscreen
from handsim.viewing.film.posture_clips import posture_model
from handsim.viewing.film.video import contact_sheet, write_image
from handsim.viewing.stage.lighting import light_any_hand, light_from_the_camera

_AXIS_COLOURS = ([0.85, 0.2, 0.15, 1], [0.2, 0.65, 0.2, 1], [0.15, 0.35, 0.85, 1])
_BEFORE = 0.35
"""Distance of the hand from the grasp, as a fraction of its approach."""


@dataclass(frozen=True)
class _Look:
    """A camera about a point: azimuth and elevation [deg], distance [m]."""

    azimuth: float
    elevation: float = -8.0
    distance: float = 0.42
    target: tuple[float, float, float] = (0.0, 0.0, 0.08)

    def camera(self) -> mujoco.MjvCamera:
        view = mujoco.MjvCamera()
        view.azimuth, view.elevation, view.distance = self.azimuth, self.elevation, self.distance
        view.lookat[:] = self.target
        return view


def hand_sheet(presets: Sequence[str] = tuple(PRESETS)) -> Frame:
    """Return hands of all presets, to one scale: palm, back, thumb's side, fist; right, then left.

    Parameters
    ----------
    presets
        One row each.
    """
    frames: list[Frame] = []
    labels: list[str] = []
    with open_offscreen(160, 200) as offscreen:
        for name in presets:
            for side in ("right", "left"):
                frames += _four_views(offscreen, name, side)
                labels += [f"{name} {side}", "", "", ""]
    return contact_sheet(frames, labels, columns=8)


def _four_views(offscreen: Offscreen, preset: str, side: Side) -> list[Frame]:
    model = posture_model(replace(PRESETS[preset], side=side))
    thumb = 1 if side == "right" else -1
    looks = (
        ("flat", _Look(180)),
        ("flat", _Look(0)),
        ("rest", _Look(-90 * thumb)),
        ("fist", _Look(-140 * thumb, -15)),
    )
    return _postures(offscreen, model, [(POSTURES[name], look) for name, look in looks])


def _postures(
    offscreen: Offscreen, model: mujoco.MjModel, shown: Sequence[tuple[Array, _Look]]
) -> list[Frame]:
    """Draw postures, (22,) [rad] each, of an upright hand."""
    light_from_the_camera(model)  # some are seen from the back
    scene, data = offscreen.add(model), mujoco.MjData(model)
    index = [model.joint(name).qposadr[0] for name in JOINT_NAMES]
    frames: list[Frame] = []
    for q, look in shown:
        data.qpos[index] = q
        mujoco.mj_forward(model, data)
        frames.append(scene.draw(data, look.camera()))
    return frames


def keyframe_sheet() -> Frame:
    """Return the keyframes of the right hand, the flat one from the palm and from the back."""
    eigengrasps = eigengrasp_postures(HandModel.from_spec(build_hand()).penetration)
    postures = {**POSTURES, **eigengrasps}
    oblique = _Look(-125, -12)
    shown = [(POSTURES["flat"], _Look(180)), (POSTURES["flat"], _Look(0))]
    shown += [(q, oblique) for name, q in postures.items() if name != "flat"]
    labels = ["flat: palm", "flat: back", *(name for name in postures if name != "flat")]
    with open_offscreen(300, 300) as offscreen:
        frames = _postures(offscreen, posture_model(), shown)
    return contact_sheet(frames, labels, columns=4)


def arm_sheet() -> Frame:
    """Return the keyframes of the right arm at the table, from the front and from its side."""
    model = mujoco.MjModel.from_xml_path(str(data_folder("models") / "arm" / "scene_right.xml"))
    looks = (
        _Look(155, -18, 1.35, (-0.27, -0.05, 0.12)),
        _Look(62, -25, 1.35, (-0.27, -0.05, 0.12)),
    )
    names = [model.key(i).name for i in range(model.nkey)]
    frames: list[Frame] = []
    with open_offscreen(300, 280) as offscreen:
        scene, data = offscreen.add(model), mujoco.MjData(model)
        for look in looks:
            for i in range(model.nkey):
                mujoco.mj_resetDataKeyframe(model, data, i)
                mujoco.mj_forward(model, data)
                frames.append(scene.draw(data, look.camera()))
    return contact_sheet(frames, names + [""] * len(names), columns=len(names))


def grasp_sheet(tasks: Sequence[Task] = TASKS) -> Frame:
    """Return the grasp frame of each task with the open hand on its way to it.

    Red: along the opposition of thumb and fingers; blue: against the approach. The posture is the
    demonstrator's of largest aperture.

    Parameters
    ----------
    tasks
        One picture each.
    """
    hand = HandModel.from_spec(build_hand())
    with open_offscreen(320, 280) as offscreen:
        frames = [_grasp_frame(offscreen, task, hand) for task in tasks]
    return contact_sheet(frames, [f"{task.number} {task.name}" for task in tasks], columns=6)


def _grasp_frame(offscreen: Offscreen, task: Task, hand: HandModel) -> Frame:
    spec = build_scene(task, base="free")  # put where the grasp has it
    _show_axes(spec)
    scene_hand = HandModel.from_spec(spec)
    model, data = scene_hand.model, scene_hand.data
    mujoco.mj_forward(model, data)
    plan, q_open = scripted_plan(task, hand)
    body = data.body("object")
    palm = Pose(body.xpos.copy(), body.xquat.copy()) @ plan.palm.moved(_BEFORE * plan.retreat)
    pos, quat = Wrist(hand.model).forearm(palm.pos, palm.quat, q_open)
    start = model.joint("forearm").qposadr[0]
    data.qpos[start : start + 7] = [*pos, *quat]
    scene_hand.set_posture(q_open)
    target = data.site("grasp").xpos
    # From beside the forearm on the thumb's side: the opening of the hand is seen from there.
    arm = data.body("forearm").xpos - target
    across = data.body("thumb_distal").xpos - data.body("little_distal").xpos
    aside = np.array([-arm[1], arm[0]])
    aside *= np.sign(aside @ across[:2]) / np.linalg.norm(aside)
    x, y = aside - 0.5 * arm[:2] / np.linalg.norm(arm[:2])
    look = _Look(float(np.rad2deg(np.arctan2(-y, -x))), -25, 0.45, tuple(target))
    return offscreen.add(model).draw(data, look.camera())


def _show_axes(spec: mujoco.MjSpec) -> None:
    """Draw the grasp frame as three rods at its site, without mass and contact."""
    site = spec.site("grasp")
    frame = site.parent.add_frame(pos=site.pos, quat=site.quat)
    for axis, colour in zip(np.eye(3), _AXIS_COLOURS, strict=True):
        rod = site.parent.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[0, 0, 0, *(0.07 * axis)],
            size=[0.0025, 0, 0],
            rgba=colour,
            contype=0,
            conaffinity=0,
            mass=0,
            group=2,
        )
        rod.set_frame(frame)


def retargeting_sheet(
    source: Path, palm: str, fingertips: Mapping[str, str], recording: Recording, n: int = 6
) -> Frame:
    """Return postures along a recording, the human hand over the robot hand, to one scale.

    Parameters
    ----------
    source, palm, fingertips
        As `handsim.retargeting.robot_hand.RobotHand` takes them.
    recording
        Its person's hand is drawn, the wrist straight: it is not mapped.
    n
        Postures.
    """
    robot = RobotHand(source, palm, fingertips)  # pyright: ignore[reportArgumentType]
    chosen = np.linspace(0, len(recording.q) - 1, n).round().astype(int)
    moved = Retargeter(robot, recording.hand).retarget(recording.q)
    human = human_hand(recording.hand)
    glove = [JOINT_NAMES.index(name) for name in human.joint_names]
    frames: list[Frame] = []
    with open_offscreen(300, 280) as offscreen:
        for spec, hand, positions in (
            (build_hand(recording.hand), human, recording.q[:, glove]),
            (robot.spec.copy(), robot, moved.positions),
        ):
            frames += _by_the_palm(offscreen, spec, hand, positions[chosen])
    times = recording.time[chosen] - recording.time[0]
    return contact_sheet(frames, [f"{time:.2f} s" for time in times] + [""] * n, columns=n)


def _by_the_palm(
    offscreen: Offscreen, spec: mujoco.MjSpec, hand: RobotHand, positions: Array
) -> list[Frame]:
    """Draw a hand from the thumb's side, its fingers to the left."""
    pos, axes = hand.palm_pose()
    back = np.array([0.35, 0.85, -0.3])
    back /= np.linalg.norm(back)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    looking = axes @ np.column_stack([right, np.cross(back, right), back])
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, looking.ravel())
    middle = pos + axes @ [0.09, 0.0, -0.03]
    spec.worldbody.add_camera(
        name="beside_the_palm", pos=middle + 0.6 * axes @ back, quat=quat, fovy=30
    )
    light_any_hand(spec)
    model = spec.compile()
    scene, data = offscreen.add(model), mujoco.MjData(model)
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
    camera.fixedcamid = model.camera("beside_the_palm").id
    index = [model.joint(name).qposadr[0] for name in hand.joint_names]
    frames: list[Frame] = []
    for at in positions:
        data.qpos[index] = at
        mujoco.mj_forward(model, data)
        frames.append(scene.draw(data, camera))
    return frames


def main() -> None:
    """Draw the sheet named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sheet", choices=("hands", "keyframes", "arm", "grasps", "retargeting"))
    parser.add_argument("file", type=Path)
    parser.add_argument("--robot", type=Path, help="MJCF of a robot hand")
    parser.add_argument("--palm", help="site or body, x distal and z dorsal")
    parser.add_argument("--fingertips", nargs="+", default=[], metavar="FINGER=NAME")
    parser.add_argument("--recording", default="tall-glass-drink", help="built-in experiment")
    given = parser.parse_args()
    if given.sheet == "retargeting":
        if not (given.robot and given.palm and given.fingertips):
            parser.error("a robot hand is needed: --robot, --palm and --fingertips")
        recordings = read_recordings(data_folder("assets") / "experiments")
        recording = next((r for r in recordings if r.name == given.recording), None)
        if recording is None:
            parser.error(f"no built-in experiment '{given.recording}'")
        fingertips = dict(pair.split("=", 1) for pair in given.fingertips)
        picture = retargeting_sheet(given.robot, given.palm, fingertips, recording)
    else:
        draw = {
            "hands": hand_sheet,
            "keyframes": keyframe_sheet,
            "arm": arm_sheet,
            "grasps": grasp_sheet,
        }
        picture = draw[given.sheet]()
    write_image(picture, given.file)


if __name__ == "__main__":
    main()
