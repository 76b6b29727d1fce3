"""One grasp that is commanded from outside, reading by reading."""

from handsim.environments.entries import ActionKind
from handsim.environments.steering import steered_driver
from handsim.grasping.plan import GraspPlan, schedule_for
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.jobs import Job
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import Runs, has_diverged
from handsim.grasping.rollout.sensing import Sensors
from handsim.learning.controller import GraspController
from handsim.silence import silent
from handsim.types import Array


class Episode:
    """A run of `handsim grasp` whose fingers a policy commands.

    Parameters
    ----------
    scene, plan, controller
        What is grasped, where the palm goes, and in whose subspace.
    kind
        What actions are.
    brief
        End the run as soon as the object is lost.

    Attributes
    ----------
    unstable
        Whether the simulation has diverged.
    """

    def __init__(
        self,
        scene: Scene,
        plan: GraspPlan,
        controller: GraspController,
        kind: ActionKind,
        *,
        brief: bool = False,
    ) -> None:
        self.scene, self.schedule = scene, schedule_for(scene.task)
        self._driver = steered_driver(kind, controller, plan, scene.lead, self.schedule)
        self._brief, self.unstable = brief, False
        job = Job(scene, plan, self._driver, self.schedule, gripped=kind == "components")
        self._runs = Runs([job])
        (self._group,) = self._runs.groups
        self.n_readings = self._runs.end
        simulations = self._runs.simulations
        self._values, self._qpos = simulations.sensordata[0], simulations.qpos[0]
        self._qvel, self._warnings = simulations.qvel[0], simulations.warnings[0]
        self._times: list[float] = self._group.commands.times.tolist()
        with silent():
            self._runs.start()
        self._group.measure(0)

    @property
    def sensors(self) -> Sensors:
        """What the values of the sensors mean."""
        return self._runs.simulations.sensors

    @property
    def values(self) -> Array:
        """Values of the sensors, a live view (n_values,)."""
        return self._values

    @property
    def qpos(self) -> Array:
        """MuJoCo's positions, a live view (nq,)."""
        return self._qpos

    @property
    def reading(self) -> int:
        """Number of the reading that the run is at; at its end, of the last."""
        return min(self._runs.tick, self.n_readings - 1)

    @property
    def time(self) -> float:
        """Time of that reading [s]."""
        return self._times[self.reading]

    @property
    def over(self) -> bool:
        """Whether the run has come to its end."""
        return self.unstable or self._runs.tick >= self._runs.end

    def seen(self) -> tuple[Array, Array]:
        """Return the glove's reading (22,), and the point in the subspace (n_components,) [rad]."""
        reference, readings, glove = self._group.seen()
        return glove[0], self._driver.point(self.time, reference, readings)[0]

    def step(self, action: Array) -> None:
        """Command by an action and go on to the next reading."""
        runs, group = self._runs, self._group
        self._driver.give(action)
        group.command(runs.tick)
        with silent():
            runs.step()
        if self._brief:
            runs.end_lost(runs.tick - 1)
        self.unstable = has_diverged(self._qvel, self._warnings)
        if not self.unstable:
            group.measure(self.reading)

    def record(self) -> Rollout:
        """Judge the run, as `handsim grasp` does, and return its record."""
        (rollout,) = self._runs.records()
        assert rollout is not None  # only a batch leaves runs out
        return rollout
