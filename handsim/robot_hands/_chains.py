"""Which links of a model are fingers, which is the palm, and which finger is which.

Names are believed where they say it; the rest is told from the tree and from where things are.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import re
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from handsim.errors import InputError
from handsim.joints import FINGERS, Finger
from handsim.types import Array

_HINGE, _SLIDE = mujoco.mjtJoint.mjJNT_HINGE.value, mujoco.mjtJoint.mjJNT_SLIDE.value
_SHORT = 0.4
"""A branch of a finger shorter than this part of the longest is no finger, but a linkage."""

_START, _END = (
    r"(?:^|[^a-z]|rh|lh)",
    r"(?=knuckle|metacarpal|base|prox|hub|mid|med|dist|tip|j?\d|[^a-z]|$)",
)
_NAMES: dict[Finger, str] = {
    "thumb": rf"thumb|{_START}th{_END}",
    "index": rf"index|forefinger|pointer|first_?finger|{_START}[fi]f{_END}",
    "ring": rf"{_START}ring|ring_?finger|third_?finger|{_START}rf{_END}",
    "little": rf"little|pink(?:y|ie)|{_START}lf{_END}",
    "middle": r"middle_?(?:finger|prox|dist|inter|tip|[_\d])|^middle$|second_?finger"
    rf"|{_START}mf{_END}",
}
"""Words for fingers, those first that a middle phalanx cannot be mistaken for."""


@dataclass(frozen=True)
class Chain:
    """A finger: its last body that a joint moves, and the joints from the palm outwards."""

    tip: int
    joints: tuple[int, ...]

    def says(self, model: mujoco.MjModel) -> str:
        """Return all names along it in one line, the outermost first."""
        bodies: list[str] = []
        body = self.tip
        inner = int(model.jnt_bodyid[self.joints[0]])
        while body > 0:
            bodies.append(model.body(body).name)
            if body == inner:
                break
            body = int(model.body_parentid[body])
        return " ".join([*bodies, *(model.joint(j).name for j in self.joints[::-1])]).lower()


def groups_of(model: mujoco.MjModel) -> dict[int, list[int]]:
    """Return the bodies that are rigid with one another, by the first of each group."""
    groups: dict[int, list[int]] = {}
    for body in range(model.nbody):
        groups.setdefault(int(model.body_weldid[body]), []).append(body)
    return groups


def find_chains(model: mujoco.MjModel, data: mujoco.MjData) -> tuple[int, list[Chain]]:
    """Return the group of the palm and the fingers that hang on it.

    Raises
    ------
    InputError
        If nothing in the model is a finger.
    """
    parents = {g: int(model.body_weldid[model.body_parentid[g]]) for g in groups_of(model) if g}
    inner = set(parents.values())
    leaves = [g for g in parents if g not in inner and _turns(model, g)]
    if not leaves:
        raise InputError("no finger was found: nothing ends in a hinge or slide; give a hand")
    palm = 0
    while True:
        below: dict[int, list[int]] = {}
        for leaf in leaves:
            way = _way(leaf, palm, parents)
            if way:
                below.setdefault(way[-1], []).append(leaf)
        most = max(below, key=lambda g: len(below[g]))
        lone = len(below) == 1 and (most not in leaves)
        if not (lone or (palm == 0 and len(below[most]) >= 3)):
            break
        palm, leaves = most, below[most]
    chains = [_chain(model, leaf, palm, parents) for leaf in leaves]
    return palm, _without_linkages(model, data, [c for c in chains if c.joints])


def chain_to(model: mujoco.MjModel, body: int, palm: int) -> Chain:
    """Return the finger from the palm's group to a body."""
    parents = {g: int(model.body_weldid[model.body_parentid[g]]) for g in groups_of(model) if g}
    return _chain(model, int(model.body_weldid[body]), palm, parents)


def _turns(model: mujoco.MjModel, group: int) -> bool:
    first, count = int(model.body_jntadr[group]), int(model.body_jntnum[group])
    return any(model.jnt_type[j] in (_HINGE, _SLIDE) for j in range(first, first + count))


def _way(group: int, to: int, parents: dict[int, int]) -> list[int]:
    """Return the groups from one up to the last below another; empty if it is not below it."""
    way = [group]
    while way[-1] in parents and parents[way[-1]] != to:
        way.append(parents[way[-1]])
    return way if parents.get(way[-1]) == to and group != to else []


