"""The hand in physics under the closed loop of its controller, as in grasps, and pushed.

Everything is as in a grasp's reach (`handsim.grasping.rollout`): MuJoCo moves the hand by position
actuators, a glove with noise and steps of 1 deg reads it 100 times a second, and `LearnedDriver`
draws its reference to the reading and makes the targets. Only object and arm are missing: the
forearm stands still. The loop stays closed at the destination.

A second hand without pushes runs beside it, on the same noise. The difference of the two is what a
push does, and nothing else.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections import deque
from collections.abc import Sequence

import mujoco
import numpy as np

from handsim.errors import InputError
from handsim.grasping.plan import Schedule
from handsim.grasping.rollout.compiled_scene import servo_lead
from handsim.grasping.rollout.drivers import LearnedDriver
from handsim.grasping.rollout.glove import RATE, DataGlove, steps_per_reading
from handsim.grasping.rollout.run import has_diverged
from handsim.joints import JOINT_NAMES, N_JOINTS, clip_to_range
from handsim.learning.controller import GraspController
from handsim.types import Array
from handsim.viewing.live.pushing.pushes import Push

REACH_S = Schedule(steps=(), hold=0.0).reach
"""Duration of the movement to the destination: that of the reach in grasps [s]."""
KEPT_S = 4.0
"""How much of the past is kept to be drawn [s]."""
MOST_AT_ONCE_S = 0.1
"""Longest time that is made up for when the page was late [s]."""


class LoopHand:
    """A hand that its controller moves from a start to a destination, and holds there.

    Parameters
    ----------
    controller
    model
        From `posture_model`: the hand alone, its forearm fixed.
    start, goal : (n_components,) [rad]
    seed
        Of the glove's noise.

    Attributes
    ----------
    time
        Since the start [s].
    past
        The latest `KEPT_S`: time [s], how far a push took the hand off [rad], and the push [N].
    trail
        Where the hand was at these times, (n_components,) [rad] each.

    Raises
    ------
    InputError
        If the controller cannot go to the destination.
    """

    def __init__(
        self, controller: GraspController, model: mujoco.MjModel, start: Array, goal: Array,
        seed: int = 0,
    ) -> None:  # fmt: skip
        actuators = np.array([model.actuator(name).id for name in JOINT_NAMES], dtype=np.intp)
        self._controller, self._lead = controller, servo_lead(model, actuators)
        self._driver, self._begun = self._to(start, goal), 0.0
        self._model, self._glove = model, DataGlove()
        self._generator = np.random.default_rng(seed)
        self._joints = [int(model.joint(name).qposadr[0]) for name in JOINT_NAMES]
        self._actuators = actuators
        q = clip_to_range(controller.subspace.inverse_transform(start))
        self._pushed, self._free = self._at(q), self._at(q)
        self._references = np.tile(start, (2, 1))  # of the pushed hand and of the other
        self._ticks, self._owed = 0, 0.0
        self.time = 0.0
        kept = round(KEPT_S * RATE)
        self.past: deque[tuple[float, float, float]] = deque(maxlen=kept)
        self.trail: deque[Array] = deque(maxlen=kept)

    @property
    def qpos(self) -> Array:
        """Joint positions of the pushed hand in MuJoCo's order, (22,) [rad]."""
        return self._pushed.qpos

    @property
    def data(self) -> mujoco.MjData:
        """State of the pushed hand."""
        return self._pushed

    @property
    def place(self) -> Array:
        """Where the pushed hand is in the subspace, (n_components,) [rad]."""
        return self._driver.coordinates(self._postures())[0]

    @property
    def off(self) -> float:
        """How far the pushed hand is from where it would be without pushes, in the subspace [rad].

        Both are read as they are, without the glove's noise.
        """
        pushed, free = self._driver.coordinates(self._postures())
        return float(np.linalg.norm(pushed - free))

    @property
    def z_goal(self) -> Array:
        """The destination (n_components,) [rad]."""
        return self._driver.z_goal

    def redirect(self, goal: Array) -> None:
        """Go on from here to another destination (n_components,) [rad].

        Raises
        ------
        InputError
            If the controller cannot go there.
        """
        self._driver, self._begun = self._to(self._references[0], goal), self.time

    def _to(self, start: Array, goal: Array) -> LearnedDriver:
        timing = self._controller.timing(start, goal, REACH_S)
        return LearnedDriver(self._controller, start, goal, timing, self._lead, REACH_S)

    def advance(self, seconds: float, pushes: Sequence[Push] = ()) -> None:
        """Simulate the next part, while pushes act, each until its own time is over.

        Parameters
        ----------
        seconds
            How long; at most `MOST_AT_ONCE_S`, what goes beyond is left out.
        pushes
        """
        self._owed += min(seconds, MOST_AT_ONCE_S)
        n = int(self._owed * RATE + 1e-9)
        self._owed -= n / RATE
        for _ in range(n):
            self._tick([push for push in pushes if push.until > self.time])

    def _tick(self, pushes: Sequence[Push]) -> None:
        """Go from one reading of the glove to the next."""
        noise = self._glove.disturbance((N_JOINTS,), self._generator)
        readings = self._glove.reading(self._postures(), noise)
        since = self.time - self._begun
        targets, self._references = self._driver.step(since, 1.0 / RATE, self._references, readings)
        force = 0.0
        for data, target, acting in zip(
            (self._pushed, self._free), targets, (pushes, ()), strict=True
        ):
            data.ctrl[self._actuators] = target
            for _ in range(steps_per_reading(self._model)):
                data.qfrc_applied[:] = 0.0
                for push in acting:
                    force = max(force, push.apply(self._model, data))
                mujoco.mj_step(self._model, data)
        for data in (self._pushed, self._free):
            if has_diverged(data.qvel, data.warning.number):
                raise InputError(
                    f"the hand became unstable at {self.time:.2f} s; run the loop again, pull less"
                )
        self._ticks += 1
        self.time = self._ticks / RATE
        self.past.append((self.time, self.off, force))
        self.trail.append(self.place)

    def _postures(self) -> Array:
        """Return the joint angles of both hands (2, 22) [rad]."""
        return np.array([data.qpos[self._joints] for data in (self._pushed, self._free)])

    def _at(self, q: Array) -> mujoco.MjData:
        data = mujoco.MjData(self._model)
        data.qpos[self._joints] = data.ctrl[self._actuators] = q
        mujoco.mj_forward(self._model, data)
        return data
