"""The way of the wrist through a recording, from what was seen of the palm."""

import numpy as np
from scipy.spatial.transform import Rotation

from handsim.errors import InputError
from handsim.hand.anthropometry import HandGeometry
from handsim.recordings.points.channels import PALM_CENTRE
from handsim.recordings.recording import Recording
from handsim.types import Array

_POSE = tuple(f"palm_{part}" for part in ("x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"))


def has_palm(recording: Recording) -> bool:
    """Whether a recording has the palm's pose as channels."""
    return all(name in recording.channels for name in _POSE)


def wrist_path(recording: Recording) -> tuple[Array, Array]:
    """Return the wrist's centre (n, 3) [m] and the palm's orientation (n, 4), w first, both seen.

    Channels hold the middle of the palm, half of the way from the wrist to the middle finger.

    Parameters
    ----------
    recording

    Raises
    ------
    InputError
        If it has no pose of the palm.
    """
    if not has_palm(recording):
        raise InputError(
            f"recording '{recording.name}' has no pose of the palm; give one with the channels "
            f"{', '.join(_POSE)}"
        )
    pose = np.stack([recording.channels[name] for name in _POSE], axis=1)
    place, quat = pose[:, :3], pose[:, 3:]
    quat = quat / np.linalg.norm(quat, axis=1, keepdims=True)
    middle = PALM_CENTRE * HandGeometry(recording.hand).mcp("middle")
    seen = np.isfinite(quat).all(axis=1)
    wrist = np.full(place.shape, np.nan)
    turn = Rotation.from_quat(quat[seen], scalar_first=True)
    wrist[seen] = place[seen] - turn.apply(middle)
    return wrist, quat
