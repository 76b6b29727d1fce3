"""The least grip that carries a load, beside what is known in closed form."""

from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np
import pytest
from scipy.optimize import linprog

from handsim.grasping.conditions import Conditions
from handsim.grasping.gripping.need import (
    LEAST,
    HandContacts,
    _edges,
    contacts_at,
    least_grip,
    spare_state,
)
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.hand.mjcf import FRICTION
from handsim.tasks.table_one import task_by_name

from ..rollout.in_hand import pushed_into

CENTRE = np.zeros(3)
COARSE = 1 / np.cos(np.pi / 8)
"""How much too large a need comes out at most, for the edges that stand for a cone."""


def contacts(*places, friction=0.8, torsion=0.005) -> HandContacts:
    """Contacts from places (3,) and normals (3,)."""
    points, normals = (np.array([each[i] for each in places], dtype=float) for i in (0, 1))
    n = len(places)
    return HandContacts(points, normals, np.full(n, friction), np.full(n, torsion))


def pinch(left: float = 0.03, right: float = 0.03, aside: float = 0.0, **values) -> HandContacts:
    """Two sides that press against each other along y, ``aside`` of the centre along x [m]."""
    return contacts(([aside, -left, 0], [0, 1, 0]), ([aside, right, 0], [0, -1, 0]), **values)


@pytest.mark.parametrize("friction", [0.3, 0.8, 1.5])
def test_two_sides_about_the_centre_share_the_weight(friction):
    """m g / (2 friction) each."""
    assert least_grip(pinch(friction=friction), CENTRE, np.array([0, 0, 8.0])) == pytest.approx(
        8.0 / (2 * friction)
    )


def test_a_need_is_counted_as_one_newton_at_least():
    assert LEAST == 1.0
    assert least_grip(pinch(), CENTRE, np.array([0, 0, 1.5])) == 1.0
    assert least_grip(pinch(), CENTRE, np.array([0, 0, 1.7])) == pytest.approx(1.7 / 1.6)
    assert least_grip(contacts(), CENTRE, np.array([0, 0, 50.0])) == 1.0


def test_the_object_moves_with_its_contacts():
    offset = np.array([0.3, -0.2, 0.5])
    moved = pinch(aside=0.01)._replace(points=pinch(aside=0.01).points + offset)
    load = np.array([1.0, 0.5, 8.0])
    assert least_grip(moved, CENTRE + offset, load) == pytest.approx(
        least_grip(pinch(aside=0.01), CENTRE, load), rel=1e-6
    )


@pytest.mark.parametrize("right", [0.01, 0.03, 0.09])
def test_the_nearer_side_carries_more(right):
    """Without torsion each carries what balances the moment, and both press alike."""
    held = pinch(0.03, right, torsion=0.0)
    expected = 8.0 * max(0.03, right) / (0.03 + right) / 0.8
    assert least_grip(held, CENTRE, np.array([0, 0, 8.0])) == pytest.approx(expected)


@pytest.mark.parametrize("aside", [0.002, 0.01, 0.03])
@pytest.mark.parametrize("torsion", [0.005, 0.01])
def test_off_centre_torsion_withstands_the_loads_torque(aside, torsion):
    """Each side has half of force and torque within one ellipse of both."""
    exact = 0.5 * np.hypot(8.0 / 0.8, 8.0 * aside / torsion)
    need = least_grip(pinch(aside=aside, torsion=torsion), CENTRE, np.array([0, 0, 8.0]))
    assert exact * (1 - 1e-6) <= need <= exact * COARSE


def test_a_need_grows_with_the_distance_from_the_centre():
    needs = [
        least_grip(pinch(aside=aside), CENTRE, np.array([0, 0, 4.0]))
        for aside in (0.0, 0.005, 0.01, 0.02, 0.04)
    ]
    assert needs == sorted(needs)
    assert needs[-1] > 6 * needs[0]


