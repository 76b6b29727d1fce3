"""The cameras of those who look at the page: where they begin, and where people have moved them."""

import time
from typing import TYPE_CHECKING

import numpy as np

from handsim.viewing.live.shown import View
from handsim.viewing.live.view_text import close_to

if TYPE_CHECKING:
    import viser

_FIELD_OF_VIEW = np.deg2rad(36.0)  # vertical, as of the scenes' own cameras
_STILL_S = 0.3
"""How long a camera has to stand still before its place is told [s]."""


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
        clients = self._server.get_clients().values()
        for camera in (self._server.initial_camera, *(client.camera for client in clients)):
            camera.position, camera.look_at = map(np.array, view)

    def _watch(self, client: "viser.ClientHandle") -> None:
        """Note where people move the camera."""

        def moved(camera: "viser.CameraHandle") -> None:
            place = (*map(float, camera.position), *map(float, camera.look_at))
            self._seen = (time.monotonic(), place)

        if self._aimed is not None:  # one that came between two views does not know the second
            client.camera.position, client.camera.look_at = map(np.array, self._aimed)
        client.camera.on_update(moved)
