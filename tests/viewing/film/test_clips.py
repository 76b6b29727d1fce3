from pathlib import Path

import imageio.v3 as iio
import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from handsim.errors import InputError
from handsim.types import Frame
from handsim.viewing.film.clip import Clip
from handsim.viewing.film.clip_player import UNMOVED, Player
from handsim.viewing.film.clips import (
    frame_times,
    render_clips,
    render_sheet,
    save_clips,
)
from handsim.viewing.film.offscreen import LoadedModel, View, open_offscreen

SMALL = View(camera="fixed", width=64, height=48, fps=10)


def lift(model: mujoco.MjModel, duration: float = 1.0, height: float = 0.6) -> Clip:
    """The ball goes up and turns about x by a right angle."""
    time = np.linspace(0, duration, 11)
    share = time / duration
    turns = Slerp([0, 1], Rotation.from_euler("x", [[0], [90]], degrees=True))(share)
    qpos = np.column_stack(
        [0 * time, 0 * time, 0.3 + height * share, turns.as_quat(scalar_first=True)]
    )
    return Clip(model, 5.0 + time, qpos)


def drawn(clips: list[Clip], view: View, columns: int | None = None) -> list[Frame]:
    return list(render_clips(clips, view, columns))


class Stamp:
    """An overlay that writes down when it was asked to draw."""

    def __init__(self) -> None:
        self.times: list[float] = []

    def draw(self, frame: Frame, time: float) -> None:
        self.times.append(time)
        frame[:4, :4] = (255, 0, 255)


@pytest.mark.parametrize("fps", [1, 24, 29.97, 30, 60])
@pytest.mark.parametrize("duration", [0.0, 0.03, 1.0, 1.99, 10.0])
def test_a_video_lasts_as_long_as_the_movement_to_within_one_frame(
    fps: float, duration: float
) -> None:
    times = frame_times(duration, fps)
    assert times[0] == 0
    assert times[-1] <= duration + 1e-6
    assert abs(len(times) / fps - duration) <= 1 / fps + 1e-6
    np.testing.assert_allclose(np.diff(times), 1 / fps)


@pytest.mark.parametrize("time", [0.0, 0.1, 0.1234, 0.55, 1.0, 7.0])
def test_states_between_samples_lie_on_the_shortest_way(
    rendering: str, ball: mujoco.MjModel, time: float
) -> None:
    clip = lift(ball)
    sparse = Clip(ball, clip.time[[0, 10]], clip.qpos[[0, 10]])
    with open_offscreen(16, 16) as offscreen:
        players = [Player(each, offscreen, "fixed") for each in (clip, sparse)]
        for player in players:
            player._pose(time)
    share = min(time, 1.0)
    expected = Rotation.from_euler("x", 90 * share, degrees=True).as_quat(scalar_first=True)
    for player in players:
        np.testing.assert_allclose(player.data.qpos[2], 0.3 + 0.6 * share, atol=1e-12)
        np.testing.assert_allclose(player.data.qpos[3:], expected, atol=1e-12)


def test_frames_follow_the_movement_and_end_with_it(rendering: str, ball: mujoco.MjModel) -> None:
    frames = drawn([lift(ball)], SMALL)
    assert len(frames) == 11
    assert all(frame.shape == (48, 64, 3) for frame in frames)
    assert len({frame.tobytes() for frame in frames}) == 11
    heights = [np.nonzero((frame > 110).all(axis=-1))[0].mean() for frame in frames]
    assert all(np.diff(heights) < 0), "the ball rises in the picture"


def test_a_movement_of_one_state_is_one_frame(rendering: str, ball: mujoco.MjModel) -> None:
    clip = Clip(ball, np.zeros(1), ball.qpos0[None])
    assert len(drawn([clip], SMALL)) == 1


def test_overlays_are_drawn_on_every_frame_at_its_time(
    rendering: str, ball: mujoco.MjModel
) -> None:
    stamp = Stamp()
    clip = lift(ball)
    frames = drawn([Clip(ball, clip.time, clip.qpos, (stamp,))], SMALL)
    np.testing.assert_allclose(stamp.times, np.arange(11) / 10, atol=1e-9)
    assert all((frame[:4, :4] == (255, 0, 255)).all() for frame in frames)


def test_grid_holds_each_movement_in_its_cell(rendering: str, ball: mujoco.MjModel) -> None:
    clips = [lift(ball), lift(ball, height=0.1), lift(ball, duration=0.5)]
    grid = drawn(clips, SMALL, columns=2)
    assert len(grid) == 11
    assert grid[0].shape == (98, 130, 3)
    wide = View(camera="fixed", width=130, height=48, fps=10)
    for clip, rows, columns, cell in (
        (clips[0], slice(0, 48), slice(0, 64), SMALL),
        (clips[1], slice(0, 48), slice(66, 130), SMALL),
        (clips[2], slice(50, 98), slice(0, 130), wide),
    ):
        alone = drawn([clip], cell)
        for i, frame in enumerate(grid):
            np.testing.assert_array_equal(frame[rows, columns], alone[min(i, len(alone) - 1)])


def test_side_by_side(rendering: str, ball: mujoco.MjModel) -> None:
    frames = drawn([lift(ball), lift(ball)], View("fixed", 64, 48, fps=2), columns=2)
    assert frames[0].shape == (48, 130, 3)
    np.testing.assert_array_equal(frames[1][:, :64], frames[1][:, 66:])


