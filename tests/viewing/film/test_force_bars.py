import numpy as np
import pytest

from handsim.joints import CONTACT_PARTS
from handsim.tasks.grip_rules import LEAST_PRESS
from handsim.types import Frame
from handsim.viewing.film.force_bars import (
    IDLE_COLOUR,
    LIMIT_COLOUR,
    MOST_OF_LIMIT,
    MOST_OF_WIDTH,
    NEED_COLOUR,
    BarField,
    ForceBars,
)
from handsim.viewing.film.overlay import FORCE_COLOUR, text_width

SIZES = [(240, 320), (360, 480), (480, 640), (1080, 1920)]


def grey(size: tuple[int, int] = (480, 640)) -> Frame:
    return np.full((*size, 3), 128, np.uint8)


def painted(frame: Frame, colour: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    return np.nonzero((frame == colour).all(axis=-1))


def bars(*newton: float, need: float = 0.0, limit: float = 0.0) -> ForceBars:
    force = np.zeros((2, len(CONTACT_PARTS)))
    force[1, : len(newton)] = newton
    return ForceBars(np.array([0.0, 1.0]), force, CONTACT_PARTS, need, limit)


def drawn(shown: ForceBars, size: tuple[int, int] = (480, 640), time: float = 1.0) -> Frame:
    frame = grey(size)
    shown.draw(frame, time)
    return frame


def column(frame: Frame, i: int, colour: tuple[int, int, int]) -> int:
    """Pixels of a colour in the middle of a column, above the line that bars stand on."""
    field = BarField.of(frame, CONTACT_PARTS)
    x = field.left + i * field.pitch + field.pitch // 2
    return int((frame[field.top : field.bottom, x] == colour).all(axis=-1).sum())


@pytest.mark.parametrize("size", SIZES)
def test_bars_are_as_high_as_the_forces_at_that_time(size: tuple[int, int]) -> None:
    shown = bars(8.0, 4.0, 2.0, 1.0)
    frame = drawn(shown, size)
    high = BarField.of(frame, CONTACT_PARTS).height
    assert high == round(0.165 * size[0])
    for i, share in enumerate((1, 1 / 2, 1 / 4, 1 / 8, 0, 0)):
        assert column(frame, i, FORCE_COLOUR) == pytest.approx(share * high, abs=0.51), i
    assert not painted(drawn(shown, size, time=0.99), FORCE_COLOUR)[0].size


def test_bars_of_79_pixels_at_the_usual_size() -> None:
    frame = drawn(bars(3.0, 0.8, need=2.0, limit=8.0))
    assert [column(frame, i, FORCE_COLOUR) for i in (0, 1)] == [30 - 2, 8]  # the need crosses one


@pytest.mark.parametrize("size", SIZES)
def test_lines_at_need_and_limit_cross_all_columns(size: tuple[int, int]) -> None:
    frame = drawn(bars(1.0, need=2.0, limit=8.0), size)
    field = BarField.of(frame, CONTACT_PARTS)
    for colour, share in ((NEED_COLOUR, 0.25), (LIMIT_COLOUR, 1.0)):
        rows, columns = painted(frame[:, field.left : field.right], colour)
        line = np.unique(rows)
        assert line.tolist() == [
            field.bottom - round(share * field.height) - 1,
            field.bottom - round(share * field.height),
        ]
        assert columns.min() < 3
        assert columns.max() > field.right - field.left - field.size
    need, limit = (
        painted(frame[:, field.left : field.right], colour)[0].size
        for colour in (NEED_COLOUR, LIMIT_COLOUR)
    )
    assert need == 2 * (field.right - field.left), "whole"
    assert 0.4 * need < limit < 0.65 * need, "dashed"


def test_no_lines_where_nothing_is_known() -> None:
    frame = drawn(bars(1.0))
    for colour in (NEED_COLOUR, LIMIT_COLOUR):
        assert not painted(frame, colour)[0].size


def test_a_part_that_presses_less_than_counts_is_grey() -> None:
    least = LEAST_PRESS
    frame = drawn(bars(1.0, 1.01 * least, 0.99 * least))
    assert column(frame, 1, FORCE_COLOUR) > 10
    assert column(frame, 2, FORCE_COLOUR) == 0
    assert column(frame, 2, IDLE_COLOUR) > 10
    field = BarField.of(frame, CONTACT_PARTS)
    names = frame[field.bottom + 1 :]
    for i, idle in enumerate((False, False, True, True, True, True)):
        middle = field.left + i * field.pitch + field.pitch // 2
        row = slice(0, int(1.2 * field.size)) if i % 2 == 0 else slice(int(1.3 * field.size), None)
        letters = names[row, middle - 8 : middle + 8]
        assert ((letters == IDLE_COLOUR).all(axis=-1).any()) == idle, i


def test_a_knock_does_not_make_the_rest_small() -> None:
    shown = bars(100.0, 4.0, need=1.0, limit=4.0)
    assert shown.full_scale == pytest.approx(MOST_OF_LIMIT * 4.0)
    frame = drawn(shown)
    high = BarField.of(frame, CONTACT_PARTS).height
    assert column(frame, 1, FORCE_COLOUR) == pytest.approx(
        high / MOST_OF_LIMIT - 2 - 2, abs=1
    )  # two lines cross
    assert column(frame, 0, FORCE_COLOUR) <= high
    assert bars(100.0, need=1.0).full_scale == 100.0, "without a limit all is shown"


def test_the_scale_shows_the_need_of_what_is_hardly_touched() -> None:
    assert bars(0.1, need=2.0).full_scale == pytest.approx(3.0)
    assert bars(0.0).full_scale == pytest.approx(LEAST_PRESS)


@pytest.mark.parametrize("size", SIZES)
def test_bars_leave_the_hand_in_view(size: tuple[int, int]) -> None:
    rows, columns = np.nonzero((drawn(bars(2.0, need=1.0, limit=4.0), size) != 128).any(axis=-1))
    assert rows.min() > 0.6 * size[0]
    assert columns.max() < (MOST_OF_WIDTH + 0.02 if size[1] > 320 else 0.58) * size[1]


def test_whole_names_where_there_is_room() -> None:
    whole = [BarField.of(grey(size), CONTACT_PARTS).whole_names for size in SIZES]
    assert whole == [False, True, True, True]


def test_bars_at_the_right_end_with_the_frame() -> None:
    force = bars(2.0, need=1.0)
    right = ForceBars(force.time, force.force, force.labels, 1.0, at_right=True)
    frame = drawn(right)
    _, columns = np.nonzero((frame != 128).any(axis=-1))
    assert columns.min() > 0.55 * 640
    assert columns.max() >= 635
    left, wide = drawn(force), np.ptp(columns)
    assert np.ptp(np.nonzero((left != 128).any(axis=-1))[1]) == pytest.approx(wide, abs=12)


@pytest.mark.parametrize("newton", [1e308, -1.0])
def test_numbers_that_no_hand_presses_are_drawn_all_the_same(newton: float) -> None:
    shown = bars(newton, need=newton, limit=4 * newton)
    assert drawn(shown).shape == (480, 640, 3)
    assert 0 < shown.full_scale < 1e7


@pytest.mark.parametrize("size", [(16, 16), (60, 80), (120, 160)])
def test_frames_too_small_for_it(size: tuple[int, int]) -> None:
    frame = drawn(bars(2.0, 1.0, need=1.0, limit=4.0), size)
    assert (frame == 128).all(), "are left as they are"


@pytest.mark.parametrize("size", [(200, 280), (240, 320), (300, 400), (480, 640)])
@pytest.mark.parametrize("limit", [4.0, 118.3])
def test_texts_stay_apart_and_within_the_frame(size: tuple[int, int], limit: float) -> None:
    """Numbers and letters are on the paler ground, whose columns they do not share."""
    shown = bars(99.9, 0.8, 0.8, 0.8, 0.8, 0.8, need=limit / 4, limit=limit)
    frame = drawn(shown, size)
    field = BarField.of(frame, CONTACT_PARTS)
    rows, columns = np.nonzero((frame != 128).any(axis=-1))
    assert columns.max() < size[1] - 1
    assert rows.max() < size[0] - 1
    assert field.title > 0.6 * size[0]
    marks = text_width(f"limit {limit:.1f}", field.size)
    assert field.right + 0.2 * field.size + marks <= columns.max() + 2, "they end on the ground"
    if size[1] >= 320:
        assert text_width("99.9", field.size) <= field.pitch + 2 * field.size // 3
