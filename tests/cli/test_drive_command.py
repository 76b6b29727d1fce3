"""`handsim drive`: what it writes and says, and what it refuses."""

import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest

import handsim
from handsim.cli.driving import ENOUGH, _like
from handsim.files import data_folder
from handsim.recordings.plausibility import PlausibilityWarning
from handsim.recordings.posture_file import read_posture_table, read_postures

PEOPLE = data_folder("assets") / "people" / "pillow"
ONE = PEOPLE / "pillow-03.csv"


@pytest.fixture(scope="module")
def pillow(tmp_path_factory) -> Path:
    """A controller with signals, learned quickly."""
    path = tmp_path_factory.mktemp("pillow") / "pillow.npz"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PlausibilityWarning)
        recordings = handsim.read_recordings(PEOPLE)[:8]
        handsim.learn_controller(recordings, 2, handsim.DirectionLearner()).controller.save(path)
    return path


@pytest.fixture
def switch(tmp_path) -> Path:
    path = tmp_path / "switch.csv"
    rows = [f"{i / 50},{int(25 < i < 300)}" for i in range(400)]
    path.write_text("\n".join(["time_s,value", *rows]) + "\n")
    return path


@pytest.fixture
def refused(run, tmp_path):
    def _refused(*args: object) -> str:
        before = sorted(path.name for path in tmp_path.rglob("*"))
        result = run("drive", *args)
        assert (result.code, result.out, result.err.count("\n")) == (2, "", 1)
        assert result.err.startswith("handsim: ")
        assert sorted(path.name for path in tmp_path.rglob("*")) == before
        return result.err

    return _refused


def test_a_recording_drives(run, pillow, tmp_path) -> None:
    out = tmp_path / "p.csv"
    result = run("drive", pillow, "--signal", ONE, "-o", out, "--json")
    assert result.code == 0
    said = result.json()
    assert (said["channel"], said["rising"], said["n_recordings"]) == ("distance_m", False, 8)
    assert 0.3 < said["explained"] < 1
    assert 0.5 < said["progress_end"] <= said["progress_most"] <= 1
    assert said["rms_deg"] < said["time_law_rms_deg"]
    assert said["ratio"] == pytest.approx(said["rms_deg"] / said["time_law_rms_deg"])
    time, q = read_postures(out)
    recorded_time, recorded = read_postures(ONE)
    np.testing.assert_allclose(time, recorded_time, atol=1e-6)
    off = np.rad2deg(np.sqrt(np.mean((q - recorded) ** 2)))
    assert off == pytest.approx(said["rms_deg"], abs=1e-3)
    channels = read_posture_table(out).channels
    assert channels["progress"][-1] == pytest.approx(said["progress_end"], abs=1e-6)
    assert channels["distance_m"][0] > channels["distance_m"][-1]


def test_what_it_says(run, pillow, tmp_path) -> None:
    """The aperture has a gap in one of the eight recordings."""
    result = run("drive", pillow, "--signal", ONE, "--channel", "aperture_m", "-o",
                 tmp_path / "p.csv")  # fmt: skip
    assert result.code == 0
    assert result.out.startswith("aperture_m ")
    assert "% of progress explained by it in 7 recordings" in result.out
    assert "off the recorded posture by" in result.out
    assert f"wrote {len(read_postures(ONE)[0])} postures" in result.err


def test_a_switch_opens_and_closes(run, tmp_path, switch) -> None:
    """The built-in controller has no signals; the range says what on and off are."""
    out = tmp_path / "p.csv"
    args = ("--signal", switch, "--range", "0", "1", "--task", "cube-raise", "-o", out, "--json")
    said = run("drive", *args).json()
    assert (said["channel"], said["explained"], said["rms_deg"]) == ("value", None, None)
    assert said["progress_most"] == pytest.approx(1.0, abs=1e-12)
    assert said["progress_end"] == pytest.approx(0.0, abs=1e-6)
    assert said["reason"] == "on the way"
    progress = read_posture_table(out).channels["progress"]
    assert (progress[:26] == 0).all()
    assert 0 < progress[40] < 1
    slower = run("drive", *args, "--speed", "0.5").json()
    assert slower["progress_end"] > 0


def test_another_destination(run, pillow, tmp_path) -> None:
    """--task comes before the end of the recording; here it is the first one's."""
    out, other = tmp_path / "p.csv", tmp_path / "o.csv"
    run("drive", pillow, "--signal", ONE, "-o", out)
    run("drive", pillow, "--signal", ONE, "--task", "pillow-01", "-o", other)
    own, tasks = read_postures(out)[1], read_postures(other)[1]
    np.testing.assert_allclose(own[0], tasks[0], atol=1e-6)
    assert np.abs(own[-1] - tasks[-1]).max() > np.deg2rad(0.5)


