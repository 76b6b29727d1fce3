"""The subspace in three dimensions on a page: recordings, the way to a destination, and phi.

Start and destination are handles that people drag.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from handsim.errors import InputError
from handsim.navigation.function import NavigationFunction
from handsim.types import Array
from handsim.viewing.figures.slices import level_shell, slice_through
from handsim.viewing.live.subspace.subspace_state import SubspaceFrame

if TYPE_CHECKING:
    import viser

_PLACE, _TURN_DEG = (0.20, -0.235, 0.06), 130.6
"""Where the box stands beside the hand, and its turn about the vertical, which faces the camera."""
_RECORDED, _WAY, _START, _GOAL = (86, 180, 233), (213, 94, 0), (0, 158, 115), (213, 94, 0)
_HERE, _EDGES, _TRAIL = (20, 24, 30), (150, 156, 164), (20, 24, 30)
WAY_COLOURS = (_WAY, (0, 114, 178), (204, 121, 167), (0, 158, 115))
"""Colours of the ways of the controllers that are shown, 0 to 255."""
SHELL_LEVEL = 0.2
"""Level set of phi that is drawn about the destination."""
_SHELL_RAYS, _SLICE_POINTS, _TRAIL_POINTS = 15, 61, 200


class SubspaceScene:
    """Draws the subspace and reads its handles.

    Parameters
    ----------
    server
    navigation
        Its workspace is the box.
    recorded : (m, n) [rad] each
        Recorded paths.
    """

    def __init__(
        self,
        server: "viser.ViserServer",
        navigation: NavigationFunction,
        recorded: Sequence[Array],
    ) -> None:
        self._scene, self._navigation = server.scene, navigation
        self.frame = SubspaceFrame(navigation.obstacle.lower, navigation.obstacle.upper)
        half = 0.5 * np.deg2rad(_TURN_DEG)
        self._root = self._scene.add_frame(
            "/subspace",
            show_axes=False,
            position=_PLACE,
            wxyz=(np.cos(half), 0.0, 0.0, np.sin(half)),
        )
        self._add_box()
        lines = [segments(self.frame.to_page(path)) for path in recorded if len(path) > 1]
        if lines:
            self._lines("recordings", np.concatenate(lines), _RECORDED, 1.5)
        self.start, self.goal = self._handle("start", _START), self._handle("goal", _GOAL)
        self._here = self._ball("here", _HERE, 0.006)
        self._field: list[viser.SceneNodeHandle] = []
        self._trail: viser.SceneNodeHandle | None = None

    def show(self, visible: bool) -> None:
        """Show or hide it all: beside a scene there is no room for it."""
        self._root.visible = visible

    def show_way(self, start: Array, goal: Array, ways: Sequence[Array], here: Array) -> None:
        """Draw the ways, the place of the hand, and put the handles where they belong."""
        for handle, z in ((self.start, start), (self.goal, goal)):
            place = self.frame.to_page(z[None])[0]
            if not np.allclose(handle.position, place, atol=1e-6):
                handle.position = place
        self.show_here(here)
        for i, way in enumerate(ways):
            colour = WAY_COLOURS[i % len(WAY_COLOURS)]
            self._lines(f"way_{i}", segments(self.frame.to_page(thinned(way))), colour, 3.5)

    def show_here(self, here: Array, trail: Array | None = None) -> None:
        """Put the ball where the hand is (n,) [rad], and draw where it came from (m, n)."""
        self._here.position = self.frame.to_page(here[None])[0]
        if self._trail is not None:
            self._trail.remove()
            self._trail = None
        if trail is not None and len(trail) > 1:
            points = segments(self.frame.to_page(thinned(trail, _TRAIL_POINTS)))
            self._trail = self._lines("trail", points, _TRAIL, 2.0)

    def show_field(self, field: str, goal: Array) -> None:
        """Draw a slice of phi or beta through the destination, and for phi a level set about it."""
        for node in self._field:
            node.remove()
        self._field = []
        if field == "none" or self._navigation.n_dimensions < 2:
            return
        plane = slice_through(self._navigation, goal, (0, 1), _SLICE_POINTS)
        values = (
            np.sqrt(plane.phi(self._navigation, goal))
            if field == "φ"
            else stretched(plane.ln_beta(self._navigation))
        )
        size = self.frame.scale * (self.frame.high - self.frame.low)[:2]
        height = self.frame.to_page(goal[None])[0, 2]
        self._field.append(
            self._scene.add_image(
                "/subspace/slice", colours(values)[::-1], *size, position=(0.0, 0.0, height)
            )
        )
        if field == "φ" and self._navigation.n_dimensions == 3:
            self._field.append(self._add_shell(goal))

    def _add_shell(self, goal: Array) -> "viser.MeshHandle":
        shell = level_shell(self._navigation, goal, SHELL_LEVEL, _SHELL_RAYS)
        rows, columns = shell.shape[:2]
        return self._scene.add_mesh_simple(
            "/subspace/shell",
            self.frame.to_page(shell.reshape(-1, 3)).astype(np.float32),
            grid_faces(rows, columns),
            color=colours(np.array([[np.sqrt(SHELL_LEVEL)]]))[0, 0],
            opacity=0.3,
            side="double",
            cast_shadow=False,
        )

    def _add_box(self) -> None:
        corners = np.array(list(np.ndindex(2, 2, 2)))
        pairs = [
            (i, j) for i in range(8) for j in range(i) if abs(corners[i] - corners[j]).sum() == 1
        ]
        low, high = (
            np.pad(each[:3], (0, max(0, 3 - len(each))))
            for each in (self.frame.low, self.frame.high)
        )
        places = (corners - 0.5) * self.frame.scale * (high - low)
        self._lines("box", np.array([[places[i], places[j]] for i, j in pairs]), _EDGES, 1.0)
        ends = {"PC 1": (0.5, -0.5, -0.5), "PC 2": (-0.5, 0.5, -0.5), "PC 3": (-0.5, -0.5, 0.5)}
        for name, end in list(ends.items())[: len(self.frame.low)]:
            place = np.array(end) * self.frame.scale * (high - low)
            self._scene.add_label(f"/subspace/{name}", name, position=place)

    def _lines(
        self, name: str, points: Array, colour: tuple[int, int, int], width: float
    ) -> "viser.LineSegmentsHandle":
        return self._scene.add_line_segments(
            f"/subspace/{name}",
            points.astype(np.float32),
            colour,
            thickness=width,
            thickness_units="screen",
        )

    def _handle(self, name: str, colour: tuple[int, int, int]) -> "viser.TransformControlsHandle":
        handle = self._scene.add_transform_controls(
            f"/subspace/{name}", scale=0.06, disable_rotations=True, depth_test=False
        )
        self._ball(f"{name}/ball", colour, 0.009)
        return handle

    def _ball(
        self, name: str, colour: tuple[int, int, int], radius: float
    ) -> "viser.IcosphereHandle":
        return self._scene.add_icosphere(
            f"/subspace/{name}", radius=radius, color=colour, cast_shadow=False
        )


def segments(points: Array) -> Array:
    """Return the pieces (m - 1, 2, 3) of a line through points (m, 3)."""
    return np.stack([points[:-1], points[1:]], axis=1)


def thinned(path: Array, most: int = 80) -> Array:
    """Return a path with its ends and no more than ``most`` points, all of them its own."""
    return path[np.unique(np.linspace(0, len(path) - 1, min(most, len(path))).round().astype(int))]


def grid_faces(rows: int, columns: int) -> npt.NDArray[np.uint32]:
    """Return the triangles (m, 3) of a surface whose corners lie in rows and columns."""
    corner = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = (
        part.ravel()
        for part in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, :-1], corner[1:, 1:])
    )
    return np.concatenate([np.column_stack([a, c, b]), np.column_stack([b, c, d])]).astype(
        np.uint32
    )


def stretched(values: Array) -> Array:
    """Return values moved to 0 to 1; the least twentieth, where ln beta falls to -inf, is 0."""
    low, high = np.quantile(values, 0.05), float(values.max())
    if not np.isfinite(high) or high <= low:
        raise InputError("a field that is the same everywhere; there is nothing to draw")
    return np.clip((values - low) / (high - low), 0.0, 1.0)


def colours(values: Array) -> npt.NDArray[np.uint8]:
    """Return colours (m, k, 3), 0 to 255, of values (m, k) from 0 to 1."""
    from matplotlib import colormaps

    return (255 * colormaps["viridis"](values)[..., :3]).astype(np.uint8)
