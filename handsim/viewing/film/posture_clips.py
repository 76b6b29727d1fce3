"""Posture sequences as clips: the hand alone, without physics."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import mujoco
import numpy as np

from handsim.hand.mjcf import build_hand
from handsim.joints import JOINT_NAMES
from handsim.types import MEDIAN_HAND, Array, HandSize
from handsim.viewing.film.clip import Clip, Overlay
from handsim.viewing.stage.lighting import light_upright_hand

_UPRIGHT = (np.sqrt(0.5), 0.0, -np.sqrt(0.5), 0.0)
"""Orientation of the hand: fingers to +z, palm to +x, thumb of the right hand to +y."""


def posture_model(size: HandSize = MEDIAN_HAND) -> mujoco.MjModel:
    """Compile the hand, upright, with light and background for drawing.

    Parameters
    ----------
    size
        As in `build_hand`.
    """
    spec = build_hand(size)
    spec.body("forearm").quat = _UPRIGHT
    light_upright_hand(spec)
    return spec.compile()


def posture_clip(
    time: Array, q: Array, model: mujoco.MjModel | None = None, overlays: tuple[Overlay, ...] = ()
) -> Clip:
    """Make a clip of postures, which are drawn as they are, beyond joint ranges too.

    Parameters
    ----------
    time : (n,) [s]
    q : (n, 22) [rad]
        Glove order.
    model
        From `posture_model`; the right hand of median size by default.
    overlays
        Drawn onto each frame.
    """
    hand = posture_model() if model is None else model
    qpos = np.tile(hand.qpos0, (len(time), 1))
    qpos[:, [hand.joint(name).qposadr[0] for name in JOINT_NAMES]] = q
    return Clip(hand, np.asarray(time, float), qpos, overlays)
