"""Which joints of a model are those of the fingers, and whether they can be worked with."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from handsim.errors import InputError, UnknownNameError
from handsim.joints import Finger
from handsim.robot_hands.hand_frames import AttachedFrame
from handsim.types import Array

_SITE, _BODY = mujoco.mjtObj.mjOBJ_SITE.value, mujoco.mjtObj.mjOBJ_BODY.value
_HINGE, _SLIDE = mujoco.mjtJoint.mjJNT_HINGE.value, mujoco.mjtJoint.mjJNT_SLIDE.value
_CONNECT, _WELD = mujoco.mjtEq.mjEQ_CONNECT.value, mujoco.mjtEq.mjEQ_WELD.value
_TENDON = mujoco.mjtEq.mjEQ_TENDON.value

Place = tuple[int, Array, Array]
"""A body, and the origin (3,) [m] and axes (3, 3) of a frame in it."""


def place_of(model: mujoco.MjModel, frame: AttachedFrame | str) -> Place:
    """Return the body of a frame, and its pose in it.

    Raises
    ------
    UnknownNameError
        If there is no site or body of its name.
    """
    wanted = AttachedFrame(frame) if isinstance(frame, str) else frame
    turn = Rotation.from_quat(wanted.quat, scalar_first=True)
    pos = np.array(wanted.pos, dtype=float)
    site = mujoco.mj_name2id(model, _SITE, wanted.name)
    if site >= 0:
        within = Rotation.from_quat(model.site_quat[site], scalar_first=True)
        pos, turn = model.site_pos[site] + within.apply(pos), within * turn
        return int(model.site_bodyid[site]), pos, turn.as_matrix()
    body = mujoco.mj_name2id(model, _BODY, wanted.name)
    if body < 0:
        sites = [model.site(i).name for i in range(model.nsite)]
        bodies = [model.body(i).name for i in range(model.nbody)]
        raise UnknownNameError("site or body", wanted.name, (*sites, *bodies))
    return body, pos, turn.as_matrix()


def ancestors(model: mujoco.MjModel, body: int) -> list[int]:
    """Return a body and all that carry it, up to the world."""
    chain = [body]
    while chain[-1] > 0:
        chain.append(int(model.body_parentid[chain[-1]]))
    return chain


def joints_between(model: mujoco.MjModel, first: int, second: int) -> list[int]:
    """Return the joints that move one body in the frame of another."""
    apart = set(ancestors(model, first)) ^ set(ancestors(model, second))
    return [j for j in range(model.njnt) if model.jnt_bodyid[j] in apart]


def own_joints(
    model: mujoco.MjModel,
    fingers: Sequence[Finger],
    ways: Sequence[list[int]],
    knuckles: Mapping[Finger, str],
) -> list[list[int]]:
    """Return the joints of each finger, from its knuckle to its tip."""
    own: list[list[int]] = []
    for i, (finger, way) in enumerate(zip(fingers, ways, strict=True)):
        if finger in knuckles:
            names = tuple(model.joint(j).name for j in way)
            if knuckles[finger] not in names:
                raise UnknownNameError(f"joint of the {finger}", knuckles[finger], names)
            own.append(way[names.index(knuckles[finger]) :])
            continue
        shared = set[int]().union(*ways[:i], *ways[i + 1 :])
        own.append([j for j in way if j not in shared])
        if not own[i]:
            raise InputError(
                f"fingertip of the {finger} moves with no joint of its own; "
                "name a site or body further out"
            )
    return own


def check_joints(model: mujoco.MjModel, joints: Sequence[int]) -> None:
    """Refuse what coordinates and couplings here cannot express."""
    for j in joints:
        if model.jnt_type[j] not in (_HINGE, _SLIDE):
            raise InputError(
                f"joint '{model.joint(j).name}' is neither a hinge nor a slide; "
                "split it into hinges"
            )
    moved = {int(model.jnt_bodyid[j]) for j in joints}
    for i in np.flatnonzero(model.eq_active0):
        kind, ends = model.eq_type[i], (model.eq_obj1id[i], model.eq_obj2id[i])
        if kind in (_CONNECT, _WELD):
            sites = model.eq_objtype[i] == _SITE
            bodies = {int(model.site_bodyid[end] if sites else end) for end in ends}
            bound = any(moved & set(ancestors(model, body)) for body in bodies)
        else:
            bound = kind == _TENDON
        if bound:
            raise InputError(
                f"equality '{model.equality(i).name}' binds the fingers otherwise than "
                "joint to joint; take it out of the file or give it active='false'"
            )
