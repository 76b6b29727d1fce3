"""What a hand feels of what it carries, and what hand and arm do about it, in whole runs."""

from functools import cache
from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.demonstrator import demonstrate
from handsim.grasping.rollout import forearm, jobs
from handsim.tasks.table_one import task_by_name

TASK = task_by_name("cup-side-move")
"""A cup of 225 g, lifted by 12 cm, moved by 10 cm and held for 3 s."""


@cache
def carried(mass: float, corrected: bool = True) -> SimpleNamespace:
    """A run with so many times the mass: what its grip layer was told, and its record."""
    told = []

    def command(self, *args, **named):
        _, slip, load, *_ = args
        told.append([None if each is None else float(each[0]) for each in (slip, load)])
        targets = usual(self, *args, **named)
        tighter.append(self._runs[0]._tighter)
        return targets

    def sense(self, values):
        forces, carrying = feel(self, values)
        held.append(carrying[0][:3])
        pushed.append(carrying[0][-1])
        assert held[-1] == self.held(values)[0].tolist()
        assert pushed[-1] == self.carried(values)[0]
        return forces, carrying

    usual, feel = jobs.GripLayer.command, jobs.Sensors.felt
    tighter, held, pushed = [], [], []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(jobs.GripLayer, "command", command)
        patch.setattr(jobs.Sensors, "felt", sense)
        if not corrected:
            patch.setattr(forearm, "FEELING", np.inf)
        run = demonstrate(TASK, Conditions(mass_scale=mass))
    action = next(i for i, (slip, _) in enumerate(told) if slip is not None)
    slip, load = np.array(told[action:]).T
    return SimpleNamespace(
        run=run,
        before=told[:action],
        action=action,
        held=np.array(held[action:]),
        pushed=np.array(pushed[action:]),
        slip=slip,
        load=load,
        tighter=tighter,
    )


def in_palm(run) -> np.ndarray:
    """Where the object's centre of mass is in the palm's frame at each reading, (n, 3) [m]."""
    model = run.model()
    data, places = mujoco.MjData(model), []
    for qpos in run.qpos:
        data.qpos[:] = qpos
        mujoco.mj_forward(model, data)
        palm = data.body("palm")
        places.append(palm.xmat.reshape(3, 3).T @ (data.body("object").xipos - palm.xpos))
    return np.array(places)


@pytest.mark.parametrize("mass", [1.0, 2.0])
def test_what_is_held_still_weighs_what_it_weighs(mass):
    """To 3 %; relative to the weight that was expected, which the mass is not."""
    made = carried(mass)
    assert made.run.outcome.success
    assert len(made.load) > 300
    np.testing.assert_allclose(made.load[-200:], mass, rtol=0.03)
    np.testing.assert_allclose(made.pushed[-200:], 9.81 * mass * TASK.object.mass, rtol=0.03)
    assert made.load[0] < 0.1 * mass  # on the table


def test_the_load_is_relative_to_what_lifts_the_object_as_the_palm_is_to_go():
    """Up to a sixth more than its weight while it is lifted, and as much less as it slows down."""
    made = carried(1.0)
    expected = 9.81 + np.diff(made.run.mocap_pos[made.action - 1 :, 2], 2) / 0.01**2
    assert expected[:90].max() > 1.1 * 9.81
    np.testing.assert_allclose(
        made.load[: len(expected)] * expected * TASK.object.mass,
        made.pushed[: len(expected)],
        rtol=1e-9,
    )


def test_nothing_is_felt_before_the_action():
    made = carried(1.0)
    (begins,) = (phase.start for phase in made.run.phases if phase.name == "action")
    assert made.action == round(100 * begins)
    assert made.before == [[None, None]] * made.action


def test_sliding_is_how_fast_the_object_moves_in_the_palm():
    made = carried(2.0)
    # Sensors are those of the last step, 2 ms old.
    np.testing.assert_allclose(made.held, in_palm(made.run)[made.action :], rtol=0, atol=5e-5)
    way = np.diff(made.held, axis=0)
    assert made.slip[0] == 0.0
    np.testing.assert_allclose(made.slip[1:], 100 * np.linalg.norm(way, axis=1), rtol=1e-9)
    assert made.slip.max() > 0.005


def test_the_grip_follows_the_load_and_keeps_to_it():
    """Where nothing slides the grip goes by the greatest load so far."""
    made = carried(2.0)
    assert made.slip.max() < 0.03
    expected = np.maximum.accumulate(np.maximum(made.load / 1.15, 1.0))
    np.testing.assert_allclose(made.tighter[made.action :], expected, rtol=1e-12)
    assert made.tighter[-1] >= 2.0 / 1.15


def test_what_is_heavier_is_lifted_as_high():
    """Without the correction the arm sags by more than a centimetre."""
    nominal = carried(1.0).run.outcome.lift_m
    assert nominal == pytest.approx(0.12, abs=0.003)
    assert carried(2.0).run.outcome.lift_m == pytest.approx(nominal, abs=0.005)
    assert carried(2.0, corrected=False).run.outcome.lift_m < nominal - 0.010
