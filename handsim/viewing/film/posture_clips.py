"""Posture sequences as clips: the hand alone before a plain background, without physics."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import mujoco
import numpy as np

from handsim.hand.mjcf import build_hand
from handsim.joints import JOINT_NAMES
from handsim.learning.controller import GraspController
from handsim.recordings.folder import Recording
from handsim.recordings.recording import SYNTHETIC
from handsim.types import MEDIAN_HAND, Array, HandSize
from handsim.viewing.film.clips import Clip, Overlay
from handsim.viewing.film.overlay import Caption, SubspaceInset

_UPRIGHT = (np.sqrt(0.5), 0.0, -np.sqrt(0.5), 0.0)
"""Orientation of the hand: fingers to +z, palm to +x, thumb of the right hand to +y."""
_SKY_TOP, _SKY_BOTTOM = (0.93, 0.95, 0.98), (0.78, 0.82, 0.87)


def posture_model(size: HandSize = MEDIAN_HAND) -> mujoco.MjModel:
    """Compile the hand, upright, with light and background for drawing.

    Parameters
    ----------
    size
        As in `build_hand`.
    """
    spec = build_hand(size)
    spec.body("forearm").quat = _UPRIGHT
    spec.add_texture(
        name="background",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=_SKY_TOP,
        rgb2=_SKY_BOTTOM,
        width=256,
        height=256,
    )
    light = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
    spec.worldbody.add_light(
        type=light, dir=[-0.4, -0.5, -0.8], diffuse=[0.5] * 3, specular=[0.1] * 3
    )
    spec.worldbody.add_light(type=light, dir=[0.2, 0.9, -0.1], diffuse=[0.25] * 3, specular=[0] * 3)
    spec.visual.headlight.ambient = [0.35] * 3
    spec.visual.headlight.diffuse = [0.35] * 3
    spec.visual.headlight.specular = [0.05] * 3
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


def comparison_clips(recording: Recording, controller: GraspController) -> tuple[Clip, Clip]:
    """Make clips of a recording and of the controller between the same two postures.

    Draw them with `render_clips` in two columns: side by side, in the recording's time. Each shows
    its way in the subspace, the controller's with the recording's in grey.
    """
    duration = recording.duration
    sequence = controller.postures(recording.q[0], recording.q[-1], duration=duration)
    model = posture_model(recording.hand)
    recorded = controller.subspace.transform(recording.q)
    followed = controller.subspace.transform(sequence.q)
    time = recording.time - recording.time[0]
    kind = "synthetic recording" if recording.subject == SYNTHETIC else "recording"
    end = "arrives" if sequence.arrived else f"does not arrive: {sequence.reason}"
    return (
        posture_clip(
            time,
            recording.q,
            model,
            (
                Caption((f"{kind} {recording.name}", recording.task)),
                SubspaceInset(time, recorded),
            ),
        ),
        posture_clip(
            sequence.time,
            sequence.q,
            model,
            (Caption(("controller", end)), SubspaceInset(sequence.time, followed, recorded)),
        ),
    )
