"""Files and folders become episodes, each with a name of its own."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from handsim.errors import FileError, InputError
from handsim.exports.episode import Quantity
from handsim.exports.export_sources import episodes_of, read_sources
from handsim.exports.task_sentences import sentence_of
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout_file import write_rollout
from handsim.recordings.folder import write_recordings
from handsim.recordings.posture_file import postures_text
from handsim.recordings.recording import RecordingSet
from handsim.tasks.table_one import TASKS


def test_a_folder_of_rollouts_is_read_in_the_order_people_count(
    with_arm: Rollout, tmp_path: Path
) -> None:
    for name in ("cube", "cube-10", "cube-2"):
        write_rollout(with_arm, tmp_path / f"{name}.npz")
    done: list[float] = []
    episodes = read_sources([tmp_path], done.append)
    assert [each.name for each in episodes] == ["cube", "cube-2", "cube-10"]
    assert done == pytest.approx([1 / 3, 2 / 3, 1])
    assert all(each.rollout == with_arm for each in episodes)


def test_all_kinds_of_sources_go_together(
    with_arm: Rollout, recordings: RecordingSet, tmp_path: Path
) -> None:
    write_rollout(with_arm, tmp_path / "one.npz")
    write_recordings(recordings, tmp_path / "folder")
    first = recordings[0]
    text = postures_text(first.time, first.q, {"force_n": first.time})
    (tmp_path / "driven.csv").write_text(text)
    episodes = read_sources([tmp_path / each for each in ("driven.csv", "folder", "one.npz")])
    kinds = ["postures", *["recording"] * len(recordings), "rollout"]
    assert [each.kind for each in episodes] == kinds
    assert episodes[0].name == "driven"
    channel = episodes[0].quantity("channel:force_n")
    assert channel is not None
    assert np.allclose(channel.values[:, 0], first.time, atol=1e-6)


def test_a_name_that_occurs_twice_gets_a_number(with_arm: Rollout, tmp_path: Path) -> None:
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        write_rollout(with_arm, tmp_path / folder / "cube.npz")
    episodes = read_sources([tmp_path / "a", tmp_path / "b"])
    assert [each.name for each in episodes] == ["cube", "cube-2"]
    again = episodes_of([*episodes, *episodes])
    assert [each.name for each in again] == ["cube", "cube-2", "cube-3", "cube-2-2"]


def test_a_name_of_a_mapping_is_no_path(with_arm: Rollout) -> None:
    (episode,) = episodes_of({"a/b": with_arm})
    assert episode.name == "a-b"


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("nowhere.npz", "no such file"),
        ("nowhere.csv", "no such file"),
        ("nowhere", "no such file"),
        ("empty", "holds neither experiments.csv nor rollouts"),
        ("notes.txt", "suffix '.txt'; give rollouts"),
    ],
)
def test_what_is_no_source_is_refused(tmp_path: Path, name: str, said: str) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "notes.txt").touch()
    with pytest.raises(FileError, match=said):
        read_sources([tmp_path / name])


def test_a_rollout_whose_model_is_of_other_sizes_is_named(
    with_arm: Rollout, tmp_path: Path
) -> None:
    write_rollout(replace(with_arm, qvel=with_arm.qvel[:, :5]), tmp_path / "bad.npz")
    with pytest.raises(FileError, match=r"bad\.npz: rollout of cube-raise: 34 positions and 5 "):
        read_sources([tmp_path / "bad.npz"])


def test_nothing_is_refused() -> None:
    with pytest.raises(InputError, match="give 1 movement or more"):
        episodes_of({})


def test_a_turn_takes_the_short_way_and_keeps_its_length() -> None:
    half = np.sqrt(0.5)
    turn = Quantity("t", ("qw", "qx", "qy", "qz"), ("",) * 4,
                    np.array([[1.0, 0, 0, 0], [-half, 0, 0, -half]]), "")  # fmt: skip
    between = turn.at(np.array([0.0, 0.5, 1.0]), np.array([0.0, 1.0]))
    assert np.allclose(np.linalg.norm(between.values, axis=1), 1.0)
    eighth = [np.cos(np.pi / 8), 0, 0, np.sin(np.pi / 8)]
    assert np.allclose(np.abs(between.values[1]), eighth)
    assert np.allclose(between.values[[0, 2]], turn.values)


def test_every_task_has_a_sentence_of_its_own() -> None:
    said = {task.name: sentence_of(task.name) for task in TASKS}
    assert len(set(said.values())) == len(TASKS)
    assert all(text.startswith("Grasp the ") and text.endswith(".") for text in said.values())
    assert said["mouse-left-click"] == "Grasp the mouse and click its left button."
    assert said["tall-glass-top-move"] == "Grasp the tall glass from the top and move it."
    assert said["cup-drink"] == "Grasp the cup and drink from it."


@pytest.mark.parametrize(
    ("task", "grasped", "said"),
    [
        ("", "", "Move the hand."),
        ("open-door", "", "Open door."),
        ("power_grip", "steel-ball", "Grasp the steel ball: power grip."),
        ("lift-bottle", "bottle", "Lift bottle."),
        ("", "bottle", "Grasp the bottle."),
    ],
)
def test_other_tasks_are_said_in_their_own_words(task: str, grasped: str, said: str) -> None:
    assert sentence_of(task, grasped) == said


def test_a_copied_folder_is_the_same(recordings: RecordingSet, tmp_path: Path) -> None:
    write_recordings(recordings, tmp_path / "a")
    shutil.copytree(tmp_path / "a", tmp_path / "b")
    a, b = (read_sources([tmp_path / name]) for name in "ab")
    assert [each.facts for each in a] == [each.facts for each in b]
