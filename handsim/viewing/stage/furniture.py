"""What stands about a grasp in pictures: the table's edge and legs, and a floor below.

It is drawn and is in no model: scenes, their digests and stored rollouts do not change with it, and
rollouts of earlier versions get it as well.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import dataclass

import mujoco
import numpy as np

from handsim.types import Array

_TABLE = "table_top"
_EDGE, _BELOW = 0.012, 0.004
"""How far the edge goes round the table's top, and how far it stays below its surface [m]."""
_LEG, _INSET = 0.022, 0.06
"""Half the thickness of a leg, and its distance from the edges [m]."""
_FLOOR = -0.73
"""Height of the floor [m]: tables for writing are 0.72 to 0.75 m high."""
_FLOOR_SIZE = 4.0
_WOOD, _FLOOR_COLOUR = (0.47, 0.37, 0.28, 1.0), (0.54, 0.56, 0.58, 1.0)


@dataclass(frozen=True)
class FurniturePart:
    """A box in the world: middle and half sizes, (3,) [m] each, and its colour."""

    pos: Array
    size: Array
    rgba: tuple[float, float, float, float]


def furniture_of(model: mujoco.MjModel) -> tuple[FurniturePart, ...]:
    """Return what is drawn about a model's table; nothing where it has none of ours.

    Parameters
    ----------
    model
        Of a scene of `handsim.tasks.scene.build_scene`, or any other.
    """
    table = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM.value, _TABLE)
    if table < 0 or model.geom_type[table] != mujoco.mjtGeom.mjGEOM_BOX.value:
        return ()
    middle, half = model.geom_pos[table], model.geom_size[table]
    sides = half + np.array([_EDGE, _EDGE, -0.5 * _BELOW])
    parts = [FurniturePart(middle - [0, 0, 0.5 * _BELOW], sides, _WOOD)]
    top = float(middle[2] - half[2])
    x, y = half[:2] - _INSET
    for across in (-x, x):
        for along in (-y, y):
            foot = np.array([middle[0] + across, middle[1] + along, 0.5 * (top + _FLOOR)])
            size = np.array([_LEG, _LEG, 0.5 * (top - _FLOOR)])
            parts.append(FurniturePart(foot, size, _WOOD))
    floor = np.array([middle[0], middle[1], _FLOOR - 0.01])
    parts.append(FurniturePart(floor, np.array([_FLOOR_SIZE, _FLOOR_SIZE, 0.01]), _FLOOR_COLOUR))
    return tuple(parts)


def draw_furniture(scene: mujoco.MjvScene, parts: tuple[FurniturePart, ...]) -> None:
    """Add boxes to what is drawn of an updated scene, as far as it has room."""
    for part in parts[: scene.maxgeom - scene.ngeom]:
        geom = scene.geoms[scene.ngeom]
        mujoco.mjv_initGeom(
            geom,
            mujoco.mjtGeom.mjGEOM_BOX.value,
            part.size,
            part.pos,
            np.eye(3).ravel(),
            np.array(part.rgba, np.float32),
        )
        geom.specular, geom.shininess = 0.0, 0.1
        # MuJoCo leaves of what stood in this place before which object it drew.
        geom.objtype, geom.objid, geom.segid = mujoco.mjtObj.mjOBJ_UNKNOWN.value, -1, -1
        scene.ngeom += 1
