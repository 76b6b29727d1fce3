"""Things that hold arrays can be compared and hashed: by content, or as themselves alone."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import trimesh

from handsim import data_folder, object_from_mesh, read_postures, read_recordings, read_rollout
from handsim.content import ByContent
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.objects.mjcf import read_mesh
from handsim.viewing.film.posture_clips import posture_clip

KEPT = Path(__file__).parent / "data" / "schemas"
EXPERIMENTS = data_folder("assets") / "experiments"


@dataclass(frozen=True, eq=False)
class Thing(ByContent):
    name: str
    values: np.ndarray
    more: dict[str, str]


@dataclass(frozen=True, eq=False)
class Other(Thing):
    pass


def thing(values: object, name: str = "a", **more: str) -> Thing:
    return Thing(name, np.array(values), more)


@pytest.mark.parametrize(
    ("one", "same"),
    [
        (thing([1.0, 2.0]), thing([1.0, 2.0])),
        (thing([1, 2]), thing([1.0, 2.0])),
        (thing([0.0]), thing([-0.0])),
        (thing([np.nan, np.inf]), thing([np.nan, np.inf])),
        (thing([], x="1", y="2"), thing([], y="2", x="1")),
        (thing([True]), thing([True])),
    ],
)
def test_equal_things_have_equal_hashes(one, same):
    assert one == same
    assert hash(one) == hash(same)
    assert {one: 1}[same] == 1


@pytest.mark.parametrize(
    "other",
    [
        thing([1.0, 2.0 + 1e-15]),
        thing([1.0]),
        thing([[1.0, 2.0]]),
        thing([1.0, 2.0], "b"),
        thing([1.0, 2.0], x="1"),
        Other("a", np.array([1.0, 2.0]), {}),
        None,
    ],
)
def test_what_differs_in_anything_is_not_equal(other):
    assert thing([1.0, 2.0]) != other


def imported(folder: Path, side: float) -> object:
    trimesh.creation.box((side, 0.05, 0.05)).export(folder / "box.stl")
    return object_from_mesh(folder / "box.stl", 0.1)


def test_what_is_read_twice_is_the_same(tmp_path):
    path = next(KEPT.glob("rollout-*.npz"))
    for made in (
        lambda: read_rollout(path),
        lambda: read_recordings(EXPERIMENTS)[:2],
        lambda: read_mesh("cube"),
        lambda: imported(tmp_path, 0.05),
    ):
        one, same = made(), made()
        assert one is not same
        assert one == same
        assert hash(one) == hash(same)
    assert imported(tmp_path, 0.05) != imported(tmp_path, 0.06)


def test_what_is_simulated_is_itself_alone():
    hands = [HandModel.from_spec(build_hand()) for _ in range(2)]
    clips = [posture_clip(*read_postures(EXPERIMENTS / "cube-raise.csv")) for _ in range(2)]
    for one, other in (hands, clips):
        assert one != other
        assert len({one, other}) == 2
