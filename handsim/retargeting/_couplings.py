"""Joints of a robot hand that follow others, by ``<equality><joint>`` or a shared tendon."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import dataclass

import mujoco
import numpy as np

from handsim.errors import InputError
from handsim.retargeting._actuation import shared_tendons
from handsim.types import Array

_JOINT = mujoco.mjtEq.mjEQ_JOINT.value
N_TRIED = 2001
"""Places of a leading joint at which the joint that follows is looked at."""
_SLACK = 1e-9


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
    for together, ways in shared_tendons(model):
        inside = [k for k, j in enumerate(together) if j in place and place[j] not in found]
        for k in inside[1:]:
            leader, joint = place[together[inside[0]]], place[together[k]]
            slope = np.array([0.0, ways[k] / ways[inside[0]], 0.0, 0.0, 0.0])
            found[joint] = Coupling(joint, leader, slope)
    ordered: list[Coupling] = []
    while found:
        ready = [joint for joint, coupling in found.items() if coupling.leader not in found]
        if not ready:
            names = ", ".join(f"'{model.joint(joints[i]).name}'" for i in found)
            raise InputError(f"joints {names} follow each other in a circle; free one")
        ordered += [found.pop(joint) for joint in ready]
    return ordered


def within_ranges(
    couplings: list[Coupling], start: Array, lower: Array, upper: Array
) -> tuple[Array, Array]:
    """Return ranges of all joints, (n,) each, narrowed so that those that follow stay in theirs.

    Parameters
    ----------
    couplings
    start, lower, upper : (n,)
        Reference and ends of the range of each joint.
    """
    lower, upper = lower.copy(), upper.copy()
    for coupling in reversed(couplings):  # those that follow a follower first
        leader, joint = coupling.leader, coupling.joint
        if leader < 0:
            continue
        tried = np.linspace(lower[leader], upper[leader], N_TRIED)
        follows = np.polynomial.Polynomial(coupling.coefficients)(tried - start[leader])
        inside = follows + start[joint]
        inside = (inside >= lower[joint] - _SLACK) & (inside <= upper[joint] + _SLACK)
        runs = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(np.int8), [0]])))
        if not len(runs):
            continue  # a reference outside its own range: nothing can be kept
        widest = int(np.argmax(runs[1::2] - runs[::2]))
        lower[leader], upper[leader] = tried[runs[2 * widest]], tried[runs[2 * widest + 1] - 1]
    return lower, upper


def offset_of(positions: Array, leader: int, start: Array) -> Array:
    """Return how far a leading joint is from its reference; 0 where there is no leader."""
    if leader < 0:
        return np.zeros(positions.shape[:-1])
    return positions[..., leader] - start[leader]
