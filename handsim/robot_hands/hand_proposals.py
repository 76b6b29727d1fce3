"""Propose the frames of palm and fingertips from the kinematic tree and the shapes of links.

Fingers bend to the side to which they have the wider range: there is the palm's side. Distal is
along the first phalanges of the fingers. The palm's frame has its origin where a person's wrist
would be, were the hand's fingers as long as the robot's: frames of robot and person then compare.
A fingertip's frame is on the palmar surface of the last link, before its rounded end.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Collection, Mapping

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from handsim.errors import InputError
from handsim.hand.anthropometry import LENGTHS, HandGeometry
from handsim.joints import Finger
from handsim.robot_hands._chains import Chain, chain_to, find_chains, groups_of, name_fingers
from handsim.robot_hands._surfaces import outermost, triangles_of
from handsim.robot_hands.finger_lines import finger_line, first_part, length_of
from handsim.robot_hands.hand_frames import AttachedFrame, HandFrames
from handsim.robot_hands.presets import NamedLinks, recognise
from handsim.types import MEDIAN_HAND, Array, Side

_SLIDE = mujoco.mjtJoint.mjJNT_SLIDE.value
_NEAR = 0.008
"""Joints closer than this turn about one place [m]."""


def propose_frames(model: mujoco.MjModel, placeholders: Collection[str] = ()) -> HandFrames:
    """Return where palm and fingertips probably are.

    Parameters
    ----------
    model
        Of the hand, perhaps with an arm.
    placeholders
        Names of meshes that stand for missing ones.

    Raises
    ------
    InputError
        If nothing in it is a finger.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = _open_posture(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    bodies = [model.body(i).name for i in range(model.nbody)]
    joints = [model.joint(j).name for j in range(model.njnt)]
    named = recognise(bodies, joints)
    palm, chains = find_chains(model, data)
    fingers: dict[Finger, Chain] = {}
    if named is not None:
        fingers = {f: chain_to(model, bodies.index(n), palm) for f, n in named.fingertips.items()}
        if not all(chain.joints for chain in fingers.values()):
            named = None
    if named is None:
        fingers = name_fingers(model, data, chains)
    axes = _palm_axes(model, data, fingers)
    knuckles = dict(named.knuckles) if named else {}
    knuckles = knuckles or _knuckles(model, data, fingers)
    begin: dict[Finger, int] = {
        f: _first_joint(model, c, knuckles.get(f)) for f, c in fingers.items()
    }
    tips: dict[Finger, _Fingertip] = {
        f: _Fingertip(model, data, c, axes, placeholders) for f, c in fingers.items()
    }
    origin = _palm_origin(model, data, fingers, begin, tips, axes)
    side = _side(model, data, fingers, begin, origin, axes, " ".join([*bodies, *joints]))
    if side == "left":
        origin = _palm_origin(model, data, fingers, begin, tips, axes, mirror=-1.0)
    on = _palm_body(model, palm, named)
    pads: dict[Finger, AttachedFrame] = {
        f: _attached(model, data, tip.body, tip.pad, tip.axes) for f, tip in tips.items()
    }
    return HandFrames(
        _attached(model, data, on, origin, axes),
        pads,
        knuckles,
        side,
        f"by link names, which are those of {named.hand}" if named else "by the kinematic tree",
    )


def _open_posture(model: mujoco.MjModel) -> Array:
    """Return the reference posture, with joints inside their ranges."""
    posture = model.qpos0.copy()
    for j in range(model.njnt):
        if model.jnt_limited[j] and model.jnt_type[j] >= _SLIDE:
            at = model.jnt_qposadr[j]
            posture[at] = np.clip(posture[at], *model.jnt_range[j])
    return posture


def _wider_side(model: mujoco.MjModel, joint: int) -> float:
    """Return by how much further a joint goes in its positive direction than in its negative."""
    if not model.jnt_limited[joint]:
        return 0.0
    start = model.qpos0[model.jnt_qposadr[joint]]
    low, high = model.jnt_range[joint]
    return float((high - start) - (start - low))


def _line(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    chain: Chain,
    end: Array | None = None,
    first: int = -1,
) -> Array:
    """Return the line of a finger to its end, or to the middle of its last link."""
    joints = list(chain.joints[chain.joints.index(first) if first >= 0 else 0 :])
    tip = data.xipos[chain.tip] if end is None else end
    slides = model.jnt_type[joints] == _SLIDE
    return finger_line(data.xanchor[joints], data.xaxis[joints], tip, slides)


def _phalanx(model: mujoco.MjModel, data: mujoco.MjData, chain: Chain) -> Array:
    return first_part(_line(model, data, chain), 2 * _NEAR)


def _palm_axes(
    model: mujoco.MjModel, data: mujoco.MjData, fingers: Mapping[Finger, Chain]
) -> Array:
    """Return distal, to the thumb's side of a right hand, and dorsal, as columns, (3, 3)."""
    others = [c for f, c in fingers.items() if f != "thumb"] or list(fingers.values())
    distal = np.sum([_phalanx(model, data, c) for c in others], axis=0)
    palmar = np.zeros(3)
    for chain in others:
        along = _phalanx(model, data, chain)
        for j in chain.joints:
            palmar += _wider_side(model, j) * np.cross(data.xaxis[j], along)
    distal = distal / max(float(np.linalg.norm(distal)), 1e-9)
    palmar = palmar - (palmar @ distal) * distal
    if np.linalg.norm(palmar) < 0.1 and "thumb" in fingers:  # ranges alike to both sides
        roots = np.mean([data.xanchor[c.joints[0]] for c in others], axis=0)
        palmar = data.xipos[fingers["thumb"].tip] - roots
        palmar = palmar - (palmar @ distal) * distal
    if np.linalg.norm(palmar) < 1e-6:
        palmar = np.cross(distal, np.eye(3)[int(np.argmin(np.abs(distal)))])
    dorsal = -palmar / np.linalg.norm(palmar)
    if np.linalg.norm(distal) < 0.5:
        distal = np.cross(np.eye(3)[int(np.argmin(np.abs(dorsal)))], dorsal)
        distal /= np.linalg.norm(distal)
    return np.column_stack([distal, np.cross(dorsal, distal), dorsal])


def _knuckles(
    model: mujoco.MjModel, data: mujoco.MjData, fingers: Mapping[Finger, Chain]
) -> dict[Finger, str]:
    """Return where fingers begin that have a joint in the palm besides those of the others."""
    found: dict[Finger, str] = {}
    others = [c for f, c in fingers.items() if f != "thumb"]
    usual = int(np.median([len(c.joints) for c in others])) if len(others) > 2 else 0
    for finger, chain in fingers.items():
        extra = len(chain.joints) - usual
        if usual and finger != "thumb" and extra > 0:
            first, second = data.xanchor[chain.joints[0]], data.xanchor[chain.joints[extra]]
            name = model.joint(chain.joints[extra]).name
            if name and np.linalg.norm(second - first) > _NEAR:
                found[finger] = name
    return found


def _first_joint(model: mujoco.MjModel, chain: Chain, knuckle: str | None) -> int:
    return next((j for j in chain.joints if model.joint(j).name == knuckle), chain.joints[0])


class _Fingertip:
    """The last link of a finger: where it ends, where it touches, and which way it points."""

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        chain: Chain,
        palm: Array,
        placeholders: Collection[str],
    ) -> None:
        self.body = chain.tip
        group = groups_of(model)[int(model.body_weldid[chain.tip])]
        anchor, axis = data.xanchor[chain.joints[-1]], data.xaxis[chain.joints[-1]]
        surface = triangles_of(model, data, group, placeholders)
        named = _named_tip(model, data, group)
        corners = surface.reshape(-1, 3)
        middle = _centre(surface) if len(corners) else data.xipos[chain.tip]
        along = (named if named is not None else middle) - anchor
        slides = model.jnt_type[chain.joints[-1]] == _SLIDE
        flat = along if slides else along - (along @ axis) * axis
        size = float(np.linalg.norm(flat))
        out = flat / size if size > 1e-3 else palm[:, 0]
        bends = np.cross(axis, out) * np.sign(_wider_side(model, chain.joints[-1]) or 1.0)
        palmar = -palm[:, 2] if slides or np.linalg.norm(bends) < 0.5 else bends
        palmar = palmar - (palmar @ out) * out
        palmar /= max(float(np.linalg.norm(palmar)), 1e-9)
        self.axes: Array = np.column_stack([out, np.cross(-palmar, out), -palmar])
        # Off the axis, the finger's middle is that of its surface.
        sideways = self.axes[:, 1]
        centre = anchor + ((middle - anchor) @ sideways) * sideways
        ends = [float(((corners - anchor) @ out).max())] if len(corners) else []
        if named is not None:
            ends.append(float((named - anchor) @ out))
        end = max(ends) if ends else float(np.linalg.norm(middle - anchor))
        self.end: Array = centre + end * out
        self.pad: Array = self._touching(surface, self.end, end)

    def _touching(self, surface: Array, end: Array, length: float) -> Array:
        """Return where the palmar surface is, as far before the end as the link is thick there."""
        out, palmar = self.axes[:, 0], -self.axes[:, 2]
        if not len(surface):
            return end
        near = surface[((end - surface.reshape(-1, 3, 3)) @ out).min(axis=1) < 0.3 * length]
        heights = (near.reshape(-1, 3) - end) @ palmar if len(near) else np.zeros(1)
        half = min(max(float(np.ptp(heights)) / 2, 0.002), 0.5 * length)
        core = end - half * out + float(heights.max() + heights.min()) / 2 * palmar
        reached = outermost(surface, core, palmar)
        return core + (reached if reached is not None else 0.0) * palmar


