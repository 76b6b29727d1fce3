"""Arm and hand as an MJCF file that plain MuJoCo loads, with postures as keyframes."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np

from handsim.arm.arm_joints import ARM_JOINT_NAMES, CHAIN_NAMES, N_ARM
from handsim.arm.mjcf import build_arm
from handsim.arm.reaching_arm import ReachingArm
from handsim.hand.export import write_model
from handsim.hand.postures import POSTURES
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


def ready_postures(size: HandSize) -> Mapping[str, Array]:
    """Return the keyframes' angles of arm and wrist, (7,) [rad] each, by name."""
    arm = ReachingArm(size)
    flip = np.ones(3) if size.side == "right" else np.array([1.0, -1.0, 1.0])
    turn = np.ones(4) if size.side == "right" else np.array([1.0, -1.0, 1.0, -1.0])
    found = {"hanging": np.zeros(len(CHAIN_NAMES))}
    for name, (pos, quat) in READY.items():
        scaled = flip * np.array(pos) * size.length / _MEDIAN_LENGTH
        made = arm.posture(scaled[None], (turn * np.array(quat))[None])
        found[name] = np.concatenate([made.arm[0], made.wrist[0]])
    return found


def write_arm(size: HandSize, folder: Path) -> Path:
    """Write ``right_arm.xml`` or ``left_arm.xml``, the person seated at the table.

    Plain MuJoCo loads it. The folder is made if it is not there. The table is not in it.

    Returns
    -------
    The file written.

    Raises
    ------
    InputError
        If the size is outside what can be built.
    FileError
        If the folder cannot be made or written.
    """
    spec = build_arm(size)
    relaxed = POSTURES["rest"]
    for name, chain in ready_postures(size).items():
        hand = relaxed.copy()
        hand[[JOINT_INDEX[joint] for joint in CHAIN_NAMES[N_ARM:]]] = chain[N_ARM:]
        of_joint = dict(zip(ARM_JOINT_NAMES, chain[:N_ARM], strict=True))
        of_joint |= {joint: hand[i] for joint, i in JOINT_INDEX.items()}
        qpos = [of_joint[joint.name] for joint in spec.joints]
        spec.add_key(name=name, qpos=qpos, ctrl=[*chain[:N_ARM], *hand])
    return write_model(spec, Path(folder) / f"{size.side}_arm.xml")
