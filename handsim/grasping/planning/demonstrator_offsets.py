"""Offsets of scripted grasps by task, and the file that holds them.

Many objects are held without offsets. For the others a search finds them; it is run by ``python
assets/search_demonstrations.py``, which writes ``assets/demonstrations.json``.
"""

import json
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

import numpy as np
from scipy.spatial.transform import Rotation

from handsim.errors import FileError
from handsim.files import data_folder, write_text
from handsim.grasping.plan import Pose
from handsim.grasping.planning.preshapes import LONG_FINGERS, Preshape
from handsim.joints import JOINT_INDEX, N_JOINTS, clip_to_range
from handsim.types import Array, Side

_JOINTS: dict[str, tuple[str, ...]] = {
    "fingers_mcp": tuple(f"{finger}_mcp" for finger in LONG_FINGERS),
    "fingers_pip": tuple(f"{finger}_pip" for finger in LONG_FINGERS),
    "index_middle_mcp": ("index_mcp", "middle_mcp"),
    "thumb_rotation": ("thumb_rotation",),
    "thumb_abduction": ("thumb_abduction",),
    "thumb_mcp": ("thumb_mcp",),
}
SPREADS: dict[str, float] = {
    "x_mm": 8.0, "y_mm": 6.0, "z_mm": 8.0,
    "turn_x_deg": 7.0, "turn_y_deg": 7.0, "turn_z_deg": 7.0,
    "beyond": 0.08, "squeeze": 0.3, "grip": 0.25,
    "fingers_mcp": 7.0, "fingers_pip": 7.0, "index_middle_mcp": 5.0,
    "thumb_rotation": 6.0, "thumb_abduction": 6.0, "thumb_mcp": 7.0,
}  # fmt: skip
"""Names of the offsets and their initial spreads in a search; joints in degrees."""


@dataclass(frozen=True)
class DemonstratorOffsets:
    """Offsets that are added to the preshape and the palm pose of a grasp.

    Attributes
    ----------
    values : (15,)
        In the order and units of `SPREADS`. Displacement and turn (rotation vector) of the palm
        are in its own frame, for a right hand. Joints are added to the open and the shut posture
        before alignment. ``beyond`` and ``squeeze`` are added to those of the preshape; the grip is
        multiplied by exp(``grip``).
    """

    values: tuple[float, ...] = (0.0,) * len(SPREADS)

    @classmethod
    def of(cls, point: Array) -> "DemonstratorOffsets":
        """Make offsets from a point (15,) in units of the spreads."""
        return cls(tuple((point * np.array(list(SPREADS.values()))).tolist()))

    @property
    def point(self) -> Array:
        """The values in units of the spreads, (15,)."""
        return np.array(self.values) / np.array(list(SPREADS.values()))

    def preshape(self, preshape: Preshape) -> Preshape:
        """Return a preshape with the offsets added to joints, ``beyond`` and ``squeeze``."""
        added, values = np.zeros(N_JOINTS), dict(zip(SPREADS, self.values, strict=True))
        for name, joints in _JOINTS.items():
            added[[JOINT_INDEX[joint] for joint in joints]] += np.deg2rad(values[name])
        return replace(
            preshape,
            open=clip_to_range(preshape.open + added),
            shut=clip_to_range(preshape.shut + added),
            beyond=preshape.beyond + values["beyond"],
            squeeze=max(0.0, preshape.squeeze + values["squeeze"]),
        )

    @property
    def grip(self) -> float:
        """Factor on the grip."""
        return float(np.exp(dict(zip(SPREADS, self.values, strict=True))["grip"]))

    def palm(self, palm: Pose, side: Side) -> Pose:
        """Return a palm pose displaced and turned in the palm's own frame."""
        mirror = np.array([1.0, 1.0 if side == "right" else -1.0, 1.0])
        shift = mirror * np.array(self.values[:3]) / 1000
        turn = mirror * mirror[1] * np.deg2rad(self.values[3:6])  # an axial vector
        return palm @ Pose(shift, Rotation.from_rotvec(turn).as_quat(scalar_first=True))


def demonstrator_offsets_file() -> Path:
    """Return where the built-in offsets are."""
    return data_folder("assets") / "demonstrations.json"


@lru_cache(maxsize=1)
def demonstrator_offsets() -> MappingProxyType[str, DemonstratorOffsets]:
    """Return the built-in offsets by task; a task that needs none is not in it.

    Raises
    ------
    FileError
        If the file is there and cannot be read.
    """
    path = demonstrator_offsets_file()
    if not path.is_file():
        return MappingProxyType({})
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))
        read = {
            task: DemonstratorOffsets(tuple(float(values.get(name, 0.0)) for name in SPREADS))
            for task, values in stored.items()
        }
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise FileError(f"{path}: not a file of offsets ({error}); make it again") from error
    return MappingProxyType(read)


def write_demonstrator_offsets(found: dict[str, DemonstratorOffsets], path: Path) -> None:
    """Write offsets by task, rounded to three decimals."""
    content = {
        task: dict(zip(SPREADS, np.round(found[task].values, 3).tolist(), strict=True))
        for task in sorted(found)
    }
    write_text(path, json.dumps(content, indent=1) + "\n")
