"""Joints of a robot hand that follow others, by ``<equality><joint>``."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import dataclass

import mujoco
import numpy as np

from handsim.errors import InputError
from handsim.types import Array

_JOINT = mujoco.mjtEq.mjEQ_JOINT.value


@dataclass(frozen=True)
class Coupling:
    """One joint that follows another (-1: none) by a polynomial about the reference posture."""

    joint: int
    leader: int
    coefficients: Array


def find_couplings(model: mujoco.MjModel, joints: list[int]) -> list[Coupling]:
    """Find joints that follow others, each after the one it follows."""
    place = {j: i for i, j in enumerate(joints)}
    found = {}
    for i in np.flatnonzero(model.eq_active0):
        joint, leader = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
        if model.eq_type[i] != _JOINT or joint not in place:
            continue
        if leader >= 0 and leader not in place:
            raise InputError(
                f"joint '{model.joint(joint).name}' follows "
                f"'{model.joint(leader).name}', which is not between palm and fingertips; "
                "give its equality active='false'"
            )
        coefficients = model.eq_data[i, :5].copy()
        found[place[joint]] = Coupling(place[joint], place.get(leader, -1), coefficients)
    ordered: list[Coupling] = []
    while found:
        ready = [joint for joint, coupling in found.items() if coupling.leader not in found]
        if not ready:
            names = ", ".join(f"'{model.joint(joints[i]).name}'" for i in found)
            raise InputError(f"joints {names} follow each other in a circle; free one")
        ordered += [found.pop(joint) for joint in ready]
    return ordered


def offset_of(positions: Array, leader: int, start: Array) -> Array:
    """Return how far a leading joint is from its reference; 0 where there is no leader."""
    if leader < 0:
        return np.zeros(positions.shape[:-1])
    return positions[..., leader] - start[leader]
