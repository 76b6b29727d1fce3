"""The hand as an MJCF file that plain MuJoCo loads, with named postures as keyframes."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import re
from collections.abc import Mapping
from pathlib import Path

import mujoco

from handsim.disk import naming
from handsim.files import write_text
from handsim.hand.eigengrasps import eigengrasp_postures
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.hand.postures import POSTURES
from handsim.joints import JOINT_INDEX
from handsim.types import Array, HandSize


def add_keyframes(spec: mujoco.MjSpec, postures: Mapping[str, Array]) -> None:
    """Add postures, (22,) [rad] each, as keyframes to a hand that stands alone.

    Their joint positions and the actuators' targets are the posture.
    """
    order = [JOINT_INDEX[joint.name] for joint in spec.joints]
    for name, q in postures.items():
        spec.add_key(name=name, qpos=q[order], ctrl=q)


def write_hand(size: HandSize, folder: Path) -> Path:
    """Write ``right_hand.xml`` or ``left_hand.xml``, with `POSTURES` and eigengrasps as keyframes.

    Plain MuJoCo loads it. The folder is made if it is not there.

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
    spec = build_hand(size)
    add_keyframes(spec, {**POSTURES, **eigengrasp_postures(HandModel.from_spec(spec).penetration)})
    return write_model(spec, Path(folder) / f"{size.side}_hand.xml")


def write_model(spec: mujoco.MjSpec, path: Path) -> Path:
    """Compile a model and write it as a file that plain MuJoCo loads; return the file.

    Raises
    ------
    FileError
        If its folder cannot be made, or the file not written.
    """
    spec.compile()
    with naming(path.parent, "made"):
        path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, _with_position_actuators(spec.to_xml()))
    return path


def _with_position_actuators(xml: str) -> str:
    """Write actuators as MuJoCo's shortcut: easier to read, and understood by older versions."""
    general = re.compile(
        r'<general (.*?)(?: input="pos")? biastype="affine"'
        r' gainprm="(\S+)" biasprm="0 -\2 -(\S+)"/>'
    )
    return general.sub(r'<position \1 kp="\2" kv="\3"/>', xml)
