"""A model on a web page: the meshes of its bodies, moved with them."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from typing import TYPE_CHECKING

import mujoco
import numpy as np

from handsim.types import Array
from handsim.viewing.live.shapes import geom_colour, geom_mesh, visible_geoms

if TYPE_CHECKING:
    import viser


class Puppet:
    """Puts a model on a page and moves it.

    Parameters
    ----------
    server
    name
        Of its root on the page; a name used again would keep the pose of what had it before.
    model
    opacity
        Factor on that of its parts: less than 1 for a ghost beside the hand.
    place : (3,) [m]
        Of the model's origin on the page.

    Attributes
    ----------
    bodies
        Frames of the bodies by their ids.
    geoms
        Meshes of each body.
    """

    def __init__(
        self,
        server: "viser.ViserServer",
        name: str,
        model: mujoco.MjModel,
        opacity: float = 1.0,
        place: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        self._server, self.model, self.data = server, model, mujoco.MjData(model)
        self.origin = np.array(place)
        self._root = server.scene.add_frame(name, show_axes=False, position=place)
        self.bodies: dict[int, viser.FrameHandle] = {}
        self.geoms: dict[int, list[viser.MeshHandle]] = {}
        for geom in visible_geoms(model):
            body = int(model.geom_bodyid[geom])
            inner = f"{name}/body_{body}"
            if body not in self.bodies:
                self.bodies[body] = server.scene.add_frame(inner, show_axes=False)
            made = self._add_geom(geom, f"{inner}/geom_{geom}", opacity)
            self.geoms.setdefault(body, []).append(made)

    def place(self, qpos: Array) -> None:
        """Move the bodies to their poses at joint positions."""
        self.data.qpos[:] = qpos
        mujoco.mj_kinematics(self.model, self.data)
        with self._server.atomic():
            for body, frame in self.bodies.items():
                frame.position, frame.wxyz = self.data.xpos[body], self.data.xquat[body]

    def show(self, visible: bool) -> None:
        """Show or hide it."""
        if self._root.visible != visible:
            self._root.visible = visible

    def remove(self) -> None:
        """Take it off the page."""
        self._root.remove()

    def _add_geom(self, geom: int, name: str, factor: float) -> "viser.MeshHandle":
        model, (*rgb, own) = self.model, geom_colour(self.model, geom)
        mesh, opacity = geom_mesh(model, geom).smooth_shaded, factor * own
        return self._server.scene.add_mesh_simple(
            name,
            np.asarray(mesh.vertices, np.float32),
            np.asarray(mesh.faces, np.uint32),
            color=np.array(rgb),
            opacity=opacity if opacity < 1 else None,
            position=model.geom_pos[geom],
            wxyz=model.geom_quat[geom],
        )
