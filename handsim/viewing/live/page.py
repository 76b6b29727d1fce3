"""A web page that shows and moves the hand, for machines without a display.

It has sliders for the principal components and the size of the hand, menus of objects and tasks,
and buttons that simulate a grasp, play it, pause it and replay it. One thread reads all controls
once a frame, so that no two actions run at the same time.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import io
import time
from collections.abc import Callable
from contextlib import redirect_stdout

import mujoco
import numpy as np

from handsim.errors import HandsimError, InputError, MissingToolError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.planner import run_plan
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.record import Rollout
from handsim.learning.controller import GraspController
from handsim.tasks.table_one import TASKS, task_by_name
from handsim.types import MEDIAN_HAND, Array, HandSize
from handsim.viewing.film.posture_clips import posture_clip, posture_model
from handsim.viewing.live.shapes import geom_colour, geom_mesh, visible_geoms

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
_OF_POSTURE: View = ((0.56, 0.48, 0.25), (0.0, 0.0, 0.04))
_OF_SCENE: View = ((0.50, 0.50, 0.38), (-0.02, -0.02, 0.09))
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
        self._root: viser.FrameHandle | None = None
        self._bodies: dict[int, viser.FrameHandle] = {}
        self._view: View | None = None
        self._alone: HandSize | None = None  # size of the hand shown without a scene
        self._time, self._playing = 0.0, False
        self._run: Rollout | None = None
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
            self._follow_choices()
            for button, react in self._buttons.items():
                if self._pressed.pop(button, False):
                    react()
        except HandsimError as error:
            self._say(str(error))
        if self._run and self._playing:
            self._go_to(self._time + elapsed)
        elif self._run and abs(self._slider.value - self._time) > 0.5 * self._slider.step:
            self._go_to(float(self._slider.value))

    def _follow_choices(self) -> None:
        """Show the choice if it has changed; moving a component deselects the task."""
        coordinates, size, task = choices = self._choices()
        before, self._seen = self._seen, choices
        if choices == before:
            return
        self._run, self._playing = None, False
        if task != NO_TASK and coordinates == before[0]:
            self._show_scene()
            return
        self._task.value = NO_TASK
        self._seen = (coordinates, size, NO_TASK)
        self._show_posture()

    def _add_controls(self) -> None:
        gui, obstacle = self._server.gui, self._controller.navigation.obstacle
        with gui.add_folder("Posture"):
            bounds = np.rad2deg(np.column_stack([obstacle.lower, obstacle.upper])).round(1)
            self._components = [
                gui.add_slider(f"PC {i + 1} [deg]", float(low), float(high), 0.1, 0.0)
                for i, (low, high) in enumerate(bounds)
            ]
        with gui.add_folder("Hand"):
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
        self._status = gui.add_markdown("")
        reactions = (self._play, lambda: setattr(self, "_playing", False), self._replay)
        self._buttons = dict(zip(names, reactions, strict=True))
        self._pressed: dict[str, bool] = {}
        for name, button in zip(names, buttons, strict=True):
            button.on_click(lambda _, name=name: self._pressed.__setitem__(name, True))

    def _choices(self) -> tuple[tuple[float, ...], HandSize, str]:
        """Return the coordinates [deg], the size of the hand and the task that are chosen."""
        coordinates = tuple(float(slider.value) for slider in self._components)
        size = HandSize(self._length.value / 1000, self._breadth.value / 1000)
        return coordinates, size, str(self._task.value)

    def _offer_tasks(self) -> None:
        """Offer the tasks of the object that is chosen."""
        chosen = self._object.value
        names = [task.name for task in TASKS if chosen in ("all", task.object_name)]
        if tuple(self._task.options) != (NO_TASK, *names):
            self._task.options = (NO_TASK, *names)
            self._task.value = names[0] if chosen != "all" else NO_TASK

    def _conditions(self) -> Conditions:
        _, size, _ = self._seen
        return Conditions(hand=size)

    def _show_posture(self) -> None:
        """Show the hand alone, at the coordinates that are chosen."""
        coordinates, size, _ = self._seen
        q = self._controller.subspace.inverse_transform(np.deg2rad(coordinates))
        if self._alone != size:
            model = posture_model(size)
            self._show(model, model.qpos0, _OF_POSTURE)
            self._alone = size
        self._place(posture_clip(np.zeros(1), q[None], self._model).qpos[0])
        self._say("A posture of the subspace." if any(coordinates) else "The mean posture.")

    def _show_scene(self) -> None:
        """Show the scene of the task that is chosen, before the grasp."""
        scene = Scene.build(task_by_name(self._seen[2]), self._conditions())
        self._show(scene.hand.model, scene.hand.data.qpos, _OF_SCENE)
        self._say(f"**{self._seen[2]}**: press play.")

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
        task, conditions = self._seen[2], self._conditions()
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

    def _show(self, model: mujoco.MjModel, qpos: Array, view: View) -> None:
        """Put a model on the page in place of what was there."""
        scene = self._server.scene
        self._model, self._data, self._alone = model, mujoco.MjData(model), None
        with self._server.atomic():
            if self._root:
                self._root.remove()
            self._n_shown += 1  # a name used again would keep the pose of what had it before
            self._root = scene.add_frame(f"/shown_{self._n_shown}", show_axes=False)
            self._bodies = {}
            for geom in visible_geoms(model):
                body = int(model.geom_bodyid[geom])
                name = f"{self._root.name}/body_{body}"
                if body not in self._bodies:
                    self._bodies[body] = scene.add_frame(name, show_axes=False)
                self._add_geom(geom, f"{name}/geom_{geom}")
            self._place(qpos)
        if view != self._view:  # otherwise it stays where people have moved it
            self._view = view
            clients = self._server.get_clients().values()
            for camera in (self._server.initial_camera, *(client.camera for client in clients)):
                camera.position, camera.look_at = map(np.array, view)

    def _add_geom(self, geom: int, name: str) -> None:
        model, (*rgb, opacity) = self._model, geom_colour(self._model, geom)
        mesh = geom_mesh(model, geom).smooth_shaded
        self._server.scene.add_mesh_simple(
            name,
            np.asarray(mesh.vertices, np.float32),
            np.asarray(mesh.faces, np.uint32),
            color=np.array(rgb),
            opacity=opacity if opacity < 1 else None,
            position=model.geom_pos[geom],
            wxyz=model.geom_quat[geom],
        )

    def _place(self, qpos: Array) -> None:
        """Move the bodies to their poses at joint positions."""
        self._data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, self._data)
        with self._server.atomic():
            for body, frame in self._bodies.items():
                frame.position, frame.wxyz = self._data.xpos[body], self._data.xquat[body]

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
