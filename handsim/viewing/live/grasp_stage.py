"""Grasps on the page: an object on the table, put where one likes, and what holds it there."""

from collections import deque
from collections.abc import Callable, Sequence
from html import escape
from typing import TYPE_CHECKING

import numpy as np

from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.planner import run_plan
from handsim.grasping.planning.search import MAX_STRAIN, NO_ARM, strain_of
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.record import Rollout
from handsim.joints import CONTACT_PARTS
from handsim.tasks.table_one import TASKS, task_by_name
from handsim.types import Array, HandSize
from handsim.viewing.live.force_rows import force_rows
from handsim.viewing.live.puppet import Puppet
from handsim.viewing.live.shown import ShownController, View
from handsim.viewing.live.table_place import (
    TURN_RANGE,
    X_RANGE,
    Y_RANGE,
    TablePlace,
    dragged,
    on_plane,
)

if TYPE_CHECKING:
    import viser

NO_TASK = "none"
_ONE: View = ((0.50, 0.50, 0.38), (-0.02, -0.02, 0.09))
_TWO: View = ((1.20, 0.80, 0.60), (-0.04, 0.42, 0.06))
_BESIDE = 0.55
"""Between two people at one table [m]."""
_NAMED = 0.17
"""How far before the objects their names are on the table [m]."""


