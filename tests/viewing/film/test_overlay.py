import numpy as np
import pytest

from handsim.types import Frame
from handsim.viewing.film.overlay import (
    BAD_COLOUR,
    GOOD_COLOUR,
    LEAST_LETTERS,
    PATH_COLOUR,
    Caption,
    SubspaceInset,
    Verdict,
    _round_length,
    draw_text,
    fitted,
    inset_view,
    text_width,
)


def grey(value: int = 128, size: tuple[int, int] = (240, 320)) -> Frame:
    return np.full((*size, 3), value, np.uint8)


def changed(frame: Frame, value: int = 128) -> tuple[np.ndarray, np.ndarray]:
    return np.nonzero((frame != value).any(axis=-1))


@pytest.mark.parametrize("value", [0, 128, 255])
def test_text_is_legible_on_any_background(value: float) -> None:
    frame = grey(value)
    draw_text(frame, ["tall-glass-drink"], (10, 20), 14)
    assert frame.min() < 40, "dark letters"
    assert frame.max() > 220, "light edge"


def test_text_stays_where_it_is_put() -> None:
    frame = grey()
    draw_text(frame, ["Mg"], (50, 60), 16)
    rows, columns = changed(frame)
    assert rows.min() >= 60
    assert rows.max() < 60 + 1.6 * 16
    assert columns.min() >= 50
    assert columns.max() < 50 + 2.5 * 16


def test_lines_lie_one_under_the_other() -> None:
    one, two = grey(), grey()
    draw_text(one, ["abc"], (5, 5), 20)
    draw_text(two, ["", "abc"], (5, 5), 20)
    np.testing.assert_array_equal(one[:-26], two[26:])


@pytest.mark.parametrize("at", [(-20, -5), (310, 230), (1000, 1000), (-1000, 0)])
def test_text_is_cut_off_at_the_edges(at: tuple[int, int]) -> None:
    frame = grey()
    draw_text(frame, ["a long line of text"], at, 20)
    assert frame.shape == (240, 320, 3)


def test_caption_shows_time_and_the_present_phase() -> None:
    caption = Caption(("cup-drink",), ((0.0, "approach"), (0.5, "close")))
    frames = [grey() for _ in range(4)]
    for frame, time in zip(frames, (0.1, 0.1, 0.2, 0.6), strict=True):
        caption.draw(frame, time)
    for frame, line in ((frames[0], "0.10 s  approach"), (frames[3], "0.60 s  close")):
        expected = grey()
        draw_text(expected, ["cup-drink", line], (0.5 * 11, 0.4 * 11), 11)
        np.testing.assert_array_equal(frame, expected)
    np.testing.assert_array_equal(frames[0], frames[1])
    assert (frames[0] != frames[2]).any()


@pytest.mark.parametrize("good", [True, False])
def test_caption_says_how_it_ended_from_when_that_is_known(good: bool) -> None:
    caption = Caption(("cup-drink",), verdict=Verdict(0.5, "held", good))
    before, after = grey(), grey()
    caption.draw(before, 0.49)
    caption.draw(after, 0.5)
    colours = [
        (frame == (GOOD_COLOUR if good else BAD_COLOUR)).all(axis=-1) for frame in (before, after)
    ]
    assert not colours[0].any()
    rows, columns = np.nonzero(colours[1])
    assert 33 <= rows.min() < rows.max() < 52, "below the time"
    assert columns.max() < 60


@pytest.mark.parametrize("width", [20, 60, 100, 128, 160, 400])
@pytest.mark.parametrize("line", ["tall-glass-side-rotate, controller", "cup, a, b", "held", ""])
def test_lines_are_made_to_fit(width: int, line: str) -> None:
    written, size = fitted(line, 16, width)
    assert text_width(written, size) <= width
    assert LEAST_LETTERS <= size <= 16
    assert line.startswith(written.removesuffix(".."))
    if text_width(line, LEAST_LETTERS) <= width:
        assert written == line, "smaller letters come first"
    elif text_width(line.partition(", ")[0], LEAST_LETTERS) <= width:
        assert not written.endswith(".."), "then what follows a comma is left out"


