"""The 21 keypoints of a hand, the orders in which they come, and the unit they are in.

The order here is that of MediaPipe and OpenPose: the wrist, then thumb, index, middle, ring and
little finger, four each from root to tip. Others are brought to it: MANO's own (the joints of
index, middle, little, ring, thumb, then five tips) and those of OpenXR (26 joints) and WebXR (25),
which have palm and metacarpals beside.
"""

from types import MappingProxyType

import numpy as np

from handsim.hand.anthropometry import CMC, LENGTHS, MCP, THUMB_DEPTH, palm_body, segment_names
from handsim.joints import FINGERS
from handsim.recordings.fitting.fit_hand import root_mean_square
from handsim.recordings.fitting.hand_points import HandPoint
from handsim.types import Array

N_KEYPOINTS = 21
KEYPOINTS: tuple[str, ...] = (
    "wrist",
    *(
        f"{finger}_{place}"
        for finger in FINGERS
        for place in (
            ("cmc", "mcp", "ip", "tip") if finger == "thumb" else ("mcp", "pip", "dip", "tip")
        )
    ),
)
"""Names of the keypoints in the order of MediaPipe."""

_FINGERS_OF_XR = tuple(i for start in (7, 12, 17, 22) for i in range(start, start + 4))
ORDERS: MappingProxyType[str, tuple[int, ...]] = MappingProxyType(
    {
        "MediaPipe": tuple(range(21)),
        "MANO": (0, 13, 14, 15, 16, 1, 2, 3, 17, 4, 5, 6, 18, 10, 11, 12, 19, 7, 8, 9, 20),
        "OpenXR": (1, 2, 3, 4, 5, *_FINGERS_OF_XR),
        "WebXR": (0, 1, 2, 3, 4, *(i - 1 for i in _FINGERS_OF_XR)),
    }
)
"""Places of the 21 keypoints in orders by their name."""
COUNTS: tuple[int, ...] = (21, 25, 26)
"""Numbers of points a frame that are understood."""

CLEARLY_SHORTER = 0.9
"""Bones in MANO's order are shorter than this part of those in MediaPipe's, if it is MANO's."""
PALM_LENGTH = 0.0862
"""Wrist to the middle finger's knuckle of the median hand, `MCP` of `HandGeometry` [m]."""
_PALM_RANGE = (0.03, 0.20)
_UNITS = (("m", 1.0), ("cm", 0.01), ("mm", 0.001))


def expected_places() -> tuple[HandPoint, ...]:
    """Return the keypoints as points on the hand.

    What networks and suits call a knuckle lies up to a centimetre from the centre of the joint, so
    that these have some freedom; a fingertip is a fingertip. Noise: as free movement in front of a
    camera shows it; tips are held tighter, since they are what grasps.
    """
    made = [HandPoint("wrist", "palm", (0.0, 0.0, 0.0), (0.010, 0.006, 0.006), 0.006)]
    # palm_ulnar begins where the arch's axis leaves the carpus, between the middle and ring bones.
    arch = tuple((a + b) / 2 for a, b in zip(CMC["middle"], CMC["ring"], strict=True))
    for finger in FINGERS:
        body, segments = palm_body(finger), segment_names(finger)
        if finger == "thumb":
            root, spread = (*CMC["thumb"], -THUMB_DEPTH), (0.015, 0.008, 0.008)
        else:
            x, y = MCP[finger]
            from_x, from_y = arch if body == "palm_ulnar" else (0.0, 0.0)
            root, spread = (x - from_x, y - from_y, 0.0), (0.008, 0.004, 0.004)
        ends = [(length, 0.0, 0.0) for length in LENGTHS[finger]]
        made += [
            HandPoint("", body, root, spread, 0.006),
            HandPoint("", segments[0], ends[0], (0.008, 0.003, 0.003), 0.006),
            HandPoint("", segments[1], ends[1], (0.006, 0.003, 0.003), 0.006),
            HandPoint("", segments[2], ends[2], (0.001, 0.001, 0.001), 0.003),
        ]
    return tuple(
        HandPoint(name, each.body, each.place, each.spread, each.noise)
        for name, each in zip(KEYPOINTS, made, strict=True)
    )


def in_order(points: Array) -> tuple[Array, str]:
    """Return points (n, k, 3), k of `COUNTS`, as the 21 in MediaPipe's order, and their own order.

    Of two orders with 21 points it is the one that leaves the fingers' bones short.
    """
    if points.shape[1] == 26:
        return points[:, ORDERS["OpenXR"]], "OpenXR"
    if points.shape[1] == 25:
        return points[:, ORDERS["WebXR"]], "WebXR"
    bones = {name: _finger_bones(points[:, ORDERS[name]]) for name in ("MediaPipe", "MANO")}
    name = "MANO" if bones["MANO"] < CLEARLY_SHORTER * bones["MediaPipe"] else "MediaPipe"
    return points[:, ORDERS[name]], name


def _finger_bones(points: Array) -> float:
    """Mean length of the bones of the fingers from knuckle to tip."""
    fingers = points[:, 1:].reshape(len(points), 5, 4, 3)
    bones = np.linalg.norm(np.diff(fingers, axis=2), axis=3)
    there = np.isfinite(bones)
    return float(np.where(there, bones, 0.0).sum() / max(there.sum(), 1))


def metres_per_unit(points: Array, hand_length: float | None) -> tuple[float, str]:
    """Return the factor that brings keypoints (n, 21, 3) to metres, and what they were.

    By the distance from the wrist to the middle finger's knuckle; 0 where there is none.
    """
    palm = _median(np.linalg.norm(points[:, 9] - points[:, 0], axis=1))
    if not np.isfinite(palm) or palm <= 0:
        return 0.0, "nothing"
    if not _in_picture(points):
        for name, factor in _UNITS:
            if _PALM_RANGE[0] <= palm * factor < _PALM_RANGE[1]:
                return factor, name
    wanted = PALM_LENGTH if hand_length is None else 0.446 * hand_length
    return wanted / palm, "a unit of their own"


def _in_picture(points: Array) -> bool:
    """Whether they are MediaPipe's places in a picture: x and y from 0 to 1, z from the wrist."""
    flat = points[np.isfinite(points).all(axis=(1, 2))]
    if not len(flat):
        return False
    inside = (flat[..., :2] >= -0.05).all() and (flat[..., :2] <= 1.05).all()
    wrist = root_mean_square(flat[:, 0])
    return bool(inside and np.abs(flat[:, 0, 2]).max() < 1e-4 * wrist)


def _median(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else np.nan
