"""Files of gloves, cameras and markers, damaged: imported, or refused in a line."""

import io
import json
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.io import savemat

from handsim import data_folder, read_recordings
from handsim.recordings.posture_file import postures_text

from .conftest import Sandbox, damaged_bytes, damaged_table, search

CUBE = next(
    each
    for each in read_recordings(data_folder("assets") / "experiments")
    if each.task == "cube-raise"
)
N = 40
Q = np.rad2deg(CUBE.q[np.linspace(0, len(CUBE.q) - 1, N).astype(int)])
TIME = np.arange(N) / 30
FINGERS = ("thumb", "index", "middle", "ring", "little")


def keypoints() -> np.ndarray:
    """A flat hand of 21 points that closes a little, (N, 21, 3) [m]."""
    x = np.array([0.02, 0.09, 0.09, 0.085, 0.075])
    y = np.array([0.03, 0.022, 0.0, -0.018, -0.035])
    points = np.zeros((N, 21, 3))
    for f in range(5):
        for k in range(4):
            reach = 0.03 * k if f else 0.025 * k
            bend = np.linspace(0.1, 0.9, N) * k / 2
            points[:, 1 + 4 * f + k, 0] = x[f] + reach * np.cos(bend)
            points[:, 1 + 4 * f + k, 1] = y[f] + (0.6 * reach if f == 0 else 0.0)
            points[:, 1 + 4 * f + k, 2] = -reach * np.sin(bend)
    return points


def table() -> bytes:
    return postures_text(TIME, np.deg2rad(Q)).encode()


def german() -> bytes:
    return table().decode().replace(",", ";").replace(".", ",").encode("utf-16")


def glove() -> bytes:
    rows = np.clip(np.round(Q + 60), 0, 255).astype(int)
    return "\n".join(" ".join(map(str, row)) for row in rows).encode()


def ninapro() -> bytes:
    stream = io.BytesIO()
    label = np.repeat([0, 1, 0, 2], N // 4)[:, None]
    savemat(stream, {"glove": Q, "restimulus": label, "repetition": label > 0, "emg": Q[:, :10]})
    return stream.getvalue()


def archive(**arrays: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def as_json() -> bytes:
    frames = [{"landmarks": [dict(zip("xyz", p, strict=True)) for p in f]} for f in keypoints()]
    return json.dumps(frames).encode()


def markers() -> bytes:
    points = 1000 * keypoints()
    named = {"hand_top": 9, "hand_left": 5, "hand_right": 17}
    named |= {f"{finger}_middle": 2 + 4 * f for f, finger in enumerate(FINGERS)}
    named |= {f"{finger}_tip": 4 + 4 * f for f, finger in enumerate(FINGERS)}
    head = ["Frame", "Time", *(f"{name} {axis}" for name in named for axis in "XYZ")]
    rows = [
        [str(i + 1), f"{TIME[i]:.3f}", *(f"{v:.2f}" for j in named.values() for v in points[i, j])]
        for i in range(N)
    ]
    return "\n".join("\t".join(row) for row in [["FREQUENCY", "30"], head, *rows]).encode()


def adroit() -> bytes:
    angles = np.linspace(0, 1, 60)[:, None] * np.linspace(0.1, 0.8, 39)
    return archive(observations_00=angles.astype(np.float32))


FILES: dict[str, tuple[str, str, Callable[[], bytes], tuple[str, ...]]] = {
    "table": ("table", "a.csv", table, ("--bridge", "0.2")),
    "german": ("table", "a.csv", german, ()),
    "glove": ("cyberglove", "a.txt", glove, ("--rate", "30", "--units", "deg")),
    "ninapro": ("ninapro", "a.mat", ninapro, ("--units", "deg")),
    "keypoints": ("keypoints", "a.npz", lambda: archive(keypoints=keypoints()), ()),
    "json": ("keypoints", "a.json", as_json, ("--side", "right")),
    "markers": ("markers", "a.tsv", markers, ("--side", "right")),
    "adroit": ("adroit", "a.npz", adroit, ()),
}


@pytest.mark.parametrize("kind", FILES)
def test_damaged_files_of_importers(sandbox: Sandbox, kind: str) -> None:
    layout, name, make, options = FILES[kind]
    original = make()

    def check(damaged: bytes) -> None:
        sandbox.fresh()
        (sandbox.inputs / name).write_bytes(damaged)
        out = sandbox.outputs / "set"
        sandbox.run(
            *("recordings", "import", sandbox.inputs / name, "--format", layout),
            *("-o", out, *options),
        )

    check(original)
    assert sandbox.codes == [0]
    cases = 3 if layout in ("keypoints", "markers") else 6  # a fit of the hand takes its time
    search(check, damaged_bytes(original), cases * sandbox.cases)
    assert 2 in sandbox.codes


def test_damaged_cells_of_tables(sandbox: Sandbox) -> None:
    def check(damaged: bytes) -> None:
        sandbox.fresh()
        (sandbox.inputs / "a.csv").write_bytes(damaged)
        draft = sandbox.outputs / "map.toml"
        sandbox.run("recordings", "map", sandbox.inputs / "a.csv", "-o", draft)
        out = sandbox.outputs / "set"
        options = ("--format", "table", "-o", out)
        sandbox.run("recordings", "import", sandbox.inputs / "a.csv", *options)

    search(check, damaged_table(table().decode()), 8 * sandbox.cases)
    assert {0, 2} <= set(sandbox.codes)


def test_damaged_times_of_cuts(sandbox: Sandbox) -> None:
    times = "file,start_s,end_s\ncube-raise.csv,0.1,0.9\ncube-raise.csv,0.9,1.2\n"
    whole = postures_text(CUBE.time, CUBE.q, {"label": np.zeros(len(CUBE.time))})
    index = (data_folder("assets") / "experiments" / "experiments.csv").read_text().splitlines()
    row = next(line for line in index if line.startswith("cube-raise.csv"))

    def check(damaged: bytes) -> None:
        sandbox.fresh()
        folder = sandbox.inputs / "whole"
        folder.mkdir()
        (folder / "cube-raise.csv").write_text(whole)
        (folder / "experiments.csv").write_text(f"{index[0]}\n{row}\n")
        (sandbox.inputs / "times.csv").write_bytes(damaged)
        words = ("--times", sandbox.inputs / "times.csv", "-o", sandbox.outputs / "cut")
        sandbox.run("recordings", "cut", folder, *words)

    search(
        check, st.one_of(damaged_table(times), damaged_bytes(times.encode())), 10 * sandbox.cases
    )
    assert 2 in sandbox.codes
