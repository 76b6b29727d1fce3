"""The record of a run, and what the judge is given."""

from types import SimpleNamespace

import numpy as np
import pytest

from handsim.grasping.conditions import Conditions
from handsim.grasping.gripping.need import contacts_at, least_grip
from handsim.grasping.plan import Schedule
from handsim.grasping.rollout import record as record_module
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.glove import DataGlove
from handsim.grasping.rollout.record import read_by, record_of
from handsim.tasks.rules import Outcome
from handsim.tasks.table_one import task_by_name

from .in_hand import pushed_into

N = 8
SCHEDULE = Schedule(steps=(0.02,), hold=0.01, reach=0.02, squeeze=0.02)
OUTCOME = Outcome(True, None, 0.1, 0.0, 0.0, 3.0, 4, 0.0, 1.0)
TIMES = np.arange(12) / 100


class Driver:
    name = "made-up"
    destination = np.zeros(22)

    def __init__(self):
        self.asked = []

    def coordinates(self, readings):
        return readings[:, :1]

    def arrived(self, reading):
        self.asked.append(reading)
        return "arrived"


def scene(task, hinges=()):
    joints = {name: SimpleNamespace(qposadr=np.array([index])) for name, index in hinges}
    hand = SimpleNamespace(
        qpos_index=np.arange(22), model=SimpleNamespace(joint=joints.__getitem__)
    )
    return SimpleNamespace(
        task=task,
        hand=hand,
        model=hand.model,
        front=np.array([0.1, 0.0, 0.02]),
        object=task.object,
        xml="<mujoco/>",
        conditions=Conditions(seed=4),
    )


def samples(**changed):
    """Eight samples in which everything differs from sample to sample."""
    row = np.arange(N, dtype=float)
    quat = np.tile([0.5, 0.5, 0.5, 0.5], (N, 1))
    axes = np.tile([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]], (N, 1, 1))  # x, y and z of the object
    made = {
        "qpos": np.outer(row, np.arange(24)) * 1e-3,
        "qvel": np.ones((N, 23)),
        "ctrl": np.ones((N, 22)),
        "mocap_pos": np.ones((N, 3)),
        "mocap_quat": quat.copy(),
        "contact_force": np.outer(row > 2, [1.0, 0.5, 0.0, 0.0, 0.0, 1e-9]),
        "press": np.multiply.outer(row, np.arange(18.0).reshape(6, 3)),
        "penetration": row * 1e-4,
        "table_force": row * 0.3,
        "pressed": np.column_stack([row, 2 * row]),
        "object_pos": np.outer(row, [1.0, 2.0, 3.0]),
        "object_quat": quat.copy(),
        "object_origin": np.outer(row, [1.0, 0.0, 0.0]),
        "object_x": axes[:, 0],
        "object_y": axes[:, 1],
        "object_z": axes[:, 2],
        "palm_pos": np.outer(row, [4.0, 5.0, 6.0]),
        "palm_quat": -quat,
    }
    return made | changed


@pytest.fixture
def look(monkeypatch):
    """What the judge is given, the record and the driver."""

    def look(
        task="pen-write",
        hinges=(),
        arrival=3,
        unstable=False,
        disturbance=0.0,
        reach=None,
        **changed,
    ):
        given = []
        monkeypatch.setattr(record_module, "judge", lambda *args: given.append(args) or OUTCOME)
        monkeypatch.setattr(record_module, "_need", lambda *args: 1.75)
        commands = SimpleNamespace(
            schedule=SCHEDULE,
            times=TIMES,
            arrival=arrival,
            disturbance=np.full((12, 22), disturbance),
            reach=reach,
        )
        driver, place = Driver(), scene(task_by_name(task), hinges)
        made = samples(**changed)
        q = made["qpos"][:, place.hand.qpos_index]
        reading, arrived = read_by(DataGlove(), commands, driver, q)
        record = record_of(
            place, commands, driver, made, reading=reading, arrived=arrived, unstable=unstable
        )
        ((traces, judged_task),) = given
        assert judged_task is place.task
        return traces, record, driver

    return look


def test_the_judge_sees_object_and_palm_as_they_were(look):
    traces, record, _ = look()
    made = samples()
    for name in (
        *("object_pos", "object_quat", "palm_pos", "palm_quat"),
        *("press", "penetration", "table_force", "pressed"),
    ):
        np.testing.assert_array_equal(getattr(traces, name), made[name])
    np.testing.assert_array_equal(traces.force, made["contact_force"])
    np.testing.assert_array_equal(traces.time, TIMES[:N])
    assert traces.action_start == pytest.approx(0.04)
    assert traces.hold_start == pytest.approx(0.06)
    assert traces.need == 1.75
    assert traces.unstable_at is None
    assert record.outcome is OUTCOME
    for name in ("penetration", "press", "table_force", "contact_force"):
        np.testing.assert_array_equal(getattr(record, name), made[name])


