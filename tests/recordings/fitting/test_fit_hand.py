"""Hands that were made by known angles are found again, from keypoints, in any frame and side."""

from dataclasses import replace

import numpy as np
import pytest
from seen_hand import SIZE, movement, poses, seen

from handsim.errors import InputError
from handsim.joints import JOINT_INDEX, LOWER, UPPER
from handsim.recordings.fitting.fit_hand import BAD_FIT_M, fit_hand
from handsim.recordings.points.keypoint_order import KEYPOINTS, expected_places
from handsim.types import HandSize

POINTS = expected_places()
KNOWN = tuple(replace(point, spread=(0.0, 0.0, 0.0)) for point in POINTS)
Q = movement()
FINGERS_SEEN = [j for name, j in JOINT_INDEX.items() if not name.startswith(("wrist", "palm"))]


def worst_deg(a, b, joints=FINGERS_SEEN) -> float:
    return float(np.rad2deg(np.abs(a - b)[:, joints]).max())


def test_size_pose_and_angles_are_found_again() -> None:
    fit = fit_hand("made", POINTS, seen(POINTS, Q), side="right")
    assert fit.hand.length == pytest.approx(SIZE.length, rel=0.03)
    assert fit.hand.breadth == pytest.approx(SIZE.breadth, rel=0.03)
    assert worst_deg(fit.q, Q) < 6
    assert np.rad2deg(np.abs(fit.q - Q)[:, FINGERS_SEEN]).mean() < 1.6
    rotation, position = poses(len(Q))
    assert np.abs(fit.position - position).max() < 0.004
    assert np.abs(fit.rotation - rotation).max() < 0.06
    assert np.nanmax(fit.frame_residual) < 0.001 and not fit.bad.any()
    assert (fit.q[:, 20:] == 0).all()  # the wrist lies before the palm


def test_known_size_and_places_are_kept_and_make_the_angles_exact() -> None:
    fit = fit_hand("made", KNOWN, seen(POINTS, Q), side="right", hand=SIZE)
    assert (fit.hand.length, fit.hand.breadth) == (SIZE.length, SIZE.breadth)
    assert np.abs(fit.points.offset).max() < 1e-6
    assert worst_deg(fit.q, Q) < 3.5


def test_the_side_is_told_and_a_left_hand_has_the_angles_of_its_mirror_image() -> None:
    left = HandSize(SIZE.length, SIZE.breadth, "left")
    q = movement(24)
    fits = {
        size.side: fit_hand("made", POINTS, seen(POINTS, q, size=size)) for size in (SIZE, left)
    }
    for side, fit in fits.items():
        assert fit.hand.side == side and fit.other_side > 2
    assert np.abs(fits["left"].q - fits["right"].q).max() < 1e-9
    mirror = np.array([1, -1, 1])
    assert np.abs(fits["left"].position - fits["right"].position * mirror).max() < 1e-9
    assert np.allclose(np.linalg.det(fits["left"].rotation), 1)
    for fit, size in ((fits["right"], SIZE), (fits["left"], left)):
        _, tip = fit.in_world("index_distal")
        dip = seen(POINTS, q, size=size)[:, KEYPOINTS.index("index_dip")]
        assert np.abs(tip - dip).max() < 0.008


def test_a_side_that_cannot_be_told_is_asked_for() -> None:
    places = 0.02 * np.random.default_rng(0).normal(size=(12, 21, 3))
    places[:, :, 2] = 0.0  # a flat picture is its own mirror image
    with pytest.raises(InputError, match="--side right or left"):
        fit_hand("flat", POINTS, places)


def test_angles_keep_to_their_ranges_where_points_do_not() -> None:
    q = movement()
    q[:, JOINT_INDEX["index_pip"]] -= np.deg2rad(30)  # bent back, as no PIP joint is
    fit = fit_hand("made", POINTS, seen(POINTS, q), side="right", hand=SIZE)
    assert (fit.q >= LOWER - 1e-12).all() and (fit.q <= UPPER + 1e-12).all()
    assert np.rad2deg(fit.q[:, JOINT_INDEX["index_pip"]]).min() == pytest.approx(0, abs=1e-9)


def test_what_is_not_seen_moves_evenly_and_the_rest_is_not_touched() -> None:
    whole = seen(POINTS, Q)
    gone = whole.copy()
    index = [i for i, name in enumerate(KEYPOINTS) if name.startswith("index") and i != 5]
    gone[20:30, index] = np.nan
    fit = fit_hand("made", KNOWN, gone, side="right", hand=SIZE)
    others = [j for j in FINGERS_SEEN if j not in [JOINT_INDEX[f"index_{p}"] for p in
              ("mcp", "pip", "dip", "abduction")]]  # fmt: skip
    assert worst_deg(fit.q, Q, others) < 3.5
    mcp = fit.q[19:31, JOINT_INDEX["index_mcp"]]
    assert np.abs(np.diff(mcp, 2)).max() < 1e-9  # on a straight line
    assert not fit.bad.any()
    gone[20:30, 3:] = np.nan
    lost = fit_hand("made", POINTS, gone, side="right", hand=SIZE)
    assert lost.lost.sum() == 10 and lost.bad.sum() == 10
    assert np.isnan(lost.frame_residual[20:30]).all() and np.isfinite(lost.q).all()


def test_a_bad_frame_is_marked_and_no_other() -> None:
    broken = seen(POINTS, Q)
    broken[33] += 0.03 * np.random.default_rng(1).normal(size=(21, 3))
    fit = fit_hand("made", POINTS, broken, side="right")
    assert np.flatnonzero(fit.bad).tolist() == [33]
    assert fit.frame_residual[33] > BAD_FIT_M


def test_too_few_frames_are_refused() -> None:
    gone = seen(POINTS, Q)
    gone[9:, 2:] = np.nan
    with pytest.raises(InputError, match="9 of 60 frames"):
        fit_hand("made", POINTS, gone, side="right")


def test_the_same_again() -> None:
    whole = seen(POINTS, Q[:15])
    first, second = (fit_hand("made", POINTS, whole, side="right") for _ in range(2))
    assert (first.q == second.q).all() and first.hand == second.hand
