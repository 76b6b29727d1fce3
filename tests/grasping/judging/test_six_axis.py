"""The six-axis protocol: what is held stays, what is not falls away as it must."""

import copy
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from handsim.grasping.conditions import Conditions
from handsim.grasping.judging.six_axis import (
    ACCELERATION,
    DIRECTIONS,
    DURATION,
    MASS,
    MAX_OVERLAP,
    MAX_SHIFT,
    MAX_TURN_DEG,
    TIMESTEP,
    SixAxisOutcome,
    _protocol_model,
    six_axis,
)
from handsim.grasping.planning.demonstrator import demonstrate
from handsim.tasks.rules import Outcome
from handsim.tasks.table_one import task_by_name

FAR = (0.0, 0.3, 0.0)
"""So far from where the plan expects it that the hand does not come near the object."""


def mechanism(
    joints: str,
    hand: str = "",
    more: str = "",
    *,
    centre: str = "0 0 0",
    qpos: Any = None,
    acting: float = 0.0,
) -> Any:
    """Return a run whose object, a body of 3 kg about a centre, moves as its joints let it.

    ``qpos`` holds a state a quarter of a second; the action begins at ``acting`` [s].
    """
    model = mujoco.MjModel.from_xml_string(f"""<mujoco>
        <option gravity="0 0 -9.81" timestep="0.002"/>
        <worldbody>
          <geom name="table" type="plane" size="1 1 1" pos="0 0 -0.05"/>
          <body name="forearm" pos="0 0 0.5"><joint type="slide" axis="0 0 1" stiffness="1e4"/>
            <geom type="sphere" size="0.01" friction="0.3 0.001 0.0001"/>{hand}</body>
          <body name="object"><inertial pos="{centre}" mass="3" diaginertia="0.003 0.003 0.003"/>
            {joints}</body>
        </worldbody>{more}</mujoco>""")
    states = np.zeros((1, model.nq)) if qpos is None else np.asarray(qpos, float)
    n = len(states)
    return SimpleNamespace(
        outcome=SimpleNamespace(reason=None),
        model=lambda: model,
        time=0.25 * np.arange(n),
        qpos=states,
        ctrl=np.zeros((n, model.nu)),
        mocap_pos=np.zeros((n, model.nmocap, 3)),
        mocap_quat=np.tile([1.0, 0.0, 0.0, 0.0], (n, model.nmocap, 1)),
        phases=[
            SimpleNamespace(name="reach", start=0.0),
            SimpleNamespace(name="action", start=acting),
        ],
    )


def slides(*x: str) -> str:
    """Joints along x, y and z with the given attributes; a geom that touches nothing."""
    joints = (f'<joint type="slide" axis="{a}" {more}/>' for a, more in zip(AXES, x, strict=True))
    return "".join(joints)


AXES = ("1 0 0", "0 1 0", "0 0 1")
FORCE = 1.0
"""Of a pull: 10 m/s^2 on 100 g [N]."""


def test_the_protocol_is_that_of_dexgraspbench():
    """100 g, 10 m/s^2, six sides, 2 s in steps of 4 ms; lost from 5 cm or 15 deg on."""
    assert (MASS, ACCELERATION, DURATION, TIMESTEP) == (0.1, 10.0, 2.0, 0.004)
    assert (MAX_SHIFT, MAX_TURN_DEG, MAX_OVERLAP) == (0.05, 15.0, 0.01)
    sides = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]]
    np.testing.assert_array_equal(DIRECTIONS, sides)


def test_in_syrup_each_pull_lasts_two_seconds():
    """At a force F against a damping c the object moves F T / c."""
    dampings = (50, 100, 400)
    outcome = six_axis(mechanism(slides(*(f'damping="{c}"' for c in dampings))))
    there = FORCE * DURATION / np.array(dampings)
    np.testing.assert_allclose(outcome.shift_m, [*there, *there], rtol=0.01)
    assert outcome.turn_deg == (0.0,) * 6
    assert outcome.penetration_m == 0.0
    assert outcome.success


def test_the_shift_is_the_distance_whatever_its_direction():
    joints = '<joint type="slide" axis="1 1 0" damping="50"/>'
    along = FORCE / np.sqrt(2) * DURATION / 50
    outcome = six_axis(mechanism(joints))
    np.testing.assert_allclose(outcome.shift_m, [along, along, 0] * 2, rtol=0.01, atol=1e-9)


def test_on_a_spring_the_largest_shift_counts_not_the_last():
    """Without damping the object swings to twice where the spring balances the force."""
    run = mechanism(slides(*(f'stiffness="{k}"' for k in (50, 80, 400))))
    twice = 2 * FORCE / np.array([50, 80, 400])
    np.testing.assert_allclose(six_axis(run).shift_m, [*twice, *twice], rtol=0.01)