def _chain(model: mujoco.MjModel, leaf: int, palm: int, parents: dict[int, int]) -> Chain:
    joints: list[int] = []
    for group in reversed(_way(leaf, palm, parents)):
        first, count = int(model.body_jntadr[group]), int(model.body_jntnum[group])
        joints += [j for j in range(first, first + count) if model.jnt_type[j] in (_HINGE, _SLIDE)]
    return Chain(leaf, tuple(joints))


def _without_linkages(
    model: mujoco.MjModel, data: mujoco.MjData, chains: list[Chain]
) -> list[Chain]:
    """Leave out short branches of fingers: rods and levers."""
    kept: list[Chain] = []
    for chain in chains:
        siblings = [c for c in chains if c.joints[0] == chain.joints[0]]
        own = [_own_length(model, data, c, siblings) for c in siblings]
        mine = own[siblings.index(chain)]
        beyond = len(set(chain.joints) - set().union(*(c.joints for c in siblings if c != chain)))
        if len(siblings) == 1 or mine >= _SHORT * max(own) or beyond >= 2:
            kept.append(chain)
    return kept


def _own_length(
    model: mujoco.MjModel, data: mujoco.MjData, chain: Chain, siblings: Sequence[Chain]
) -> float:
    """Return how far a chain's last body is from its first joint of its own [m]."""
    shared = set[int]().union(*(c.joints for c in siblings if c != chain))
    own = [j for j in chain.joints if j not in shared] or [chain.joints[-1]]
    end = data.xipos[chain.tip]
    return float(np.linalg.norm(end - data.xanchor[own[0]])) + 1e-6 * len(own)


def name_fingers(
    model: mujoco.MjModel, data: mujoco.MjData, chains: Sequence[Chain]
) -> dict[Finger, Chain]:
    """Return which finger each chain is; beyond five, those furthest from the thumb are left out.

    Parameters
    ----------
    model
    data
        With positions computed.
    chains
        One or more.
    """
    said: dict[Finger, Chain] = {}
    for chain in chains:
        text = chain.says(model)
        found: Finger | None = next(
            (f for f, words in _NAMES.items() if re.search(words, text)), None
        )
        if found is not None and found not in said:
            said[found] = chain
    rest = [chain for chain in chains if chain not in said.values()]
    if not rest:
        return {f: said[f] for f in FINGERS if f in said}
    if "thumb" not in said and len(chains) > 1:
        said["thumb"] = max(rest, key=lambda c: _apartness(model, data, c, chains))
        rest.remove(said["thumb"])
    free: list[Finger] = [f for f in FINGERS if f not in said]
    if "thumb" in said:
        thumb = data.xanchor[said["thumb"].joints[0]]
        rest.sort(key=lambda c: float(np.linalg.norm(data.xanchor[c.joints[0]] - thumb)))
    others: list[Finger] = [f for f in free if f != "thumb"]
    for other, chain in zip(others, rest, strict=False):
        said[other] = chain
    return {f: said[f] for f in FINGERS if f in said}


def _apartness(
    model: mujoco.MjModel, data: mujoco.MjData, chain: Chain, chains: Sequence[Chain]
) -> float:
    """Return how much a chain points, bends and stands otherwise than the rest do."""
    others = [c for c in chains if c != chain]
    mine, mean = _direction(data, chain), np.mean([_direction(data, c) for c in others], axis=0)
    axes = np.array([data.xaxis[c.joints[-1]] for c in others])
    bends = float(np.mean(np.abs(axes @ data.xaxis[chain.joints[-1]])))
    roots = np.array([data.xanchor[c.joints[0]] for c in others])
    span = float(np.ptp(roots, axis=0).max()) + 1e-3
    away = data.xanchor[chain.joints[0]] - roots.mean(axis=0)
    if len(others) > 1:  # off the line of the others' roots
        line = np.linalg.svd(roots - roots.mean(axis=0))[2][0]
        away = away - (away @ line) * line
    apart = min(float(np.linalg.norm(away)) / span, 2.0)
    fewer = 0.5 * (len(chain.joints) < min(len(c.joints) for c in others))
    return (1 - float(mine @ mean)) + (1 - bends) + apart + fewer


def _direction(data: mujoco.MjData, chain: Chain) -> Array:
    along = data.xipos[chain.tip] - data.xanchor[chain.joints[0]]
    return along / (np.linalg.norm(along) + 1e-9)
