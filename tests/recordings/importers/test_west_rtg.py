"""The published MATLAB layout: an imitation of it, and the real files where they are at hand."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from handsim.errors import FileError, InputError, UnknownNameError
from handsim.joints import JOINT_INDEX
from handsim.recordings.importers.import_files import import_recordings

REAL = Path(__file__).parents[3] / "../shared/data/reach_to_grasp"
REAL_FILES = [REAL / f"{letter}_R2G_SUBJECTbyOBJECT_raw.mat" for letter in "tX"]
real_data = pytest.mark.skipif(not REAL.is_dir(), reason="no published recordings in ../shared")


@pytest.fixture
def files(tmp_path: Path) -> list[Path]:
    """Two subjects, two trials a cell; column c of trial t ends at (c + 1 + t) hundredths rad."""
    rng = np.random.default_rng(0)
    angles, times = np.empty((2, 5), object), np.empty((2, 5), object)
    for cell in np.ndindex(2, 5):
        trials, clocks = [], []
        for trial in range(2):
            time = np.sort(rng.uniform(3, 9, 400))
            x = np.clip((time - 4) / 1.5, 0, 1)
            profile = x**3 * (10 - 15 * x + 6 * x**2)
            trials.append(-np.outer(profile, (np.arange(23) + 1 + trial) / 100))
            clocks.append(time[:, None])
        angles[cell], times[cell] = np.vstack(trials), np.vstack(clocks)
    savemat(tmp_path / "X.mat", {"X_R2G_SUBJECTbyOBJECT": angles})
    savemat(tmp_path / "t.mat", {"t_R2G_SUBJECTbyOBJECT": times})
    return [tmp_path / "X.mat", tmp_path / "t.mat"]


def test_trials_are_split_where_time_jumps_back(files: list[Path]) -> None:
    one = import_recordings(files, "west-rtg", 2)
    assert [r.number for r in one] == list(range(1, 11))
    assert (
        one[0].name == "subject-2-scissors-1" and one[9].name == "subject-2-wire-harness-untied-2"
    )
    assert {r.subject for r in one} == {"2"}
    assert len(import_recordings(files[::-1], "west-rtg")) == 20


def test_columns_and_signs(files: list[Path]) -> None:
    q = import_recordings(files, "west-rtg", 1)[0].q
    travel = np.rad2deg(q[-1] - q[0]) / np.rad2deg(0.01)
    # Source column + 1 is the travel; the phase rule leaves out the slow ends of the movement.
    for joint, column in (("thumb_rotation", 1), ("index_mcp", 5), ("middle_mcp", 9),
                          ("ring_mcp", 13), ("little_dip", 19), ("wrist_flexion", 22)):  # fmt: skip
        assert travel[JOINT_INDEX[joint]] == pytest.approx(column, rel=0.06)
    for joint, column in (("index_abduction", 8), ("palm_arch", 21), ("wrist_deviation", 23)):
        assert travel[JOINT_INDEX[joint]] == pytest.approx(-column, rel=0.06)
    for joint, column in (("thumb_abduction", 4), ("ring_abduction", 16), ("little_abduction", 20)):
        assert travel[JOINT_INDEX[joint]] == pytest.approx(column, rel=0.06)


def test_bad_input(files: list[Path], tmp_path: Path) -> None:
    for subject in (0, 3, -1):
        with pytest.raises(InputError, match="give 1 to 2"):
            import_recordings(files, "west-rtg", subject)
    with pytest.raises(UnknownNameError, match="west-rtg"):
        import_recordings(files, "west")
    with pytest.raises(FileError, match="t_R2G"):
        import_recordings(files[:1], "west-rtg")
    with pytest.raises(FileError, match="no such file"):
        import_recordings([tmp_path / "no.mat"], "west-rtg")
    files[0].write_bytes(files[0].read_bytes()[:3000])
    with pytest.raises(FileError, match=r"X\.mat"):
        import_recordings(files, "west-rtg")


@pytest.mark.parametrize("damage", [1e300, np.nan, -np.inf])
def test_angles_that_are_damage_are_refused(files: list[Path], damage: float) -> None:
    angles = loadmat(files[0])["X_R2G_SUBJECTbyOBJECT"]
    angles[1, 3][100, 7] = damage
    savemat(files[0], {"X_R2G_SUBJECTbyOBJECT": angles})
    with pytest.raises(FileError, match=r"wire-harness-tied: .* finite angles .* 1e\+06"):
        import_recordings(files, "west-rtg")


@real_data
@pytest.mark.real_data
@pytest.mark.parametrize(
    ("subject", "variance"), [(1, 0.83), (2, 0.85), (3, 0.89), (4, 0.94)]
)  # README of the data
def test_real_recordings_give_the_published_variances(subject: int, variance: float) -> None:
    recordings = import_recordings(REAL_FILES, "west-rtg", subject)
    assert len(recordings) == 20
    eigenvalues = np.linalg.eigvalsh(np.cov(np.vstack([r.q for r in recordings]).T))[::-1]
    assert eigenvalues[:3].sum() / eigenvalues.sum() == pytest.approx(variance, abs=0.006)


@real_data
@pytest.mark.real_data
def test_real_grasps_look_like_grasps() -> None:
    recordings = import_recordings(REAL_FILES, "west-rtg")
    travel = np.mean([r.q[-1] - r.q[0] for r in recordings], axis=0)
    for joint in ("thumb_rotation", "index_mcp", "middle_pip", "ring_mcp", "little_mcp"):
        assert travel[JOINT_INDEX[joint]] > np.deg2rad(15)  # fingers flex, the thumb opposes
    for joint in ("index_abduction", "ring_abduction", "little_abduction"):
        assert travel[JOINT_INDEX[joint]] < 0  # and fingers close up
