"""Fit a posture in a subspace so that its finger pads stand where a scripted grasp has them.

Projecting a posture onto a few principal components keeps its shape roughly but moves its
fingertips. Coordinates, palm pose and squeeze are therefore fitted together, without physics.
Before the squeeze the pads should stand where the script has them, or somewhat wider. After the
squeeze each pad that grasps should have passed its target, so that the object stops it.

A plan of one hand is carried over to another in the same way: the pads of the other hand should
stand where those of the first stand, before the squeeze and after it.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from handsim.grasping.gripping.squeeze import squeeze_offset
from handsim.grasping.plan import GraspPlan, Pose
from handsim.grasping.planning.opposition import palm_pose
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import FINGERS, clip_to_range
from handsim.learning.subspace import PostureSubspace
from handsim.objects.grasp import Grasp
from handsim.types import Array, HandSize

IDLE = 0.05
"""Weight of fingers that the grasp does not use."""
PRESSED = 0.006
"""How far beyond its target the squeeze should send a pad [m]."""
WEIGHTS = {"wider": 0.3, "narrower": 1.0, "pressed": 1.0, "approach": 0.6, "across": 0.25}
"""Weights of distances between pads and targets.

``wider`` and ``narrower`` are along the opposition before the squeeze. ``pressed`` is what is
missing along the opposition after the squeeze. The others are along the approach and across both.
Narrower weighs more, since a hand that arrives too narrow does not get around its object."""
NORMAL = 0.006
"""Weight of a unit error of the direction of a pad [m]."""
POSTURE = 0.003
"""Weight of a radian between posture and recorded destination [m]."""
TURN = 0.008
"""Weight of a radian between palm and scripted palm [m]."""
SQUEEZE = 0.002
"""Weight of a unit between the factor on the squeeze and that of the script [m]."""
SQUEEZE_RANGE = (0.3, 2.0)
REMEMBERED = 32
"""Postures whose pads a fit remembers: more than one set of derivatives has."""
MIRROR = np.array([1.0, -1.0, 1.0])
"""Across y = 0 of the object frame, as `Task.for_side` mirrors a grasp."""


@dataclass(frozen=True)
class PadTargets:
    """Where the pads of the five fingers should be, object frame.

    Attributes
    ----------
    pos, normal : (5, 3) [m], (5, 3)
    outward : (5, 3)
        Direction in which each pad leaves the object.
    axes : (3, 3)
        Rows: opposition, approach and across both.
    weight : (5,)
    opposing : (5,)
        Weights with which the pads give the vector from the fingers' mean to the thumb.
    plan
        The scripted plan.
    grasp
        The grasp on the object.
    """

    pos: Array
    normal: Array
    outward: Array
    axes: Array
    weight: Array
    opposing: Array
    plan: GraspPlan
    grasp: Grasp


@dataclass(frozen=True)
class FingertipFit:
    """Coordinates, palm pose and squeeze with which the pads are near their targets.

    Attributes
    ----------
    z : (n_components,) [rad]
    palm
        In the object frame.
    squeeze
        Factor on the squeeze layer.
    error
        Root of the sum of squares of all weighted residuals [m].
    """

    z: Array
    palm: Pose
    squeeze: float
    error: float


def pad_targets(hand: HandModel, plan: GraspPlan, grasp: Grasp) -> PadTargets:
    """Return where a plan has the pads at the grasp; unused fingers have the weight `IDLE`."""
    pos, normal = _pads_in_palm(hand, plan.q_goal)
    turn = plan.palm.rotation
    used = [finger == "thumb" or finger in grasp.fingers for finger in FINGERS]
    opposition, approach = np.array(grasp.opposition), np.array(grasp.approach)
    faced = np.array([finger in grasp.fingers and finger != "thumb" for finger in FINGERS])
    return PadTargets(
        pos=plan.palm.pos + turn.apply(pos),
        normal=turn.apply(normal),
        outward=np.outer([-1.0, 1.0, 1.0, 1.0, 1.0], opposition),
        axes=np.stack([opposition, approach, np.cross(opposition, approach)]),
        weight=np.sqrt(np.where(used, 1.0, IDLE)),
        opposing=(np.array(FINGERS) == "thumb") - faced / max(faced.sum(), 1),
        plan=plan,
        grasp=grasp,
    )


def fit_fingertips(
    hand: HandModel,
    subspace: PostureSubspace,
    targets: PadTargets,
    z_start: Array,
    box: tuple[Array, Array],
    lever: float = 0.0,
) -> FingertipFit:
    """Fit coordinates, palm pose and squeeze.

    Parameters
    ----------
    hand, subspace
    targets
        Where the pads should be.
    z_start : (n_components,) [rad]
        Where the fit begins.
    box : two of (n_components,) [rad]
        Least and greatest coordinates.
    lever
        Weight of the distance between thumb and fingers across the opposition after the squeeze.
        Forces with such a lever turn the object.
    """
    n = len(z_start)
    plan, full = targets.plan, squeeze_offset(1.0, targets.grasp.fingers)
    pads = _Pads(hand)

    def unpacked(x: Array) -> tuple[Array, Pose, float]:
        palm = plan.palm.moved(x[n : n + 3], Rotation.from_rotvec(x[n + 3 : n + 6]))
        return np.clip(x[:n], *box), palm, float(np.clip(plan.squeeze + x[n + 6], *SQUEEZE_RANGE))

    def residuals(x: Array) -> Array:
        z, palm, squeeze = unpacked(x)
        before = clip_to_range(subspace.inverse_transform(z))
        after, turn = clip_to_range(before + squeeze * full), palm.rotation
        off_before = palm.pos + turn.apply(pads(before)[0]) - targets.pos
        pos, normal = pads(after)
        off_after = palm.pos + turn.apply(pos) - targets.pos
        askew = turn.apply(normal) - targets.normal
        clearance = (off_before * targets.outward).sum(axis=1)
        clearance = np.where(clearance > 0, WEIGHTS["wider"], WEIGHTS["narrower"]) * clearance
        lacking = np.maximum((off_after * targets.outward).sum(axis=1) + PRESSED, 0.0)
        aside = (off_before + off_after) / 2 @ targets.axes.T
        weighed = np.stack(
            [
                clearance,
                WEIGHTS["pressed"] * lacking,
                WEIGHTS["approach"] * aside[:, 1],
                WEIGHTS["across"] * aside[:, 2],
                *(NORMAL * askew.T),
            ]
        )
        return np.concatenate(
            [
                (targets.weight * weighed).ravel(),
                lever * (targets.opposing @ off_after @ targets.axes[1:].T),
                POSTURE * (x[:n] - z_start),
                TURN * x[n + 3 : n + 6],
                SQUEEZE * x[n + 6 :],
            ]
        )

    scale = np.concatenate([np.full(n, 0.3), np.full(3, 0.02), np.full(3, 0.2), [0.5]])
    start = np.concatenate([np.clip(z_start, *box), np.zeros(7)])
    fit = least_squares(residuals, start, x_scale=scale, max_nfev=25)
    return FingertipFit(*unpacked(fit.x), error=float(np.linalg.norm(fit.fun)))


def mirrored(plan: GraspPlan) -> GraspPlan:
    """Return the plan with which the other hand does the mirror image, across y = 0.

    Joint angles are those of either hand. A turn is an axial vector.
    """
    w, turn = plan.palm.quat[0], -MIRROR * plan.palm.quat[1:]
    palm = Pose(MIRROR * plan.palm.pos, np.array([w, *turn]))
    return replace(plan, palm=palm, retreat=MIRROR * plan.retreat)


def carried_over(
    plan: GraspPlan,
    hands: tuple[HandSize, HandSize],
    grasp: Grasp,
    subspace: PostureSubspace,
    box: tuple[Array, Array],
) -> GraspPlan:
    """Return a plan of one hand as one of another, without physics.

    For the other side it is the mirror image. For another size, coordinates and palm pose are
    fitted so that the pads of the grasping fingers stand as they did.

    Parameters
    ----------
    plan
    hands
        Whose plan it is, and who is to grasp by it.
    grasp
        For a right hand.
    subspace
        Of the controller.
    box : two of (n_components,) [rad]
        Least and greatest coordinates.
    """
    of, to = hands
    if of.side == "left":
        plan = mirrored(plan)
    if (of.length, of.breadth) != (to.length, to.breadth):
        right = (HandModel.from_spec(build_hand(replace(each, side="right"))) for each in hands)
        plan = _resized(plan, (next(right), next(right)), grasp, subspace, box)
    return plan if to.side == "right" else mirrored(plan)


def _resized(
    plan: GraspPlan,
    hands: tuple[HandModel, HandModel],
    grasp: Grasp,
    subspace: PostureSubspace,
    box: tuple[Array, Array],
) -> GraspPlan:
    """Return a plan with which the pads of another right hand stand as those of the first."""
    z_start, full = plan.goal_in(subspace), squeeze_offset(plan.squeeze, grasp.fingers)
    n = len(z_start)
    weight = pad_targets(hands[0], plan, grasp).weight[:, None]

    def unpacked(x: Array) -> tuple[Array, Pose]:
        shift, turn = x[n : n + 3], Rotation.from_rotvec(x[n + 3 :])
        return np.clip(z_start + x[:n], *box), plan.palm.moved(shift, turn)

    def pads(hand: _Pads, z: Array, palm: Pose) -> Array:
        q = clip_to_range(subspace.inverse_transform(z))
        before, normal = hand(q)
        after, _ = hand(clip_to_range(q + full))
        turn = palm.rotation
        pos = [palm.pos + turn.apply(each) for each in (before, after)]
        return np.concatenate([*pos, NORMAL * turn.apply(normal)], axis=1)

    wanted, other = pads(_Pads(hands[0]), z_start, plan.palm), _Pads(hands[1])

    def residuals(x: Array) -> Array:
        off = weight * (pads(other, *unpacked(x)) - wanted)
        return np.concatenate([off.ravel(), TURN * x[n + 3 :]])

    scale = np.concatenate([np.full(n, 0.3), np.full(3, 0.02), np.full(3, 0.2)])
    z, palm = unpacked(least_squares(residuals, np.zeros(n + 6), x_scale=scale, max_nfev=25).x)
    q_goal = clip_to_range(subspace.inverse_transform(z))
    return replace(plan, palm=palm, z_goal=z, q_goal=q_goal)


class _Pads:
    """The pads of a hand in its palm's frame, by posture.

    Of the steps with which a fit finds its derivatives most move the palm alone: the postures of
    the latest are remembered.
    """

    def __init__(self, hand: HandModel) -> None:
        self._hand, self._known = hand, dict[bytes, tuple[Array, Array]]()

    def __call__(self, q: Array) -> tuple[Array, Array]:
        """Return positions [m] and normals of the pads in a posture (22,) [rad], each (5, 3)."""
        key = q.tobytes()
        if key not in self._known:
            while len(self._known) >= REMEMBERED:
                del self._known[next(iter(self._known))]
            self._known[key] = _pads_in_palm(self._hand, q)
        return self._known[key]


def _pads_in_palm(hand: HandModel, q: Array) -> tuple[Array, Array]:
    """Return positions [m] and normals of the pads in the palm's frame, each (5, 3)."""
    hand.pose(q)
    palm = palm_pose(hand)
    back = palm.rotation.inv()
    pos, normal = hand.pads()
    return back.apply(pos - palm.pos), back.apply(normal)