def _centre(triangles: Array) -> Array:
    """Return the centre of a surface, (3,) [m]."""
    sides = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = np.linalg.norm(sides, axis=1) + 1e-15
    return np.average(triangles.mean(axis=1), axis=0, weights=areas)


def _named_tip(model: mujoco.MjModel, data: mujoco.MjData, group: list[int]) -> Array | None:
    """Return where a body or site of a link is that is called a tip, away from the link's own."""
    places = [data.xpos[b] for b in group[1:] if "tip" in model.body(b).name.lower()] + [
        data.site_xpos[s]
        for s in range(model.nsite)
        if int(model.site_bodyid[s]) in group and "tip" in model.site(s).name.lower()
    ]
    for place in places:
        if np.linalg.norm(place - data.xpos[group[0]]) > _NEAR:
            return place.copy()
    return None


def _palm_origin(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    fingers: Mapping[Finger, Chain],
    begin: Mapping[Finger, int],
    tips: Mapping[Finger, _Fingertip],
    axes: Array,
    mirror: float = 1.0,
) -> Array:
    """Return where the wrist of a person would be whose fingers were as long, (3,) [m]."""
    person = HandGeometry(MEDIAN_HAND)
    others: list[Finger] = [f for f in fingers if f != "thumb"] or list(fingers)
    lines = [_line(model, data, fingers[f], tips[f].end, begin[f]) for f in others]
    roots = np.array([line[0] for line in lines])
    bones = [sum(LENGTHS[f]) * MEDIAN_HAND.length for f in others]
    scale = sum(map(length_of, lines)) / sum(bones)
    own = [person.thumb_cmc if f == "thumb" else person.mcp(f) for f in others]
    place = scale * np.mean(own, axis=0) * [1.0, mirror, 1.0]
    return roots.mean(axis=0) - axes @ place