def test_a_pull_ends_where_the_object_is_lost():
    """A free mass: after n steps from rest x = a dt^2 n (n + 1) / 2; each pull begins at rest."""
    n = np.arange(100)
    x = ACCELERATION * TIMESTEP**2 * n * (n + 1) / 2
    outcome = six_axis(mechanism("<freejoint/>", qpos=[[0, 0, 0, 0, 1, 0, 0, 0]]))
    np.testing.assert_allclose(outcome.shift_m, x[x >= 0.05][0], rtol=1e-6)
    assert outcome.reason == "slipped"


def test_one_joint_that_diverges_is_enough():
    """A spring far too stiff for the time step throws the object off at 4 km/s along y."""
    joints = slides('damping="100"', 'stiffness="1e7"', 'damping="100"')
    outcome = six_axis(mechanism(joints, qpos=[[0.0, 0.0, 0.01, 0.0]]))
    assert outcome.reason == "unstable"
    assert outcome.shift_m == outcome.turn_deg == (np.inf,) * 6


def test_the_turn_is_in_degrees_and_the_smaller_of_the_two_ways_round():
    """A pendulum with its mass at 45 deg: pulled at, it swings to the other side of the force.

    That is 90 deg for pulls at 45 deg, and 270 deg for those at 135 deg, which passes half a turn.
    The object's frame lies in the hinge, so that it does not shift.
    """
    outcome = six_axis(mechanism('<joint type="hinge" axis="0 0 1"/>', centre="0.01 0.01 0"))
    np.testing.assert_allclose(outcome.turn_deg, [90, 90, 0, 180, 180, 0], atol=0.5)
    np.testing.assert_allclose(outcome.shift_m, 0.0, atol=1e-12)
    assert outcome.reason == "tilted"


@pytest.mark.parametrize(("acting", "row"), [(0.5, 2), (0.45, 2), (0.55, 3), (9.0, 3)])
def test_the_pulls_begin_with_the_first_sample_of_the_action(acting, row):
    """On damped springs, away from where they rest: from x to F / k along the pull."""
    x = np.array([0.0, 0.008, 0.016, 0.024])[:, None] * [1.0, -0.8, 0.7]
    joints = slides(*('stiffness="100" damping="10"',) * 3)
    outcome = six_axis(mechanism(joints, qpos=np.column_stack([0 * x[:, 0], x]), acting=acting))
    expected = np.linalg.norm(FORCE / 100 * DIRECTIONS - x[row], axis=1)
    np.testing.assert_allclose(outcome.shift_m, expected, rtol=1e-3)


def test_the_deepest_overlap_of_the_object_in_any_pull_counts():
    """A ball pushed along +x into two soft walls of the hand, one behind the other, sinks in.

    Two parts of the hand that overlap by 3 cm each other, and the table, are not the object's.
    """
    soft = 'solref="-100 -2" solimp="0.5 0.5 0.001"'
    stiff = '<joint type="slide" axis="1 0 0" stiffness="1e4" damping="20"/>'
    walls = f"""<body pos="0.03 0 -0.5"><geom type="box" size="0.01 0.05 0.05" {soft}/></body>
        <body pos="0.031 0 -0.5"><geom type="box" size="0.01 0.05 0.05" {soft}/></body>
        <body pos="0 0 0.4">{stiff}<geom type="sphere" size="0.03" {soft}/></body>
        <body pos="0.03 0 0.4">{stiff}<geom type="sphere" size="0.03" {soft}/></body>"""
    ball = f'<geom type="sphere" size="0.02" {soft}/>'
    held = (f'stiffness="{k}" damping="1"' for k in (100, 400, 400))
    outcome = six_axis(mechanism(slides(*held) + ball, walls))
    assert 0.01 < outcome.shift_m[3] < 0.02  # away from the walls: swings beyond F / k
    assert 0.002 < outcome.shift_m[0] < 0.0095
    assert outcome.penetration_m == pytest.approx(outcome.shift_m[0], rel=0.01)