def test_every_part_that_presses_touches(look):
    traces, _, _ = look()
    assert traces.touching.tolist() == [False] * 3 + [True] * 5


def test_the_strain_is_the_arms_greatest(look):
    assert look()[0].strain == 0.0
    reach = SimpleNamespace(strain=np.array([0.1, 1.3, 0.2]))
    assert look(reach=reach)[0].strain == 1.3


def test_what_diverged_has_the_least_need(look):
    assert look(unstable=True)[0].need == 1.0


def needed(name, **conditions):
    """The need of a run whose samples are all of one state, at each of whose rows it accelerates.

    The hand stays in a posture in which it overlaps with the object.
    """
    made = Scene.build(task_by_name(name), Conditions(base="free", **conditions))
    for seed in range(30):
        pushed_into(made, seed)
        if made.hand.data.ncon > 6:
            break
    data, n = made.hand.data, 40
    arrays = {
        key: np.tile(getattr(data, key), (n, *(1,) * getattr(data, key).ndim))
        for key in ("qpos", "ctrl", "mocap_pos", "mocap_quat")
    }
    load = np.tile([0.0, 0.0, 9.81], (n, 1))
    commands = SimpleNamespace(
        schedule=SimpleNamespace(hold_start=0.1), row=lambda time: round(100 * time), load=load
    )
    least = least_grip(
        contacts_at(made.hand.model, data),
        data.subtree_com[made.hand.model.body("object").id],
        np.array([0.0, 0.0, 9.81]) * made.object.mass * made.conditions.mass_scale,
    )
    return made, commands, arrays, least


def test_the_need_is_that_of_the_moment_of_greatest_load_in_the_hold():
    made, commands, arrays, least = needed("hammer-use")
    assert least > 1.5
    need = record_module._need(made, commands, arrays)
    assert need == pytest.approx(least, rel=0.02)
    commands.load[:10] *= 7.0  # before the hold
    assert record_module._need(made, commands, arrays) == need
    commands.load[33] *= 3.0
    assert record_module._need(made, commands, arrays) == pytest.approx(3 * need, rel=1e-6)
    short = {name: rows[:10] for name, rows in arrays.items()}
    assert record_module._need(made, commands, short) == 1.0


def test_the_need_grows_with_the_objects_mass():
    _, _, _, usual = needed("hammer-use")
    made, commands, arrays, _ = needed("hammer-use", mass_scale=2.0)
    assert record_module._need(made, commands, arrays) == pytest.approx(2 * usual, rel=0.1)


def test_what_is_not_lifted_needs_the_least():
    made, commands, arrays, _ = needed("mouse-slide")
    commands.load[:] *= 50.0
    assert record_module._need(made, commands, arrays) == 1.0


def test_the_front_end_is_that_of_the_object(look):
    """The object's x points along the world's y, its z along the world's x."""
    traces, _, _ = look()
    expected = np.outer(np.arange(N), [1.0, 0.0, 0.0]) + [0.02, 0.1, 0.0]
    np.testing.assert_allclose(traces.front_pos, expected)


def test_symmetry_is_that_of_the_object(look):
    assert look("pen-write")[0].symmetry == "x"
    assert look("tall-glass-drink")[0].symmetry == "z"
    assert look("cube-raise")[0].symmetry is None


def test_the_hinge_is_that_of_the_rule(look):
    hinges = (("left_button", 22), ("right_button", 23))
    traces, _, _ = look("mouse-right-click", hinges)
    np.testing.assert_allclose(traces.hinge, np.arange(N) * 23e-3)
    assert not look("cube-raise")[0].hinge.any()


def test_the_driver_is_asked_at_the_end_of_the_reach_by_what_the_glove_read(look):
    traces, record, driver = look(arrival=3, disturbance=np.deg2rad(2.0))
    assert traces.arrived == "arrived"
    assert len(driver.asked) == 1
    np.testing.assert_array_equal(driver.asked[0], record.reading[3])
    expected = np.round(np.rad2deg(3e-3 * np.arange(22)) + 2.0)
    np.testing.assert_allclose(np.rad2deg(record.reading[3]), expected, atol=1e-9)
    # A run that diverged before is judged by its last sample.
    _, record, driver = look(arrival=9)
    np.testing.assert_array_equal(driver.asked[0], record.reading[N - 1])


def test_divergence_is_after_the_last_sample_and_leaves_numbers_alone(look):
    bad = np.full((N, 3), np.nan)
    traces, record, _ = look(unstable=True, object_pos=bad, qvel=np.full((N, 23), np.inf))
    assert traces.unstable_at == pytest.approx(0.07)
    assert np.isfinite(traces.object_pos).all()
    assert np.isfinite(record.qvel).all()


def test_phases_are_those_of_the_schedule(look):
    _, record, _ = look()
    phases = {phase.name: phase.start for phase in record.phases}
    expected = {"reach": 0.0, "squeeze": 0.02, "action": 0.04, "hold": 0.06}
    assert phases == pytest.approx(expected)
    assert list(phases) == list(expected)
