"""A web page that shows and moves the hand, for machines without a display.

It has sliders for the principal components and the size of the hand, the subspace with the way to a
destination beside the hand, a loop that can be pushed, menus of objects and tasks, an object that
is put where one likes, and buttons that simulate a grasp and play it. Two controllers or more stand
side by side. A link shows the same again. One thread reads all controls once a frame, so that no
two actions run at the same time.
"""

import io
import socket
import time
from collections.abc import Sequence
from contextlib import redirect_stdout
from dataclasses import replace

from handsim.errors import HandsimError, InputError, MissingToolError
from handsim.tasks.table_one import task_by_name
from handsim.types import MEDIAN_HAND, HandSize
from handsim.viewing.live.front import Front
from handsim.viewing.live.grasp_stage import NO_TASK, GraspStage
from handsim.viewing.live.page_camera import PageCamera
from handsim.viewing.live.posture_stage import PostureStage, joint_difference
from handsim.viewing.live.pushing.push_controls import PushControls
from handsim.viewing.live.shown import ShownController
from handsim.viewing.live.subspace.subspace_panel import SubspacePanel
from handsim.viewing.live.subspace.subspace_state import state_values
from handsim.viewing.live.view_text import (
    BREADTHS_MM,
    LENGTHS_MM,
    PageView,
    link_html,
    read_view,
    view_text,
)
from handsim.wording import number_of

RATE = 30.0
"""How often the controls are read and the hand is moved [1/s]."""
MOST_SHOWN = 4
"""Controllers side by side; more would be too small to look at."""
INSTALL = "pip install 'handsim[viewer]'"


