"""A web page that shows and moves the hand, for machines without a display.

It has sliders for the principal components and the size of the hand, the subspace with the way to a
destination beside the hand, menus of objects and tasks, and buttons that simulate a grasp, play it,
pause it and replay it. One thread reads all controls
once a frame, so that no two actions run at the same time.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import io
import time
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout

import mujoco
import numpy as np

from handsim.errors import HandsimError, InputError, MissingToolError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.planner import run_plan
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.record import Rollout
from handsim.joints import CONTACT_PARTS
from handsim.learning.controller import GraspController
from handsim.recordings.recording import Recording
from handsim.tasks.table_one import TASKS, task_by_name
from handsim.types import MEDIAN_HAND, Array, HandSize
from handsim.viewing.film.posture_clips import posture_clip, posture_model
from handsim.viewing.live.force_rows import force_rows
from handsim.viewing.live.puppet import Puppet
from handsim.viewing.live.subspace_panel import SubspacePanel

PlanSource = Callable[[str, Conditions], GraspPlan | None]
"""Returns the plan of a task under conditions, or None where none is known."""

RATE = 30.0
"""How often the controls are read and the hand is moved [1/s]."""
LENGTHS_MM, BREADTHS_MM = (150, 220), (65, 105)
"""Ranges of the sliders of hand length and breadth: those of adults [mm]."""
NO_TASK = "none"
INSTALL = "pip install 'handsim[viewer]'"

View = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Position of the camera and the point that it looks at [m]."""
_OF_POSTURE: View = ((0.72, 0.53, 0.27), (0.06, -0.07, 0.05))
_OF_SCENE: View = ((0.50, 0.50, 0.38), (-0.02, -0.02, 0.09))
_GHOST = 0.35
"""Opacity of a recorded hand beside the controller's."""
_FIELD_OF_VIEW = np.deg2rad(36.0)  # vertical, as of the scenes' own cameras


