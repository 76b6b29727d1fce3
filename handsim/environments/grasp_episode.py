"""Grasps that are commanded from outside, reading by reading: one, or several side by side."""

from collections.abc import Sequence
from typing import NamedTuple

from handsim.environments.entries import ActionKind
from handsim.environments.steering import steered_driver
from handsim.grasping.plan import GraspPlan, schedule_for
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.jobs import Job
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import Runs, diverged, has_diverged
from handsim.learning.controller import GraspController
from handsim.silence import silent
from handsim.types import Array


class Row(NamedTuple):
    """Live views of the state of one run.

    Attributes
    ----------
    values, qpos : (n_values,), (nq,)
        Of the sensors, and MuJoCo's positions.
    sites : (3 * n_sites,) [m]
        Places of the sites in the world, one after the other.
    """

    values: Array
    qpos: Array
    sites: Array


class GraspEpisode:
    """Runs of `handsim grasp` whose fingers a policy commands; they differ in conditions alone.

    Parameters
    ----------
    scenes
        One for each run.
    plan, controller
        Where the palm goes, and in whose subspace.
    kind
        What actions are.
    brief
        End each run as soon as its object is lost.

    Attributes
    ----------
    unstable
        Whether each simulation has diverged.
    sensors
        What the values of the sensors mean.
    rows
        The states of the runs.
    n_readings
        How many readings, and steps, the runs have.
    reading
        Number of the reading that the runs are at; at their end, of the last.
    over
        Whether all runs have come to their end.
    """

    def __init__(
        self,
        scenes: Sequence[Scene],
        plan: GraspPlan,
        controller: GraspController,
        kind: ActionKind,
        *,
        brief: bool = False,
    ) -> None:
        scene = scenes[0]
        schedule = schedule_for(scene.task)
        self._driver = steered_driver(kind, controller, plan, scene.lead, schedule)
        self._brief, self.unstable = brief, [False] * len(scenes)
        gripped = kind == "components"
        self._runs = runs = Runs(
            [Job(each, plan, self._driver, schedule, gripped=gripped) for each in scenes]
        )
        (self._group,) = runs.groups
        self.n_readings = runs.end
        simulations = runs.simulations
        self.sensors = simulations.sensors
        sites = simulations.site_xpos.reshape(len(scenes), -1)  # a view, as the others
        self.rows = [
            Row(*row) for row in zip(simulations.sensordata, simulations.qpos, sites, strict=True)
        ]
        self._speeds = simulations.qvel, simulations.warnings
        self._first_speeds = simulations.qvel[0], simulations.warnings[0]
        self._times: list[float] = self._group.commands.times.tolist()
        self.reading, self.over, self._silent = 0, False, silent()
        with self._silent:
            runs.start()
        self._group.measure(0)

    @property
    def time(self) -> float:
        """Time of that reading [s]."""
        return self._times[self.reading]

    def seen(self) -> tuple[Array, Array]:
        """Return the gloves' readings (n, 22), and points in the subspace (n, n_components) [rad].

        Of readings that are late or lost it is what comes.
        """
        reference, readings, glove = self._group.seen()
        return glove, self._driver.point(self.time, reference, readings)

    def step(self, actions: Array) -> None:
        """Command by actions (n, size) and go on to the next reading."""
        runs, group = self._runs, self._group
        self._driver.give(actions)
        group.command(runs.tick)
        with self._silent:
            runs.step()
        if self._brief:
            runs.end_lost(runs.tick - 1)
        self.unstable = unstable = self._diverged()
        self.over = runs.tick >= runs.end or all(unstable)
        self.reading = min(runs.tick, self.n_readings - 1)
        group.measure(self.reading)

    def _diverged(self) -> list[bool]:
        if len(self.rows) == 1:
            return [has_diverged(*self._first_speeds)]
        now: list[bool] = diverged(*self._speeds).tolist()
        return [before or bad for before, bad in zip(self.unstable, now, strict=True)]

    def records(self) -> list[Rollout]:
        """Judge the runs, as `handsim grasp` does, and return their records.

        In several runs side by side, contacts of a part beyond those that a sensor has room for do
        not count.
        """
        self._runs.uncounted[:] = False
        return [rollout for rollout in self._runs.records() if rollout is not None]
