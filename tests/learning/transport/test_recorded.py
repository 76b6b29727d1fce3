"""A transport is learned from recordings in which the palm was seen."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.errors import InputError
from handsim.files import data_folder
from handsim.hand.anthropometry import HandGeometry
from handsim.joints import N_JOINTS
from handsim.learning.transport.recorded import LEAST_WAY, recorded_transport
from handsim.recordings.folder import read_recordings
from handsim.recordings.points.channels import PALM_CENTRE, pose_channels
from handsim.recordings.points.palm_path import has_palm, wrist_path
from handsim.recordings.recording import Recording
from handsim.types import HandSize

N = 60
TURN = Rotation.from_euler("xyz", [0.3, -0.5, 1.0])
_MIRROR = np.array([1.0, -1.0, 1.0])


def reach(name: str, way: np.ndarray, side: str = "right") -> Recording:
    """A recording of a palm whose wrist goes a way (n, 3)."""
    hand = HandSize(0.19, 0.085, side)
    middle = PALM_CENTRE * HandGeometry(hand).mcp("middle")
    channels = pose_channels("palm", np.tile(TURN.as_matrix(), (N, 1, 1)), way + TURN.apply(middle))
    return Recording(
        name,
        np.arange(N) / 50,
        np.zeros((N, N_JOINTS)),
        1,
        "me",
        "cup",
        "cup-drink",
        hand,
        channels=channels,
    )


def way(seed: int) -> np.ndarray:
    """A reach of some 30 cm that bends to its left and upwards."""
    s, rng = np.linspace(0.0, 1.0, N)[:, None], np.random.default_rng(seed)
    bump = np.sin(np.pi * s) * [0.0, 0.05, 0.03]
    return rng.normal(scale=0.01, size=3) + s * [0.3, 0.0, -0.1] + bump


def bend_to_the_left(transport) -> float:
    made = transport.reach(np.zeros(3), np.array([0.3, 0.0, -0.1]))
    middle = made.path.points[len(made.path.points) // 2]
    return float(middle[1])


def test_the_way_is_that_of_the_wrist() -> None:
    path = way(0)
    found, quat = wrist_path(reach("a", path))
    np.testing.assert_allclose(found, path, atol=1e-12)
    np.testing.assert_allclose(Rotation.from_quat(quat, scalar_first=True).as_matrix()[3],
                               TURN.as_matrix(), atol=1e-12)  # fmt: skip


def test_where_the_palm_was_not_seen_there_is_no_way() -> None:
    seen = reach("a", way(0))
    lost = {name: np.where(np.arange(N) == 7, np.nan, x) for name, x in seen.channels.items()}
    found, _ = wrist_path(replace(seen, channels=lost))
    assert np.flatnonzero(np.isnan(found).any(axis=1)).tolist() == [7]
    without = replace(seen, channels={"palm_x_m": np.zeros(N)})
    assert has_palm(seen) and not has_palm(without)
    with pytest.raises(InputError, match="recording 'a' has no pose of the palm"):
        wrist_path(without)


def test_left_hands_count_as_their_mirror_images_and_move_so() -> None:
    right = [reach(f"r{i}", way(i)) for i in range(3)]
    left = [reach(f"l{i}", way(3 + i) * _MIRROR, "left") for i in range(3)]
    transport = recorded_transport([*right, *left])
    assert transport.n_reaches == 6
    assert transport.certificate.certified
    bend = bend_to_the_left(transport)
    assert bend > 0.02
    assert bend_to_the_left(transport.for_side("right")) == bend
    assert bend_to_the_left(transport.for_side("left")) == pytest.approx(-bend, abs=1e-9)


def test_only_reaches_count_and_it_takes_three() -> None:
    still = reach("still", np.tile([0.1, 0.0, 0.0], (N, 1)))
    short = reach("short", way(0) * 0.5 * LEAST_WAY / 0.3)
    blind = replace(still, channels={})
    three = [reach(f"r{i}", way(i)) for i in range(3)]
    assert recorded_transport([still, short, blind, *three]).n_reaches == 3
    with pytest.raises(InputError, match=r"2 recordings .* more than 30 mm, fewer than 3; give"):
        recorded_transport([still, short, blind, *three[:2]])


def test_the_reaches_that_are_shipped_are_proved_to_arrive() -> None:
    transport = recorded_transport(read_recordings(data_folder("assets") / "people" / "pillow"))
    assert transport.n_reaches == 20
    assert transport.certificate.certified
