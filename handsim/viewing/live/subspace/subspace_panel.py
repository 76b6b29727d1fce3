"""The controls of the subspace on the page, kept in step with its handles.

Components and handles say the same thing in two ways. Whichever a person has moved since the last
look wins, and the other is moved after it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from handsim.errors import UnknownNameError
from handsim.learning.controller import GraspController
from handsim.recordings.recording import Recording
from handsim.types import Array
from handsim.viewing.live.subspace.subspace_scene import SubspaceScene
from handsim.viewing.live.subspace.subspace_state import (
    FIELDS,
    SubspaceState,
    carried_over,
    ghost_posture,
    read_state,
    seen_from,
    state_values,
    way,
)

if TYPE_CHECKING:
    import viser

NO_RECORDING = "none"
FIELD_DELAY_S = 0.25
"""How long the destination has to stand still before phi is drawn about it again [s]."""


class SubspacePanel:
    """Controls and picture of the subspace; `step` reads them once a frame.

    Parameters
    ----------
    server
    controllers
        The box is the subspace of the first. The others go from the same posture to the same one,
        each in its own subspace.
    recordings
        Shown in the subspace, and as ghosts beside the hand.

    Attributes
    ----------
    state
        Start, destination and place on the way, in the subspace of the first controller.
    paths : (m, n_components) [rad] each
        Of each controller, in its own subspace.
    said
        Why there is no path, or why it is not quite the same.
    """

    def __init__(
        self,
        server: "viser.ViserServer",
        controllers: Sequence[GraspController],
        recordings: Sequence[Recording] = (),
    ) -> None:
        self._controllers, controller = controllers, controllers[0]
        self._recordings = {recording.name: recording for recording in recordings}
        self._recorded = {r.name: controller.subspace.transform(r.q) for r in recordings}
        obstacle = controller.navigation.obstacle
        self._low, self._high = obstacle.lower, obstacle.upper
        goal = np.clip(controller.demonstrations[0].z_goal, self._low, self._high)
        self._usual = SubspaceState(np.zeros(len(goal)), goal)
        self.state = self._usual
        learned = [d.path for d in controller.demonstrations if d.path is not None]
        shown = tuple(self._recorded.values()) or learned  # a controller keeps their paths
        self.scene = SubspaceScene(server, controller.navigation, shown)
        self._add_controls(server.gui)
        self._field_shown: tuple[str, tuple[float, ...]] | None = None
        self._still = 0.0
        self._find_ways()
        self._write()

    def _add_controls(self, gui: "viser.GuiApi") -> None:
        state = self.state
        bounds = np.rad2deg(np.column_stack([self._low, self._high])).round(1)
        with gui.add_folder("Posture") as posture:
            self.components = [
                gui.add_slider(f"PC {i + 1} [deg]", float(low), float(high), 0.1, 0.0)
                for i, (low, high) in enumerate(bounds)
            ]
        with gui.add_folder("Way to the destination") as way_to:
            self.share = gui.add_slider("share of the way", 0.0, 1.0, 0.005, state.share)
            self.field = gui.add_dropdown("field", FIELDS, initial_value=state.field)
            names = (NO_RECORDING, *self._recordings)
            self.recording = gui.add_dropdown("ghost", names, initial_value=state.recording)

        self._folders = (posture, way_to)

    def show(self, visible: bool) -> None:
        """Show or hide subspace and controls: beside a scene there is no room for them."""
        self.scene.show(visible)
        for folder in self._folders:
            folder.visible = visible

    def step(self, elapsed: float) -> bool:
        """Read the controls; return whether the hand is to be shown anew."""
        before = self.state
        state = replace(
            before.moved(self._start(), self._goal(), float(self.share.value)),
            field=str(self.field.value),
            recording=str(self.recording.value),
        )
        self._still += elapsed
        changed = state_values(state) != state_values(before)
        if changed:
            self.apply(state)
        self._show_field()
        return changed

    def apply(self, state: SubspaceState) -> None:
        """Show a state, and move all controls to it."""
        before, self.state = self.state, state
        if state.start is not before.start or state.goal is not before.goal:
            self._find_ways()
        if not np.array_equal(state.goal, before.goal):
            self._still = 0.0
        self._write()

    def read(self, given: Mapping[str, str]) -> SubspaceState:
        """Return the state that a link gives; what it leaves out stays as it is at first.

        Raises
        ------
        InputError
            If a value makes no sense.
        UnknownNameError
            If there is no such recording.
        """
        state = read_state(given, self._usual, self._low, self._high)
        if state.recording != NO_RECORDING and state.recording not in self._recordings:
            raise UnknownNameError("recording", state.recording, tuple(self._recordings))
        return state

    @property
    def postures(self) -> list[Array]:
        """The hands' joint angles, (22,) [rad] each."""
        return [
            controller.subspace.inverse_transform(state.place(path))
            for controller, state, path in zip(
                self._controllers, self.states, self.paths, strict=True
            )
        ]

    @property
    def ghost(self) -> Array | None:
        """Those of the recording at the same share of its way; None where none is chosen."""
        chosen = self._recordings.get(self.state.recording)
        if chosen is None:
            return None
        return ghost_posture(chosen, self._recorded[chosen.name], self.state.share)

    def _start(self) -> Array:
        """Return the start as the components or its handle have it, whichever was moved."""
        sliders = tuple(float(slider.value) for slider in self.components)
        if sliders != self._sliders:
            return np.clip(np.deg2rad(sliders), self._low, self._high)
        return self._dragged(self.scene.start, self.state.start)

    def _goal(self) -> Array:
        return self._dragged(self.scene.goal, self.state.goal)

    def _dragged(self, handle: "viser.TransformControlsHandle", known: Array) -> Array:
        """Return where a handle is, exactly what is known unless it was moved."""
        place = self.scene.frame.to_page(known[None])[0]
        if np.allclose(handle.position, place, atol=1e-5):
            return known
        return self.scene.frame.to_subspace(np.asarray(handle.position), known)

    def _find_ways(self) -> None:
        """Find the way of each controller."""
        first = self._controllers[0]
        carried = [carried_over(self.state, first, each) for each in self._controllers]
        found = [
            way(each, state) for each, (state, _) in zip(self._controllers, carried, strict=True)
        ]
        self._states = [state for state, _ in carried]
        self.paths = [path for path, _ in found]
        self.said = " ".join(said for pair in (found, carried) for _, said in pair if said)

    @property
    def states(self) -> list[SubspaceState]:
        """The state in the subspace of each controller."""
        shown = self.state
        return [replace(each, at=shown.at, share=shown.share) for each in self._states]

    def _write(self) -> None:
        """Move all controls and handles to the state."""
        state = self.state
        for slider, angle in zip(self.components, np.rad2deg(state.start), strict=True):
            slider.value = min(max(round(float(angle), 1), slider.min), slider.max)
        self._sliders = tuple(float(slider.value) for slider in self.components)
        self.share.value = state.share
        self.field.value, self.recording.value = state.field, state.recording
        first = self._controllers[0]
        ways = [
            seen_from(first, each, path)
            for each, path in zip(self._controllers, self.paths, strict=True)
        ]
        self.scene.show_way(state.start, state.goal, ways, state.place(self.paths[0]))

    def _show_field(self) -> None:
        """Draw the field about the destination once that stands still."""
        wanted = (self.state.field, tuple(self.state.goal))
        if wanted == self._field_shown:
            return
        before = self._field_shown
        if before is None or before[0] != wanted[0] or self._still >= FIELD_DELAY_S:
            self._field_shown = wanted
            self.scene.show_field(self.state.field, self.state.goal)
