"""What a rule judges: samples of one run."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from handsim.tasks.turns import composed
from handsim.types import Array, Mask

AVERAGED = 0.1
"""Time over which limits of force average [s]: a knock of a hundredth of a second hurts nobody."""


@dataclass(frozen=True)
class GraspTraces:
    """Samples of one run at a constant rate.

    Attributes
    ----------
    time : (n,) [s]
    object_pos, object_quat : (n, 3) [m], (n, 4)
        Pose of the object's centre of mass in the world, quaternions w, x, y, z.
    palm_pos, palm_quat : (n, 3) [m], (n, 4)
    press : (n, 6, 3) [N]
        Normal force of each part of the hand (`handsim.joints.CONTACT_PARTS`) on the object, as a
        vector in the world.
    force : (n, 6) [N]
        Sum of the magnitudes of the same normal forces.
    penetration : (n,) [m]
        Deepest overlap of the hand with object or table.
    table_force : (n,) [N]
        What hand and arm press on the table.
    pressed : (n, n_pressed) [N]
        Force on each body that the rule wants pressed, by the fingers that it names.
    need : [N]
        Least force on a side that holds the object in the hold (`least_grip`), at least 1 N.
    action_start, hold_start
        When the task's first movement is commanded and when its last has ended [s].
    symmetry
        Axis of the object about which rotation does not count, or None.
    front_pos : (n, 3) [m]
        The object's front end in the world, for rules of kind ``trace``.
    hinge : (n,) [rad]
        Angle of the rule's hinge, for rules of kind ``joint``.
    strain
        How far from natural the arm is at worst: up to 1 a person does it (`ArmPosture.strain`).
    arrived
        Whether the driver brought the hand to its destination.
    unstable_at
        Time of the first sample that is not a number or absurd, or None [s].
    """

    time: Array
    object_pos: Array
    object_quat: Array
    palm_pos: Array
    palm_quat: Array
    press: Array
    force: Array
    penetration: Array
    table_force: Array
    pressed: Array
    need: float
    action_start: float
    hold_start: float
    symmetry: Literal["x", "z"] | None
    front_pos: Array | None = None
    hinge: Array | None = None
    strain: float = 0.0
    arrived: bool = True
    unstable_at: float | None = None

    @property
    def touching(self) -> Mask:
        """Whether any part of the hand touches the object, (n,)."""
        return np.asarray((self.force > 0).any(axis=1))

    @property
    def first_acting(self) -> int:
        """Row at which the task's first movement begins."""
        return int(np.searchsorted(self.time, self.action_start - 1e-9))

    @property
    def first_holding(self) -> int:
        """Row at which the hold begins."""
        return int(np.searchsorted(self.time, self.hold_start - 1e-9))

    def averaged(self, values: Array) -> Array:
        """Return the means (m, ...) of values (n, ...) over each stretch of `AVERAGED`."""
        step = float(np.diff(self.time[:2]).sum()) or 1.0
        width = max(1, min(round(AVERAGED / step), len(values)))
        total = np.cumsum(np.concatenate([np.zeros_like(values[:1]), values]), axis=0)
        return (total[width:] - total[:-width]) / width

    def slip(self, first: int) -> Array:
        """Return the displacement of the object in the palm since row ``first``, (n,) [m]."""
        from scipy.spatial.transform import Rotation  # who lists tasks need not wait for it

        palm = Rotation.from_quat(self.palm_quat, scalar_first=True)
        local = palm.inv().apply(self.object_pos - self.palm_pos)
        return np.linalg.norm(local - local[first], axis=1)

    def way(self) -> Array:
        """Return the displacement of the object in the world since the first sample, (n,) [m]."""
        return np.linalg.norm(self.object_pos - self.object_pos[0], axis=1)

    def turn(self, first: int, with_palm: int | None) -> Array:
        """Return the rotation of the object since row ``first``, (n,) [rad].

        Turning about an axis of symmetry does not count, and from row ``with_palm`` on neither does
        what the palm turns since then: an object that turns with the palm, as in drinking, does not
        tilt in the hand. None takes all rotation in the world.
        """
        from scipy.spatial.transform import Rotation

        own = Rotation.from_quat(self.object_quat, scalar_first=True)
        if with_palm is not None:
            palm = Rotation.from_quat(self.palm_quat, scalar_first=True)
            carried = composed(palm[with_palm:], palm[with_palm].inv())
            kept = composed(carried.inv(), own[with_palm:])
            own = Rotation.concatenate([own[:with_palm], kept])
        if self.symmetry is None:
            return composed(own, own[first].inv()).magnitude()
        axes = own.apply(np.eye(3)["xyz".index(self.symmetry)])
        return np.arccos(np.clip(axes @ axes[first], -1.0, 1.0))
