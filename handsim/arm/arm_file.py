"""Arm and hand as MJCF files that plain MuJoCo loads, with postures as keyframes."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

from handsim.arm.arm_joints import ARM_JOINT_NAMES, CHAIN_NAMES, N_ARM
from handsim.arm.mjcf import build_arm, build_trunk
from handsim.arm.reaching_arm import ReachingArm
from handsim.hand.export import write_model
from handsim.hand.postures import POSTURES
from handsim.hand.scene_files import Keyframes, Surroundings, write_beside
from handsim.joints import JOINT_INDEX
from handsim.types import Array, HandSize

READY: MappingProxyType[str, tuple[tuple[float, float, float], tuple[float, ...]]] = (
    MappingProxyType(
        {
            "over_table": ((-0.17, -0.17, 0.085), (0.9659, 0.0, 0.0, 0.2588)),
            "thumb_up": ((-0.12, -0.10, 0.07), (0.6830, 0.6830, 0.1830, 0.1830)),
            "raised": ((-0.15, -0.10, 0.20), (0.6830, 0.6830, 0.1830, 0.1830)),
        }
    )
)
"""Keyframes beside ``hanging``: wrist [m] and orientation of a right palm, of median size.

The hand points 30 deg to the left; palm down over the table, and thumb up. Other sizes have it in
proportion, left hands mirrored.
"""
_MEDIAN_LENGTH = 0.1933
BESIDE = 0.1
"""How much farther from the middle the keyframes of two arms are, which would meet there [m]."""

SURROUNDINGS = Surroundings(
    kind="arm",
    root="upper_arm",
    apart=0.0,  # shoulders are beside the middle already
    centre=(-0.25, -0.1, 0.12),
    extent=0.6,
    azimuth=155,
    elevation=-22,
    ambient=0.35,
    diffuse=0.35,
    assets=('<material name="table" rgba="0.80 0.76 0.70 1"/>',),
    bodies=(
        '<geom name="table" type="box" pos="0.105 0 -0.0151" size="0.4 0.45 0.015"'
        ' material="table"/>',
    ),
    include="trunk.xml",
)
"""A table before the person."""


def ready_postures(size: HandSize, aside: float = 0.0) -> Mapping[str, Array]:
    """Return the keyframes' angles of arm and wrist, (7,) [rad] each, by name.

    Parameters
    ----------
    size
    aside
        How much farther from the middle all but ``hanging`` are [m], of a hand of median size.

    Raises
    ------
    InputError
        If the size is outside what can be built.
    """
    arm = ReachingArm(size)
    flip = np.ones(3) if size.side == "right" else np.array([1.0, -1.0, 1.0])
    turn = np.ones(4) if size.side == "right" else np.array([1.0, -1.0, 1.0, -1.0])
    found = {"hanging": np.zeros(len(CHAIN_NAMES))}
    for name, (pos, quat) in READY.items():
        scaled = flip * (np.array(pos) - [0.0, aside, 0.0]) * size.length / _MEDIAN_LENGTH
        made = arm.posture(scaled[None], (turn * np.array(quat))[None])
        found[name] = np.concatenate([made.arm[0], made.wrist[0]])
    return found


def keyframes_of(size: HandSize, aside: float = 0.0) -> Keyframes:
    """Return keyframes of the arm that `write_arm` writes, by name.

    Parameters
    ----------
    size, aside
        As in `ready_postures`.

    Raises
    ------
    InputError
        If the size is outside what can be built.
    """
    order = [joint.name for joint in build_arm(size).joints]
    found: dict[str, tuple[Array, Array]] = {}
    for name, chain in ready_postures(size, aside).items():
        hand = POSTURES["rest"].copy()
        hand[[JOINT_INDEX[joint] for joint in CHAIN_NAMES[N_ARM:]]] = chain[N_ARM:]
        of_joint = dict(zip(ARM_JOINT_NAMES, chain[:N_ARM], strict=True))
        of_joint |= {joint: hand[i] for joint, i in JOINT_INDEX.items()}
        qpos = np.array([of_joint[joint] for joint in order])
        found[name] = qpos, np.concatenate([chain[:N_ARM], hand])
    return found


def write_arm(size: HandSize, folder: Path) -> Path:
    """Write the arm of a person at a table, ``right_arm.xml``, and beside it what shows it.

    These are ``keyframes_right.xml`` and ``scene_right.xml``, which includes both and has the
    table. Plain MuJoCo loads the arm and its scene. The folder is made if it is not there.

    Returns
    -------
    The file of the arm.

    Raises
    ------
    InputError
        If the size is outside what can be built.
    FileError
        If the folder cannot be made or written.
    """
    folder = Path(folder)
    keyframes = keyframes_of(size)
    written = write_model(build_arm(size), folder / f"{size.side}_arm.xml")
    write_beside(folder, size.side, SURROUNDINGS, keyframes)
    return written


def write_trunk(size: HandSize, folder: Path) -> Path:
    """Write ``trunk.xml``: chest and neck between a person's two arms, seen only.

    Returns
    -------
    The file.

    Raises
    ------
    InputError, FileError
        As `write_arm`.
    """
    return write_model(build_trunk(size), Path(folder) / "trunk.xml")
