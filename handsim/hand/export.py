"""The hand as MJCF files that plain MuJoCo loads, with named postures as keyframes."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import re
from pathlib import Path

import mujoco

from handsim.disk import naming
from handsim.files import write_text
from handsim.hand.eigengrasps import eigengrasp_postures
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.hand.postures import POSTURES
from handsim.hand.scene_files import Keyframes, Surroundings, write_beside
from handsim.joints import JOINT_INDEX
from handsim.types import HandSize

SURROUNDINGS = Surroundings(
    kind="hand",
    root="forearm",
    apart=0.12,
    centre=(0.08, 0.0, 0.0),
    extent=0.3,
    azimuth=-140,
    elevation=-25,
    ambient=0.3,
    diffuse=0.4,
    assets=(
        '<texture name="floor" type="2d" builtin="checker" rgb1="0.82 0.84 0.86"'
        ' rgb2="0.78 0.8 0.82" width="256" height="256"/>',
        '<material name="floor" texture="floor" texrepeat="10 10" texuniform="true"/>',
    ),
    bodies=(
        '<geom name="floor" type="plane" pos="0 0 -0.2" size="0.6 0.6 0.05" material="floor"/>',
    ),
)
"""A floor below the hand."""


def keyframes_of(size: HandSize) -> Keyframes:
    """Return `POSTURES` and the eigengrasps as keyframes of the hand that `write_hand` writes.

    Raises
    ------
    InputError
        If the size is outside what can be built.
    """
    spec = build_hand(size)
    postures = {**POSTURES, **eigengrasp_postures(HandModel.from_spec(spec).penetration)}
    order = [JOINT_INDEX[joint.name] for joint in spec.joints]
    return {name: (q[order], q) for name, q in postures.items()}


def write_hand(size: HandSize, folder: Path) -> Path:
    """Write a hand that plain MuJoCo loads, ``right_hand.xml``, and beside it what shows it.

    These are ``keyframes_right.xml``, with `POSTURES` and the eigengrasps, and ``scene_right.xml``,
    which includes both. The folder is made if it is not there.

    Returns
    -------
    The file of the hand.

    Raises
    ------
    InputError
        If the size is outside what can be built.
    FileError
        If the folder cannot be made or written.
    """
    folder = Path(folder)
    keyframes = keyframes_of(size)
    written = write_model(build_hand(size), folder / f"{size.side}_hand.xml")
    write_beside(folder, size.side, SURROUNDINGS, keyframes)
    return written


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
