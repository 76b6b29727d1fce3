"""Gains and offsets of a known glove are found again; what cannot be known is said."""

from pathlib import Path

import numpy as np
import pytest

from handsim.errors import FileError, InputError
from handsim.joints import JOINT_INDEX, N_JOINTS
from handsim.recordings.glove.calibrate import (
    POSTURES,
    HeldPosture,
    calibrate_postures,
    calibrate_ranges,
    postures_of_files,
    postures_of_table,
)
from handsim.recordings.glove.calibration import calibrated, read_calibration, write_calibration

GAIN = np.linspace(0.8, 1.2, N_JOINTS)
OFFSET = -GAIN * np.linspace(80, 110, N_JOINTS)


def held(name: str, noise: float = 0.0, **others: float) -> HeldPosture:
    angles = {**POSTURES.get(name, {}), **others}
    q = np.zeros(N_JOINTS)
    for joint, angle in angles.items():
        q[JOINT_INDEX[joint]] = angle
    jitter = noise * np.where(np.arange(40) % 2, 1, -1)[:, None]
    return HeldPosture(name, (q - OFFSET) / GAIN + jitter, angles)


def test_postures_give_gain_and_offset_back() -> None:
    made = calibrate_postures([held(name) for name in POSTURES])
    assert made.how == ("postures",) * N_JOINTS
    assert made.gain == pytest.approx(GAIN) and made.offset == pytest.approx(OFFSET)
    assert made.rms < 1e-9
    counts = np.full((3, N_JOINTS), 100.0)
    assert made.angles(counts)[0] == pytest.approx(100 * GAIN + OFFSET)


def test_the_residual_tells_jitter_and_contradiction() -> None:
    jittering = calibrate_postures([held("flat", 2.0), held("fist", 2.0)])
    j = JOINT_INDEX["index_pip"]
    assert jittering.gain[j] == pytest.approx(GAIN[j])
    assert jittering.residual[j] == pytest.approx(2 * GAIN[j])
    wrong = HeldPosture("half", held("half", index_pip=50).counts, {"index_pip": 60.0})
    assert calibrate_postures([held("flat"), held("fist"), wrong]).residual[j] > 4


def test_joints_that_no_posture_moves_are_held_and_said() -> None:
    made = calibrate_postures([held("flat"), held("fist")])
    assert made.how[JOINT_INDEX["wrist_flexion"]] == "held"
    assert "held constant: thumb_rotation" in made.summary
    counts = np.full((2, N_JOINTS), np.nan)
    assert made.angles(counts)[0, JOINT_INDEX["wrist_flexion"]] == 0
    with pytest.raises(InputError, match="hold at least 2"):
        calibrate_postures([held("flat")])
    with pytest.raises(InputError, match=r"index_mcp, index_pip.* cannot be calibrated"):
        calibrate_postures([held("flat"), held("spread")])
    dead = held("fist")
    dead.counts[:, JOINT_INDEX["ring_mcp"]] = held("flat").counts[0, JOINT_INDEX["ring_mcp"]]
    with pytest.raises(InputError, match="ring_mcp: stated angles from 0 to 85 deg"):
        calibrate_postures([held("flat"), dead])


def test_a_sensor_at_the_end_of_its_counts_does_not_count() -> None:
    cut = held("wrist-extended")
    cut.counts[:, JOINT_INDEX["wrist_flexion"]] = 0
    made = calibrate_postures([held("flat"), held("fist"), held("wrist-flexed"), cut])
    assert made.gain[JOINT_INDEX["wrist_flexion"]] == pytest.approx(GAIN[20])


def test_ranges_lie_between_the_ends_of_the_joints() -> None:
    counts = np.linspace(60, 170, 50)[:, None] + np.zeros(N_JOINTS)
    counts[:, JOINT_INDEX["palm_arch"]] = 90
    counts[:, JOINT_INDEX["ring_dip"]] = np.nan
    counts[:, JOINT_INDEX["index_abduction"]] = np.linspace(60, 70, 50)
    made = calibrate_ranges([counts[:25], counts[25:]], "two files")
    ends = made.angles(counts)[[0, -1]]
    assert ends[:, JOINT_INDEX["index_pip"]] == pytest.approx([0, 110])
    assert ends[:, JOINT_INDEX["wrist_flexion"]] == pytest.approx([-70, 80])
    assert made.how[JOINT_INDEX["palm_arch"]] == "held"
    assert made.how[JOINT_INDEX["ring_dip"]] == "none"
    assert np.isnan(made.angles(np.full((1, N_JOINTS), 90.0))[0, JOINT_INDEX["ring_dip"]])
    assert np.isnan(ends[:, JOINT_INDEX["ring_dip"]]).all()
    assert "residual not known" in made.summary and "coarse" in made.summary
    assert made.summary.count("index_abduction") == 1


