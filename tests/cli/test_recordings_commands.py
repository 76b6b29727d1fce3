"""`handsim recordings` and what other commands say of recordings that cannot be right."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from handsim import GraspController, data_folder
from handsim.recordings.folder import read_recordings, write_recordings
from handsim.recordings.recording import RecordingSet

EXPERIMENTS = data_folder("assets") / "experiments"
USER_FILES = Path(__file__).parents[3] / "shared/data/user_files"
real_files = pytest.mark.skipif(
    not USER_FILES.is_dir(), reason="the files of users are not beside the checkout"
)


@pytest.fixture
def good(tmp_path: Path) -> Path:
    write_recordings(read_recordings(EXPERIMENTS)[:4], tmp_path / "good")
    return tmp_path / "good"


@pytest.fixture
def radians(good: Path, tmp_path: Path) -> Path:
    few = [replace(r, q=np.deg2rad(r.q)) for r in read_recordings(good)]
    write_recordings(RecordingSet(tuple(few)), tmp_path / "radians")
    return tmp_path / "radians"


def test_every_command_that_reads_recordings_stops(run, radians, tmp_path):
    controller = data_folder("assets") / "controller.npz"
    for command in (
        ("learn", radians, "-o", tmp_path / "c.npz"),
        ("evaluate", controller, radians),
        ("figures", controller, radians, "-o", tmp_path / "figures"),
        ("report", controller, radians, "-o", tmp_path / "r.html", "--tasks", "none"),
    ):
        result = run(*command)
        assert result.code == 2
        assert "are these radians" in result.err and "--units rad" in result.err
        assert result.err.count("\n") == 1
    assert not (tmp_path / "c.npz").exists() and not (tmp_path / "r.html").exists()


def test_what_is_accepted_is_kept_and_need_not_be_said_again(run, radians, tmp_path):
    path = tmp_path / "c.npz"
    assert run("learn", radians, "-o", path, "--components", 1, "--accept", "radians").code == 0
    assert GraspController.load(path).accepted == ("radians",)
    assert run("evaluate", path, radians).code == 0
    refused = run("learn", radians, "-o", path, "--accept", "radian")
    assert refused.code == 2 and "did you mean radians" in refused.err


def test_info_tells_names_from_their_numbers_and_shows_no_empty_table(run, tmp_path):
    one = [each for each in read_recordings(EXPERIMENTS) if each.name == "cube-raise"]
    write_recordings(RecordingSet((replace(one[0], subject="1"),)), tmp_path / "one")
    said = run("recordings", "info", tmp_path / "one").out
    assert re.search(r"^ +subjects  1 \(1\)$", said, re.MULTILINE)
    assert re.search(r"^ +duration_s  least 1\.15, ", said, re.MULTILINE)
    assert "n_frames_out_of_range  0" in said and "joint out of range" not in said
    assert "joint out of range" in run("recordings", "info").out


def test_info_says_it_with_a_light_a_recording_and_draws(run, good, radians, tmp_path):
    said = run("recordings", "info", radians, "--plot", tmp_path / "i.png", "--json").json()
    assert {row["light"] for row in said["recordings"]} == {"red"}
    first = said["recordings"][0]
    assert set(first) >= {"name", "frames", "duration_s", "rate_hz", "side", "warnings"}
    assert set(first["warnings"][0]) >= {"kind", "joint", "value", "limit"}
    assert first["warnings"][0]["kind"] == "radians"
    assert (tmp_path / "i.png").stat().st_size > 10_000
    said = run("recordings", "info", good, "--json").json()
    assert {row["light"] for row in said["recordings"]} == {"green"}
    words = run("recordings", "info", radians).out
    assert "STOP" in words and "are these radians" in words


def test_formats_are_listed(run):
    listed = run("recordings", "formats").out
    said = run("recordings", "formats", "--json").json()["formats"]
    names = {each["name"] for each in said}
    own = {
        "handsim",
        "west-rtg",
        "table",
        "cyberglove",
        "ninapro",
        "keypoints",
        "markers",
        "adroit",
    }
    assert own <= names
    assert all(name in listed for name in names)


def test_options_without_a_use_are_refused(run, good, tmp_path):
    result = run(
        *("recordings", "import", good, "--format", "handsim", "-o", tmp_path / "x"),
        *("--rate", 100),
    )
    assert result.code == 2 and "no use for rate_hz" in result.err
    assert not (tmp_path / "x").exists()


def test_counts_are_not_taken_for_angles(run, good, tmp_path):
    words = ("--format", "handsim", "--units", "counts", "-o", tmp_path / "x")
    result = run("recordings", "import", good, *words)
    assert result.code == 2 and "give counts of a glove to format table" in result.err
    assert not (tmp_path / "x").exists()


def test_radians_are_imported_as_such(run, good, radians, tmp_path):
    words = ("--format", "handsim", "--units", "rad", "-o", tmp_path / "back")
    assert run("recordings", "import", radians, *words).code == 0
    for before, after in zip(
        read_recordings(good), read_recordings(tmp_path / "back"), strict=True
    ):
        np.testing.assert_allclose(after.q, before.q, rtol=0, atol=2e-6)


RIGHT_ANSWERS = {
    "radians": (2, ("radians", "--units rad")),
    "time-in-ms": (2, ("1200 s", "milliseconds")),
    "raw-counts": (2, ("raw counts", "calibrat")),
    "return-to-rest": (2, ("same posture", "recordings cut")),
    "semicolon-comma": (0, ("semicolon", "decimal commas")),
    "tab": (0, ("tab",)),
    "unit-row": (0, ()),
    "comment-header": (0, ()),
    "blank-lines": (2, ("row 63", "thumb_ip_deg")),
    "index-extra-column": (0, ("handedness",)),
    "eighteen-sensors": (0, ("index_dip", "0.67")),
    "left-hand": (0, ("spreading is positive", "--side left")),
    "nan-gap": (2, ("row 41", "index_mcp_deg", "--bridge")),
}


@real_files
@pytest.mark.real_data
@pytest.mark.parametrize("kind", RIGHT_ANSWERS)
def test_files_of_users_get_the_right_answer(run, kind, tmp_path):
    code, words = RIGHT_ANSWERS[kind]
    output = tmp_path / "c.npz"
    result = run("learn", USER_FILES / kind, "-o", output, "--components", 1)
    assert result.code == code
    for word in words:
        assert word in result.err
    assert output.exists() == (code == 0)


@real_files
@pytest.mark.real_data
def test_a_left_hand_is_played_on_the_right_side(run, tmp_path):
    words = ("--format", "handsim", "--side", "left", "-o", tmp_path / "left")
    assert "turned around" in run("recordings", "import", USER_FILES / "left-hand", *words).err
    said = run("recordings", "info", tmp_path / "left", "--json").json()
    assert {row["side"] for row in said["recordings"]} == {"left"}
    learned = run("learn", tmp_path / "left", "-o", tmp_path / "c.npz", "--components", 1)
    assert "2 of 2 recordings of a left hand, taken as its mirror image" in learned.err
    assert {row["light"] for row in said["recordings"]} == {"green"}
    as_given, mirrored = (
        read_recordings(folder) for folder in (USER_FILES / "left-hand", tmp_path / "left")
    )
    assert (as_given[0].q[:, 3] < 0).all() and (mirrored[0].q[:, 3] > 0).all()
