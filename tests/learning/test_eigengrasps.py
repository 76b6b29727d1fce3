import csv
import io

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.files import data_folder
from handsim.joints import JOINT_NAMES
from handsim.learning.eigengrasps import eigengrasps_text, main
from handsim.motion.recording import Recording, RecordingSet, read_recordings, write_recordings


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
        hand_length=0.19,
        hand_breadth=0.09,
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


def test_standard_deviations_along_the_components_in_degrees(ellipsoid):
    columns, rows = table(eigengrasps_text(ellipsoid))
    assert columns == ["name", *(f"{joint}_deg" for joint in JOINT_NAMES)]
    assert list(rows) == ["mean", "eigengrasp_1", "eigengrasp_2", "eigengrasp_3"]
    assert np.allclose(rows.pop("mean"), 30, atol=0.006)
    for row, (joint, size) in zip(rows.values(), ((4, 20), (7, 10), (9, 5)), strict=True):
        expected = np.zeros(22)
        expected[joint] = size
        assert np.allclose(np.abs(row), expected, atol=0.006)


def test_recordings_that_hardly_vary_have_no_eigengrasps():
    with pytest.raises(InputError, match="vary"):
        eigengrasps_text(RecordingSet((recording("still", np.zeros((20, 22))),)))


def test_command_writes_the_table(ellipsoid, tmp_path, monkeypatch):
    write_recordings(ellipsoid, tmp_path / "recordings")
    file = tmp_path / "table.csv"
    monkeypatch.setattr("sys.argv", ["eigengrasps", str(tmp_path / "recordings"), str(file)])
    main()
    written = table(file.read_text())[1]
    for name, row in table(eigengrasps_text(ellipsoid))[1].items():
        assert np.allclose(written[name], row, atol=0.011)


def test_committed_table_is_that_of_the_committed_experiments():
    """Within the last digit, which may round the other way elsewhere."""
    folder = data_folder("models") / "hand"
    columns, committed = table((folder / "eigengrasps.csv").read_text())
    made = table(eigengrasps_text(read_recordings(data_folder("assets") / "experiments")))
    assert made[0] == columns
    assert list(made[1]) == list(committed)
    for name, row in made[1].items():
        assert np.allclose(committed[name], row, atol=0.011), "out of date: run `make models`"
