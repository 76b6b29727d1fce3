"""Force closure of a grasp: how large a disturbance its contacts resist from any direction."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import mujoco
import numpy as np
from scipy.spatial import ConvexHull, QhullError

from handsim.grasping.rollout.record import Rollout
from handsim.types import Array

EDGES = 8
"""Edges of the pyramid that approximates a friction cone."""


def ferrari_canny(
    points: Array, normals: Array, friction: float, torsion: float, centre: Array, scale: float
) -> float:
    """Return epsilon: the radius of the largest ball of wrenches that the contacts resist.

    The contacts' normal forces sum to 1 (the L1 metric); torques are divided by ``scale`` [m]. 0
    means no force closure.

    Parameters
    ----------
    points, normals : (n, 3) [m], (n, 3)
        Contacts and the unit normals along which the hand pushes the object.
    friction
        Tangential coefficient.
    torsion
        Torsional coefficient [m]; 0 for hard fingers.
    centre : (3,) [m]
        About which torques are taken: the object's centre of mass.
    scale
        Length by which torques are divided, such as the greatest distance of a contact from the
        centre.

    References
    ----------
    C. Ferrari & J. Canny (1992), Planning optimal grasps, IEEE ICRA, 2290-2295.
    """
    wrenches: list[Array] = []
    for point, normal in zip(points, normals, strict=True):
        helper = np.eye(3)[np.argmin(np.abs(normal))]
        first = np.cross(normal, helper)
        first /= np.linalg.norm(first)
        second = np.cross(normal, first)
        arm = (point - centre) / scale
        for angle in 2 * np.pi * np.arange(EDGES) / EDGES:
            force = normal + friction * (np.cos(angle) * first + np.sin(angle) * second)
            wrenches.append(np.concatenate([force, np.cross(arm, force)]))
        for twist in (-torsion, torsion) if torsion else ():
            moment = np.cross(arm, normal) + twist / scale * normal
            wrenches.append(np.concatenate([normal, moment]))
    if len(wrenches) < 7:
        return 0.0
    try:
        hull = ConvexHull(np.array(wrenches))
    except QhullError:  # all wrenches in one plane: no closure
        return 0.0
    return float(max(0.0, -hull.equations[:, -1].max()))


def grasp_quality(rollout: Rollout) -> float:
    """Return epsilon of the contacts of hand and object at the end of a run."""
    model = rollout.model()
    data = mujoco.MjData(model)
    data.qpos[:], data.ctrl[:] = rollout.qpos[-1], rollout.ctrl[-1]
    data.mocap_pos[:], data.mocap_quat[:] = rollout.mocap_pos[-1], rollout.mocap_quat[-1]
    mujoco.mj_forward(model, data)
    root = model.body_rootid[model.geom_bodyid]
    object_id, hand = model.body("object").id, model.body_rootid[model.body("forearm").id]
    contact = data.contact
    first, second = root[contact.geom[:, 0]], root[contact.geom[:, 1]]
    pushed = ((first == hand) & (second == object_id)) | ((first == object_id) & (second == hand))
    if not pushed.any():
        return 0.0
    # MuJoCo's normal points from the first geom to the second.
    sign = np.where(second[pushed] == object_id, 1.0, -1.0)
    points = contact.pos[pushed]
    centre = data.subtree_com[object_id]
    return ferrari_canny(
        points,
        sign[:, None] * contact.frame[pushed, :3],
        friction=float(contact.friction[pushed, 0].min()),
        torsion=float(contact.friction[pushed, 2].min()),
        centre=centre,
        scale=float(np.linalg.norm(points - centre, axis=1).max()),
    )
