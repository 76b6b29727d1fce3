"""A picture of a robot hand for its user to confirm: palm, fingertips, and how it moves.

Above, the open hand from four sides with the frames drawn in: x red, y green, z blue, long for the
palm, short for the fingertips. Below, postures of a person's hand, and the robot's under them.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Sequence

import mujoco
import numpy as np

from handsim.hand.postures import POSTURES
from handsim.retargeting.retarget import Retargeter
from handsim.retargeting.robot_hand import RobotHand
from handsim.robot_hands.hand_frames import AttachedFrame
from handsim.silence import quiet_compile
from handsim.types import Array, Frame
from handsim.viewing.film.offscreen import Offscreen, open_offscreen
from handsim.viewing.film.video import contact_sheet
from handsim.viewing.stage.lighting import light_any_hand

SHOWN = ("flat", "rest", "tripod", "fist")
"""Postures of the person that are drawn."""
_VIEWS = {  # from where, and what is up, in the frame of the palm
    "palm": ((0.0, 0.0, -1.0), (1.0, 0.0, 0.0)),
    "back": ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0)),
    "thumb's side": ((0.15, 1.0, 0.0), (1.0, 0.0, 0.0)),
    "oblique": ((-0.2, 0.8, -0.8), (1.0, 0.0, 0.0)),
}
_COLOURS = ((0.9, 0.15, 0.1, 1), (0.15, 0.7, 0.15, 1), (0.1, 0.3, 0.95, 1))
_SIZE = (300, 320)
"""Width and height of each picture [pixels]."""
_FOV = 30.0
"""Vertical field of view [deg]."""
_HIDDEN, _DRAWN = 5, 1
"""Groups of geoms: MuJoCo draws the first three."""


def robot_hand_sheet(robot: RobotHand) -> Frame:
    """Return the picture.

    Parameters
    ----------
    robot
    """
    retargeter = Retargeter(robot)
    postures = np.array([POSTURES[name] for name in SHOWN])
    moved = retargeter.retarget(postures, max_gain=np.inf)
    straight = robot.joint_positions(np.clip(robot.reference, robot.lower, robot.upper))
    human = retargeter.person.hand
    person = human.joint_positions(postures[:, retargeter.person.glove])
    mirrored = 1.0 if robot.side == "right" else -1.0
    labels = [*_VIEWS, *SHOWN, *(_said(e) for e in moved.opening_error)]
    with open_offscreen(*_SIZE) as offscreen:
        open_hand = [(straight, view) for view in _VIEWS]
        frames = _drawn(offscreen, robot, open_hand, mirrored, axes=True)
        frames += _drawn(offscreen, human, [(q, "oblique") for q in person], mirrored)
        frames += _drawn(offscreen, robot, [(q, "oblique") for q in moved.positions], mirrored)
    return contact_sheet(frames, labels, columns=len(_VIEWS))


def _said(errors: Array) -> str:
    return f"openings within {1e3 * errors.max():.0f} mm"


def _drawn(
    offscreen: Offscreen,
    hand: RobotHand,
    shown: Sequence[tuple[Array, str]],
    mirrored: float,
    axes: bool = False,
) -> list[Frame]:
    """Draw a hand in postures and from sides, its frames if wanted."""
    spec = hand.spec.copy()
    if axes:
        _show(spec, hand.frames.palm, 0.5 * float(hand.reach.mean()))
        for frame in hand.frames.fingertips.values():
            _show(spec, frame, 0.2 * float(hand.reach.mean()))
    pos, turned = hand.palm_pose()
    length = float(np.max(hand.roots[:, 0]) + hand.reach.mean())
    middle = pos + turned @ [0.55 * length, 0.0, -0.05 * length]
    for name, (towards, up) in _VIEWS.items():
        back = np.array(towards) * [1.0, mirrored, 1.0]
        back /= np.linalg.norm(back)
        right = np.cross(up, back)
        right /= np.linalg.norm(right)
        quat = np.empty(4)
        looking = turned @ np.column_stack([right, np.cross(back, right), back])
        mujoco.mju_mat2Quat(quat, looking.ravel())
        away = 0.9 * length / np.tan(np.deg2rad(_FOV / 2))
        spec.worldbody.add_camera(
            name=f"handsim {name}", pos=middle + away * turned @ back, quat=quat, fovy=_FOV
        )
    light_any_hand(spec)
    model = quiet_compile(spec)
    if axes or hand.frames.origin != "given":
        _show_each_link(model, hand.placeholders)
    scene, data = offscreen.add(model), mujoco.MjData(model)
    index = [model.joint(name).qposadr[0] for name in hand.joint_names]
    frames: list[Frame] = []
    for positions, name in shown:
        data.qpos[index] = positions
        mujoco.mj_forward(model, data)
        camera = mujoco.MjvCamera()
        camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
        camera.fixedcamid = model.camera(f"handsim {name}").id
        frames.append(scene.draw(data, camera))
    return frames


def _show(spec: mujoco.MjSpec, frame: AttachedFrame, length: float) -> None:
    """Draw a frame as three rods, without mass and contact."""
    site = spec.site(frame.name)
    body = spec.body(frame.name) if site is None else site.parent
    outer = body.add_frame()
    if site is not None:
        outer.pos, outer.quat = site.pos, site.quat
    inner = body.add_frame(pos=frame.pos, quat=frame.quat)
    inner.set_frame(outer)
    for axis, colour in zip(np.eye(3), _COLOURS, strict=True):
        rod = body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[0, 0, 0, *(length * axis)],
            size=[0.03 * length + 0.0008, 0, 0],
            rgba=colour,
            contype=0,
            conaffinity=0,
            mass=0,
            group=_DRAWN,
        )
        rod.set_frame(inner)


def _show_each_link(model: mujoco.MjModel, placeholders: frozenset[str]) -> None:
    """Draw what is made to be seen of each link, or else what touches."""
    mesh = mujoco.mjtGeom.mjGEOM_MESH.value
    touches = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    meshes = model.geom_type == mesh
    missing = np.array(
        [
            bool(meshes[g]) and model.mesh(int(model.geom_dataid[g])).name in placeholders
            for g in range(model.ngeom)
        ],
        dtype=bool,
    )
    seen = meshes & ~touches & ~missing & (model.geom_group < 3)
    bodies = set(model.geom_bodyid[seen].tolist())
    for g in np.flatnonzero(touches):
        # Fingertips of rubber are often in the file as what touches alone.
        covered = int(model.geom_bodyid[g]) in bodies
        hidden = covered and (not meshes[g] or model.geom_group[g] >= 3)
        model.geom_group[g] = _HIDDEN if hidden else _DRAWN
    model.geom_group[missing] = _HIDDEN
