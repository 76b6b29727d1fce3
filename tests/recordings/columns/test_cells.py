"""Numbers in the ways of several countries."""

import numpy as np
import pytest

from handsim.recordings.columns.cells import column_numbers


@pytest.mark.parametrize(
    ("cells", "comma", "numbers"),
    [
        (["1.5", "-2e-3"], False, [1.5, -0.002]),
        (["1,5", "-2,25"], True, [1.5, -2.25]),
        (["990", "1.000", "1.010"], True, [990, 1000, 1010]),  # thousands
        (["1.234,5", "2.000,0"], True, [1234.5, 2000]),
        (["0.010", "1.020"], True, [0.01, 1.02]),  # points in one column of a file with commas
        (["1.5", "2,5"], True, [1.5, 2.5]),
        (["1.250", "1.300"], True, [1.25, 1.3]),  # every cell the same: no thousands
        (["1,234.5", "7"], False, [1234.5, 7]),
        (["1'234.5", "12 345"], False, [1234.5, 12345]),
        (["−9.2°", "8°"], False, [-9.2, 8]),
        (["", "n/a", "1"], False, [np.nan, np.nan, 1]),
    ],
)
def test_columns(cells: list[str], comma: bool, numbers: list[float]) -> None:
    assert column_numbers(cells, comma) == pytest.approx(numbers, nan_ok=True)
