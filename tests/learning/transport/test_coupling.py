import numpy as np
import pytest

from handsim.errors import InputError
from handsim.learning.movement.progress import ProgressLaw, minimum_jerk
from handsim.learning.transport.coupling import WIDEST_AT, hand_law, widest_of

TRANSPORT = ProgressLaw(1.2)


@pytest.mark.parametrize("widest", [0.05, 0.3, 0.6, 0.9])
@pytest.mark.parametrize("duration", [None, 1.5])
def test_the_hand_is_widest_at_two_thirds_of_the_transport(widest, duration) -> None:
    law = hand_law(TRANSPORT, widest, duration)
    assert law.duration == (duration or 1.2)
    assert law.covered(WIDEST_AT * 1.2) == pytest.approx([widest], abs=0.02)
    covered = law.covered(np.linspace(0.0, law.duration, 200))
    assert (np.diff(covered) >= 0).all()
    assert covered[[0, -1]].tolist() == [0.0, 1.0]


def test_a_hand_that_is_open_from_the_start_waits_with_closing() -> None:
    law = hand_law(TRANSPORT, 0.0)
    assert law.covered(WIDEST_AT * 1.2)[0] < 0.05
    assert minimum_jerk(WIDEST_AT * 1.2, 1.2) > 0.7


def test_a_hand_that_never_closes_has_nothing_to_be_timed() -> None:
    assert hand_law(TRANSPORT, 1.0).curve is None


def test_the_widest_place_of_a_path() -> None:
    assert widest_of(np.array([0.05, 0.08, 0.10, 0.09, 0.04])) == 0.5


@pytest.mark.parametrize(("duration", "at"), [(None, 1.0), (None, 0.0), (0.5, 0.67)])
def test_a_moment_outside_the_movement_is_refused(duration, at) -> None:
    with pytest.raises(InputError, match="cannot be widest"):
        hand_law(TRANSPORT, 0.3, duration, at)