def test_a_caption_stays_within_a_small_picture() -> None:
    verdict = Verdict(0.0, "failed: the object was touched by nothing for too long", good=False)
    frame = grey(size=(120, 160))
    Caption(("tall-glass-side-rotate, demonstrator",), ((0.0, "squeeze"),), verdict).draw(frame, 0)
    rows, columns = changed(frame)
    assert 130 < columns.max() < 158
    assert rows.max() < 60


def test_larger_letters() -> None:
    heights = []
    for scale in (1.0, 2.0):
        frame = grey(size=(480, 640))
        Caption((), scale=scale).draw(frame, 0.0)
        heights.append(np.ptp(changed(frame)[0]) + 1)
    assert heights[1] == pytest.approx(2 * heights[0], abs=3)


def test_second_view_is_whole_at_the_lower_right_or_below_the_caption() -> None:
    picture = np.zeros((80, 100, 3), np.uint8)
    for below_caption, (top, left) in ((False, (153, 213)), (True, (59, 7))):
        frame = grey()
        inset_view(frame, picture, below_caption)
        rows, columns = np.nonzero((frame == 0).all(axis=-1))
        assert (rows.min(), columns.min()) == (top, left)
        assert (np.ptp(rows) + 1, np.ptp(columns) + 1) == (80, 100)
        rows, columns = changed(frame)
        assert (np.ptp(rows) + 1, np.ptp(columns) + 1) == (84, 104), "with its edge"


def test_inset_shows_where_the_movement_is() -> None:
    time = np.linspace(0, 1, 11)
    inset = SubspaceInset(time, np.stack([time, 0 * time, time], axis=1))
    places = []
    for at in (0.0, 0.5, 1.0):
        frame = grey()
        inset.draw(frame, at)
        rows, columns = np.nonzero((frame == PATH_COLOUR).all(axis=-1))
        places.append((columns.max(), rows.mean()))
        outside = frame[:, : -72 - 72 // 16]
        assert (outside == 128).all(), "nothing beyond the inset"
    (x0, y0), (x1, y1), (x2, y2) = places
    assert x1 - x0 == pytest.approx(x2 - x1, abs=1.5)
    assert x1 - x0 > 10
    assert y0 == pytest.approx(y1, abs=1) == pytest.approx(y2, abs=1)


def test_inset_has_its_second_coordinate_upwards() -> None:
    up, down = grey(), grey()
    inset = SubspaceInset(np.arange(2.0), np.array([[0, 0], [1.0, 1.0]]))
    inset.draw(down, 0.0)
    inset.draw(up, 1.0)
    lowest, highest = (np.nonzero((f == PATH_COLOUR).all(axis=-1))[0].min() for f in (down, up))
    assert highest < lowest - 20


def test_inset_leaves_the_lower_right_to_a_second_view() -> None:
    frame = grey()
    inset = SubspaceInset(np.arange(2.0), np.array([[0, 0], [1.0, 1.0]]), below_caption=True)
    inset.draw(frame, 1.0)
    rows, columns = changed(frame)
    assert (rows.min(), np.ptp(rows) + 1) == (57, 72)
    assert (columns.min(), np.ptp(columns) + 1) == (5, 72)


def test_inset_of_a_movement_that_stays() -> None:
    frame = grey()
    SubspaceInset(np.zeros(1), np.zeros((1, 3))).draw(frame, 0.0)
    assert (frame == PATH_COLOUR).all(axis=-1).any()


@pytest.mark.parametrize(
    ("value", "expected"), [(0.999, 0.5), (1.0, 1), (3.7, 2), (19.9, 10), (20, 20), (63, 50)]
)
def test_scale_bar_has_a_round_length(value: float, expected: float) -> None:
    assert _round_length(value) == pytest.approx(expected)
