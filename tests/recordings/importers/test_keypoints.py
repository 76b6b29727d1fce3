"""From files of keypoints to recordings: a hand made by known angles, and two published files."""

from pathlib import Path

import numpy as np
import pytest
from seen_hand import SIZE, movement, seen

from handsim.errors import FileError
from handsim.hand.kinematics import Kinematics
from handsim.joints import FINGERS, JOINT_INDEX, LOWER, UPPER
from handsim.recordings.importers.import_files import import_recordings
from handsim.recordings.importers.layout import ImportOptions
from handsim.recordings.points.keypoint_order import ORDERS, expected_places
from handsim.recordings.recording import Recording
from handsim.types import HandSize

REAL = Path(__file__).parents[3] / "../shared/data/keypoints"
real_data = pytest.mark.skipif(not REAL.is_dir(), reason="no published recordings in ../shared")
POINTS = expected_places()
Q = movement(30)


def imported(file: Path, **said: object) -> Recording:
    return import_recordings([file], "keypoints", options=ImportOptions(**said))[0]  # type: ignore[arg-type]


def error_deg(recording: Recording) -> float:
    return float(np.rad2deg(np.abs(recording.q - Q)[:, :19]).mean())


def test_a_left_hand_in_millimetres_and_manos_order(tmp_path: Path) -> None:
    size = HandSize(SIZE.length, SIZE.breadth, "left")
    points = np.empty((30, 21, 3))
    points[:, ORDERS["MANO"]] = 1000 * seen(POINTS, Q, size=size)
    np.savez(tmp_path / "grasp.npz", points=points, t=40.0 * np.arange(30))
    recording = imported(tmp_path / "grasp.npz", subject=3, object="cup", task="drink")
    assert (recording.name, recording.subject, recording.object, recording.task) == (
        "grasp", "3", "cup", "drink"
    )  # fmt: skip
    assert recording.hand.side == "left" and error_deg(recording) < 2
    assert recording.time == pytest.approx(0.04 * np.arange(30))
    notes = "; ".join(recording.notes)
    for said in (
        "times taken as ms",
        "MANO's order",
        "taken as mm",
        "a left hand",
        "wrist_flexion",
    ):
        assert said in notes
    assert "assumed" not in notes


def test_channels_and_marks(tmp_path: Path) -> None:
    points = seen(POINTS, Q)
    points[12] += 0.04 * np.random.default_rng(0).normal(size=(21, 3))
    points[20, 8] = np.nan  # one tip in one frame: bridged
    np.savez(tmp_path / "a.npz", points)
    recording = imported(tmp_path / "a.npz", side="right", rate_hz=60.0)
    channels = recording.channels
    assert np.flatnonzero(channels["fit_bad"]).tolist() == [12]
    assert channels["fit_residual_m"][12] > 0.01
    assert np.median(channels["fit_residual_m"]) < 0.002
    good = np.arange(30) != 12
    aperture = np.linalg.norm(points[:, 4] - points[:, 8], axis=1)[good & (np.arange(30) != 20)]
    assert np.abs(channels["aperture_m"][good & (np.arange(30) != 20)] - aperture).max() < 0.004
    palm = np.stack([channels[f"palm_{axis}_m"] for axis in "xyz"], axis=1)
    middle = (points[:, 0] + points[:, 9]) / 2  # of wrist and middle MCP, as they were learned
    assert np.abs(palm - middle)[good].max() < 0.010
    quaternion = np.stack([channels[f"palm_q{part}"] for part in "wxyz"], axis=1)
    assert np.allclose(np.linalg.norm(quaternion, axis=1), 1)
    notes = "; ".join(recording.notes)
    assert "1 of 30 frames marked fit_bad" in notes and "1 frame with points missing" in notes
    assert recording.duration == pytest.approx(29 / 60)
    assert (recording.q[:, 20:] == 0).all()
    assert recording.not_seen == {"wrist_flexion", "wrist_deviation"}


def test_a_stated_size_is_kept(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", seen(POINTS, Q))
    hand = HandSize(0.18, 0.09)
    assert imported(tmp_path / "a.npz", hand=hand, side="right").hand == hand


def test_files_without_a_hand(tmp_path: Path) -> None:
    for points, said in (
        (np.zeros((20, 21, 3)), "coincide or are missing"),
        (seen(POINTS, Q)[:9], "9 frames"),
        (np.full((20, 21, 3), np.nan), "coincide or are missing"),
        (np.full((20, 21, 3), 1e200), "coincide or are missing"),
    ):
        np.savez(tmp_path / "a.npz", points)
        with pytest.raises(FileError, match=rf"a\.npz: .*{said}"):
            imported(tmp_path / "a.npz")


@real_data
@pytest.mark.real_data
@pytest.mark.parametrize(
    ("name", "most_mm", "tips_mm"), [("free_hand", 6.0, 6.0), ("mustard", 2.0, 1.5)]
)
def test_published_keypoints_become_hands(name: str, most_mm: float, tips_mm: float) -> None:
    recording = imported(REAL / f"{name}.npz")
    outside = (recording.q < LOWER - 1e-6) | (recording.q > UPPER + 1e-6)
    assert outside.mean(axis=0).max() <= 0.02
    assert recording.hand.side == "right"
    assert 1000 * np.sqrt((recording.channels["fit_residual_m"] ** 2).mean()) < most_mm
    assert recording.channels["fit_bad"].mean() < 0.01
    with np.load(REAL / f"{name}.npz") as file:
        points = file["keypoints"]
    hand = Kinematics(recording.hand)
    tips = hand.points(hand.frames(recording.q), hand.fingertips)
    for i, finger in enumerate(FINGERS[1:], start=1):
        made = np.linalg.norm(tips[:, i] - tips[:, 0], axis=1)
        there = np.linalg.norm(points[:, 4 + 4 * i] - points[:, 4], axis=1)
        assert 1000 * np.sqrt(((made - there) ** 2).mean()) < tips_mm, finger
        assert np.corrcoef(made, there)[0, 1] > 0.98
    flexions = recording.q[:, [JOINT_INDEX[f"{finger}_pip"] for finger in FINGERS[1:]]]
    assert (
        np.median(flexions, axis=0) > np.deg2rad(5)
    ).all()  # fingers flex, they do not bend back
