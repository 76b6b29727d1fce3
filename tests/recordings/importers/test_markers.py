"""From files of markers to recordings: a hand made by known angles, and published reaches."""

from pathlib import Path

import numpy as np
import pytest
from seen_hand import SIZE, movement, poses, seen

from handsim.errors import FileError
from handsim.hand.kinematics import Kinematics
from handsim.joints import FINGERS, JOINT_INDEX
from handsim.recordings.importers.import_files import import_recordings
from handsim.recordings.importers.layout import ImportOptions
from handsim.recordings.points.marker_roles import HAND_ROLES
from handsim.recordings.recording import Recording
from handsim.types import HandSize

REAL = Path(__file__).parents[3] / "../shared/data/pillow_reach/recording.tsv"
real_data = pytest.mark.skipif(not REAL.is_file(), reason="no published recordings in ../shared")
N = 60
ON_HAND = [
    ("hand_top", "palm", (0.012, 0.005, 0)), ("hand_left", "palm", (-0.01, 0.02, 0.002)),
    ("hand_right", "palm", (-0.012, -0.015, 0)),
    *((f"{finger}_{place}", f"{finger}_{place}", (0.004, 0.001, 0.001))
      for finger in FINGERS for place in ("tip", "middle")),
]  # fmt: skip
POINTS = tuple(HAND_ROLES[role] for _, role, _ in ON_HAND)
OFFSET = np.array([offset for _, _, offset in ON_HAND])


def moved() -> np.ndarray:
    q = movement(N)
    q[:, JOINT_INDEX["wrist_flexion"]] = np.linspace(-0.7, 0.2, N)
    q[:, JOINT_INDEX["wrist_deviation"]] = -0.1
    return q


def write(path: Path, size: HandSize = SIZE, gaps: tuple[tuple[str, slice], ...] = ()) -> Path:
    """Write 100 Hz of a hand, an elbow in the middle of its joint by two markers, and a box."""
    q = moved()
    hand_only = q.copy()
    hand_only[:, 20:] = 0
    on_hand = seen(POINTS, hand_only, size=size, offset=OFFSET).swapaxes(0, 1)
    markers = dict(zip([name for name, _, _ in ON_HAND], on_hand, strict=True))
    palm, wrist = poses(N)
    forearm = palm @ Kinematics(SIZE).frames(q).rotation[:, 0].swapaxes(1, 2)
    mirror = np.array([1, -1, 1]) if size.side == "left" else np.ones(3)
    elbow = wrist - 0.26 * forearm[:, :, 0]
    side = 0.04 * forearm[:, :, 1]
    markers |= {"elbow_in": (elbow + side) * mirror, "elbow_out": (elbow - side) * mirror,
                "shoulder": (elbow + [0, 0, 0.3]) * mirror}  # fmt: skip
    markers |= {f"box_{i}": np.tile([0.8, 0.1 * i, 0.05 * i * i], (N, 1)) for i in range(3)}
    for name, frames in gaps:
        markers[name][frames] = np.nan
    header = "\t".join(f"{name} {axis}" for name in markers for axis in "XYZ")
    rows = 1000 * np.concatenate(list(markers.values()), axis=1)
    lines = [
        f"{k / 100:.2f}\t" + "\t".join("" if np.isnan(x) else f"{x:.3f}" for x in row)
        for k, row in enumerate(rows)
    ]
    path.write_text("\n".join([f"Time\t{header}", *lines]))
    return path


def imported(file: Path, **said: object) -> Recording:
    return import_recordings([file], "markers", options=ImportOptions(**said))[0]  # type: ignore[arg-type]


@pytest.mark.parametrize("side", ["right", "left"])
def test_hand_wrist_arm_and_object(tmp_path: Path, side: str) -> None:
    size = HandSize(SIZE.length, SIZE.breadth, side)  # type: ignore[arg-type]
    recording = imported(write(tmp_path / "a.tsv", size), object="box")
    assert recording.hand.side == side
    assert recording.hand.length == pytest.approx(0.178, rel=0.1)  # markers on skin tell little
    channels = recording.channels
    assert 1000 * np.sqrt((channels["fit_residual_m"] ** 2).mean()) < 1.5
    error = np.rad2deg(np.abs(recording.q - moved()))
    flexions = [j for name, j in JOINT_INDEX.items() if name.endswith(("mcp", "pip"))]
    assert error[:, flexions].mean() < 5
    for j in flexions[1:]:  # whatever the zero, the way is that of the joint
        assert np.corrcoef(recording.q[:, j], moved()[:, j])[0, 1] > 0.99
    wrist = [JOINT_INDEX["wrist_flexion"], JOINT_INDEX["wrist_deviation"]]
    assert error[:, wrist].mean() < 5
    assert {"palm_x_m", "palm_qw", "elbow_x_m", "shoulder_z_m", "object_qz"} <= set(channels)
    assert channels["object_x_m"] == pytest.approx(0.8) and channels["object_qw"] == pytest.approx(
        1
    )
    notes = "; ".join(recording.notes)
    for said in ("taken as mm", f"a {side} hand", "wrist angles from elbow_in, elbow_out"):
        assert said in notes
    assert "beside the joint" not in notes