class GraspStage:
    """Menus of objects and tasks, the object's place, and the grasps that are played.

    Parameters
    ----------
    server
    shown
        Each grasps by its own plan.

    Attributes
    ----------
    runs
        Of each controller, once they are made; None where no plan is known.
    time
        Since the start of the runs [s].
    """

    def __init__(self, server: "viser.ViserServer", shown: Sequence[ShownController]) -> None:
        self._server, self._shown = server, shown
        self.puppets: list[Puppet] = []
        self.runs: list[Rollout | None] = []
        self.time, self.playing = 0.0, False
        self._n_made = 0
        self._labels: list[viser.LabelHandle] = []
        self._what: tuple[str, HandSize] | None = None
        self._place = TablePlace()
        self._held: tuple[TablePlace, Array, Array] | None = None
        self.drags: deque[tuple[str, Array, Array, Array, bool]] = deque()
        self.pressed: dict[str, bool] = {}
        self._add_controls(server.gui)

    @property
    def view(self) -> View:
        """The camera's place."""
        return _ONE if len(self._shown) == 1 else _TWO

    @property
    def place(self) -> TablePlace:
        """Where the controls put the object."""
        return TablePlace(*(float(slider.value) for slider in self.sliders))

    def put(self, place: TablePlace) -> None:
        """Put the object at a place."""
        for slider, value in zip(self.sliders, (place.x, place.y, place.turn), strict=True):
            slider.value = value

    def _add_controls(self, gui: "viser.GuiApi") -> None:
        with gui.add_folder("Grasp"):
            objects = list(dict.fromkeys(task.object_name for task in TASKS))
            self.object = gui.add_dropdown("object", ["all", *objects])
            self.task = gui.add_dropdown("task", [NO_TASK, *(task.name for task in TASKS)])
            with gui.add_folder("Object on the table") as self._where:
                self.sliders = [
                    gui.add_slider("away [mm]", *X_RANGE, 1.0, 0.0),
                    gui.add_slider("left [mm]", *Y_RANGE, 1.0, 0.0),
                    gui.add_slider("turned [deg]", *TURN_RANGE, 1.0, 0.0),
                ]
            buttons = gui.add_button_group("run", tuple(self._reactions()))
            buttons.on_click(lambda _: self.pressed.__setitem__(str(buttons.value), True))
            self.slider = gui.add_slider("time [s]", 0.0, 1.0, 0.01, 0.0)
            self.forces = gui.add_html("")
        self._of_scene = (self._where, buttons, self.slider, self.forces)
        self._show_controls(False)

    def _show_controls(self, visible: bool) -> None:
        """Show or hide what makes sense beside a scene alone."""
        for handle in self._of_scene:
            handle.visible = visible

    def offer(self) -> None:
        """Offer the tasks of the object that is chosen."""
        chosen = self.object.value
        names = [task.name for task in TASKS if chosen in ("all", task.object_name)]
        if tuple(self.task.options) != (NO_TASK, *names):
            self.task.options = (NO_TASK, *names)
            self.task.value = names[0] if chosen != "all" else NO_TASK

    def choose(self, task: str) -> None:
        """Choose a task, of whatever object."""
        if task not in self.task.options:
            self.object.value = "all"
            self.offer()
        self.task.value = task

    def show(self, task: str, size: HandSize) -> str:
        """Show the scene of a task before the grasp, and return what there is to say."""
        self.remove()
        self._what, self._place = (task, size), self.place
        self._usual = scene = Scene.build(task_by_name(task), Conditions(hand=size))
        self._plans = [each.plans(task, scene.conditions) for each in self._shown]
        first = int(scene.model.joint("object_joint").qposadr[0])
        self._object = slice(first, first + 7)
        for i, each in enumerate(self._shown):
            self._n_made += 1  # a name used again would keep the pose of what had it before
            place = (0.0, i * _BESIDE, 0.0)
            puppet = Puppet(self._server, f"/scene_{self._n_made}", scene.model, place=place)
            self._watch(puppet)
            self.puppets.append(puppet)
            if len(self._shown) > 1:
                self._labels.append(
                    self._server.scene.add_label(
                        f"/grasps_{self._n_made}", each.name, position=(_NAMED, place[1], 0.01)
                    )
                )
        self._show_controls(True)
        self._stand()
        return self._before()

    def remove(self) -> None:
        """Take everything off the page, and forget the runs."""
        for handle in (*self.puppets, *self._labels):
            handle.remove()
        self.puppets, self._labels = [], []
        self._forget()
        self._show_controls(False)

    def _forget(self) -> None:
        self.runs, self.playing, self.time = [], False, 0.0
        self.forces.content = ""

    def advance(self, elapsed: float) -> str | None:
        """Follow the pointer, the buttons and the time; return what there is to say, if it is new.

        Raises
        ------
        InputError
            If no plan is known by which the task can be done.
        """
        self._follow_pointer()
        if self.place != self._place:
            self._place = self.place
            self._forget()
            self._stand()
            return self._before()
        said: str | None = None
        for name, react in self._reactions().items():
            if self.pressed.pop(name, False):
                react()
        if self.runs and self.playing:
            said = self.go_to(self.time + elapsed)
        elif self.runs and abs(self.slider.value - self.time) > 0.5 * self.slider.step:
            said = self.go_to(float(self.slider.value))
        return said

    def _reactions(self) -> dict[str, Callable[[], None]]:
        return {"grasp": self.grasp, "pause": self._pause, "replay": self._replay}

    def grasp(self) -> None:
        """Play the grasp from where it stands; simulate it first if that has not been done."""
        if not self.runs:
            self._simulate()
        if self.time >= self._end:
            self.time = 0.0
        self.playing = True

    def _pause(self) -> None:
        self.playing = False

    def _replay(self) -> None:
        self.time = 0.0
        self.grasp()

    @property
    def _end(self) -> float:
        return max(float(run.time[-1] - run.time[0]) for run in self.runs if run is not None)

    def _simulate(self) -> None:
        """Simulate the grasp of each controller, with the object where it stands."""
        assert self._what is not None
        name, size = self._what
        conditions, task = Conditions(hand=size), self._place.of(task_by_name(name))
        scene = Scene.build(task, conditions)
        runs = [
            None if plan is None else run_plan(each.controller, scene, plan)
            for each, plan in zip(self._shown, self._plans, strict=True)
        ]
        if all(run is None for run in runs):
            raise InputError(f"No plan is stored; run `handsim grasp --task {name}` once.")
        self.runs, self.time = runs, 0.0
        self.slider.max = round(self._end, 2)

    def go_to(self, seconds: float) -> str:
        """Show the runs at a time since their start, stop at the end; return what there is to say.

        A run that is shorter stays at its end.
        """
        self.time = min(seconds, self._end)
        self.playing = self.playing and self.time < self._end
        self.slider.value = round(self.time, 2)
        said: list[str] = []
        rows: list[str] = []
        for each, puppet, run in zip(self._shown, self.puppets, self.runs, strict=True):
            named = f"{each.name}: " if len(self._shown) > 1 else ""
            if run is None:
                said.append(f"{named}no plan is stored")
                continue
            i = min(int(np.searchsorted(run.time - run.time[0], self.time)), len(run.time) - 1)
            puppet.place(run.qpos[i])
            said.append(f"{named}{verdict_of(run)}")
            head = f"<b style='font-size:.85em'>{escape(each.name)}</b>" if named else ""
            rows.append(f"<div style='padding:0 .8em'>{head}{_forces_at(run, i)}</div>")
        self.forces.content = "".join(rows)
        phase = next(run for run in self.runs if run is not None)
        where = phase.phase_at(phase.time[0] + self.time)
        assert self._what is not None
        first = f"**{self._what[0]}**{_at(self._place)}, {self.time:.2f} s, {where}"
        return "  \n".join((first, *said))

    def _stand(self) -> None:
        """Show the object where the controls put it, with the hand at rest."""
        qpos = self._usual.hand.data.qpos.copy()
        qpos[self._object] = self._place.moved_pose(qpos[self._object])
        for puppet in self.puppets:
            puppet.place(qpos)

    def _reach(self) -> str:
        """Say where the arm has to strain to get there."""
        scene = self._usual
        plan = self._plans[0]
        if plan is None or scene.arm is None:
            return ""
        strain = strain_of(plan, self._place.of(scene.task), scene.arm)
        if strain > NO_ARM:
            return "No arm reaches it there in this way."
        return "The arm comes to its limits there." if strain > MAX_STRAIN else ""

    def _before(self) -> str:
        assert self._what is not None
        how = "drag the object, or turn it with Shift; then grasp."
        return f"**{self._what[0]}**{_at(self._place)}: {how}  \n{self._reach()}".rstrip()

    def _watch(self, puppet: Puppet) -> None:
        """Let the pointer drag the object, and turn it with Shift."""
        root = puppet.model.body("object").id
        for body, meshes in puppet.geoms.items():
            if puppet.model.body_rootid[body] != root:
                continue
            for mesh in meshes:
                mesh.on_drag(self._dragging(puppet.origin, turning=False))
                turn = self._dragging(puppet.origin, turning=True)
                mesh.on_drag("left", modifier="shift")(turn)

    def _dragging(self, origin: Array, *, turning: bool):  # noqa: ANN202 - viser's type of callback
        async def moved(event: "viser.SceneNodeDragEvent[viser.MeshHandle]") -> None:
            places = (event.start_position, event.end_position, event.client.camera.position)
            start, end, camera = (np.array(each) - origin for each in places)
            self.drags.append((event.phase, start, end, camera, turning))

        return moved

    def _follow_pointer(self) -> None:
        """Put the object where the pointer has dragged it since the last look."""
        while self.drags:
            phase, start, end, camera, turning = self.drags.popleft()
            if phase == "start" or self._held is None:
                usual = self._usual.hand.data.qpos[self._object]
                self._held = (self.place, self.place.moved_pose(usual)[:3], start)
            before, middle, grabbed = self._held
            pointer = on_plane(camera, end, float(grabbed[2]))
            if pointer is not None:
                self.put(dragged(before, middle, grabbed, pointer, turning))
            if phase == "end":
                self._held = None


def verdict_of(run: Rollout) -> str:
    """Say how a run ended."""
    outcome = run.outcome
    return "success" if outcome.success else f"failed, {outcome.reason}"


def _forces_at(run: Rollout, row: int) -> str:
    most = float(np.quantile(run.contact_force, 0.99))
    return force_rows(run.contact_force[row], CONTACT_PARTS, run.outcome.need_n, most)


def _at(place: TablePlace) -> str:
    if place == TablePlace():
        return ""
    return f" at {place.x:+.0f}, {place.y:+.0f} mm, {place.turn:+.0f} deg"
