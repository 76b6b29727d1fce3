"""Simulations that leave all bounds end at once, as an outcome that names the step."""

import re
from dataclasses import dataclass, field, replace

import mujoco
import numpy as np
import pytest

from handsim.grasping.conditions import LIMITS, Conditions
from handsim.grasping.planning.demonstrator import demonstrate, scripted_plan
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.run import simulate
from handsim.grasping.rollout_file import read_rollout, write_rollout
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import N_JOINTS
from handsim.tasks.table_one import task_by_name
from handsim.types import HandSize

TASK = task_by_name("cube-raise")
AT = 0.31
"""When things go wrong [s]."""


@pytest.fixture(params=["arm", "free"])
def scene(request):
    return Scene.build(TASK, Conditions(base=request.param))


@pytest.fixture(scope="module")
def plan():
    return scripted_plan(TASK, HandModel.from_spec(build_hand()))[0]


@dataclass
class Troubled:
    """Holds the hand still, and at a time does something to the simulation."""

    trouble: object
    targets_after: np.ndarray = field(default_factory=lambda: np.zeros(N_JOINTS))
    name: str = "troubled"
    reach: float = np.inf

    @property
    def destination(self):
        return np.zeros(N_JOINTS)

    def start(self, n):
        return np.empty((n, 0))

    def step(self, time, dt, reference, readings):
        if time < AT:
            return np.zeros(N_JOINTS), reference
        if self.trouble is not None:
            self.trouble()
        return self.targets_after, reference

    def coordinates(self, readings):
        return readings[:, :0]

    def arrived(self, reading):
        return True


def troubles(data: mujoco.MjData) -> dict[str, Troubled]:
    """Every way in which a number can go bad, by name."""

    def fill(array, value):
        return Troubled(lambda: array.__setitem__(3, value))

    return {
        "target": Troubled(None, np.full(N_JOINTS, np.nan)),
        "position": fill(data.qpos, np.nan),
        "velocity": fill(data.qvel, np.inf),
        "huge velocity": fill(data.qvel, 1e12),
        "fast": fill(data.qvel, 1e4),
        "force": fill(data.qfrc_applied, 1e14),
    }


@pytest.mark.parametrize(
    "kind", ["target", "position", "velocity", "huge velocity", "fast", "force"]
)
def test_what_is_no_number_is_found_within_a_step(scene, plan, kind, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    run = simulate(scene, plan, troubles(scene.hand.data)[kind])
    assert run.outcome.reason == "unstable"
    assert not run.outcome.success
    step = round(AT / 0.01)
    assert re.search(rf"{AT:.3f} s \(step {step}\)", run.outcome.detail)
    assert run.time[-1] == pytest.approx(AT)
    # What was recorded are numbers, and can be stored and read again.
    assert all(np.isfinite(a).all() for a in (run.qpos, run.qvel, run.ctrl, run.reading))
    write_rollout(run, tmp_path / "r.npz")
    assert read_rollout(tmp_path / "r.npz").outcome == run.outcome
    # MuJoCo would tell the terminal, and a log file in whatever folder one happens to be in.
    assert [path.name for path in tmp_path.iterdir()] == ["r.npz"]
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    "extreme",
    [
        {"hand": HandSize(0.13, 0.06)},
        {"hand": HandSize(0.25, 0.11)},
        {"friction": LIMITS["friction"][0]},
        {"friction": LIMITS["friction"][1]},
        {"mass_scale": LIMITS["mass_scale"][0]},
        {"mass_scale": LIMITS["mass_scale"][1]},
        {"object_offset": (0.5, -0.5, 3.0)},
        {"shake": LIMITS["shake"][1]},
        {"shake": LIMITS["shake"][1], "base": "free"},
        {"bias": LIMITS["bias"][1]},
        {"drift": LIMITS["drift"][1]},
        {"latency": LIMITS["latency"][1]},
        {"lost": LIMITS["lost"][1]},
    ],
)
def test_extremes_end_in_an_outcome(extreme, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    run = demonstrate(TASK, replace(Conditions(), **extreme))
    outcome = run.outcome
    assert outcome.success == (outcome.reason is None)
    assert np.isfinite(run.qpos).all()
    assert np.isfinite([outcome.lift_m, outcome.peak_slip_m, outcome.peak_tilt_deg]).all()
    assert list(tmp_path.iterdir()) == []
    assert capfd.readouterr() == ("", "")
