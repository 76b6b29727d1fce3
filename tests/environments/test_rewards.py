"""The parts of the dense reward are what its description says."""

from math import exp

import pytest

pytest.importorskip("gymnasium", reason="comes with handsim[gym]")

from handsim.environments.observing import Felt
from handsim.environments.rewards import NEAR, DenseReward
from handsim.joints import CONTACT_PARTS, FINGERS
from handsim.tasks.grip_rules import LEAST_PRESS, MAX_MARGIN
from handsim.tasks.table_one import task_by_name

FAR = dict.fromkeys(FINGERS, 1.0)
NEED = 2.0
Pressed = dict[str, tuple[float, float, float]]


def parts(task: str, pressed: Pressed, away: dict[str, float] | None = None) -> dict[str, float]:
    """The parts where some parts of the hand press with forces [N], and fingers are away [m]."""
    press = [pressed.get(part, (0.0, 0.0, 0.0)) for part in CONTACT_PARTS]
    force = [sum(x * x for x in each) ** 0.5 for each in press]
    distances = FAR | (away or {})
    felt = Felt(force, press, [distances[finger] for finger in FINGERS])
    return DenseReward(task_by_name(task), NEED).parts(felt)


def test_nothing_far_away_is_worth_little():
    found = parts("pen-write", {})
    assert found.pop("distance") == pytest.approx(exp(-1.0 / NEAR))
    assert found == {"contact": 0.0, "opposition": 0.0, "margin": 0.0}


def test_distance_is_the_mean_of_the_fingers_that_grasp():
    near = {"thumb": 0.0, "index": 0.03, "middle": 0.06, "ring": 9.0}
    assert parts("pen-write", {}, near)["distance"] == pytest.approx(exp(-0.03 / NEAR))
    for finger in ("thumb", "index", "middle"):
        closer = parts("pen-write", {}, near | {finger: near[finger] + 0.03})
        assert closer["distance"] == pytest.approx(exp(-0.04 / NEAR))


def test_contact_counts_the_fingers_that_grasp_and_press():
    just, less = (0.0, LEAST_PRESS, 0.0), (0.0, 0.9 * LEAST_PRESS, 0.0)
    assert parts("pen-write", {"thumb": just, "index": less})["contact"] == pytest.approx(1 / 3)
    others: Pressed = {"ring": just, "palm": just}
    assert parts("pen-write", {"thumb": just, "index": just, **others})["contact"] == (
        pytest.approx(2 / 3)
    )


@pytest.mark.parametrize(
    ("pressed", "opposition"),
    [
        ({"thumb": (3.0, 4.0, 0.0), "index": (-3.0, -4.0, 0.0)}, 1.0),
        ({"thumb": (0.0, 3.0, 4.0), "index": (0.0, 0.0, -2.0), "ring": (0.0, -1.5, 0.0)}, 1.0),
        ({"thumb": (3.0, 0.0, 0.0), "palm": (-3.0, 4.0, 0.0)}, 0.6),
        ({"thumb": (0.0, 0.0, 5.0), "little": (0.0, 3.0, -4.0)}, 0.8),
        ({"thumb": (3.0, 0.0, 0.0), "index": (3.0, 0.0, 0.0)}, 0.0),  # the same way
        ({"thumb": (0.1, 0.0, 0.0), "index": (-3.0, 0.0, 0.0)}, 0.0),  # hardly touching
        ({"thumb": (3.0, 0.0, 0.0), "index": (-0.1, 0.0, 0.0)}, 0.0),
        ({"thumb": (3.0, 0.0, 0.0)}, 0.0),
    ],
)
def test_opposition_is_the_cosine_against_the_thumb(pressed, opposition):
    assert parts("pen-write", pressed)["opposition"] == pytest.approx(opposition)


def test_a_finger_that_works_is_no_side_of_the_grip():
    """The index clicks the mouse, which ring and little finger hold."""
    pressed: Pressed = {"thumb": (3.0, 0.0, 0.0), "index": (0.0, -9.0, 0.0)}
    held: Pressed = pressed | {"ring": (-3.0, 0.0, 0.0)}
    assert parts("mouse-left-click", held)["opposition"] == pytest.approx(1.0)
    assert parts("mouse-left-click", pressed)["opposition"] == 0.0
    assert parts("pen-write", held)["opposition"] < 0.5


@pytest.mark.parametrize(
    ("task", "share", "margin"),
    [
        ("pen-write", 0.5, 0.5),
        ("pen-write", 1.0, 1.0),
        ("pen-write", 0.5 * MAX_MARGIN, 1.0),
        ("pen-write", MAX_MARGIN, 1.0),
        ("pen-write", 2.0 * MAX_MARGIN, 0.5),
        ("mouse-slide", 2.0 * MAX_MARGIN, 1.0),  # not lifted: pressed as hard as one likes
    ],
)
def test_the_margin_is_of_the_greatest_force_beside_the_need(task, share, margin):
    pressed: Pressed = {"thumb": (0.0, 0.0, share * NEED), "index": (0.0, 0.0, 0.4 * share * NEED)}
    assert parts(task, pressed)["margin"] == pytest.approx(margin)