def test_a_calibration_is_read_as_it_was_written(tmp_path: Path) -> None:
    made = calibrate_postures([held(name, 1.0) for name in ("flat", "fist", "spread")])
    path = tmp_path / "glove.toml"
    write_calibration(made, path)
    read = read_calibration(path)
    assert read.how == made.how and read.source == "flat, fist, spread"
    for name in ("gain", "offset", "residual", "counts"):
        assert np.array_equal(getattr(read, name), getattr(made, name), equal_nan=True)
    text = path.read_text()
    for damaged, said in (
        (text.replace("schema = 1", "schema = 2"), "schema 2"),
        (text.replace("handsim glove", "other"), "is no glove calibration"),
        (text[: len(text) // 2], "no \\[\\[sensor\\]\\] for|is no TOML"),
        (text.replace("gain_deg = ", "gain_deg = inf # ", 1), "no number in range"),
        (text.replace('"index_mcp"', '"index_pip"'), "there twice"),
    ):
        path.write_text(damaged)
        with pytest.raises(FileError, match=said):
            read_calibration(path)


def test_counts_beyond_those_of_the_calibration_are_said() -> None:
    made = calibrate_ranges([np.linspace(60, 170, 50)[:, None] + np.zeros(N_JOINTS)], "a")
    counts = np.full((10, N_JOINTS), 100.0)
    counts[:, 4] = 240
    _, notes = calibrated(made, counts, "x")
    assert notes[-1] == "frames far beyond the calibrated counts: index_mcp (100 %)"
    eighteen = counts.copy()
    eighteen[:, 6] = np.nan
    made18 = calibrate_ranges(
        [np.where(np.isnan(eighteen[0]), np.nan, np.linspace(60, 170, 9)[:, None])], "b"
    )
    with pytest.raises(InputError, match="has no index_dip"):
        calibrated(made18, counts, "x")


def write_counts(path: Path, posture: HeldPosture) -> None:
    lines = [" ".join(f"{round(c)}" for c in row) for row in posture.counts]
    path.write_text("\n".join(lines))


def test_postures_of_files_and_of_a_table(tmp_path: Path) -> None:
    files = [tmp_path / "flat_hand.txt", tmp_path / "fist.txt"]
    for file in files:
        write_counts(file, held(file.stem.split("_")[0], thumb_mcp=0))
    named = calibrate_postures(postures_of_files(files))
    table = tmp_path / "postures.toml"
    table.write_text(
        '[[posture]]\nfile = "flat_hand.txt"\nname = "flat"\nrows = [3, 30]\n'
        '[[posture]]\nfile = "fist.txt"\nname = "fist"\nangles = { index_mcp = 42.5 }\n'
    )
    stated = calibrate_postures(postures_of_table(table, []))
    i, m = JOINT_INDEX["index_mcp"], JOINT_INDEX["middle_mcp"]
    assert named.gain[m] == stated.gain[m] == pytest.approx(GAIN[m], rel=0.01)
    assert stated.gain[i] == pytest.approx(named.gain[i] / 2)
    write_counts(tmp_path / "wave.txt", held("flat"))
    with pytest.raises(FileError, match="named as none of the postures flat, fist"):
        postures_of_files([tmp_path / "wave.txt"])
    for wrong, said in (
        ('name = "fits"', "did you mean fist"),
        ("rows = [90, 99]\nname = 'flat'", "has no rows 90 to 99"),
        ("angles = { index = 1 }", "key 'index'"),
        ("", "states no angles"),
    ):
        table.write_text(f'[[posture]]\nfile = "fist.txt"\n{wrong}\n')
        with pytest.raises(FileError, match=said):
            postures_of_table(table, files)
