from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.optimize import minimize

from handsim.errors import UnknownNameError
from handsim.hand.mjcf import PASSING_PAIRS, build_hand
from handsim.hand.model import HandModel
from handsim.hand.population import PRESETS
from handsim.hand.postures import POSTURES, posture
from handsim.joints import FINGERS, JOINT_INDEX, JOINTS, LOWER, UPPER


@pytest.fixture(scope="module")
def hand() -> HandModel:
    return HandModel.from_spec(build_hand())


def deepest(hand: HandModel) -> float:
    """Deepest penetration in the present state [m], 0 if nothing touches."""
    return -min((contact.dist for contact in hand.data.contact), default=0.0)


def gap(hand: HandModel, first: str, second: str) -> float:
    """Distance between two ellipsoids [m], negative if they overlap."""
    ids = [hand.model.geom(f"{name}_geom").id for name in (first, second)]
    return mujoco.mj_geomDistance(hand.model, hand.data, *ids, 0.1, None)


def test_postures_are_within_the_ranges_of_motion():
    assert set(POSTURES) >= {"flat", "rest", "fist", "pinch", "tripod"}
    for q in POSTURES.values():
        assert q.shape == (22,)
        assert np.all((q >= LOWER) & (q <= UPPER))


def test_postures_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        posture("rest")[0] = 1.0


def test_unknown_posture_offers_the_nearest():
    with pytest.raises(UnknownNameError, match="pinch"):
        posture("pinsh")


def bring_together(hand: HandModel, finger: str, cost: Callable[[], float]) -> None:
    """Move thumb, finger and palm arch to a posture of small cost."""
    free = [i for i, joint in enumerate(JOINTS) if joint.finger in ("thumb", finger)]
    free.append(JOINT_INDEX["palm_arch"])
    start = np.zeros(22)
    for name in ("rotation", "abduction", "mcp", "ip"):
        start[JOINT_INDEX[f"thumb_{name}"]] = {"rotation": 1.5}.get(name, 0.35)
    for name in ("mcp", "pip", "dip"):
        start[JOINT_INDEX[f"{finger}_{name}"]] = {"dip": 0.4}.get(name, 0.85)

    def of(x: np.ndarray) -> float:
        q = start.copy()
        q[free] = x
        hand.set_posture(q)
        return cost()

    bounds = list(zip(LOWER[free], UPPER[free], strict=True))
    of(minimize(of, start[free], bounds=bounds, method="L-BFGS-B").x)


@pytest.mark.parametrize("finger", FINGERS[1:])
def test_thumb_reaches_every_fingertip(hand, finger):
    """Within 8 mm, which is less than a fingertip's breadth, and without crossing it."""
    number = FINGERS.index(finger)

    def distance() -> float:
        return float(np.linalg.norm(hand.fingertips()[0] - hand.fingertips()[number]))

    def cost() -> float:
        touching = gap(hand, "thumb_distal", f"{finger}_distal")
        return (max(0.0, distance() - 0.007) / 1e-3) ** 2 + (touching / 1e-3) ** 2

    bring_together(hand, finger, cost)
    assert distance() < 0.008
    assert deepest(hand) < 0.002


@pytest.mark.parametrize("finger", FINGERS[1:])
def test_pad_of_the_thumb_faces_every_fingers_pad(hand, finger):
    number = FINGERS.index(finger)

    def measure() -> tuple[float, float]:
        pads, normals = hand.pads()
        return float(np.linalg.norm(pads[0] - pads[number])), float(normals[0] @ normals[number])

    def cost() -> float:
        meet, along = measure()
        return (meet / 2e-3) ** 2 + 5 * (1 + along)

    bring_together(hand, finger, cost)
    meet, along = measure()
    assert meet < 0.002
    assert along < -np.cos(np.deg2rad(45))


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("side", ("right", "left"))
def test_named_postures_do_not_cross_themselves(preset, side):
    hand = HandModel.from_spec(build_hand(replace(PRESETS[preset], side=side)))
    for q in POSTURES.values():
        hand.set_posture(q)
        assert deepest(hand) < 0.002


def test_only_what_would_meet_in_the_named_postures_may_pass_through():
    spec = build_hand()
    for exclude in spec.excludes:
        spec.delete(exclude)
    hand, met = HandModel.from_spec(spec), set()
    for q in POSTURES.values():
        hand.set_posture(q)
        for contact in hand.data.contact:
            bodies = hand.model.geom_bodyid[contact.geom]
            met.add(frozenset(hand.model.body(body).name for body in bodies))
    assert len(PASSING_PAIRS) == 6
    assert met >= {frozenset(pair) for pair in PASSING_PAIRS}


def test_pinch_tripod_and_fist_are_what_they_are_called(hand):
    hand.set_posture(POSTURES["pinch"])
    assert abs(gap(hand, "thumb_distal", "index_distal")) < 0.002
    assert gap(hand, "thumb_distal", "middle_distal") > 0.01
    hand.set_posture(POSTURES["tripod"])
    for finger in ("index", "middle"):
        assert abs(gap(hand, "thumb_distal", f"{finger}_distal")) < 0.002
    hand.set_posture(POSTURES["fist"])
    assert np.all(hand.fingertips()[1:, 0] < 0.35 * 0.1933), "fingertips back at the palm"
    assert abs(gap(hand, "thumb_distal", "middle_middle")) < 0.002
