"""Learning from many recordings: time, memory and growth; run by `make test-all`."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))
from scale import Size, learn_elsewhere

pytestmark = pytest.mark.slow


def test_a_thousand_recordings_take_30_seconds_and_2_gigabytes() -> None:
    some, many = (learn_elsewhere(Size(n), 1) for n in (100, 1000))
    assert many.cpu < 30.0
    assert many.peak_mb < 2000.0
    assert many.cpu < 10.0 * some.cpu  # grows no faster than linearly
    assert many.peak_mb - many.before_mb < 10.0 * (some.peak_mb - some.before_mb)


def test_a_thousand_recordings_in_4_dimensions_fit_into_2_gigabytes() -> None:
    assert learn_elsewhere(Size(1000, 4), 1).peak_mb < 2000.0