@pytest.mark.parametrize("angle", np.deg2rad([0, 11.25, 22.5, 45, 70, 90]))
def test_weight_in_any_direction_across_the_normals(angle):
    load = 8.0 * np.array([np.cos(angle), 0.0, np.sin(angle)])
    assert 5.0 * (1 - 1e-6) <= least_grip(pinch(), CENTRE, load) <= 5.0 * COARSE


def test_an_acceleration_along_the_normals_is_carried_by_one_side():
    """It presses 3 N more than the other, which needs 5 N for its half of the weight."""
    assert least_grip(pinch(), CENTRE, np.array([0, 3.0, 8.0])) == pytest.approx((5.0 + 8.0) / 2)
    assert least_grip(pinch(), CENTRE, np.array([0, 30.0, 0.0])) == pytest.approx(15.0)


def test_what_lies_on_the_hand_needs_no_friction():
    below = contacts(([0, 0, -0.02], [0, 0, 1]), friction=0.01)
    assert least_grip(below, CENTRE, np.array([0, 0, 8.0])) == pytest.approx(4.0)


def test_what_contacts_cannot_carry_is_carried_by_nobody():
    above = contacts(([0, 0, 0.02], [0, 0, -1]))
    assert least_grip(above, CENTRE, np.array([0, 0, 8.0])) == LEAST
    # One side alone presses nothing: it would push the object away.
    one = contacts(([0, -0.03, 0], [0, 1, 0]))
    assert least_grip(one, CENTRE, np.array([0, 0, 8.0])) == LEAST


def test_a_third_contact_never_makes_it_worse():
    generator = np.random.default_rng(0)
    for _ in range(10):
        held = pinch(aside=float(generator.uniform(0, 0.02)))
        point, normal = generator.normal(size=(2, 3)) * [[0.03], [1.0]]
        more = HandContacts(
            np.vstack([held.points, point]),
            np.vstack([held.normals, normal / np.linalg.norm(normal)]),
            np.append(held.friction, 0.8),
            np.append(held.torsion, 0.005),
        )
        load = np.array([0.5, 0.0, 6.0])
        assert least_grip(more, CENTRE, load) <= least_grip(held, CENTRE, load) + 1e-6


def programmed(held: HandContacts, load: np.ndarray) -> tuple[float, float]:
    """Half the least sum of normal forces, and the load that is missing: all by `linprog`."""
    edges = _edges(held, CENTRE)
    n = edges.shape[1]
    found = linprog(
        np.append(np.ones(n), np.full(12, 1e3)),
        A_eq=np.hstack([edges, np.eye(6), -np.eye(6)]),
        b_eq=np.append(load, np.zeros(3)),
    )
    return 0.5 * float(found.x[:n].sum()), float(found.x[n:].sum())


def test_needs_are_those_of_a_linear_program():
    """Of contacts that carry the load and of others, where the least counts and where not."""
    generator, kinds = np.random.default_rng(3), []
    for i in range(240):
        n = int(generator.integers(1, 6))
        points, normals = 0.03 * generator.normal(size=(n, 3)), generator.normal(size=(n, 3))
        if i % 2:  # on two sides, as in a grip
            normals = 0.3 * normals + np.where(np.arange(n) % 2, 1.0, -1.0)[:, None] * [0, 1, 0]
            points[:, 1] = -0.03 * np.sign(normals[:, 1])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        friction, torsion = generator.uniform([0.3, 0.002], [1.2, 0.01], (n, 2)).T
        held = HandContacts(points, normals, friction, torsion)
        load = generator.normal(size=3) * generator.choice([0.3, 1.0, 2.0, 5.0])
        need, missing = programmed(held, load)
        assert least_grip(held, CENTRE, load) == pytest.approx(max(LEAST, need), rel=0, abs=1e-6)
        kinds.append((missing < 1e-6 * np.linalg.norm(load), need > LEAST))
    for kind in ((True, True), (True, False), (False, True), (False, False)):
        assert kinds.count(kind) >= 5, kind


