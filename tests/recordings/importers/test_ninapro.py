"""Files of Ninapro: a recording a repetition, labels and EMG kept, counts not taken for angles."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from handsim.errors import FileError, InputError
from handsim.recordings.glove.calibrate import calibrate_ranges, counts_of_files
from handsim.recordings.glove.calibration import write_calibration
from handsim.recordings.importers.import_files import import_recordings
from handsim.recordings.importers.layout import ImportOptions

USER_FILES = Path(__file__).parents[3] / "../shared/data/user_files"
real_data = pytest.mark.skipif(not USER_FILES.is_dir(), reason="no user files in ../shared")
N = 800


def variables(**others) -> dict:
    """Movements 5 (twice) and 6 of 100 rows each, rests of 100 and of 20 rows between them."""
    label, repetition = np.zeros(N, int), np.zeros(N, int)
    for movement, number, start in ((5, 1, 100), (5, 2, 220), (6, 1, 420)):
        label[start : start + 100], repetition[start : start + 100] = movement, number
    ramp = np.linspace(0, 60, N)[:, None] + np.arange(22)
    return {
        "glove": ramp, "stimulus": np.zeros((N, 1), int), "restimulus": label[:, None],
        "repetition": np.zeros((N, 1), int), "rerepetition": repetition[:, None],
        "emg": np.arange(N)[:, None] + np.arange(10) / 10, "subject": 3, "exercise": 2, **others,
    }  # fmt: skip


def read(tmp_path: Path, file: dict | None = None, name: str = "x.mat", **said):
    content = variables() if file is None else file
    savemat(tmp_path / name, {k: v for k, v in content.items() if v is not None})
    return import_recordings([tmp_path / name], "ninapro", options=ImportOptions(**said))


def test_a_recording_a_repetition(tmp_path: Path) -> None:
    recordings = read(tmp_path, units="deg")
    assert [r.name for r in recordings] == ["s3-e2-m05-r01", "s3-e2-m05-r02", "s3-e2-m06-r01"]
    # Half a second of rest before, or all of it where it is shorter.
    assert [len(r.time) for r in recordings] == [150, 120, 150]
    second = recordings[1]
    assert second.time[0] == 0 and second.duration == pytest.approx(1.19)
    assert np.rad2deg(second.q[0, 5]) == pytest.approx(60 * 200 / (N - 1) + 5)
    assert second.channels["emg_01"][0] == 200 and second.channels["emg_10"][-1] == 319.9
    assert second.channels["label"].tolist() == [0] * 20 + [5] * 100
    assert (second.task, second.subject, second.number) == ("movement-05", "3", 2)
    assert second.extra == {"movement": "5", "repetition": "2", "exercise": "2"}
    assert "movements by restimulus" in second.notes
    assert "rate 100 Hz, that of DB1, by 10 columns of emg" in second.notes
    assert "starts 0.2 s before its label" in second.notes


def test_rates_by_the_databases(tmp_path: Path) -> None:
    def rate(emg: int, acc: int = 0, **others) -> float:
        file = variables(emg=np.zeros((N, emg)) if emg else None,
                         acc=np.zeros((N, acc)) if acc else None, **others)  # fmt: skip
        return 1 / np.diff(read(tmp_path, file, units="deg")[0].time)[0]

    for said, expected in (
        ((12, 36), 2000),
        ((16, 3), 200),
        ((14, 42), 2000),
        ((16, 48), 2000),
        ((10,), 100),
    ):
        assert rate(*said) == pytest.approx(expected)
    assert rate(8, frequency=500) == pytest.approx(500)
    with pytest.raises(InputError, match=r"8 columns of emg .* give it in Hz by --rate"):
        rate(8)
    assert 1 / np.diff(read(tmp_path, variables(emg=None), units="deg", rate_hz=25)[0].time)[
        0
    ] == pytest.approx(25)


def test_counts_need_a_calibration(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"uncalibrated values from 0 to 81; calibrate"):
        read(tmp_path)
    made = calibrate_ranges(counts_of_files([tmp_path / "x.mat"]), "x.mat")
    write_calibration(made, tmp_path / "g.toml")
    recording = read(tmp_path, calibration=tmp_path / "g.toml")[2]
    assert np.rad2deg(recording.q[0, 5]) == pytest.approx(110 * 370 / (N - 1))
    assert any("counts calibrated by x.mat" in note for note in recording.notes)


def test_eighteen_sensors_labels_shown_and_names_of_files(tmp_path: Path) -> None:
    file = variables(glove=variables()["glove"][:, :18], subject=None, exercise=None,
                     restimulus=None, rerepetition=None,
                     stimulus=variables()["restimulus"], repetition=None)  # fmt: skip
    recordings = read(tmp_path, file, "S12_A1_E3.mat", units="deg")
    assert [r.name for r in recordings] == ["s12-e3-m05-r01", "s12-e3-m05-r02", "s12-e3-m06-r01"]
    assert {"movements by stimulus", "repetitions counted"} <= set(recordings[0].notes)
    degrees = np.rad2deg(recordings[0].q[0])
    assert degrees[6] == pytest.approx(0.67 * degrees[5])
    assert degrees[7] == pytest.approx(60 * 50 / (N - 1) + 6)  # the 7th of 18 sensors


def test_calibrated_angles_of_the_database_come_first(tmp_path: Path) -> None:
    angles = variables()["glove"] / 2
    angles[:, 10] = np.nan  # sensor 11 was left out by the authors
    recording = read(tmp_path, variables(angles=angles))[0]
    assert np.rad2deg(recording.q[0, 5]) == pytest.approx((60 * 50 / (N - 1) + 5) / 2)
    assert (recording.q[:, 10] == 0).all()
    assert any("index_abduction taken as constant" in note for note in recording.notes)


def test_bad_files(tmp_path: Path) -> None:
    for others, said in (
        ({"glove": np.zeros((N, 20))}, r"glove is of shape \(800, 20\)"),
        ({"glove": None}, "glove is missing"),
        ({"restimulus": None, "stimulus": None}, "no variable restimulus or stimulus"),
        ({"restimulus": np.zeros((N, 1))}, "labels are all rest"),
        ({"restimulus": np.zeros((N - 1, 1))}, "799 values for 800 rows"),
        ({"restimulus": np.full((N, 1), np.nan)}, "no labels"),
        ({"glove": np.array([["a"]])}, "glove holds <U1|not rows of numbers"),
    ):
        with pytest.raises(FileError, match=said):
            read(tmp_path, variables(**others), units="deg")
    (tmp_path / "new.mat").write_bytes(b"MATLAB 7.3 MAT-file" + bytes(493) + b"\x89HDF\r\n\x1a\n")
    with pytest.raises(FileError, match=r"MATLAB 7\.3 .*savemat"):
        import_recordings([tmp_path / "new.mat"], "ninapro")
    gap = variables()["glove"]
    gap[450, 4] = np.nan
    with pytest.raises(FileError, match="row 451, column index_mcp of glove"):
        read(tmp_path, variables(glove=gap), units="deg")


@real_data
@pytest.mark.real_data
def test_user_file() -> None:
    file = USER_FILES / "ninapro-mat/S1_E2_A1.mat"
    with pytest.raises(InputError, match=r"from 102\.572 to 176\.058; calibrate"):
        import_recordings([file], "ninapro")
    recordings = import_recordings([file], "ninapro", options=ImportOptions(units="deg"))
    assert [r.name for r in recordings] == ["s1-e2-m01-r01", "s1-e2-m02-r01"]
    assert [len(r.channels) for r in recordings] == [13, 13]
