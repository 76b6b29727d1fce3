"""`handsim recordings map` and `calibrate`, and imports with what they write."""

from pathlib import Path

import numpy as np
import pytest

from handsim.joints import JOINT_NAMES, N_JOINTS
from handsim.recordings.folder import read_recordings


def glove_file(path: Path, start: float, end: float, frames: int = 30) -> Path:
    """Counts of 22 sensors that go from one value to another and jitter by half a count."""
    counts = np.linspace(start, end, frames)[:, None] + np.zeros(N_JOINTS)
    counts[::2] += 1
    path.write_text("\n".join(" ".join(f"{c:.0f}" for c in row) for row in counts) + "\n")
    return path


def test_a_glove_is_calibrated_and_imported(run, tmp_path: Path) -> None:
    flat, fist = (
        glove_file(tmp_path / f"{name}.txt", c, c) for name, c in (("flat", 60), ("fist", 160))
    )
    reach = glove_file(tmp_path / "reach.txt", 60, 110)
    glove = tmp_path / "glove.toml"
    postures = tmp_path / "postures.toml"
    angles = ", ".join(f"{name} = 50" for name in JOINT_NAMES)
    postures.write_text(
        '[[posture]]\nfile = "flat.txt"\nname = "flat"\n'
        f'[[posture]]\nfile = "fist.txt"\nangles = {{ {angles} }}\n'
    )
    said = run("recordings", "calibrate", flat, fist, "--postures", postures, "-o", glove)
    assert said.code == 0
    assert "22 joints by postures, rms residual 0.25 deg" in said.err
    assert "0.500" in said.out and "60 to 161" in said.out
    imported = (
        "recordings",
        "import",
        reach,
        "--format",
        "cyberglove",
        "--rate",
        "100",
        "-o",
        tmp_path / "out",
    )
    done = run(*imported)
    assert done.code == 2 and "raw counts from 61 to 110" in done.err
    assert not (tmp_path / "out").exists()
    assert run(*imported, "--calibration", glove).code == 0
    recording = read_recordings(tmp_path / "out")[0]
    assert np.rad2deg(recording.q[-1]) == pytest.approx(24.75)
    assert any("calibrated by flat.txt, fist.txt" in note for note in recording.notes)
    assert run("recordings", "calibrate", flat, "--ranges", "-o", tmp_path / "r.toml").code == 2
    assert not (tmp_path / "r.toml").exists()
    assert (
        run("recordings", "calibrate", flat, "--ranges", "--postures", postures, "-o", glove).code
        == 2
    )


def test_a_map_is_drafted(run, tmp_path: Path) -> None:
    table = tmp_path / "a.csv"
    values = np.column_stack([np.arange(20) / 100, np.full((20, N_JOINTS), 12.5)])
    header = ["t", *(f"s{i}" for i in range(N_JOINTS))]
    np.savetxt(table, values, delimiter=",", header=",".join(header), comments="")
    out = tmp_path / "out"
    done = run("recordings", "import", table, "--format", "table", "-o", out)
    assert done.code == 2 and f"handsim recordings map {table} -o a.toml" in done.err
    done = run("recordings", "map", table, "-o", tmp_path / "a.toml")
    assert done.code == 0 and "to decide: thumb_rotation may be s0" in done.err
    mapped = ("--map", tmp_path / "a.toml")
    assert run("recordings", "import", table, "--format", "table", *mapped, "-o", out).code == 0
    assert np.rad2deg(read_recordings(out)[0].q) == pytest.approx(12.5)
