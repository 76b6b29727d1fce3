"""The hand in a compiled model: where its joints, actuators, fingertips and pads are."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from handsim.joints import FINGERS, JOINT_NAMES
from handsim.types import Array


@dataclass(frozen=True, eq=False)
class HandModel:
    """A compiled model with a hand in it, and where the hand's parts are.

    As its state changes while it is simulated, it is equal to itself alone.

    Attributes
    ----------
    model, data
        The compiled model and one state of it.
    qpos_index, qvel_index, ctrl_index
        Indices of the 22 joints, in glove order, in ``qpos``, ``qvel`` and ``ctrl``.
    tip_site, pad_site
        Site ids, thumb to little finger.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    qpos_index: npt.NDArray[np.intp]
    qvel_index: npt.NDArray[np.intp]
    ctrl_index: npt.NDArray[np.intp]
    tip_site: npt.NDArray[np.intp]
    pad_site: npt.NDArray[np.intp]

    @classmethod
    def from_spec(cls, spec: mujoco.MjSpec, prefix: str = "") -> "HandModel":
        """Compile a spec that holds a hand and find its parts.

        Parameters
        ----------
        spec
        prefix
            Of the hand's names, where the scene holds two (`attach_hand`).
        """
        model = spec.compile()
        joints = [model.joint(prefix + name) for name in JOINT_NAMES]
        return cls(
            model,
            mujoco.MjData(model),
            np.array([joint.qposadr[0] for joint in joints]),
            np.array([joint.dofadr[0] for joint in joints]),
            np.array([model.actuator(prefix + name).id for name in JOINT_NAMES]),
            np.array([model.site(f"{prefix}{finger}_tip").id for finger in FINGERS]),
            np.array([model.site(f"{prefix}{finger}_pad").id for finger in FINGERS]),
        )

    @property
    def q(self) -> Array:
        """The posture in ``data``, (22,) [rad], glove order."""
        return self.data.qpos[self.qpos_index]

    def set_posture(self, q: Array) -> None:
        """Put joints and actuator targets at q, (22,) [rad], at rest, and update positions."""
        self.data.qpos[self.qpos_index] = q
        self.data.qvel[self.qvel_index] = 0.0
        self.data.ctrl[self.ctrl_index] = np.clip(
            q, *self.model.actuator_ctrlrange[self.ctrl_index].T
        )
        mujoco.mj_forward(self.model, self.data)

    def pose(self, q: Array) -> None:
        """Put joints at q, (22,) [rad], and update nothing but where everything is."""
        self.data.qpos[self.qpos_index] = q
        mujoco.mj_kinematics(self.model, self.data)

    def penetration(self, q: Array) -> float:
        """Return how deep anything penetrates in posture q, (22,) [rad], which is set [m]."""
        self.set_posture(q)
        return -min((contact.dist for contact in self.data.contact), default=0.0)

    def fingertips(self) -> Array:
        """Positions of the fingertips in the world, (5, 3) [m], thumb first."""
        return self.data.site_xpos[self.tip_site]

    def pads(self) -> tuple[Array, Array]:
        """Positions of the finger pads and their outward unit normals, each (5, 3)."""
        normals = -self.data.site_xmat[self.pad_site].reshape(-1, 3, 3)[:, :, 2]
        return self.data.site_xpos[self.pad_site], normals
