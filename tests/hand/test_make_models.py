import csv
import io

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.files import data_folder
from handsim.joints import JOINT_NAMES
from handsim.recordings.folder import read_recordings
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import HandSize


@pytest.fixture(scope="module")
def make(script):
    return script("models/hand/make.py")


def table(text: str) -> tuple[list[str], dict[str, np.ndarray]]:
    columns, *rows = csv.reader(io.StringIO(text))
    return columns, {name: np.array(row, dtype=float) for name, *row in rows}


def recording(name: str, q: np.ndarray) -> Recording:
    return Recording(
        name=name,
        time=0.01 * np.arange(len(q)),
        q=q,
        number=1,
        subject="nobody",
        object="cube",
        task="cube-raise",
        hand=HandSize(0.19, 0.09),
    )


@pytest.fixture
def ellipsoid() -> RecordingSet:
    """Deviations of 20, 10 and 5 deg along three joints about a posture of 30 deg each."""
    q = np.full((60, 22), np.deg2rad(30.0))
    turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    for joint, size, wave in (
        (4, 20, np.sin(turn)),
        (7, 10, np.cos(turn)),
        (9, 5, np.sin(2 * turn)),
    ):
        q[:, joint] += np.deg2rad(size) * wave / np.std(wave, ddof=1)
    return RecordingSet((recording("one", q[:30]), recording("two", q[30:])))


def test_standard_deviations_along_the_components_in_degrees(make, ellipsoid):
    columns, rows = table(make.eigengrasps_text(ellipsoid))
    assert columns == ["name", *(f"{joint}_deg" for joint in JOINT_NAMES)]
    assert list(rows) == ["mean", "eigengrasp_1", "eigengrasp_2", "eigengrasp_3"]
    assert np.allclose(rows.pop("mean"), 30, atol=0.006)
    for row, (joint, size) in zip(rows.values(), ((4, 20), (7, 10), (9, 5)), strict=True):
        expected = np.zeros(22)
        expected[joint] = size
        assert np.allclose(np.abs(row), expected, atol=0.006)


def test_recordings_that_hardly_vary_have_no_eigengrasps(make):
    with pytest.raises(InputError, match="vary"):
        make.eigengrasps_text(RecordingSet((recording("still", np.zeros((20, 22))),)))


def test_the_script_writes_the_table_and_all_models(make, tmp_path):
    make.main(tmp_path)
    committed = data_folder("models") / "hand"
    names = sorted(path.name for path in committed.glob("*.xml"))
    assert sorted(path.name for path in tmp_path.glob("*.xml")) == names
    for name in names:
        # Numbers may differ in their last digit; that they are right test_committed_hand.py tells.
        assert len((tmp_path / name).read_text()) == pytest.approx(
            len((committed / name).read_text()), rel=0.01
        )
    both = "scene_both.xml"  # in which there is no number that a processor could round otherwise
    assert (tmp_path / both).read_text() == (committed / both).read_text()
    written = table((tmp_path / "eigengrasps.csv").read_text())[1]
    for name, row in table((committed / "eigengrasps.csv").read_text())[1].items():
        assert np.allclose(written[name], row, atol=0.011)


def test_committed_table_is_that_of_the_committed_experiments(make):
    """Within the last digit, which may round the other way elsewhere."""
    folder = data_folder("models") / "hand"
    columns, committed = table((folder / "eigengrasps.csv").read_text())
    made = table(make.eigengrasps_text(read_recordings(data_folder("assets") / "experiments")))
    assert made[0] == columns
    assert list(made[1]) == list(committed)
    for name, row in made[1].items():
        assert np.allclose(committed[name], row, atol=0.011), "out of date: run `make models`"
