"""The cameras of those who look at the page: where they begin, and where people have moved them."""

import time
from typing import TYPE_CHECKING

import numpy as np

from handsim.viewing.live.shown import View
from handsim.viewing.live.view_text import close_to

if TYPE_CHECKING:
    import viser

_FIELD_OF_VIEW = np.deg2rad(36.0)  # vertical, as of the scenes' own cameras
_WIDE_ENOUGH = 1.3
"""Width by height of a window in which a view is seen whole, beside the panel of controls."""
_RAISED = 0.24
"""How far a view is moved up in a narrow window, as a share of its height."""
_STILL_S = 0.3
"""How long a camera has to stand still before its place is told [s]."""


def fitted(view: View, aspect: float) -> View:
    """Return a view for a window of an aspect, width by height.

    Where it is narrower than `_WIDE_ENOUGH`, all is seen from farther away, and in the upper part:
    the panel of controls covers the lower one.
    """
    narrow = max(1.0, _WIDE_ENOUGH / aspect)
    place, target = (np.array(each) for each in view)
    away = narrow * (place - target)
    seen = 2.0 * float(np.linalg.norm(away)) * np.tan(0.5 * _FIELD_OF_VIEW)  # from top to bottom
    lower = np.array([0.0, 0.0, _RAISED * min(narrow - 1.0, 1.0) * seen])
    x, y, z, *rest = (*(target - lower + away).tolist(), *(target - lower).tolist())
    return (x, y, z), (rest[0], rest[1], rest[2])


class PageCamera:
    """Aims the cameras of all clients, and knows where the latest one was moved.

    Parameters
    ----------
    server

    Attributes
    ----------
    place
        Position and the point looked at [m], where a camera was moved from the usual place.
    """

    def __init__(self, server: "viser.ViserServer") -> None:
        self._server = server
        server.initial_camera.fov = _FIELD_OF_VIEW
        self._usual: View | None = None
        self._aimed: View | None = None
        self._seen: tuple[float, tuple[float, ...]] | None = None
        self._sent: dict[int, tuple[float, ...]] = {}
        self.place: tuple[float, ...] | None = None
        server.on_client_connect(self._watch)

    def look(self, view: View) -> None:
        """Move the cameras, unless the same view was shown before: people may have moved them."""
        if view == self._usual:
            return
        self._usual, self.place = view, None
        self._aim(view)

    def put(self, place: tuple[float, ...]) -> None:
        """Move the cameras to the place of a link."""
        self.place = place
        x, y, z, *target = place
        self._aim(((x, y, z), (target[0], target[1], target[2])))

    def settle(self) -> None:
        """Take note of a camera that has come to a stand."""
        seen = self._seen
        if seen is None or time.monotonic() - seen[0] <= _STILL_S:
            return
        self._seen, self.place = None, seen[1]
        if self._usual is not None and close_to(self.place, (*self._usual[0], *self._usual[1])):
            self.place = None

    def _aim(self, view: View) -> None:
        self._aimed, self._seen = view, None
        first = self._server.initial_camera
        first.position, first.look_at = map(np.array, view)
        for client in self._server.get_clients().values():
            self._send(client)

    def _send(self, client: "viser.ClientHandle") -> None:
        """Aim the camera of one client, from farther away where its window is narrow."""
        assert self._aimed is not None
        view = self._aimed if self.place is not None else fitted(self._aimed, client.camera.aspect)
        self._sent[client.client_id] = (*view[0], *view[1])
        client.camera.position, client.camera.look_at = map(np.array, view)

    def _watch(self, client: "viser.ClientHandle") -> None:
        """Note where people move the camera."""

        def moved(camera: "viser.CameraHandle") -> None:
            place = (*map(float, camera.position), *map(float, camera.look_at))
            if not close_to(place, self._sent.get(client.client_id)):
                self._seen = (time.monotonic(), place)

        if self._aimed is not None:  # one that came between two views does not know the second
            self._send(client)
        client.camera.on_update(moved)