def test_short_gaps_are_bridged_and_long_ones_fitted_without(tmp_path: Path) -> None:
    gaps = (("index_tip", slice(10, 14)), ("ring_tip", slice(20, 50)))
    recording = imported(write(tmp_path / "a.tsv", gaps=gaps), side="right", hand=SIZE)
    whole = imported(write(tmp_path / "b.tsv"), side="right", hand=SIZE)
    notes = "; ".join(recording.notes)
    assert "0.1 s bridged: 4 positions" in notes and "30 positions of markers missing" in notes
    assert "missing" not in "; ".join(whole.notes)
    apart = np.rad2deg(np.abs(recording.q - whole.q))
    ring = [j for name, j in JOINT_INDEX.items() if name.startswith("ring")]
    assert np.delete(apart, ring, axis=1).max() < 4
    assert not recording.channels["fit_bad"].any()
    dip = recording.q[21:49, JOINT_INDEX["ring_dip"]]
    assert np.abs(np.diff(dip, 2)).max() < 1e-9  # nothing tells of it: on a straight line


def test_a_map_names_markers_whose_names_say_nothing(tmp_path: Path) -> None:
    file = write(tmp_path / "a.tsv")
    text = file.read_text()
    for i, (name, _, _) in enumerate(ON_HAND):
        text = text.replace(name, f"M{i}")
    file.write_text(text)
    with pytest.raises(FileError, match=r"0 of 19 markers .* --map .*M0, M1"):
        imported(file)
    lines = [f'M{i} = "{role}"' for i, (_, role, _) in enumerate(ON_HAND)]
    lines += ['elbow_in = "elbow"']
    table = tmp_path / "map.toml"
    table.write_text("\n".join(['side = "right"', "wrist = false", "[markers]", *lines]))
    recording = imported(file, column_map=table)
    assert "markers by map.toml" in recording.notes
    assert "shoulder_x_m" not in recording.channels and "elbow_x_m" in recording.channels
    assert (recording.q[:, 20:] == 0).all()
    assert any("wrist_deviation not seen" in note for note in recording.notes)


def test_files_without_a_hand(tmp_path: Path) -> None:
    file = write(tmp_path / "a.tsv")
    lines = file.read_text().split("\n")
    file.write_text("\n".join(lines[:9]))
    with pytest.raises(FileError, match=r"a\.tsv: 8 frames"):
        imported(file)
    time = [line.split("\t", maxsplit=1) for line in lines[1:]]
    file.write_text("\n".join([lines[0], *("\t".join([t, *["1"] * 57]) for t, _ in time)]))
    with pytest.raises(FileError, match="no hand in m, cm or mm"):
        imported(file)


@real_data
@pytest.mark.real_data
def test_published_reaches_fit_to_4_mm() -> None:
    recording = imported(REAL)
    assert len(recording.time) == 6000 and recording.duration == pytest.approx(59.99)
    residual = recording.channels["fit_residual_m"]
    assert 1000 * np.sqrt((residual**2).mean()) < 3.0
    assert recording.hand.side == "right" and 0.19 < recording.hand.length < 0.22
    values = np.linalg.eigvalsh(np.cov(recording.q.T))[::-1]
    assert values[:3].sum() / values.sum() > 0.90
    assert not recording.channels["fit_bad"].any()
    # One marker at the elbow does not tell where its centre is.
    assert recording.not_seen == {"wrist_flexion", "wrist_deviation"}
    assert np.rad2deg(np.abs(np.diff(recording.q, axis=0))).max() < 20  # no leaps in 10 ms
    assert {"elbow_x_m", "shoulder_x_m", "torso_x_m", "object_qw"} <= set(recording.channels)
