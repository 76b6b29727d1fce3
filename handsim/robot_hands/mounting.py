"""A robot hand in a scene: on a free base that follows a mocap body, or fixed to a body."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import mujoco
import numpy as np
import numpy.typing as npt

from handsim.errors import InputError, UnknownNameError
from handsim.hand.mjcf import weld_to_mocap
from handsim.robot_hands.hand_frames import AttachedFrame
from handsim.silence import quiet_compile
from handsim.types import Array


def mount_robot_hand(
    scene: mujoco.MjSpec,
    hand: mujoco.MjSpec,
    palm: AttachedFrame,
    pos: npt.ArrayLike = (0.0, 0.0, 0.0),
    quat: npt.ArrayLike = (1.0, 0.0, 0.0, 0.0),
    *,
    body: str = "",
    prefix: str = "robot_",
) -> str:
    """Add a robot hand to a scene; return the name of the body that carries it.

    Parameters
    ----------
    scene
        Changed in place; compile it afterwards.
    hand
        As `handsim.RobotHand.spec`. It is copied.
    palm
        As `handsim.RobotHand.frames.palm`.
    pos, quat
        Pose of the palm's frame, reference posture: (3,) [m], (4,) w, x, y, z; in the world, or in
        ``body``.
    body
        The body that carries it. Empty: a free base that is welded to the mocap body
        ``{prefix}mount_target``, both with the pose that the palm is to have.
    prefix
        Put before all names of the hand.

    Raises
    ------
    InputError
        If the scene has a hand of these names already.
    UnknownNameError
        If the scene has no such body.
    """
    base = f"{prefix}mount"
    while any(f"{prefix}{other.name}" == base for other in hand.bodies):
        base += "_"
    if scene.body(base) is not None:
        raise InputError(f"the scene has a body '{base}' already; give another prefix")
    carrier = scene.worldbody if not body else scene.body(body)
    if carrier is None:
        raise UnknownNameError("body", body, tuple(other.name for other in scene.bodies))
    carried = carrier.add_body(name=base, pos=pos, quat=quat)
    if not body:
        target = f"{base}_target"
        scene.worldbody.add_body(name=target, pos=pos, quat=quat, mocap=True)
        carried.add_freejoint(name=base)
        weld_to_mocap(scene, f"{base}_weld", target, base)
        # A free body needs mass, and the hand's own is all in bodies that it carries.
        carried.mass, carried.inertia, carried.ipos = 1e-3, np.full(3, 1e-6), np.zeros(3)
        carried.explicitinertial = True  # without a position, XML would leave it out
    own = hand.copy()
    own.option = scene.option  # which count anyway; MuJoCo would warn of those that differ
    origin, turn = _inverse(own, palm)
    scene.attach(own, prefix=prefix, frame=carried.add_frame(pos=origin, quat=turn))
    return base


def _inverse(hand: mujoco.MjSpec, palm: AttachedFrame) -> tuple[Array, Array]:
    """Return the pose of the hand's world in the frame of its palm."""
    model = quiet_compile(hand)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE.value, palm.name)
    at = data.site(site) if site >= 0 else data.body(palm.name)
    pos, quat = np.empty(3), np.empty(4)
    within = np.empty(4)
    mujoco.mju_mat2Quat(within, at.xmat)
    mujoco.mju_mulPose(
        pos,
        quat,
        at.xpos,
        within,
        np.array(palm.pos, dtype=float),
        np.array(palm.quat, dtype=float),
    )
    origin, turn = np.empty(3), np.empty(4)
    mujoco.mju_negPose(origin, turn, pos, quat)
    return origin, turn
