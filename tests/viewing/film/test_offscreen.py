import mujoco
import numpy as np
import pytest

from handsim.errors import InputError
from handsim.viewing.film.offscreen import View, open_offscreen, parse_size
from handsim.viewing.stage.camera import Camera


def started(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data


def test_frame_has_the_size_asked_for_and_shows_something(
    rendering: str, ball: mujoco.MjModel
) -> None:
    data = started(ball)
    with open_offscreen(100, 60) as offscreen:
        frame = offscreen.add(ball).draw(data, Camera(ball, data, "fixed").view)
    assert frame.shape == (60, 100, 3)
    assert frame.dtype == np.uint8
    assert np.ptp(frame) > 50


def test_first_row_is_the_top(rendering: str, ball: mujoco.MjModel) -> None:
    data = started(ball)
    with open_offscreen(64, 64) as offscreen:
        frame = offscreen.add(ball).draw(data, Camera(ball, data, "fixed").view)
    assert frame[:8].mean() < 5, "the sky, which this model leaves black"
    assert frame[-8:].mean() > 20, "the floor"


def test_scenes_on_one_stage_do_not_draw_over_each_other(
    rendering: str, ball: mujoco.MjModel
) -> None:
    other = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><light/><geom size=".4" rgba="1 0 0 1"/></worldbody></mujoco>'
    )
    alone, together = [], []
    for model in (ball, other):
        data = started(model)
        with open_offscreen(64, 48) as offscreen:
            alone.append(offscreen.add(model).draw(data, Camera(model, data, "view").view))
    with open_offscreen(64, 48) as offscreen:
        scenes = [offscreen.add(model) for model in (ball, other)]
        for scene in scenes:
            data = started(scene.model)
            together.append(scene.draw(data, Camera(scene.model, data, "view").view))
    for first, second in zip(alone, together, strict=True):
        np.testing.assert_array_equal(first, second)


def test_model_is_left_as_it_was(rendering: str, ball: mujoco.MjModel) -> None:
    def settings() -> tuple[float, ...]:
        quality = ball.vis.quality
        return (ball.vis.global_.offwidth, quality.shadowsize, ball.vis.map.shadowclip)

    before = settings()
    with open_offscreen(1000, 60) as offscreen:
        offscreen.add(ball)
    assert settings() == before


def test_shadows_fall_so_widely_that_lit_surfaces_are_not_dotted(
    rendering: str, ball: mujoco.MjModel, monkeypatch
) -> None:
    made: list[mujoco.MjrContext] = []
    usual = mujoco.MjrContext
    monkeypatch.setattr(mujoco, "MjrContext", lambda *given: made.append(usual(*given)) or made[-1])
    for own, drawn in ((1.0, 2.0), (3.0, 3.0)):
        ball.vis.map.shadowclip = own
        with open_offscreen(64, 64, True) as offscreen:
            offscreen.add(ball)
            assert made[-1].shadowClip == pytest.approx(drawn * ball.stat.extent)


def test_shadows_only_where_asked_for_on_software(rendering: str, ball: mujoco.MjModel) -> None:
    data = started(ball)
    frames = []
    for shadows in (False, True):
        with open_offscreen(64, 64, shadows) as offscreen:
            frames.append(offscreen.add(ball).draw(data, Camera(ball, data, "fixed").view))
    darker = frames[0].astype(int) - frames[1] > 20
    assert 0.01 < darker.any(axis=-1).mean() < 0.5, "the ball's shadow, and no more"


@pytest.mark.parametrize(
    ("width", "height", "fps"), [(8, 480, 30), (640, 5000, 30), (640, 480, 0.5), (640, 480, 1000)]
)
def test_view_out_of_limits(width: int, height: int, fps: float) -> None:
    with pytest.raises(InputError, match="give"):
        View(width=width, height=height, fps=fps)


def test_size_is_read() -> None:
    assert parse_size("640x480") == (640, 480)
    assert parse_size(" 32X16 ") == (32, 16)


@pytest.mark.parametrize("text", ["640", "640x", "x480", "640x480x3", "a x b", "-1x5", "1.5x2"])
def test_size_that_is_none(text: str) -> None:
    with pytest.raises(InputError, match="640x480"):
        parse_size(text)
