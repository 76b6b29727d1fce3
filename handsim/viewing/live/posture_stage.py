"""The hands alone, upright and side by side: in postures of the subspace, or in physics."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from handsim.joints import JOINT_NAMES
from handsim.types import Array, HandSize
from handsim.viewing.film.posture_clips import posture_clip, posture_model
from handsim.viewing.live.puppet import Puppet
from handsim.viewing.live.pushing.loop_hand import LoopHand
from handsim.viewing.live.pushing.push_controls import PushControls
from handsim.viewing.live.shown import SPACING, ShownController, View
from handsim.viewing.live.subspace.subspace_panel import SubspacePanel

if TYPE_CHECKING:
    import viser

_GHOST = 0.35
"""Opacity of a recorded hand beside the controller's."""
_LABEL_HEIGHT = 0.225
"""Of the names over the hands [m]."""
_PULLED = (213, 94, 0)
_ALONE: View = ((0.80, 0.56, 0.29), (0.09, -0.10, 0.05))
_RIGHT = np.array([-0.67, 0.74, 0.0])
"""To the right as the camera sees it."""


class PostureStage:
    """Shows a hand for each controller, and the ghost of a recording.

    Parameters
    ----------
    server
    shown
        The controllers.
    panel
        The subspace, which says where they are.
    controls
        Of the loop.
    """

    def __init__(
        self,
        server: "viser.ViserServer",
        shown: Sequence[ShownController],
        panel: SubspacePanel,
        controls: PushControls,
    ) -> None:
        self._server, self._shown, self._panel, self.controls = server, shown, panel, controls
        self._n_made = 0
        self.size: HandSize | None = None
        self.puppets: list[Puppet] = []
        self.ghost: Puppet | None = None
        self.loops: list[LoopHand] = []
        self._labels: list[viser.LabelHandle] = []
        self._lines: dict[int, viser.LineSegmentsHandle] = {}

    @property
    def view(self) -> View:
        """The camera's place: farther away the more hands there are."""
        n = len(self._shown)
        middle = 0.8 * (n - 1) * SPACING * _RIGHT  # farther right they stand behind a panel
        place, target = (np.array(each) for each in _ALONE)
        back = (1.0 + 0.22 * (n - 1)) * (place - target)
        return tuple(target + middle + back), tuple(target + middle)

    def show(self, size: HandSize) -> None:
        """Put hands of a size on the page; what is there already stays."""
        if self.size == size:
            return
        self.remove()
        self.size = size
        model = posture_model(size)
        self._model = model
        for i, each in enumerate(self._shown):
            self._n_made += 1  # a name used again would keep the pose of what had it before
            place = tuple(i * SPACING * _RIGHT)
            puppet = Puppet(self._server, f"/hand_{self._n_made}", model, place=place)
            self.controls.watch(i, puppet)
            self.puppets.append(puppet)
            if len(self._shown) > 1:
                top = (*place[:2], _LABEL_HEIGHT)
                self._labels.append(
                    self._server.scene.add_label(f"/name_{self._n_made}", each.name, position=top)
                )

    def remove(self) -> None:
        """Take everything off the page."""
        self.stop()
        for handle in (*self.puppets, *self._labels):
            handle.remove()
        if self.ghost is not None:
            self.ghost.remove()
        self.size, self.ghost = None, None
        self.puppets, self._labels = [], []

    def place(self) -> None:
        """Move hands and ghost to where the subspace says."""
        for puppet, q in zip(self.puppets, self._panel.postures, strict=True):
            puppet.place(self._qpos(q))
        ghost = self._panel.ghost
        if ghost is not None:
            if self.ghost is None:
                name = f"/ghost_{self._n_made}"
                self.ghost = Puppet(self._server, name, self._model, _GHOST)
            self.ghost.place(self._qpos(ghost))
        if self.ghost is not None:
            self.ghost.show(ghost is not None)

    def _qpos(self, q: Array) -> Array:
        return posture_clip(np.zeros(1), q[None], self._model).qpos[0]

    def start(self) -> None:
        """Begin the loop of each hand: from its start to its destination, in physics.

        Raises
        ------
        InputError
            If a controller cannot go to the destination.
        """
        self._end()
        self.loops = [
            LoopHand(each.controller, self._model, state.start, state.goal)
            for each, state in zip(self._shown, self._panel.states, strict=True)
        ]
        self._starts = [state.start for state in self._panel.states]
        self.controls.begin()

    def follow(self) -> None:
        """Let running loops go on to where the destination is now; begin again from another start.

        Raises
        ------
        InputError
            If a controller cannot go there.
        """
        states = self._panel.states
        if any(
            not np.array_equal(before, state.start)
            for before, state in zip(self._starts, states, strict=True)
        ):
            self.start()
            return
        for loop, state in zip(self.loops, states, strict=True):
            if not np.array_equal(loop.z_goal, state.goal):
                loop.redirect(state.goal)

    def stop(self) -> None:
        """End the loops, and let go of the hands."""
        self._end()
        self.controls.clear()

    def _end(self) -> None:
        self.loops = []
        for line in self._lines.values():
            line.remove()
        self._lines.clear()

    def advance(self, elapsed: float) -> str:
        """Simulate the loops, show where they are, and return what there is to say."""
        self.controls.advance(self.loops, [puppet.origin for puppet in self.puppets], elapsed)
        for i, (loop, puppet) in enumerate(zip(self.loops, self.puppets, strict=True)):
            puppet.place(loop.qpos)
            self._draw_line(i, self.controls.line(i, loop, puppet.origin))
        first = self.loops[0]
        self._panel.scene.show_here(first.place, np.array(first.trail or [first.place]))
        return self.controls.said(self.loops, elapsed)

    def _draw_line(self, hand: int, line: Array | None) -> None:
        """Draw a line from a pointer to what it pulls at."""
        before = self._lines.pop(hand, None)
        if before is not None:
            before.remove()
        if line is not None:
            self._lines[hand] = self._server.scene.add_line_segments(
                f"/pull_{hand}", line[None].astype(np.float32), _PULLED, thickness=4.0,
                thickness_units="screen",
            )  # fmt: skip


def joint_difference(postures: Sequence[Array]) -> str:
    """Say how far hands differ at most from the first, and in which joint."""
    if len(postures) < 2:
        return ""
    apart = [np.abs(q - postures[0]) for q in postures[1:]]
    worst = max(apart, key=lambda each: float(each.max()))
    joint, most = JOINT_NAMES[int(worst.argmax())], np.rad2deg(worst.max())
    return (
        f"They differ by up to {most:.0f} deg ({joint})." if most >= 0.5 else "They are the same."
    )
