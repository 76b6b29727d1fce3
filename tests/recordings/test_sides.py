"""Left hands in the signs of a right hand's glove are recognised and turned."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from handsim import data_folder
from handsim.joints import JOINT_INDEX, N_JOINTS
from handsim.recordings.folder import INDEX_FILE, read_recordings, write_recordings
from handsim.recordings.recording import RecordingSet
from handsim.recordings.sides import MIRRORED_JOINTS, looks_mirrored, mirrored, on_one_side
from handsim.types import HandSize

COLUMNS = [JOINT_INDEX[name] for name in MIRRORED_JOINTS]


def spread(q: np.ndarray) -> np.ndarray:
    """A posture with all abductions open by 6 deg more."""
    q = q.copy()
    q[:, COLUMNS] += np.deg2rad(6)
    return q


@pytest.fixture
def people() -> RecordingSet:
    few = read_recordings(data_folder("assets") / "experiments")[:3]
    return RecordingSet(tuple(replace(r, q=spread(r.q)) for r in few))


def test_the_mirror_turns_abductions_and_deviation_alone() -> None:
    q = np.arange(2.0 * N_JOINTS).reshape(2, N_JOINTS)
    turned = mirrored(q)
    others = [j for j in range(N_JOINTS) if j not in COLUMNS]
    assert len(COLUMNS) == 5
    np.testing.assert_array_equal(turned[:, COLUMNS], -q[:, COLUMNS])
    np.testing.assert_array_equal(turned[:, others], q[:, others])
    np.testing.assert_array_equal(mirrored(turned), q)


def test_signs_are_told_apart(people: RecordingSet) -> None:
    assert not looks_mirrored([r.q for r in people])
    assert looks_mirrored([mirrored(r.q) for r in people])


def left(people: RecordingSet, folder: Path, *, turned: bool) -> Path:
    """A folder of a left hand, its abductions in either convention."""
    hand = HandSize(0.19, 0.085, "left")
    write_recordings(
        RecordingSet(
            tuple(replace(r, hand=hand, q=mirrored(r.q) if turned else r.q) for r in people)
        ),
        folder,
    )
    return folder


@pytest.mark.parametrize("turned", [True, False])
def test_left_hands_are_read_in_one_convention(
    people: RecordingSet, tmp_path: Path, turned: bool
) -> None:
    read = read_recordings(left(people, tmp_path / "L", turned=turned))
    for before, after in zip(people, read, strict=True):
        np.testing.assert_allclose(after.q, before.q, rtol=0, atol=1e-7)
        assert after.hand.side == "left"
        assert any("turned around" in note for note in after.notes) == turned


def test_what_was_turned_is_not_turned_again(people: RecordingSet, tmp_path: Path) -> None:
    once = read_recordings(left(people, tmp_path / "L", turned=True))
    write_recordings(once, tmp_path / "again")
    twice = read_recordings(tmp_path / "again")
    np.testing.assert_allclose(twice[0].q, once[0].q, rtol=0, atol=1e-7)
    assert twice[0].notes == once[0].notes


def test_right_hands_are_left_as_they_are(people: RecordingSet, tmp_path: Path) -> None:
    odd = RecordingSet(tuple(replace(r, q=mirrored(r.q)) for r in people))
    write_recordings(odd, tmp_path / "R")
    np.testing.assert_allclose(read_recordings(tmp_path / "R")[0].q, odd[0].q, rtol=0, atol=1e-7)


@pytest.mark.parametrize(("value", "side"), [("left", "left"), ("L", "left"), ("", "right")])
def test_a_column_like_side_is_taken_for_it(
    people: RecordingSet, tmp_path: Path, value: str, side: str
) -> None:
    write_recordings(people, tmp_path / "R")
    index = tmp_path / "R" / INDEX_FILE
    header, *rows = index.read_text().splitlines()
    rows = [row.removesuffix(",right") + f",{value}" for row in rows]
    index.write_text("\n".join([header.replace("side", "handedness"), *rows]))
    read = read_recordings(tmp_path / "R")
    assert read[0].hand.side == side
    assert read[0].extra == {"handedness": value}
    assert ("side left by column handedness" in read[0].notes) == (side == "left")


def abductions(*degrees: tuple[float, float, float, float]) -> np.ndarray:
    """Ten frames of each: abductions of thumb, index, ring and little finger [deg]."""
    q = np.zeros((10 * len(degrees), N_JOINTS))
    q[:, COLUMNS[:4]] = np.deg2rad(degrees).repeat(10, axis=0)
    return q


OTHER = (-20.0, -15.0, -15.0, -15.0)
EVIDENCE: dict[str, tuple[list[np.ndarray], bool]] = {
    "all negative": ([abductions(OTHER)], True),
    "thumb hardly closed": ([abductions((-2, -20, -20, -20))], False),
    "thumb and two fingers": ([abductions((-20, -15, -15, 5))], True),
    "thumb and one finger": ([abductions((-20, -15, 5, 5))], False),
    "open at the start": ([abductions((10, 10, 10, 10), OTHER)], False),
    "another recording says otherwise": (
        [abductions(OTHER), abductions((16, 10, 10, 10))],
        False,
    ),
    "inside the ranges": ([abductions((-4, -4, -4, -4), (60, 0, 0, 0))], False),
    "outside both ways, 15 and 12.5 deg": (
        [abductions((-20, -5, -5, -5), (17.5, 0, 0, 0))],
        False,
    ),
    "outside both ways, 15 and 7.5 deg": (
        [abductions((-20, -5, -5, -5), (12.5, 0, 0, 0))],
        True,
    ),
}


@pytest.mark.parametrize("case", EVIDENCE)
def test_what_is_evidence_of_the_other_hand(case: str) -> None:
    postures, expected = EVIDENCE[case]
    assert looks_mirrored(postures) == expected


def test_each_session_is_judged_alone(people: RecordingSet) -> None:
    hand = HandSize(0.19, 0.085, "left")
    first = replace(people[0], hand=hand, session="a", q=mirrored(people[0].q))
    second = replace(people[1], hand=hand, session="b")
    one, other = on_one_side([first, second], "folder")
    np.testing.assert_array_equal(one.q, people[0].q)
    np.testing.assert_array_equal(other.q, people[1].q)
    assert "turned around" in one.notes[-1]
    assert other.notes == second.notes