class LivePage:
    """The page and its server; `step` brings it up to date and is called once a frame.

    Parameters
    ----------
    controller
        Its subspace is what the sliders move in, and it executes the grasps.
    plans
        Source of the plans of grasps.
    host, port
        Address of the page. If the port is taken, another free one is used.
    task
        The task that is selected when the page opens.
    recordings
        Shown in the subspace, and as ghosts.
    text
        Of the view that the page begins with, as a page gives it.

    Raises
    ------
    MissingToolError
        If viser is not installed.
    """

    def __init__(
        self,
        controller: GraspController,
        plans: PlanSource,
        host: str = "127.0.0.1",
        port: int = 8080,
        task: str | None = None,
        recordings: Sequence[Recording] = (),
        text: str | None = None,
    ) -> None:
        try:
            import viser
        except ImportError as error:
            raise MissingToolError(f"the page needs viser; run: {INSTALL}") from error
        chosen = NO_TASK if task is None else task_by_name(task).name
        self._controller, self._plans = controller, plans
        with redirect_stdout(io.StringIO()):  # it greets there whatever it is told
            self._server = viser.ViserServer(host=host, port=port, verbose=False)
        self._server.gui.configure_theme(show_logo=False, show_share_button=False)
        self._server.initial_camera.fov = _FIELD_OF_VIEW
        self._n_shown = 0
        self._puppet: Puppet | None = None
        self._ghost: Puppet | None = None
        self._view: View | None = None
        self._alone: HandSize | None = None  # size of the hand shown without a scene
        self._time, self._playing = 0.0, False
        self._run: Rollout | None = None
        try:
            self._panel = SubspacePanel(self._server, controller, recordings, text)
        except HandsimError:
            self.close()
            raise
        self._add_controls()
        self._seen = self._choices()
        self._show_posture()
        self._task.value = chosen

    @property
    def address(self) -> str:
        """Address of the page for a browser."""
        return f"http://{self._server.get_host()}:{self._server.get_port()}"

    def close(self) -> None:
        """Stop serving."""
        with redirect_stdout(io.StringIO()):
            self._server.stop()

    def step(self, elapsed: float) -> None:
        """Read the controls, and advance the grasp that is played by ``elapsed`` [s]."""
        self._offer_tasks()
        try:
            self._follow_choices(self._panel.step(elapsed))
            for button, react in self._buttons.items():
                if self._pressed.pop(button, False):
                    react()
        except HandsimError as error:
            self._say(str(error))
        if self._run and self._playing:
            self._go_to(self._time + elapsed)
        elif self._run and abs(self._slider.value - self._time) > 0.5 * self._slider.step:
            self._go_to(float(self._slider.value))

    def _follow_choices(self, moved: bool) -> None:
        """Show the choice if it has changed; moving in the subspace deselects the task."""
        size, task = choices = self._choices()
        before, self._seen = self._seen, choices
        if choices == before and not moved:
            return
        self._run, self._playing = None, False
        self._forces.content = ""
        if task != NO_TASK and not moved:
            self._show_scene()
            return
        self._task.value = NO_TASK
        self._seen = (size, NO_TASK)
        self._show_posture()

    def _add_controls(self) -> None:
        gui = self._server.gui
        with gui.add_folder("Hand", expand_by_default=False):
            length, breadth = round(1000 * MEDIAN_HAND.length), round(1000 * MEDIAN_HAND.breadth)
            self._length = gui.add_slider("length [mm]", *LENGTHS_MM, 1, length)
            self._breadth = gui.add_slider("breadth [mm]", *BREADTHS_MM, 1, breadth)
        with gui.add_folder("Grasp"):
            objects = list(dict.fromkeys(task.object_name for task in TASKS))
            self._object = gui.add_dropdown("object", ["all", *objects])
            self._task = gui.add_dropdown("task", [NO_TASK, *(task.name for task in TASKS)])
            names = ("play", "pause", "replay")
            buttons = [gui.add_button(name) for name in names]
            self._slider = gui.add_slider("time [s]", 0.0, 1.0, 0.01, 0.0)
            self._forces = gui.add_html("")
        self._status = gui.add_markdown("")
        reactions = (self._play, lambda: setattr(self, "_playing", False), self._replay)
        self._buttons = dict(zip(names, reactions, strict=True))
        self._pressed: dict[str, bool] = {}
        for name, button in zip(names, buttons, strict=True):
            button.on_click(lambda _, name=name: self._pressed.__setitem__(name, True))

    def _choices(self) -> tuple[HandSize, str]:
        """Return the size of the hand and the task that are chosen."""
        return HandSize(self._length.value / 1000, self._breadth.value / 1000), str(
            self._task.value
        )

    def _offer_tasks(self) -> None:
        """Offer the tasks of the object that is chosen."""
        chosen = self._object.value
        names = [task.name for task in TASKS if chosen in ("all", task.object_name)]
        if tuple(self._task.options) != (NO_TASK, *names):
            self._task.options = (NO_TASK, *names)
            self._task.value = names[0] if chosen != "all" else NO_TASK

    def _conditions(self) -> Conditions:
        return Conditions(hand=self._seen[0])

    def _show_posture(self) -> None:
        """Show the hand alone, where it is in the subspace, and the ghost of a recording."""
        size, _ = self._seen
        if self._alone != size:
            model = posture_model(size)
            self._show(model, model.qpos0, _OF_POSTURE)
            self._alone = size
        state, ghost = self._panel.state, self._panel.ghost
        self._place(self._qpos(self._panel.posture))
        if ghost is not None:
            if self._ghost is None:
                name = f"/ghost_{self._n_shown}"
                self._ghost = Puppet(self._server, name, self._model, _GHOST)
            self._ghost.place(self._qpos(ghost))
        if self._ghost is not None:
            self._ghost.show(ghost is not None)
        where = {"start": "A posture of the subspace.", "goal": "The destination."}
        said = where.get(state.at, f"{100 * state.share:.0f} % of the way to the destination.")
        mean = state.at == "start" and not state.start.any()
        self._say(("The mean posture." if mean else said) + f" {self._panel.said}".rstrip())

    def _qpos(self, q: Array) -> Array:
        return posture_clip(np.zeros(1), q[None], self._model).qpos[0]

    def _show_scene(self) -> None:
        """Show the scene of the task that is chosen, before the grasp."""
        scene = Scene.build(task_by_name(self._seen[1]), self._conditions())
        self._show(scene.hand.model, scene.hand.data.qpos, _OF_SCENE)
        self._say(f"**{self._seen[1]}**: press play.")

    def _play(self) -> None:
        """Play the grasp from where it stands; simulate it first if that has not been done."""
        if self._run is None:
            self._simulate()
        if self._run and self._time >= self._run.time[-1] - self._run.time[0]:
            self._time = 0.0
        self._playing = True

    def _replay(self) -> None:
        self._time = 0.0
        self._play()

    def _simulate(self) -> None:
        """Simulate the grasp of the task that is chosen."""
        task, conditions = self._seen[1], self._conditions()
        if task == NO_TASK:
            raise InputError("Choose a task first.")
        plan = self._plans(task, conditions)
        if plan is None:
            raise InputError(f"No plan is stored; run `handsim grasp --task {task}` once.")
        self._say(f"**{task}**: simulating …")
        scene = Scene.build(task_by_name(task), conditions)
        self._run, self._time = run_plan(self._controller, scene, plan), 0.0
        self._slider.max = round(float(self._run.time[-1] - self._run.time[0]), 2)
        self._show(scene.hand.model, self._run.qpos[0], _OF_SCENE)

    def _go_to(self, seconds: float) -> None:
        """Show the run at a time since its start, and stop at its end."""
        run = self._run
        assert run is not None  # only called while there is one
        since = run.time - run.time[0]
        self._time = min(seconds, float(since[-1]))
        self._playing = self._playing and self._time < since[-1]
        self._slider.value = round(self._time, 2)
        i = min(int(np.searchsorted(since, self._time)), len(since) - 1)
        self._place(run.qpos[i])
        outcome = run.outcome
        verdict = "success" if outcome.success else f"failed, {outcome.reason}"
        force = run.contact_force[i].sum()
        self._say(
            f"**{run.task}**: {verdict}  \n{self._time:.2f} s, {run.phase_at(run.time[i])}, "
            f"contact forces {force:.1f} N"
        )
        most = float(np.quantile(run.contact_force, 0.99))
        self._forces.content = force_rows(run.contact_force[i], CONTACT_PARTS, outcome.need_n, most)

    def _show(self, model: mujoco.MjModel, qpos: Array, view: View) -> None:
        """Put a model on the page in place of what was there."""
        with self._server.atomic():
            for shown in (self._puppet, self._ghost):
                if shown is not None:
                    shown.remove()
            self._n_shown += 1  # a name used again would keep the pose of what had it before
            self._puppet = Puppet(self._server, f"/shown_{self._n_shown}", model)
            self._ghost, self._alone, self._model = None, None, model
            self._panel.scene.show(view == _OF_POSTURE)
            self._place(qpos)
        if view != self._view:  # otherwise it stays where people have moved it
            self._view = view
            clients = self._server.get_clients().values()
            for camera in (self._server.initial_camera, *(client.camera for client in clients)):
                camera.position, camera.look_at = map(np.array, view)

    def _place(self, qpos: Array) -> None:
        assert self._puppet is not None  # there is one from the beginning
        self._puppet.place(qpos)

    def _say(self, text: str) -> None:
        if self._status.content != text:
            self._status.content = text


def serve(page: LivePage) -> None:
    """Keep a page alive until it is interrupted."""
    last = time.monotonic()
    try:
        while True:
            now = time.monotonic()
            page.step(now - last)
            last = now
            time.sleep(max(0.0, 1 / RATE - (time.monotonic() - now)))
    except KeyboardInterrupt:
        pass
    finally:
        page.close()