def test_the_scene_of_the_protocol():
    """Gravity and table vanish, what leads the hand stays; masses and friction are set."""
    parts = """<freejoint/><geom type="box" size="0.02 0.03 0.04" friction="0.4 0.003 0.0002"/>
        <body name="lid" pos="0 0 0.05"><joint type="hinge" axis="0 0 1"/>
        <inertial pos="0 0 0" mass="1" diaginertia="0.001 0.002 0.002"/></body>"""
    welds = """<equality><weld name="forearm_led" body1="forearm"/></equality>"""
    finger = '<body pos="0 0 0.1"><geom name="finger" type="sphere" size="0.01"/></body>'
    run: Any = mechanism(parts, finger, welds)
    before = copy.copy(run.model())
    model = _protocol_model(run, hard=False)
    grasp_object, lid = model.body("object").id, model.body("lid").id
    np.testing.assert_allclose(model.body_mass[[grasp_object, lid]], [0.075, 0.025])
    for body in (grasp_object, lid):
        np.testing.assert_allclose(model.body_inertia[body], before.body_inertia[body] / 40)
    assert model.body_subtreemass[grasp_object] == pytest.approx(MASS)
    forearm = model.body("forearm").id
    assert model.body_mass[forearm] == before.body_mass[forearm]
    table = model.geom("table")
    assert (table.contype[0], table.conaffinity[0]) == (0, 0)
    of_hand = model.body_rootid[model.geom_bodyid] == forearm
    assert of_hand.sum() == 2
    np.testing.assert_allclose(model.geom_friction[of_hand, :2], [[0.6, 0.02]] * 2)
    np.testing.assert_allclose(model.geom_friction[of_hand, 2], before.geom_friction[of_hand, 2])
    np.testing.assert_allclose(model.geom_friction[~of_hand], before.geom_friction[~of_hand])
    assert model.eq_active0[model.equality("forearm_led").id]
    np.testing.assert_array_equal(model.opt.gravity, 0.0)
    assert model.opt.timestep == 0.004
    assert model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_AUTORESET


@pytest.fixture(scope="module")
def cube():
    return demonstrate(task_by_name("cube-raise"), Conditions())


def test_a_cube_in_the_hand_stays_there(cube):
    for hard in (False, True):
        outcome = six_axis(cube, hard=hard)
        assert outcome.success
        assert len(outcome.shift_m) == len(outcome.turn_deg) == 6
        assert 0 < max(outcome.shift_m) < 0.02
    # Contacts that creep let more happen.
    assert max(six_axis(cube, hard=True).shift_m) > max(six_axis(cube).shift_m)


@pytest.mark.parametrize("name", ["cube-raise", "jar-unscrew"])
def test_what_nothing_holds_falls_away_as_a_free_mass_does(name):
    outcome = six_axis(demonstrate(task_by_name(name), Conditions(object_offset=FAR)))
    assert outcome.reason == "slipped"
    # From rest, x after n steps is a dt^2 n (n + 1) / 2; the pull ends beyond 5 cm.
    n = np.arange(100)
    x = ACCELERATION * TIMESTEP**2 * n * (n + 1) / 2
    np.testing.assert_allclose(outcome.shift_m, x[x >= 0.05][0], rtol=0.02)
    assert max(outcome.turn_deg) < 1 if name == "cube-raise" else True


def test_the_object_weighs_what_the_protocol_says(cube):
    model = _protocol_model(cube, hard=False)
    assert model.body_subtreemass[model.body("object").id] == pytest.approx(MASS)
    np.testing.assert_array_equal(model.opt.gravity, 0.0)
    hand = model.geom("index_distal_geom")
    np.testing.assert_allclose(hand.friction[:2], (0.6, 0.02))
    assert model.geom("table").contype == 0
    assert (model.opt.impratio, model.opt.noslip_iterations) == (10.0, 2)
    hard = _protocol_model(cube, hard=True)
    assert (hard.opt.impratio, hard.opt.noslip_iterations) == (1.0, 0)


def test_the_worst_of_the_six_decides():
    kept = SixAxisOutcome((0.01,) * 6, (3.0,) * 6, 0.001)
    assert kept.success
    assert kept.reason is None
    assert replace(kept, shift_m=(0.01,) * 5 + (0.05,)).reason == "slipped"
    assert replace(kept, turn_deg=(15.0,) + (3.0,) * 5).reason == "tilted"
    assert replace(kept, penetration_m=0.0101).reason == "penetrated"
    assert replace(kept, penetration_m=0.01, shift_m=(0.0499,) * 6, turn_deg=(14.9,) * 6).success
    assert replace(kept, penetration_m=0.0101, shift_m=(0.05,) * 6).reason == "penetrated"
    assert replace(kept, shift_m=(0.05,) * 6, turn_deg=(15.0,) * 6).reason == "slipped"
    assert replace(kept, shift_m=(0.01,) * 5 + (np.inf,)).reason == "unstable"


def test_a_run_that_diverged_holds_nothing(cube, tmp_path, monkeypatch, capfd):
    unstable = Outcome(False, "unstable", 0.0, 0.0, 0.0, 0.0, 0, 0.0)
    assert six_axis(replace(cube, outcome=unstable)).reason == "unstable"
    monkeypatch.chdir(tmp_path)
    broken = cube.qpos.copy()
    broken[:, -1] = np.nan
    assert six_axis(replace(cube, qpos=broken)).reason == "unstable"
    assert capfd.readouterr() == ("", "")
    assert not list(tmp_path.iterdir())  # MuJoCo's log
