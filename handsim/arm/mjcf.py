"""The arm as a MuJoCo model that carries the hand: 5 hinges and 5 position actuators.

World frame: z up, table top at z = 0; the person sits at -x and looks to +x, right is -y. Bodies
``upper_arm`` (three hinges at the shoulder), ``lower_arm`` (the elbow) and the hand's own
``forearm``, which pronation and supination turn. Their frames in the zero posture, in which the arm
hangs: x ahead, y left, z up. Flesh of the arm is seen only; the hand's stub of a forearm touches
things, as before.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import replace

import mujoco
import numpy as np

from handsim.arm._arm_parts import (
    FLAT,
    add_arm_actuators,
    add_arm_defaults,
    add_hinge,
    add_looks,
    add_trunk,
    set_inertia,
    stub_inertia,
)
from handsim.arm.arm_geometry import ArmGeometry, Seat
from handsim.arm.arm_joints import N_ARM
from handsim.errors import InputError
from handsim.hand.mjcf import add_skin_material, mount_hand
from handsim.physics import set_physics
from handsim.types import MEDIAN_HAND, Array, HandSize

STIFFNESS_RANGE = (0.05, 20.0)
"""Factors on the arm's stiffness that can be asked for."""


def build_arm(size: HandSize = MEDIAN_HAND, seat: Seat | None = None) -> mujoco.MjSpec:
    """Build arm and hand alone, the shoulder where it is in the world: nq = nv = nu = 27.

    Parameters
    ----------
    size
        Size and side of the hand; the arm is that of the person with such a hand.
    seat
        Where the person sits.

    Raises
    ------
    InputError
        If the size is outside what can be built.
    """
    spec = mujoco.MjSpec()
    spec.modelname = f"{size.side}_arm"
    set_physics(spec)
    attach_arm(spec, size, seat)
    return spec


def attach_arm(
    scene: mujoco.MjSpec,
    size: HandSize = MEDIAN_HAND,
    seat: Seat | None = None,
    *,
    stiffness: float = 1.0,
    trunk: bool = True,
    prefix: str = "",
) -> None:
    """Add a person's arm with the hand on it to a scene.

    Its 5 coordinates come before the hand's 22, as do its actuators. Its weight is carried
    (``gravcomp``), as a person does without thought. The options of `set_physics` are set.

    Parameters
    ----------
    scene
        Changed in place; compile it afterwards.
    size
        Of the hand, which tells the arm's.
    seat
        Where the person sits.
    stiffness
        Factor on the gains of the arm's actuators: 0.3 is a relaxed arm.
    trunk
        Whether chest and neck are shown.
    prefix
        Put before all names of arm and hand.

    Raises
    ------
    InputError
        If size or stiffness is outside what can be built, or the scene has an arm or a hand of
        these names already.
    """
    low, high = STIFFNESS_RANGE
    if not low <= stiffness <= high:
        raise InputError(f"stiffness {stiffness:g} of the arm is outside {low:g} to {high:g}")
    if scene.body(f"{prefix}upper_arm") is not None:
        raise InputError(f"the scene has a body '{prefix}upper_arm' already; give a prefix")
    geometry = ArmGeometry(size)
    mirror = 1.0 if size.side == "right" else -1.0
    shoulder = geometry.shoulder(seat)
    set_physics(scene)
    kind = add_arm_defaults(scene, size, prefix)
    upper, lower = _add_bones(scene, geometry, shoulder, mirror, prefix, kind)
    add_arm_actuators(scene, geometry, stiffness, prefix)
    forearm = mount_hand(
        scene, size, lower.name, [0, 0, -geometry.forearm], _flat_quat(mirror), prefix=prefix
    )
    add_hinge(scene, forearm, N_ARM - 1, mirror, prefix)
    stub = scene.geom(f"{prefix}forearm_geom")
    set_inertia(lower, geometry.forearm_inertia.without(stub_inertia(stub, geometry.forearm)))
    _add_shirt(scene, prefix)
    add_looks(scene, upper, lower, forearm, geometry, prefix)
    if trunk:
        add_trunk(scene, shoulder, geometry, mirror, prefix)


def build_trunk(size: HandSize = MEDIAN_HAND) -> mujoco.MjSpec:
    """Build what is between a person's two arms, seen only: chest and neck, behind the table.

    Parameters
    ----------
    size
        Of a hand; its side does not matter.

    Raises
    ------
    InputError
        If the size is outside what can be built.
    """
    right = replace(size, side="right")
    geometry = ArmGeometry(right)
    spec = mujoco.MjSpec()
    spec.modelname = "trunk"
    set_physics(spec)
    add_skin_material(spec)
    _add_shirt(spec, "")
    add_arm_defaults(spec, right, "")
    add_trunk(spec, geometry.shoulder(None), geometry, 1.0, "", other_arm=False)
    return spec


def _add_shirt(scene: mujoco.MjSpec, prefix: str) -> None:
    scene.add_material(name=f"{prefix}shirt", rgba=[0.42, 0.50, 0.60, 1], specular=0.05)


def _add_bones(
    scene: mujoco.MjSpec,
    geometry: ArmGeometry,
    shoulder: Array,
    mirror: float,
    prefix: str,
    kind: str,
) -> tuple[mujoco.MjsBody, mujoco.MjsBody]:
    """Add the bodies of upper arm and elbow with their hinges."""
    upper = scene.worldbody.add_body(
        name=f"{prefix}upper_arm", pos=shoulder, gravcomp=1.0, childclass=kind
    )
    for index in range(3):
        add_hinge(scene, upper, index, mirror, prefix)
    set_inertia(upper, geometry.upper_arm_inertia)
    lower = upper.add_body(name=f"{prefix}lower_arm", pos=[0, 0, -geometry.upper_arm], gravcomp=1.0)
    add_hinge(scene, lower, 3, mirror, prefix)
    return upper, lower


def _flat_quat(mirror: float) -> Array:
    """Return the orientation of the hand in the hanging forearm, (4,)."""
    flip = np.array([1.0, mirror, 1.0])
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, (flip[:, None] * FLAT * flip).ravel())
    return quat
