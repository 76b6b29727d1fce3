import numpy as np
import pytest

from handsim.errors import InputError
from handsim.viewing.film.grid import GAP, Grid

SIZES = [(160, 120), (320, 240), (640, 480), (480, 640), (64, 48)]


@pytest.mark.parametrize("n", [*range(1, 31), 37, 60])
@pytest.mark.parametrize("size", SIZES)
def test_no_place_is_empty_and_no_cell_smaller_than_asked_for(
    n: int, size: tuple[int, int]
) -> None:
    grid = Grid.of(n, *size)
    assert len(grid.widths) == n
    assert min(grid.widths) >= size[0] - 1  # to within the pixel by which they differ
    assert grid.height == size[1]
    lengths = [len(row) for row in grid.rows]
    assert max(lengths) - min(lengths) <= 1
    whole = grid.assemble([np.zeros((size[1], width, 3), np.uint8) for width in grid.widths])
    assert (whole.shape[1], whole.shape[0]) == grid.size
    white = (whole == 255).all(axis=-1).sum()
    between = sum(size[1] * GAP * (length - 1) for length in lengths)
    assert white == between + GAP * (len(lengths) - 1) * grid.size[0], "only the gaps are white"


@pytest.mark.parametrize(
    ("n", "lengths"),
    [
        (1, [1]),
        (2, [2]),
        (3, [3]),
        (4, [2, 2]),
        (5, [3, 2]),
        (6, [3, 3]),
        (7, [3, 2, 2]),
        (24, [6, 6, 6, 6]),
    ],
)
def test_rows_are_equal_where_they_can_be(n: int, lengths: list[int]) -> None:
    assert [len(row) for row in Grid.of(n, 640, 480).rows] == lengths


def test_sizes_are_even_where_the_cells_are() -> None:
    for n in range(1, 31):
        assert not any(edge % 2 for edge in Grid.of(n, 160, 120).size), n


def test_a_given_number_of_columns_is_kept() -> None:
    grid = Grid.of(7, 100, 50, columns=4)
    assert grid.rows == ((100,) * 4, (134, 134, 134))
    assert grid.size == (406, 102)


def test_a_picture_too_large_for_encoders() -> None:
    with pytest.raises(InputError, match=r"24 movements of 1920x1080 pixels make 9608x5408.*8192"):
        Grid.of(24, 1920, 1080, columns=5)
    with pytest.raises(InputError, match="no movements"):
        Grid.of(0, 64, 48)
