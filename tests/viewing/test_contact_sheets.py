from pathlib import Path

import imageio.v3 as iio
import numpy as np
import numpy.typing as npt
import pytest

from handsim.files import data_folder
from handsim.recordings.folder import read_recordings
from handsim.tasks.table_one import task_by_name
from handsim.types import Frame
from handsim.viewing.contact_sheets import (
    grasp_sheet,
    hand_sheet,
    keyframe_sheet,
    main,
    retargeting_sheet,
)

ROBOT = Path(__file__).parents[1] / "retargeting" / "data" / "four_finger_hand.xml"
TIPS = {"thumb": "thumb_touch", "index": "f1_touch", "middle": "f2_touch", "ring": "f3_touch"}

pytestmark = pytest.mark.usefixtures("rendering")


def skin(frame: Frame) -> npt.NDArray[np.bool_]:
    """Pixels that are of the hand: more red than blue, by far more than the background."""
    return frame[..., 0].astype(int) - frame[..., 2] > 40


def cells(sheet: Frame, rows: int, columns: int) -> list[Frame]:
    """The pictures of a sheet, without the gaps of 2 pixels between them."""
    height, width = (sheet.shape[0] + 2) // rows, (sheet.shape[1] + 2) // columns
    return [
        sheet[r * height : (r + 1) * height - 2, c * width : (c + 1) * width - 2]
        for r in range(rows)
        for c in range(columns)
    ]


def test_hands_of_both_sides_mirrored_and_to_one_scale():
    pictures = cells(hand_sheet(("woman-5", "man-95")), 2, 8)
    for right, left in zip(pictures[:3], pictures[4:7], strict=True):
        # Without the label at the lower left.
        apart = skin(right)[:-30] ^ skin(left[:, ::-1])[:-30]
        assert apart.mean() < 0.01 < skin(right).mean()
    small, large = (skin(pictures[i])[:-30] for i in (0, 8))
    assert large.sum() > 1.3 * small.sum()
    assert large.any(axis=1).argmax() < small.any(axis=1).argmax(), "it reaches higher"


def test_every_keyframe_has_its_picture():
    pictures = cells(keyframe_sheet(), 3, 4)
    assert all(0.02 < skin(picture).mean() < 0.5 for picture in pictures)
    for i, first in enumerate(pictures):
        for second in pictures[i + 1 :]:
            assert np.mean(skin(first) ^ skin(second)) > 0.005


def test_grasp_frames_with_the_open_hand_before_the_object():
    tasks = [task_by_name("cube-raise"), task_by_name("jar-unscrew")]
    for picture in cells(grasp_sheet(tasks), 1, 2):
        colours = picture.astype(int)
        blue = (colours[..., 2] > colours[..., 0] + 60) & (colours[..., 2] > colours[..., 1] + 40)
        assert blue.sum() > 30, "the axis against the approach"
        centre = np.argwhere(blue).mean(axis=0) / picture.shape[:2]
        assert np.all(np.abs(centre - 0.5) < 0.2)
        assert skin(picture[: len(picture) // 2]).mean() > 0.05, "the hand above it"


def test_robot_hand_moves_as_the_recorded_one_does():
    recording = read_recordings(data_folder("assets") / "experiments")[0]
    pictures = cells(retargeting_sheet(ROBOT, "base_frame", TIPS, recording, n=3), 2, 3)
    for row in (pictures[:3], pictures[3:]):
        drawn = [picture[:-30].astype(int).sum(axis=2) < 500 for picture in row]
        assert all(0.02 < mask.mean() < 0.6 for mask in drawn)
        assert np.mean(drawn[0] ^ drawn[2]) > 0.01, "it has moved"
    assert skin(pictures[0]).mean() > 0.02
    assert skin(pictures[3]).mean() < 0.01, "the robot has no skin"


def test_command_writes_the_sheet(target, monkeypatch, capsys):
    file = target / "rt.png"
    robot = ["--robot", str(ROBOT), "--palm", "base_frame", "--fingertips"]
    tips = [f"{finger}={name}" for finger, name in TIPS.items()]
    monkeypatch.setattr("sys.argv", ["sheets", "retargeting", str(file), *robot, *tips])
    main()
    assert iio.imread(file).shape[1] > 1000
    monkeypatch.setattr("sys.argv", ["sheets", "retargeting", str(file)])
    with pytest.raises(SystemExit):
        main()
    assert "--fingertips" in capsys.readouterr().err
