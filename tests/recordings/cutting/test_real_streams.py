"""Cutting of real movements: streams made of whole trials, a door, a pillow."""

from pathlib import Path

import numpy as np
import pytest

from handsim.recordings.cutting.cut import cut_recordings
from handsim.recordings.cutting.find import WHOLE, find_reaches
from handsim.recordings.cutting.reach import CutOptions
from handsim.recordings.importers.import_files import import_recordings
from handsim.recordings.recording import Recording, RecordingSet
from handsim.recordings.statistics import median_statistics, reach_statistics
from handsim.types import HandSize

REAL = Path(__file__).parents[3] / "../shared/data"
WEST = [REAL / "reach_to_grasp" / f"{x}_R2G_SUBJECTbyOBJECT_raw.mat" for x in "tX"]
pytestmark = [
    pytest.mark.real_data,
    pytest.mark.skipif(not REAL.is_dir(), reason="no published recordings in ../shared"),
]


def record(name: str, q: np.ndarray, channels: dict[str, np.ndarray]) -> Recording:
    return Recording(
        name, np.arange(len(q)) / 100, q, 1, "s", "o", "t", HandSize(), channels=channels
    )


def streamed(reach: np.ndarray, pause_s: float, rng: np.random.Generator) -> Recording:
    """Rest for 1 s, reach with a pause half way, hold for 1.5 s, return three times as fast."""
    half = len(reach) // 2
    path = np.linalg.norm(reach - reach[0], axis=1)
    half = int(np.argmax(path > 0.5 * path[-1]))
    parts = [
        np.tile(reach[0], (100, 1)), reach[:half], np.tile(reach[half], (round(100 * pause_s), 1)),
        reach[half:], np.tile(reach[-1], (150, 1)), reach[::-3], np.tile(reach[0], (150, 1)),
    ]  # fmt: skip
    q = np.vstack(parts)
    return record("stream", q + np.deg2rad(0.3) * rng.normal(size=q.shape), {})


@pytest.mark.parametrize("subject", [3, 4])
def test_paused_reaches_with_fast_returns_are_cut_rightly_or_not_at_all(subject: int) -> None:
    """Persons on whom nothing was tuned. What creeps at the start may be left out."""
    rng = np.random.default_rng(subject)
    certain = 0
    for reach in import_recordings(WEST, "west-rtg", subject):
        found = find_reaches(streamed(reach.q, 0.4, rng), CutOptions())
        sure = [each for each in found if each.certain]
        assert len(found) == 1
        certain += len(sure)
        for each in sure:
            end = 1.0 + 0.4 + len(reach.q) / 100
            assert each.end_s == pytest.approx(end, abs=0.2)
            rest = round(100 * each.start_s) - 100
            left = np.linalg.norm(reach.q[max(rest, 0)] - reach.q[0])
            assert left < 0.2 * np.linalg.norm(reach.q[-1] - reach.q[0])
    assert certain >= 18


def test_imported_trials_are_single_reaches() -> None:
    cut = cut_recordings(import_recordings(WEST, "west-rtg", 1))
    assert len(cut.recordings) == 20
    assert all(reach.reason == WHOLE for reach in cut.reaches)


def test_doors_are_reached_for_until_the_latch_moves() -> None:
    with np.load(REAL / "door_teleop/door.npz") as file:
        tables = [file[name][25:] for name in sorted(file.files) if name.startswith("observ")]
    doors = [record(f"d{i}", o[:, 3:25], {"latch_rad": o[:, 27]}) for i, o in enumerate(tables)]
    cut = cut_recordings(RecordingSet(tuple(doors)), CutOptions(channel="latch_rad"))
    assert len(cut.recordings) == 25 == len(cut.reaches)
    for table, reach in zip(tables, cut.reaches, strict=True):
        latch = table[:, 27]
        first = np.flatnonzero(np.abs(latch - latch[0]) > 0.02)[0] / 100
        assert reach.end_s == pytest.approx(first, abs=0.03)


@pytest.fixture(scope="module")
def pillow() -> dict[str, np.ndarray]:
    """Palm, pillow and aperture [m] of the tab-separated export; gaps are empty or 0."""
    lines = (REAL / "pillow_reach/recording.tsv").read_text().splitlines()
    header = lines[11].split("\t")
    rows = [(line.split("\t") + [""] * len(header))[: len(header)] for line in lines[12:]]
    table = np.array([[float(cell) if cell.strip() else np.nan for cell in row] for row in rows])
    table[table == 0] = np.nan

    def marker(name: str) -> np.ndarray:
        place = header.index(f"{name} X")
        return table[:, place : place + 3] / 1000

    palm = np.mean([marker(f"hand_{side}") for side in ("top", "left", "right")], axis=0)
    thing = np.mean([marker(f"pillow_{side}") for side in ("top", "left", "right")], axis=0)
    aperture = np.linalg.norm(marker("thumb_tip") - marker("index_tip"), axis=1)
    named = {f"palm_{axis}_m": palm[:, i] for i, axis in enumerate("xyz")}
    named |= {f"object_{axis}_m": thing[:, i] for i, axis in enumerate("xyz")}
    return {**named, "aperture_m": aperture}


@pytest.mark.parametrize("with_object", [True, False])
def test_figures_of_pillow_reaches(pillow: dict[str, np.ndarray], with_object: bool) -> None:
    """Medians as measured when the data came: 1.02 s, peak at 52 %, aperture at 69 %."""
    channels = {k: v for k, v in pillow.items() if with_object or not k.startswith("object")}
    q = np.zeros((len(pillow["aperture_m"]), 22))
    cut = cut_recordings(RecordingSet((record("pillow", q, channels),)))
    assert 18 <= len(cut.recordings) <= 20
    medians = median_statistics([reach_statistics(each) for each in cut.recordings])
    assert medians["duration_s"] == pytest.approx(1.02, rel=0.05)
    assert medians["peak_speed_at"] == pytest.approx(0.52, rel=0.05)
    assert medians["aperture_at"] == pytest.approx(0.69, rel=0.05)
    assert medians["peak_speed_m_s"] == pytest.approx(0.31, rel=0.07)
    # 31 % of 1.02 s: what was measured as closing, 0.41 s, goes on after the palm has stopped.
    assert medians["closing_s"] == pytest.approx(0.32, abs=0.03)


@pytest.mark.parametrize(("name", "certain"), [("mustard", True), ("free_hand", False)])
def test_hands_seen_by_a_camera(name: str, certain: bool) -> None:
    """One reaches for a bottle. The other moves its fingers for 20 s, which is no reach."""
    with np.load(REAL / f"keypoints/{name}.npz") as file:
        points = file["keypoints"]
    wrist, tips = points[:, 0], points[:, [4, 8, 12, 16, 20]]
    q = np.zeros((len(points), 22))
    q[:, :5] = 10 * np.linalg.norm(tips - wrist[:, None], axis=2)  # [rad], roughly
    palm = {f"palm_{axis}_m": wrist[:, i] for i, axis in enumerate("xyz")}
    seen = Recording(name, np.arange(len(q)) / 30, q, 1, "s", "o", "t", HandSize(), channels=palm)
    found = find_reaches(seen, CutOptions())
    assert [reach.certain for reach in found] == [certain]
