"""Readers that others wrote take a data set for one of theirs, where they are installed."""

from pathlib import Path

import numpy as np
import pytest

from handsim.exports.export_sources import episodes_of
from handsim.exports.lerobot.data_set import write_lerobot
from handsim.exports.lerobot.features import plan_of, take_of
from handsim.grasping.rollout.record import Rollout

HERE = "local/handsim"
pytestmark = pytest.mark.filterwarnings("ignore")  # theirs, about one another


@pytest.fixture(scope="module")
def filmed(with_arm: Rollout, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("lerobot") / "filmed"
    named = {"first": with_arm, "second": with_arm}
    write_lerobot(named, folder, fps=2, camera="front", size=(96, 64))
    return folder


def test_lerobot_reads_it(
    filmed: Path, with_arm: Rollout, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    reason = "lerobot is not installed; it brings PyTorch, and is in no extra"
    lerobot = pytest.importorskip("lerobot.datasets.lerobot_dataset", reason=reason)
    monkeypatch.setenv("HF_HOME", str(tmp_path))
    data = lerobot.LeRobotDataset(HERE, root=filmed, video_backend="pyav")
    (episode,) = episodes_of(with_arm)
    take = take_of(episode, plan_of([episode], 2))
    n = len(take.time)
    assert (data.fps, data.num_episodes, len(data)) == (2, 2, 2 * n)
    assert data.meta.camera_keys == ["observation.images.front"]
    for i in range(2 * n):
        item = data[i]
        assert item["task"] == "Grasp the cube and raise it."
        assert item["episode_index"].item() == i // n
        assert item["timestamp"].item() == pytest.approx((i % n) / 2)
        for feature in take.features:
            expected = feature.values[i % n]
            assert np.array_equal(item[feature.name].numpy(), np.squeeze(expected)), feature.name
        assert item["observation.images.front"].shape == (3, 64, 96)
    apart = lerobot.LeRobotDataset(HERE, root=filmed, episodes=[1], video_backend="pyav")
    assert len(apart) == n
    mean = data.meta.stats["observation.images.front"]["mean"]
    pictures = np.mean([data[i]["observation.images.front"].numpy() for i in range(2 * n)], axis=0)
    assert np.allclose(mean[:, 0, 0], pictures.mean(axis=(1, 2)), atol=0.02)


def test_rerun_reads_it(filmed: Path) -> None:
    reason = "needs rerun-sdk 0.41, which is in no extra of tests"
    readers = pytest.importorskip("rerun.experimental", reason=reason)
    if not hasattr(readers, "LeRobotReader"):
        pytest.skip(reason)
    reader = readers.LeRobotReader(filmed)
    assert reader.version == "v3"
    assert reader.episodes() == [0, 1]
    entities = {chunk.entity_path for chunk in reader.stream(1)}
    assert {"/observation.state", "/action", "/observation.images.front"} <= entities