def test_a_state_is_drawn_once_however_long_it_lasts(
    rendering: str, ball: mujoco.MjModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    times = []
    draw = LoadedModel.draw
    monkeypatch.setattr(LoadedModel, "draw", lambda *a: (times.append(1), draw(*a))[1])
    still = Clip(ball, np.arange(3.0), ball.qpos0[None].repeat(3, axis=0), (Stamp(),))
    frames = drawn([still], SMALL)
    assert len(frames) == 21
    assert sum(times) == 1
    frames[0][:] = 0
    assert frames[1].any(), "each frame is an array of its own"
    times.clear()
    creeping = np.tile(ball.qpos0, (21, 1))
    creeping[:, 2] += 0.3 * UNMOVED * np.arange(21)
    drawn([Clip(ball, np.arange(21) / 10, creeping)], SMALL)
    assert sum(times) == 6, "what creeps is followed"


def test_sheet_spreads_states_over_the_way_not_over_time(
    rendering: str, ball: mujoco.MjModel
) -> None:
    clip = lift(ball)
    waiting = Clip(
        ball,
        np.concatenate([clip.time - 100, clip.time]),
        np.concatenate([clip.qpos[:1].repeat(11, axis=0), clip.qpos]),
        (Stamp(),),
    )
    sheet = render_sheet(waiting, SMALL, n=4, columns=4)
    assert sheet.shape == (48, 4 * 64 + 3 * 2, 3)
    cells = [sheet[:30, i * 66 : i * 66 + 64] for i in range(4)]
    assert len({cell.tobytes() for cell in cells}) == 4, "no posture is shown twice"
    assert not (sheet == (255, 0, 255)).all(axis=-1).any(), "overlays are left out"


def test_sheet_of_a_movement_that_stays_is_one_picture(
    rendering: str, ball: mujoco.MjModel
) -> None:
    clip = Clip(ball, np.arange(3.0), ball.qpos0[None].repeat(3, axis=0))
    assert render_sheet(clip, SMALL, n=8).shape == (48, 64, 3)


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_suffix_chooses_video(
    rendering: str, ball: mujoco.MjModel, target: Path, suffix: str
) -> None:
    assert save_clips([lift(ball)], target / f"a{suffix}", SMALL) == 11


def test_suffix_chooses_picture(rendering: str, ball: mujoco.MjModel, target: Path) -> None:
    assert save_clips([lift(ball)], target / "one.png", SMALL, n_postures=6, columns=3) == 6
    assert save_clips([lift(ball)] * 5, target / "five.png", SMALL) == 5
    assert iio.imread(target / "one.png").shape == (2 * 48 + 2, 3 * 64 + 2 * 2, 3)
    assert iio.imread(target / "five.png").shape == (2 * 48 + 2, 3 * 64 + 2 * 2, 3)


def test_arrays_that_do_not_belong_together(ball: mujoco.MjModel) -> None:
    with pytest.raises(InputError, match=r"qpos of shape \(3, 6\) for 3 times; give \(3, 7\)"):
        Clip(ball, np.arange(3.0), np.zeros((3, 6)))
    with pytest.raises(InputError, match="does not increase"):
        Clip(ball, np.array([0.0, 1.0, 1.0]), np.zeros((3, 7)))
    with pytest.raises(InputError, match="no movements"):
        drawn([], SMALL)


def test_context_is_freed_when_only_some_frames_are_taken(
    rendering: str, ball: mujoco.MjModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    freed = []
    stream = render_clips([lift(ball)], SMALL)
    next(stream)
    original = mujoco.MjrContext.free
    monkeypatch.setattr(
        mujoco.MjrContext, "free", lambda context: (freed.append(1), original(context))
    )
    stream.close()
    assert freed == [1]


def test_a_pause_shows_the_last_state_and_its_time(rendering: str, ball: mujoco.MjModel) -> None:
    stamp, clip = Stamp(), lift(ball)
    waiting = Clip(ball, clip.time, clip.qpos, (stamp,), pause=0.5)
    frames = drawn([waiting], SMALL)
    assert len(frames) == 16
    assert set(stamp.times[10:]) == {1.0}
    for frame in frames[11:]:
        np.testing.assert_array_equal(frame, frames[10])


def test_a_second_view_is_set_into_the_usual_one_where_there_is_room(
    rendering: str, ball: mujoco.MjModel
) -> None:
    clip = lift(ball)
    beside = Clip(ball, clip.time, clip.qpos, beside=("fixed",))
    for view, inset in (
        (View("view", 320, 240, fps=1), True),
        (View("view", 160, 120, fps=1), False),
        (View("top", 320, 240, fps=1), False),
    ):
        alone, both = drawn([clip], view)[0], drawn([beside], view)[0]
        rows, columns = np.nonzero((alone != both).any(axis=-1))
        assert bool(rows.size) == inset, view
        if inset:
            assert rows.min() > 0.6 * 240
            assert columns.min() > 0.6 * 320
            small = drawn([clip], View("fixed", 109, 82, fps=1))[0]
            place = both[240 - 5 - 2 - 82 : 240 - 5 - 2, 320 - 5 - 2 - 109 : 320 - 5 - 2]
            assert np.abs(place.astype(int) - small).mean() < 3