class LivePage:
    """The page and its server; `step` brings it up to date and is called once a frame.

    Parameters
    ----------
    shown
        The controllers. The first one's subspace is what the sliders move in.
    host, port
        Address of the page. If the port is taken, the next free one is used.
    task
        The task that is selected when the page opens.
    text
        The view that the page begins with, as a page gives it, or a link to one.

    Raises
    ------
    InputError
        If there are no controllers or more than `MOST_SHOWN`, or the text or the address makes no
        sense.
    MissingToolError
        If viser is not installed.
    """

    def __init__(
        self,
        shown: Sequence[ShownController],
        host: str = "127.0.0.1",
        port: int = 8080,
        task: str | None = None,
        text: str | None = None,
    ) -> None:
        try:
            import viser
        except ImportError as error:
            raise MissingToolError(f"the page needs viser; run: {INSTALL}") from error
        check_number(len(shown))
        chosen = NO_TASK if task is None else task_by_name(task).name
        self._shown, self._names = shown, tuple(each.name for each in shown)
        with redirect_stdout(io.StringIO()):  # it greets there whatever it is told
            self._server = viser.ViserServer(host="127.0.0.1", port=_free_port(), verbose=False)
        try:
            self._front = Front(host, port, self._server.get_port())
        except InputError:
            self._stop_server()
            raise
        self._asked: PageView | None = None
        try:
            self._build(chosen, text)
        except HandsimError:
            self.close()
            raise

    def _build(self, chosen: str, text: str | None) -> None:
        """Put everything on the page."""
        server, shown = self._server, self._shown
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        self._camera = PageCamera(server)
        self.status = server.gui.add_markdown("")
        recordings = [recording for each in shown for recording in each.recordings]
        self.panel = SubspacePanel(server, [each.controller for each in shown], recordings)
        self.pushing = PushControls(server.gui, self._names)
        with server.gui.add_folder("Hand", expand_by_default=False):
            self.length = server.gui.add_slider("length [mm]", *LENGTHS_MM, 1, _mm(MEDIAN_HAND)[0])
            breadth = _mm(MEDIAN_HAND)[1]
            self.breadth = server.gui.add_slider("breadth [mm]", *BREADTHS_MM, 1, breadth)
        self.postures = PostureStage(server, shown, self.panel, self.pushing)
        self.grasps = GraspStage(server, shown)
        with server.gui.add_folder("This view"):
            self.link = server.gui.add_text("view", "", hint="Copy it, or paste another one here.")
            self.link_shown = server.gui.add_html("")
        self._linked = ""
        if text is not None:
            self._ask(text)
            if self._asked is not None and self._asked.task is None and chosen != NO_TASK:
                self._asked = replace(self._asked, task=chosen)
        self._seen = self._choices()
        self._show_postures()
        self.grasps.choose(chosen)
        self._apply_asked()

    @property
    def address(self) -> str:
        """Address of the page for a browser."""
        return f"http://{self._front.host}:{self._front.port}"

    def close(self) -> None:
        """Stop serving."""
        self._front.close()
        self._stop_server()

    def _stop_server(self) -> None:
        with redirect_stdout(io.StringIO()):
            self._server.stop()

    def step(self, elapsed: float) -> None:
        """Read the controls, and advance what is in motion by ``elapsed`` [s]."""
        try:
            self._read_links()
            self.grasps.offer()
            self._follow_choices(self.panel.step(elapsed))
            self._apply_asked()
            self._advance(elapsed)
        except HandsimError as error:
            self.say(str(error))
        self._write_link()

    def _advance(self, elapsed: float) -> None:
        """Advance the grasp that is played, or the loop."""
        if self._seen[1] != NO_TASK:
            said = self.grasps.advance(elapsed)
            if said is not None:
                self.say(said)
            return
        if self.grasps.pressed:
            self.grasps.pressed.clear()
            raise InputError("Choose a task first.")
        if not self.pushing.wanted:
            if self.postures.loops:
                self.postures.stop()
                self._show_postures()
            return
        try:
            if not self.postures.loops or self.pushing.restart:
                self.postures.start()
            self.postures.follow()
            self.say(self.postures.advance(elapsed))
        except HandsimError:
            self.pushing.running.value = False
            self.postures.stop()
            raise

    def _follow_choices(self, moved: bool) -> None:
        """Show the choice if it has changed; moving in the subspace deselects the task."""
        size, task = choices = self._choices()
        before, self._seen = self._seen, choices
        if choices == before and not moved:
            return
        if task != NO_TASK and not moved:
            self._show_scene()
            return
        if task != NO_TASK:
            self.grasps.task.value = NO_TASK
        self._seen = (size, NO_TASK)
        self._show_postures()

    def _choices(self) -> tuple[HandSize, str]:
        """Return the size of the hand and the task that are chosen."""
        chosen = (int(self.length.value), int(self.breadth.value))
        size = HandSize(chosen[0] / 1000, chosen[1] / 1000)
        return MEDIAN_HAND if chosen == _mm(MEDIAN_HAND) else size, str(self.grasps.task.value)

    def _show_postures(self) -> None:
        """Show the hands alone, where they are in the subspace."""
        with self._server.atomic():
            self.grasps.remove()
            self.postures.show(self._seen[0])
            self.panel.show(True)
            self.pushing.show(True)
            if not self.postures.loops:
                self.postures.place()
        self._camera.look(self.postures.view)
        if self.postures.loops:
            return
        state = self.panel.state
        where = {"start": "A posture of the subspace.", "goal": "The destination."}
        said = where.get(state.at, f"{100 * state.share:.0f} % of the way to the destination.")
        if state.at == "start" and not state.start.any():
            said = "The mean posture."
        said = f"{said} {joint_difference(self.panel.postures)}".rstrip()
        self.say(f"{said} {self.panel.said}".rstrip())

    def _show_scene(self) -> None:
        """Show the scene of the task that is chosen, before the grasp."""
        size, task = self._seen
        with self._server.atomic():
            self.postures.remove()
            self.panel.show(False)
            self.pushing.show(False)
            said = self.grasps.show(task, size)
        self._camera.look(self.grasps.view)
        self.say(said)

    def _read_links(self) -> None:
        """Take the view of a link that was opened, or that somebody has pasted."""
        while self._front.asked:
            self._ask(self._front.asked.popleft())
        if self.link.value != self._linked:
            self._linked = self.link.value
            self._ask(self._linked)

    def _ask(self, text: str) -> None:
        view = read_view(text, self._names)
        self.panel.read(view.subspace)  # so that nothing changes where a part makes no sense
        self._asked = view

    def _apply_asked(self) -> None:
        """Show the view that was asked for."""
        view, self._asked = self._asked, None
        if view is None:
            return
        self.length.value, self.breadth.value = _mm(view.size)
        self.panel.apply(self.panel.read(view.subspace))
        self.grasps.put(view.place)
        self.grasps.choose(view.task or NO_TASK)
        self.pushing.running.value = view.loop
        self._seen = self._choices()
        if self._seen[1] == NO_TASK:
            self._show_postures()
        else:
            self._show_scene()
        if view.camera is not None:
            self._camera.put(view.camera)
        if view.task is not None and view.time > 0:
            self.grasps.grasp()
            self.grasps.playing = False
            self.say(self.grasps.go_to(view.time))

    def _write_link(self) -> None:
        """Say how this view can be had again."""
        self._camera.settle()
        if self.grasps.playing:  # the text would change with every frame
            return
        text = view_text(self._shown_view())
        whole = f"{self.address}/?{text}"
        if whole != self._linked:
            self.link.value = self._linked = whole
            self.link_shown.content = link_html(text)

    def _shown_view(self) -> PageView:
        """Return what is shown."""
        size, task = self._seen
        return PageView(
            state_values(self.panel.state),
            size,
            None if task == NO_TASK else task,
            self.grasps.place if task != NO_TASK else PageView().place,
            self.grasps.time,
            bool(self.pushing.running.value),
            self._camera.place,
            self._names if len(self._names) > 1 else (),
        )

    def say(self, text: str) -> None:
        """Say something below the controls."""
        if self.status.content != text:
            self.status.content = text


def check_number(n_shown: int) -> None:
    """Raise InputError where a page cannot show so many controllers."""
    if not 1 <= n_shown <= MOST_SHOWN:
        raise InputError(f"{number_of(n_shown, 'controller')}; give 1 to {MOST_SHOWN}")


def _mm(size: HandSize) -> tuple[int, int]:
    return round(1000 * size.length), round(1000 * size.breadth)


def _free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


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
