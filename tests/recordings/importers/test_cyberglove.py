"""Raw files of gloves, in the ways that loggers write them."""

from pathlib import Path

import numpy as np
import pytest

from handsim.errors import FileError, InputError
from handsim.joints import JOINT_NAMES, JOINTS, N_JOINTS
from handsim.recordings.glove.calibration import GloveCalibration, write_calibration
from handsim.recordings.importers.import_files import import_recordings
from handsim.recordings.importers.layout import ImportOptions

USER_FILES = Path(__file__).parents[3] / "../shared/data/user_files"
real_data = pytest.mark.skipif(not USER_FILES.is_dir(), reason="no user files in ../shared")
GAIN, OFFSET = 0.5, -40.0
EIGHTEEN = [i for i, name in enumerate(JOINT_NAMES) if not name.endswith("_dip")]
COUNTS = np.round(90 + np.outer(np.linspace(0, 1, 30), np.arange(N_JOINTS) * 2 + 10))
TIME = np.arange(30) / 50


@pytest.fixture
def calibration(tmp_path: Path) -> Path:
    ones = np.ones(N_JOINTS)
    made = GloveCalibration(
        source="flat, fist",
        how=("postures",) * N_JOINTS,
        gain=GAIN * ones,
        offset=OFFSET * ones,
        residual=0.7 * ones,
        counts=np.outer(ones, [80, 160]),
    )
    write_calibration(made, tmp_path / "glove.toml")
    return tmp_path / "glove.toml"


def written(path: Path, columns: list[int], before: str = "", sep: str = " ", after: str = "",
            header: str = "") -> Path:  # fmt: skip
    lines = [header] if header else []
    for i, (t, row) in enumerate(zip(TIME, COUNTS, strict=True)):
        start = before.format(t=t, ms=1000 * t, s=1 + t, i=i)
        lines.append(start + sep.join(f"{row[c]:.0f}" for c in columns) + after)
    path.write_text("\n".join(lines) + "\n")
    return path


ALL = list(range(N_JOINTS))
LETTERS = ";".join(["t", *"abcdefghijklmnopqrstuv"])
TURNED = ",".join(["t", *(joint.sensor for joint in JOINTS[::-1])])
WAYS = {
    "22": (ALL, {}, 50.0),
    "22 commas": (ALL, {"sep": ","}, 50.0),
    "18": (EIGHTEEN, {}, 50.0),
    "18 and seconds": (EIGHTEEN, {"before": "{t:.2f} "}, None),
    "milliseconds": (ALL, {"before": "{ms:.0f},", "sep": ","}, None),
    "a header": (ALL, {"before": "{ms:.0f};", "sep": ";", "header": LETTERS}, None),
    "maker's stamps": (ALL, {"before": '"12:30:{s:06.3f}" '}, None),
    "dates": (EIGHTEEN, {"before": '"2024-05-01 12:30:{s:06.3f}" '}, None),
    "dates without quotes": (EIGHTEEN, {"before": "2024-05-01 12:30:{s:06.3f} "}, None),
    "counter and time": (ALL, {"before": "{i} {ms:.0f} "}, None),
    "status": (ALL, {"after": " 3"}, 50.0),
    "time and status": (ALL, {"before": "{ms:.0f} ", "after": " 3"}, None),
    "names in another order": (
        ALL[::-1],
        {"before": "{t:.2f},", "sep": ",", "header": TURNED},
        None,
    ),
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_counts_become_the_same_angles(way: str, tmp_path: Path, calibration: Path) -> None:
    columns, said, rate = WAYS[way]
    path = written(tmp_path / "a.txt", columns, **said)
    options = ImportOptions(calibration=calibration, rate_hz=rate)
    recording = import_recordings([path], "cyberglove", options=options)[0]
    angles = GAIN * COUNTS + OFFSET
    degrees = np.rad2deg(recording.q)
    assert degrees[:, EIGHTEEN] == pytest.approx(angles[:, EIGHTEEN])
    if len(columns) == 18:
        assert degrees[:, 6] == pytest.approx(0.67 * angles[:, 5])
        assert "index_dip, middle_dip, ring_dip, little_dip filled" in recording.notes[-1]
    else:
        assert degrees == pytest.approx(angles)
    assert recording.time == pytest.approx(TIME)
    assert any(
        "flat, fist: 22 joints by postures, rms residual 0.7 deg" in n for n in recording.notes
    )


def test_counts_without_a_calibration_are_refused(tmp_path: Path, calibration: Path) -> None:
    path = written(tmp_path / "a.txt", ALL)
    with pytest.raises(InputError, match=r"raw counts from 90 to 142; calibrate .*--calibration"):
        import_recordings([path], "cyberglove", options=ImportOptions(rate_hz=50))
    with pytest.raises(InputError, match="no column of time; give the rate"):
        import_recordings([path], "cyberglove", options=ImportOptions(calibration=calibration))
    with pytest.raises(InputError, match="one of the two"):
        import_recordings(
            [path], "cyberglove", options=ImportOptions(calibration=calibration, units="deg")
        )
    with pytest.raises(FileError, match="has 14 columns; a raw file has 18 or 22 sensors"):
        import_recordings([written(tmp_path / "b.txt", ALL[:14])], "cyberglove")
    path.write_text(path.read_text().replace("90 90 90", "90 -4 90", 1))
    options = ImportOptions(calibration=calibration, rate_hz=50)
    with pytest.raises(InputError, match="row 1, thumb_mcp: -4 is no count from 0 to 4095"):
        import_recordings([path], "cyberglove", options=options)


def test_angles_in_the_maker_s_order(tmp_path: Path) -> None:
    path = written(tmp_path / "a.txt", ALL)
    options = ImportOptions(units="deg", rate_hz=50)
    recording = import_recordings([path], "cyberglove", options=options)[0]
    assert np.rad2deg(recording.q) == pytest.approx(COUNTS)


@real_data
@pytest.mark.real_data
def test_user_files_of_raw_counts(tmp_path: Path) -> None:
    from handsim.recordings.glove.calibrate import calibrate_ranges, counts_of_files

    files = sorted((USER_FILES / "raw-counts").glob("raw*.csv"))
    write_calibration(calibrate_ranges(counts_of_files(files), "all four"), tmp_path / "g.toml")
    options = ImportOptions(units="counts", calibration=tmp_path / "g.toml")
    by_table = import_recordings([USER_FILES / "raw-counts"], "table", options=options)
    options = ImportOptions(calibration=tmp_path / "g.toml")
    by_glove = import_recordings(files, "cyberglove", options=options)
    for a, b in zip(by_table, by_glove, strict=True):
        assert np.array_equal(a.q, b.q)
        assert np.rad2deg(a.q).min() >= -70 - 1e-9 and np.rad2deg(a.q).max() <= 120 + 1e-9


def test_a_table_of_counts_and_of_angles(tmp_path: Path, calibration: Path) -> None:
    """Counts of some columns go through the calibration, angles of others stay, gaps included."""
    units = ["raw"] * 20 + ["deg"] * 2
    names = [f"{name}_{unit}" for name, unit in zip(JOINT_NAMES, units, strict=True)]
    header = ",".join(["time_s", *names])
    path = written(tmp_path / "a.csv", ALL, before="{t:.2f},", sep=",", header=header)
    recording = import_recordings([path], "table", options=ImportOptions(calibration=calibration))[
        0
    ]
    degrees = np.rad2deg(recording.q)
    assert degrees[:, :20] == pytest.approx((GAIN * COUNTS + OFFSET)[:, :20])
    assert degrees[:, 20:] == pytest.approx(COUNTS[:, 20:])