def _side(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    fingers: Mapping[Finger, Chain],
    begin: Mapping[Finger, int],
    origin: Array,
    axes: Array,
    names: str,
) -> Side:
    """Return which human hand it resembles: the thumb is at +y of a right one."""
    others: list[Finger] = [f for f in fingers if f != "thumb"]
    across = {
        f: float((_line(model, data, c, None, begin[f])[0] - origin) @ axes[:, 1])
        for f, c in fingers.items()
    }
    if "thumb" in across and others:
        apart = across["thumb"] - float(np.mean([across[f] for f in others]))
        if abs(apart) > _NEAR:
            return "right" if apart > 0 else "left"
    if len(others) > 1 and abs(across[others[0]] - across[others[-1]]) > _NEAR:
        return "right" if across[others[0]] > across[others[-1]] else "left"
    return "left" if "left" in names.lower() else "right"


def _palm_body(model: mujoco.MjModel, palm: int, named: NamedLinks | None) -> int:
    """Return the body of the palm's group that is called so, or else its first."""
    group = groups_of(model)[palm]
    if named is not None and named.palm:
        body = model.body(named.palm).id
        if body in group:
            return int(body)
    called = [b for b in group if "palm" in model.body(b).name.lower()]
    return (called or [b for b in group if b > 0] or [0])[0]


def _attached(
    model: mujoco.MjModel, data: mujoco.MjData, body: int, pos: Array, axes: Array
) -> AttachedFrame:
    """Return a frame of the world as one of a body."""
    turned = data.xmat[body].reshape(3, 3)
    name = model.body(body).name
    if not name:
        raise InputError("a link has no name; give every body of the hand one")
    at = turned.T @ (pos - data.xpos[body])
    quat = Rotation.from_matrix(turned.T @ axes).as_quat(scalar_first=True)
    return AttachedFrame(
        name,
        (float(at[0]), float(at[1]), float(at[2])),
        (float(quat[0]), float(quat[1]), float(quat[2]), float(quat[3])),
    )