@pytest.mark.parametrize("need", [0.97, 0.99, 0.996, 1.0, 1.004, 1.01])
def test_a_need_about_the_least_is_not_mistaken_for_less(need):
    found = least_grip(pinch(), CENTRE, np.array([0, 0, 1.6 * need]))
    assert found == pytest.approx(max(LEAST, need), rel=0, abs=1e-9)


def test_many_contacts_at_once_are_those_one_by_one():
    """Whatever direction their normals have."""
    generator = np.random.default_rng(2)
    points, normals = generator.normal(size=(2, 5, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    friction, torsion = generator.uniform(0.3, 1.0, 5), generator.uniform(0.002, 0.01, 5)
    edges = _edges(HandContacts(points, normals, friction, torsion), CENTRE)
    single = [
        _edges(HandContacts(*(each[[i]] for each in (points, normals, friction, torsion))), CENTRE)
        for i in range(5)
    ]
    np.testing.assert_allclose(edges, np.hstack(single), atol=1e-12)


def test_edges_lie_on_the_cone_that_the_simulation_has():
    """Unit normal force, friction and torsion on one ellipsoid, torque about the centre."""
    point, normal = np.array([[0.02, -0.01, 0.03]]), np.array([[0.0, 0.6, 0.8]])
    edges = _edges(HandContacts(point, normal, np.array([0.5]), np.array([0.004])), CENTRE).T
    assert len(edges) == 26
    force, torque = edges[:, :3], edges[:, 3:]
    np.testing.assert_allclose(force @ normal[0], 1.0)
    along = np.linalg.norm(force - normal, axis=1)
    own = torque - np.cross(point, force)
    about = own @ normal[0]
    np.testing.assert_allclose(own, about[:, None] * normal, atol=1e-12)
    np.testing.assert_allclose((along / 0.5) ** 2 + (about / 0.004) ** 2, 1.0)
    assert about.min() == pytest.approx(-0.004)
    assert about.max() == pytest.approx(0.004)


@pytest.mark.parametrize("base", ["arm", "free"])
def test_contacts_are_those_of_hand_and_object_in_the_model(base):
    """Normals point to the object, whichever of both MuJoCo names first."""
    scene = Scene.build(task_by_name("tall-glass-drink"), Conditions(base=base, friction=0.6))
    model, data = scene.hand.model, scene.hand.data
    for seed in range(20):
        pushed_into(scene, seed)
        if data.ncon > 4:
            break
    found = contacts_at(model, data)
    expected = []
    for contact in data.contact:
        bodies = [model.geom_bodyid[geom] for geom in contact.geom]
        of_object = [model.body_rootid[body] == model.body("object").id for body in bodies]
        if sum(of_object) != 1 or 0 in bodies:  # the table
            continue
        # MuJoCo's normals point from the first geom to the second.
        expected.append((contact.pos, contact.frame[:3] * (1 if of_object[1] else -1)))
    assert len(expected) > 2
    np.testing.assert_array_equal(found.points, [each[0] for each in expected])
    np.testing.assert_array_equal(found.normals, [each[1] for each in expected])
    np.testing.assert_allclose(found.friction, 0.6)
    np.testing.assert_allclose(found.torsion, FRICTION[1] * 0.6 / FRICTION[0])


def test_a_need_is_found_where_least_squares_give_up(monkeypatch):
    def gives_up(*_):
        raise RuntimeError("Maximum number of iterations reached.")

    monkeypatch.setattr("handsim.grasping.gripping.need.nnls", gives_up)
    for weight in (0.5, 8.0):
        need = max(LEAST, weight / (2 * 0.8))
        assert least_grip(pinch(), CENTRE, np.array([0, 0, weight])) == pytest.approx(need)


def test_a_spare_state_is_a_new_one_each_time_and_each_threads_own():
    box = "<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>"
    model, other = (mujoco.MjModel.from_xml_string(box) for _ in range(2))
    first = spare_state(model)
    first.qpos[:] = 5.0
    again = spare_state(model)
    assert again is first  # the same memory
    np.testing.assert_array_equal(again.qpos, model.qpos0)
    assert spare_state(other) is not first
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(spare_state, other).result() is not spare_state(other)