def test_a_controller_of_one_task_needs_no_name_of_it(run, pillow, tmp_path) -> None:
    signal = tmp_path / "s.csv"
    rows = [f"{i / 50},{0.4 - 0.3 * i / 99}" for i in range(100)]
    signal.write_text("\n".join(["time_s,distance_m", *rows]))
    said = run("drive", pillow, "--signal", signal, "-o", tmp_path / "p.csv", "--json").json()
    assert said["channel"] == "distance_m"
    assert said["progress_end"] == 1.0


def test_films(run, pillow, tmp_path, read_video) -> None:
    film, end = tmp_path / "p.mp4", tmp_path / "end.csv"
    lines = ONE.read_text().splitlines()
    end.write_text("\n".join([lines[0], *lines[-16:]]))  # its last 0.3 s
    result = run("drive", pillow, "--signal", end, "-o", tmp_path / "p.csv", "--video", film)
    assert result.code == 0
    metadata, frames = read_video(film)
    assert len(frames) / metadata["fps"] == pytest.approx(0.3, abs=0.1)
    driven, recorded = np.split(frames[-1].astype(float), 2, axis=1)
    assert np.abs(driven - recorded).max() > 50  # two hands
    assert np.abs(driven - recorded).mean() < 20


def test_enough_recordings_of_an_object_go_alone(pillow) -> None:
    known = handsim.GraspController.load(pillow).demonstrations
    other = [handsim.learning.demonstration.Demonstration(
        **{**vars(d), "object": "cup"}) for d in known]  # fmt: skip
    mixed = [*known[:ENOUGH], *other]
    assert list(_like(mixed, "pillow", "distance_m")) == mixed[:ENOUGH]
    assert list(_like(mixed[1:], "pillow", "distance_m")) == mixed[1:]
    assert list(_like(mixed, None, "distance_m")) == mixed


@pytest.mark.parametrize(
    "args, words",
    [
        ((), "hold no channels"),
        (("--channel", "palm_w"), "did you mean palm_"),
        (("--range", "1", "1", "--channel", "palm_x_m"), "two different finite numbers"),
        (("--range", "0", "1", "--channel", "palm_x_m", "--speed", "0"), "speed 0;"),
        (("--range", "0", "1", "--channel", "palm_x_m", "--smoothing", "-1"), "smoothing -1;"),
        (
            ("--range", "0", "1", "--channel", "palm_x_m", "--task", "cube-rise"),
            "did you mean cube-raise",
        ),
        (("--range", "0", "1", "--channel", "palm_x_m", "--object", "cubb"), "did you mean cube"),
        (("--video", "p.avi"), "suffix '.avi'"),
    ],
)
def test_what_is_refused(refused, tmp_path, args, words) -> None:
    """With the built-in controller, whose recordings have no channels."""
    assert words in refused("--signal", ONE, "-o", tmp_path / "p.csv", *args)


def test_signals_that_tell_nothing(refused, pillow, tmp_path) -> None:
    said = refused(pillow, "--signal", ONE, "--channel", "palm_qw", "-o", tmp_path / "p.csv")
    assert "says too little about progress" in said
    assert "8 recordings" in said


def test_where_it_ends_must_be_known(refused, switch, tmp_path) -> None:
    said = refused("--signal", switch, "--range", "0", "1", "-o", tmp_path / "p.csv")
    assert "--task" in said


def test_damaged_files(refused, tmp_path, switch) -> None:
    out = tmp_path / "p.csv"
    assert "no such file" in refused("--signal", tmp_path / "none.csv", "-o", out)
    broken = tmp_path / "c.npz"
    shutil.copy(switch, broken)
    assert "not a readable controller" in refused(broken, "--signal", switch, "-o", out)
    (tmp_path / "b.csv").write_bytes(bytes(range(256)))
    assert "b.csv" in refused("--signal", tmp_path / "b.csv", "-o", out)
    assert "suffix" in refused("--signal", switch, "-o", tmp_path / "p.txt")
    gaps = tmp_path / "g.csv"
    gaps.write_text("time_s,value\n" + "".join(f"{i},\n" for i in range(20)))
    said = refused("--signal", gaps, "--range", "0", "1", "--task", "cube-raise", "-o", out)
    assert "no value in 20 frames" in said
