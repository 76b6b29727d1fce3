"""A mount of limited force that carries a robot hand, as the flange of an arm for it does.

Six servos pull the hand's base to where its palm is to be, along and about the axes of the palm
that is wanted: springs with dampers, none stronger than its limit. Table and object push back.
The arm is one with a payload of 5 kg, such as Universal Robots' UR5e. It carries itself; the hand
is a load.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Iterator

import mujoco
import numpy as np

from handsim.errors import InputError

PAYLOAD = 5.0
"""Heaviest hand [kg], by the UR5e's technical data."""
MOST_FORCE = 150.0
"""Of each servo along an axis [N]: what the UR5's manual promises not to exceed, and ISO
10218-1:2006 set for arms beside people. Stretched out to 0.85 m, the shoulder's 150 N m do 176 N.
"""
MOST_TORQUE = 28.0
"""Of each servo about an axis [N m]: what the UR5e's wrist joints can do by its technical data."""
STIFFNESS = 5e4
"""Along an axis [N/m]. Assumed: strain-wave gears of the UR5e's size have some 3e4 N m/rad in their
makers' catalogues, and base, shoulder and elbow of 0.5 m give way together."""
TURN_STIFFNESS = 3e3
"""About an axis [N m/rad]; assumed as that of the smaller gears of the wrist."""
MASS = 5.0
"""That the arm has at its flange [kg]: links of the wrist, 3 kg, and what is felt of the others and
of the motors through their gears; assumed."""
INERTIA = 0.1
"""The same about each axis [kg m^2]."""
LAG = 2.0 * float(np.sqrt(MASS / STIFFNESS))
"""Ratio of damping to stiffness of the servos along the axes [s], critical for the arm itself."""
TURN_LAG = 2.0 * float(np.sqrt(INERTIA / TURN_STIFFNESS))
"""The same about the axes [s]."""
LAGS = np.repeat([LAG, TURN_LAG], 3)
"""Controls that let the servos follow a velocity, relative to it (6,) [s]."""
NAMES = ("mount_x", "mount_y", "mount_z", "mount_turn_x", "mount_turn_y", "mount_turn_z")
"""Of the servos."""


def add_mount(spec: mujoco.MjSpec, hand: mujoco.MjModel) -> None:
    """Let servos pull the body ``forearm`` to ``forearm_target``, and let it carry a hand.

    Parameters
    ----------
    spec
        A scene with both bodies, and the hand below ``forearm``, whose weight is compensated. That
        of its links is held by their servos, as controllers of such hands see to; it loads the
        mount all the same.
    hand
        The hand by itself.

    Raises
    ------
    InputError
        If the hand is heavier than `PAYLOAD`.
    """
    weight = float(hand.body_mass.sum())
    if weight > PAYLOAD:
        raise InputError(
            f"the hand weighs {weight:.3g} kg, more than the {PAYLOAD:g} kg that the mount "
            "carries; give --base free"
        )
    base, target = spec.body("forearm"), spec.body("forearm_target")
    for body in _fixed_to(base):
        body.gravcomp = 0.0
    links = float(hand.body_mass[hand.body_weldid != 0].sum())
    base.gravcomp = 1.0 - links / MASS  # their weight, which is compensated where they are
    base.explicitinertial = True  # without a position, XML would leave it out
    base.mass, base.inertia, base.ipos = MASS, np.full(3, INERTIA), np.zeros(3)
    for body in (base, target):
        body.add_site(name=f"{body.name}_flange", group=4)
    for i, name in enumerate(NAMES):
        along = i < 3
        stiffness = STIFFNESS if along else TURN_STIFFNESS
        most = MOST_FORCE if along else MOST_TORQUE
        spec.add_actuator(
            name=name,
            trntype=mujoco.mjtTrn.mjTRN_SITE,
            target=f"{base.name}_flange",
            refsite=f"{target.name}_flange",
            gear=np.eye(6)[i],
            gaintype=mujoco.mjtGain.mjGAIN_FIXED,
            gainprm=[stiffness] + [0.0] * 9,
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
            biasprm=[0.0, -stiffness, -stiffness * (LAG if along else TURN_LAG)] + [0.0] * 7,
            forcelimited=True,
            forcerange=[-most, most],
        )


def _fixed_to(body: mujoco.MjsBody) -> Iterator[mujoco.MjsBody]:
    """Yield all bodies below one that no joint moves against it."""
    for each in body.bodies:
        if not each.joints:
            yield each
            yield from _fixed_to(each)
