"""People's own signals drive: their distance to what they reach for, each trial left out."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

from handsim.recordings.signals import DISTANCE

REAL = Path(__file__).parents[2] / "../shared/data/door_teleop/door.npz"
real_data = pytest.mark.skipif(not REAL.is_file(), reason="no published recordings in ../shared")
MOST = 1.15
"""Of the rms of the controller's time law, which is told how long the person took."""

Script = Callable[[str], ModuleType]


@pytest.fixture(scope="module")
def benchmark_script(script: Script) -> ModuleType:
    return script("tests/benchmarks/driven.py")


def test_the_shipped_reaches_for_a_pillow(benchmark_script: ModuleType) -> None:
    results = benchmark_script.left_out(benchmark_script.pillow(), DISTANCE, (6,))
    driven, law, ratio = benchmark_script.means(results)
    assert driven < 1.9
    assert ratio <= MOST
    assert law > 0
    assert results[0].progress[-1] > 0.5


@real_data
@pytest.mark.real_data
def test_reaches_for_a_door(benchmark_script: ModuleType) -> None:
    results = benchmark_script.left_out(benchmark_script.door(), DISTANCE, (5,))
    assert benchmark_script.means(results)[2] <= MOST


@pytest.mark.slow
def test_every_reach_for_a_pillow(benchmark_script: ModuleType) -> None:
    recordings = benchmark_script.pillow()
    results = benchmark_script.left_out(recordings, DISTANCE, range(len(recordings)))
    driven, _, ratio = benchmark_script.means(results)
    assert driven < 1.45
    assert ratio <= MOST


@real_data
@pytest.mark.real_data
@pytest.mark.slow
def test_every_reach_for_a_door(benchmark_script: ModuleType) -> None:
    recordings = benchmark_script.door()
    results = benchmark_script.left_out(recordings, DISTANCE, range(len(recordings)))
    driven, _, ratio = benchmark_script.means(results)
    assert driven < 4.5
    assert ratio <= MOST
