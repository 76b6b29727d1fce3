"""A transport that was kept does what it did, and the one that is shipped is what is learned."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from handsim.errors import FileError
from handsim.files import data_folder, read_archive, write_archive
from handsim.learning.transport.recorded import recorded_transport
from handsim.learning.transport.stored import (
    KIND,
    SCHEMA,
    load_transport,
    save_transport,
    shipped_transport,
)
from handsim.learning.transport.transport import Transport
from handsim.recordings.folder import read_recordings

START, GOAL = np.array([0.1, 0.3, 0.4]), np.array([0.0, 0.0, 0.1])
SHIPPED = data_folder("assets") / "people" / "transport.npz"


@pytest.fixture(scope="module")
def learned() -> Transport:
    return recorded_transport(read_recordings(data_folder("assets") / "people" / "pillow"))


def test_what_is_kept_does_the_same_to_the_bit(learned: Transport, tmp_path) -> None:
    save_transport(learned, tmp_path / "mine.npz")
    again = load_transport(tmp_path / "mine.npz")
    assert again == learned
    assert again.certificate.certified
    assert (again.duration, again.n_reaches, again.rises) == (
        learned.duration,
        learned.n_reaches,
        learned.rises,
    )
    ways = [each.reach(START, GOAL).path.points for each in (again, learned)]
    np.testing.assert_array_equal(*ways)


def test_the_shipped_one_is_learned_from_the_shipped_reaches(learned: Transport) -> None:
    assert shipped_transport() == learned
    assert shipped_transport().n_reaches == 20


def test_it_can_be_handed_to_another_process_after_a_reach(learned: Transport) -> None:
    for each in (learned, learned.for_side("left")):
        way = each.reach(START, GOAL).path.points
        again = pickle.loads(pickle.dumps(each))
        assert again == each
        np.testing.assert_array_equal(again.reach(START, GOAL).path.points, way)


def test_that_of_a_left_hand_is_the_mirror_image(learned: Transport) -> None:
    left = shipped_transport("left")
    assert left.mirrored
    assert left != learned
    assert left.for_side("left") is left
    assert left.for_side("right") == learned
    mirror = np.array([1.0, -1.0, 1.0])
    there = left.reach(START * mirror, GOAL * mirror).path.points
    np.testing.assert_allclose(there * mirror, learned.reach(START, GOAL).path.points, atol=1e-9)


def test_what_moves_otherwise_is_another(learned: Transport) -> None:
    for other in (
        replace(learned, progress=learned.progress**2),
        replace(learned, duration=2.0),
        replace(learned, rises=(-0.1, 0.1)),
    ):
        assert other != learned
        assert hash(other) != hash(learned)
    assert learned != "transport"


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("duration", -1.0),
        ("duration", "long"),
        ("n_reaches", "many"),
        ("degree", 50),
        ("k", None),
        ("obstacle", "none"),
        ("metric_reach", 0.0),
        ("progress", np.zeros(3)),
        ("rises", np.zeros(3)),
        ("rises", np.array([0.0, np.nan])),
        ("closing_width", np.zeros(3)),
        ("coefficients", np.zeros(7)),
        ("knots_2", np.zeros(4)),
    ],
)
def test_a_damaged_file_is_refused_in_one_line(tmp_path, name, value) -> None:
    metadata, arrays = read_archive(SHIPPED, KIND, SCHEMA)
    kept = {key: each for key, each in metadata.items() if key not in ("kind", "schema")}
    (arrays if isinstance(value, np.ndarray) else kept)[name] = value
    write_archive(tmp_path / "bad.npz", KIND, SCHEMA, kept, arrays)
    with pytest.raises(
        FileError, match=r"bad\.npz: not a whole transport .*; learn it again"
    ) as said:
        load_transport(tmp_path / "bad.npz")
    assert "\n" not in str(said.value)


def test_another_kind_of_file_is_refused() -> None:
    with pytest.raises(FileError, match="not a transport"):
        load_transport(data_folder("assets") / "controller.npz")
