"""Forward kinematics of the compiled hand against chains of rotations written out by hand."""

import numpy as np
import pytest

from handsim.hand.anthropometry import (
    CMC,
    LENGTHS,
    MCP,
    THUMB_DEPTH,
    THUMB_PRONATION_DEG,
    THUMB_SPLAY_DEG,
)
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import FINGERS, JOINT_INDEX, LOWER, UPPER
from handsim.types import HandSize


def turn(axis: str | np.ndarray, angle: float) -> np.ndarray:
    """Rotation matrix about a coordinate axis, or by Rodrigues' formula about a unit vector."""
    unit = np.eye(3)["xyz".index(axis)] if isinstance(axis, str) else axis
    cross = np.cross(np.eye(3), unit)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def fingertips(q: np.ndarray, length: float, breadth: float) -> np.ndarray:
    """Fingertips of the right hand in the forearm's frame, (5, 3) [m], from the tables alone."""
    a = dict(zip(JOINT_INDEX, q, strict=True))
    scale = np.array([length, breadth, breadth])
    wrist = turn("y", a["wrist_flexion"]) @ turn("z", a["wrist_deviation"])
    ends = [(np.array(table["middle"]) + table["ring"]) / 2 for table in (CMC, MCP)]
    near, far = (np.array([*end, 0.0]) * scale for end in ends)
    arch = turn((far - near) / np.linalg.norm(far - near), a["palm_arch"])

    tips = []
    for finger in FINGERS:
        first, second, third = (fraction * length * np.eye(3)[0] for fraction in LENGTHS[finger])
        if finger == "thumb":
            root = np.array([*CMC["thumb"], -THUMB_DEPTH]) * scale
            opening = np.deg2rad(THUMB_SPLAY_DEG) + a["thumb_abduction"]
            # The fingers' frame faces palmar (-z); a quarter turn about its own axis makes the
            # pad face ulnar, from where it is turned back a little to palmar.
            own = turn("x", -np.pi / 2 + np.deg2rad(THUMB_PRONATION_DEG))
            base = turn("x", -a["thumb_rotation"]) @ turn("z", opening) @ own
            bends = a["thumb_mcp"], a["thumb_ip"]
        else:
            root = np.array([*MCP[finger], 0.0]) * scale
            ulnar = finger in ("ring", "little")
            spread = 0.0 if finger == "middle" else a[f"{finger}_abduction"]
            base = turn("y", a[f"{finger}_mcp"]) @ turn("z", -spread if ulnar else spread)
            bends = a[f"{finger}_pip"], a[f"{finger}_dip"]
            if ulnar:
                root, base = near + arch @ (root - near), arch @ base
        chain = first + turn("y", bends[0]) @ (second + turn("y", bends[1]) @ third)
        tips.append(wrist @ (root + base @ chain))
    return np.array(tips)


@pytest.mark.parametrize("side", ["right", "left"])
@pytest.mark.parametrize("size", [(0.1933, 0.0883), (0.13, 0.05), (0.26, 0.12)])
def test_fingertips_are_where_the_closed_form_puts_them(size, side):
    hand = HandModel.from_spec(build_hand(HandSize(*size, side)))
    mirror = [1, 1, 1] if side == "right" else [1, -1, 1]
    rng = np.random.default_rng(5)
    for q in rng.uniform(LOWER, UPPER, size=(40, 22)):
        hand.set_posture(q)
        assert np.allclose(hand.fingertips(), fingertips(q, *size) * mirror, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("joint", "finger", "direction"),
    [
        ("index_mcp", "index", (0, 0, -1)),
        ("middle_pip", "middle", (0, 0, -1)),
        ("little_dip", "little", (0, 0, -1)),
        ("index_abduction", "index", (0, 1, 0)),
        ("ring_abduction", "ring", (0, -1, 0)),
        ("little_abduction", "little", (0, -1, 0)),
        ("palm_arch", "little", (0, 0, -1)),
        ("wrist_flexion", "middle", (0, 0, -1)),
        ("wrist_deviation", "middle", (0, 1, 0)),
        ("thumb_rotation", "thumb", (0, 0, -1)),
        ("thumb_abduction", "thumb", (0, 1, 0)),
        ("thumb_mcp", "thumb", (0, -1, 0)),
        ("thumb_ip", "thumb", (0, -1, 0)),
    ],
)
def test_positive_angles_move_the_fingertip_this_way(joint, finger, direction):
    """+x distal, +y to the thumb's side, +z dorsal: flexion goes to -z."""
    hand = HandModel.from_spec(build_hand())
    q = np.zeros(22)
    hand.set_posture(q)
    before = hand.fingertips()[FINGERS.index(finger)].copy()
    q[JOINT_INDEX[joint]] = np.deg2rad(5)
    hand.set_posture(q)
    moved = hand.fingertips()[FINGERS.index(finger)] - before
    assert moved @ direction > 0.8 * np.linalg.norm(moved[1:]) > 0


def test_pads_face_palmar_and_the_thumbs_ulnar_in_the_flat_hand():
    hand = HandModel.from_spec(build_hand())
    hand.set_posture(np.zeros(22))
    places, normals = hand.pads()
    assert np.allclose(normals[1:], [0, 0, -1])
    assert normals[0, 1] < -0.8
    below = hand.fingertips()[1:, 2] - places[1:, 2]
    assert np.all((below > 0.005) & (below < 0.010))
