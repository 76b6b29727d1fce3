"""The controls of the loop on the page: run it, push a finger, pull at one with the pointer."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from handsim.joints import FINGERS
from handsim.types import Array
from handsim.viewing.live.puppet import Puppet
from handsim.viewing.live.pushing.loop_hand import LoopHand
from handsim.viewing.live.pushing.off_trace import off_trace, return_words
from handsim.viewing.live.pushing.pushes import MOST_FORCE, PUSH_S, PadPush, Pull, Push, finger_of

if TYPE_CHECKING:
    import viser

USUAL_FORCE = 20.0
"""Of a push on a pad when the page opens [N]."""
TRACE_EVERY_S = 0.1
"""How often the picture of the deviation is drawn anew [s]."""


@dataclass(frozen=True, eq=False)
class Grab:
    """A pointer that holds a body of a hand.

    Attributes
    ----------
    hand
        Which of the hands.
    body
        Id of its body.
    held, target : (3,) [m]
        Where it took hold, and where it is now, on the page.
    begins
        Whether it has just taken hold.
    """

    hand: int
    body: int
    held: Array
    target: Array
    begins: bool


class PushControls:
    """The controls, and what pushes the hands at a time.

    Parameters
    ----------
    gui
    names
        Of the hands.

    Attributes
    ----------
    grabs
        What pointers hold, by hand; written by the server's thread, read once a frame.
    asked
        Fingers that are to be pushed.
    """

    def __init__(self, gui: "viser.GuiApi", names: Sequence[str]) -> None:
        self._names = names
        with gui.add_folder("Push", expand_by_default=True) as self._folder:
            self.running = gui.add_checkbox(
                "run the loop", False,
                hint="The hand in physics, under its controller. Pull at a finger.",
            )  # fmt: skip
            self.force = gui.add_slider("force [N]", 1.0, MOST_FORCE, 1.0, USUAL_FORCE)
            self._fingers = gui.add_button_group("push", FINGERS)
            self.speed = gui.add_slider("speed", 0.1, 1.0, 0.1, 1.0)
            self._again = gui.add_button("start again")
            self._trace = gui.add_html("")
        self.asked: list[str] = []
        self.restart = False
        self.grabs: dict[int, Grab | None] = {}
        self._pulls: dict[int, Pull] = {}
        self._pushes: list[Push] = []
        self._undrawn = 0.0
        self._fingers.on_click(lambda _: self.asked.append(str(self._fingers.value)))
        self._again.on_click(lambda _: setattr(self, "restart", True))

    def show(self, visible: bool) -> None:
        """Show or hide them all."""
        self._folder.visible = visible

    def begin(self) -> None:
        """Forget what pushed hands that were there before."""
        self._pulls.clear()
        self._pushes.clear()
        self.restart, self._undrawn = False, TRACE_EVERY_S

    def watch(self, hand: int, puppet: Puppet) -> None:
        """Let pointers take hold of the fingers of a hand."""
        for body, meshes in puppet.geoms.items():
            if finger_of(puppet.model.body(body).name) is None:
                continue
            for mesh in meshes:
                mesh.on_drag(self._grabbing(hand, body))

    def advance(self, loops: Sequence[LoopHand], origins: Sequence[Array], elapsed: float) -> None:
        """Simulate the next part of all hands, pushed as the controls say.

        Parameters
        ----------
        loops
            The hands.
        origins : (3,) [m] each
            Of their models on the page.
        elapsed
            Since the latest part [s].
        """
        elapsed *= float(self.speed.value)
        self._pushes = [push for push in self._pushes if push.until > loops[0].time]
        while self.asked:
            until = loops[0].time + PUSH_S
            self._pushes.append(PadPush(self.asked.pop(0), float(self.force.value), until))
        for i, (loop, origin) in enumerate(zip(loops, origins, strict=True)):
            pull = self._pull(i, loop, origin)
            loop.advance(elapsed, self._pushes if pull is None else [*self._pushes, pull])

    def line(self, hand: int, loop: LoopHand, origin: Array) -> Array | None:
        """Return the line (2, 3) [m] between what is held of a hand and the pointer."""
        pull = self._pulls.get(hand)
        return None if pull is None else np.array([pull.held(loop.data), pull.target]) + origin

    def said(self, loops: Sequence[LoopHand], elapsed: float) -> str:
        """Draw the deviations, and say what the latest push did to each hand."""
        self._undrawn += elapsed
        if self._undrawn >= TRACE_EVERY_S:
            self._undrawn = 0.0
            self._trace.content = off_trace([list(loop.past) for loop in loops], self._names)
        words = [return_words(list(loop.past)) for loop in loops]
        if len(loops) == 1:
            return words[0] or "Pull at a finger, or press its button."
        return "  \n".join(
            f"{name}: {each}" for name, each in zip(self._names, words, strict=True) if each
        )

    def clear(self) -> None:
        """Draw no deviation, and let go of everything."""
        self.asked.clear()
        self.grabs.clear()
        self._trace.content = ""

    @property
    def wanted(self) -> bool:
        """Whether the loop is to run: it begins by itself when a finger is pushed."""
        pushed = bool(self.asked) or any(grab is not None for grab in tuple(self.grabs.values()))
        if pushed and not self.running.value:
            self.running.value = True
        return bool(self.running.value)

    def _pull(self, hand: int, loop: LoopHand, origin: Array) -> Pull | None:
        """Return the pull at a hand: a spring from where it was taken to the pointer."""
        grab = self.grabs.get(hand)
        if grab is None:
            self._pulls.pop(hand, None)
            return None
        target, known = grab.target - origin, self._pulls.get(hand)
        if known is None or grab.begins:
            self._pulls[hand] = Pull.at(loop.data, grab.body, grab.held - origin, target)
            self.grabs[hand] = Grab(hand, grab.body, grab.held, grab.target, begins=False)
        else:
            self._pulls[hand] = Pull(grab.body, known.point, target)
        return self._pulls[hand]

    def _grabbing(self, hand: int, body: int):  # noqa: ANN202 - viser's own type of callback
        # Coroutines run in the order of the events; other callbacks may overtake each other.
        async def grabbed(event: "viser.SceneNodeDragEvent[viser.MeshHandle]") -> None:
            if event.phase == "end":
                self.grabs[hand] = None
                return
            held, target = np.array(event.start_position), np.array(event.end_position)
            begins = self.grabs.get(hand) is None
            self.grabs[hand] = Grab(hand, body, held, target, begins)

        return grabbed
