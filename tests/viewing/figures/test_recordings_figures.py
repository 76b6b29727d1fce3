"""Pictures of recordings and of what was cut: what is drawn in them, not how it looks."""

from dataclasses import replace
from pathlib import Path

import imageio.v3 as iio
import numpy as np
import pytest

from handsim.joints import JOINTS, UPPER
from handsim.recordings.cutting.reach import Reach
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import HandSize
from handsim.viewing.figures.cutting_figure import AMBER, MAX_STRIPS, cutting_figure
from handsim.viewing.figures.recordings_figure import recordings_figure
from handsim.viewing.figures.style import BLUE, VERMILION, save_picture


def closing(name: str, n: int = 200) -> Recording:
    share = np.clip(np.linspace(-1, 2, n), 0, 1)
    return Recording(
        name, np.arange(n) / 100, np.outer(share, 0.6 * UPPER), 1, "s", "o", "t", HandSize()
    )


def lines(axes, colour: str) -> list[np.ndarray]:
    return [line.get_xydata() for line in axes.lines if line.get_color() == colour]


def test_a_panel_a_joint_with_its_range_and_what_leaves_it() -> None:
    out = np.array(closing("a").q)
    out[50:60, 4] = UPPER[4] + 0.2
    two = RecordingSet((replace(closing("a"), q=out), closing("b", 120)))
    figure = recordings_figure(two)
    assert [a.get_title(loc="left") for a in figure.axes[:22]] == [
        joint.name.replace("_", " ") for joint in JOINTS
    ]
    index = figure.axes[4]
    assert [len(data) for data in lines(index, BLUE)] == [200, 120]
    assert index.get_title(loc="right") == "10 out"
    assert figure.axes[5].get_title(loc="right") == ""
    marked = np.concatenate(lines(index, VERMILION))
    np.testing.assert_allclose(marked[:, 1], np.rad2deg(UPPER[4] + 0.2))
    least, greatest = index.get_ylim()
    assert least < JOINTS[4].lower_deg and greatest > np.rad2deg(UPPER[4] + 0.2)
    assert "320 frames, 10 of them (3.1 %)" in figure.get_suptitle()
    assert lines(index, BLUE)[1][-1, 0] == 1.0  # several: shares of the duration


def test_one_recording_is_drawn_over_its_seconds() -> None:
    figure = recordings_figure(RecordingSet((closing("a"),)))
    assert lines(figure.axes[0], BLUE)[0][-1, 0] == pytest.approx(1.99)
    assert figure.get_suptitle().startswith("a: 200 frames")


def reach(name: str, start: float, sure: float = 1.0, second=None) -> Reach:
    return Reach(name, start, start + 0.4, start + 0.6, sure, "why not", second)


def spans(axes) -> list[tuple[float, float]]:
    return [(p.get_x(), p.get_x() + p.get_width()) for p in axes.patches]


def test_what_was_cut_is_marked_and_its_confidence_written() -> None:
    two = RecordingSet((closing("a", 400), closing("b", 400)))
    reaches = [reach("a", 1.0), reach("b", 1.0, 0.55, (1.0, 2.2))]
    figure = cutting_figure(two, reaches)
    assert len(figure.axes) == 2
    assert spans(figure.axes[0])[:2] == [
        (1.0, pytest.approx(1.4)),
        (pytest.approx(1.4), pytest.approx(1.6)),
    ]
    assert [text.get_text() for text in figure.axes[0].texts] == ["1.00"]
    assert lines(figure.axes[0], AMBER) == []
    bracket = lines(figure.axes[1], AMBER)
    assert len(bracket) == 1 and list(bracket[0][:, 0]) == [1.0, 2.2]
    assert "why not" in figure.axes[1].get_title(loc="left")
    assert figure.get_suptitle() == "1 reach cut from 2 recordings, 1 doubtful"


def test_long_recordings_take_several_rows_and_many_are_not_all_drawn() -> None:
    long = closing("a", 6000)
    many = [reach("a", 1.0 + i) for i in range(50)]
    figure = cutting_figure(RecordingSet((long,)), many)
    assert len(figure.axes) == 3
    assert sum(len(axes.texts) for axes in figure.axes) == 50
    assert figure.axes[1].get_xlim() == pytest.approx((19.997, 39.993), abs=0.01)
    crowd = RecordingSet(tuple(closing(f"r{i}") for i in range(40)))
    figure = cutting_figure(crowd, [reach("r39", 0.5, 0.6)])
    assert len(figure.axes) == MAX_STRIPS
    assert "r39" in figure.axes[-1].get_title(loc="left")
    assert "10 recordings are not drawn" in figure.get_suptitle()


def test_pictures_are_written(tmp_path: Path) -> None:
    one = RecordingSet((closing("a"),))
    save_picture(cutting_figure(one, [reach("a", 0.5)]), tmp_path / "cut.png")
    save_picture(recordings_figure(one), tmp_path / "info.png")
    assert iio.imread(tmp_path / "cut.png").shape[1] == 1440
    assert iio.imread(tmp_path / "info.png").std() > 10
