"""Place the finger pads of a posture in a subspace where a scripted grasp has them.

A posture put through a few principal components keeps its shape roughly and its fingertips not at
all. Choosing coordinates and palm pose together so that the pads come back to their places needs no
physics and takes a fraction of a second.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from handsim.hand.grasp_task import Grasp
from handsim.hand.model import HandModel
from handsim.joints import FINGERS, clip_to_range
from handsim.learning.subspace import PostureSubspace
from handsim.simulation.alignment import palm_pose
from handsim.simulation.plan import GraspPlan, Pose

Array = npt.NDArray[np.float64]

IDLE = 0.15
"""Weight of fingers that the grasp does not use."""
NORMAL_WEIGHT = 0.012
"""What a unit error of a pad's direction counts for [m]: two thirds of a finger's thickness."""
POSTURE_WEIGHT = 0.004
"""What a radian between posture and recorded destination counts for [m]."""
TURN_WEIGHT = 0.01
"""What a radian between palm and scripted palm counts for [m]."""


@dataclass(frozen=True)
class PadTargets:
    """Where the pads of the five fingers should be, object frame.

    Attributes
    ----------
    pos, normal : (5, 3) [m], (5, 3)
    weight : (5,)
    palm
        Pose of the palm that goes with them.
    """

    pos: Array
    normal: Array
    weight: Array
    palm: Pose


@dataclass(frozen=True)
class Placement:
    """A posture in the subspace and a palm pose that put the pads near their targets.

    Attributes
    ----------
    z : (n_components,) [rad]
    palm
        In the object frame.
    error
        Root of the weighted mean square distance of the pads from their targets [m].
    """

    z: Array
    palm: Pose
    error: float


def pad_targets(hand: HandModel, plan: GraspPlan, grasp: Grasp) -> PadTargets:
    """Return where a plan has the pads at the grasp; the thumb and the grasp's fingers count."""
    pos, normal = _pads_in_palm(hand, plan.q_goal)
    turn = plan.palm.rotation
    used = [finger == "thumb" or finger in grasp.fingers for finger in FINGERS]
    return PadTargets(
        plan.palm.pos + turn.apply(pos),
        turn.apply(normal),
        np.where(used, 1.0, IDLE),
        plan.palm,
    )


def place(
    hand: HandModel,
    subspace: PostureSubspace,
    targets: PadTargets,
    z_start: Array,
    box: tuple[Array, Array],
) -> Placement:
    """Fit coordinates and palm pose to pad targets, beginning at ``z_start`` (n_components,).

    ``box`` holds the least and greatest coordinates, each (n_components,) [rad].
    """
    n = len(z_start)
    root = np.sqrt(targets.weight)[:, None]

    def palm_at(x: Array) -> Pose:
        return targets.palm.moved(x[n : n + 3], Rotation.from_rotvec(x[n + 3 :]))

    def misses(x: Array) -> tuple[Array, Array]:
        pos, normal = _pads_in_palm(
            hand, clip_to_range(subspace.inverse_transform(np.clip(x[:n], *box)))
        )
        palm = palm_at(x)
        turn = palm.rotation
        return palm.pos + turn.apply(pos) - targets.pos, turn.apply(normal) - targets.normal

    def residuals(x: Array) -> Array:
        off, askew = misses(x)
        return np.concatenate(
            [
                (root * off).ravel(),
                (NORMAL_WEIGHT * root * askew).ravel(),
                POSTURE_WEIGHT * (x[:n] - z_start),
                TURN_WEIGHT * x[n + 3 :],
            ]
        )

    scale = np.concatenate([np.full(n, 0.3), np.full(3, 0.02), np.full(3, 0.2)])
    start = np.concatenate([z_start, np.zeros(6)])
    x = least_squares(residuals, start, x_scale=scale, max_nfev=25).x
    squared = targets.weight @ (misses(x)[0] ** 2).sum(axis=1) / targets.weight.sum()
    return Placement(np.clip(x[:n], *box), palm_at(x), float(np.sqrt(squared)))


def _pads_in_palm(hand: HandModel, q: Array) -> tuple[Array, Array]:
    """Return positions [m] and normals of the pads in the palm's frame, each (5, 3)."""
    hand.set_posture(q)
    palm = palm_pose(hand)
    back = palm.rotation.inv()
    pos, normal = hand.pads()
    return back.apply(pos - palm.pos), back.apply(normal)
