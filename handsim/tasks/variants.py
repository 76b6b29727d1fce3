"""Hands and scenes for MuJoCo's other simulators, MJX and mujoco_warp.

mujoco_warp (4.0) takes all of them as they are. MJX has neither ``noslip`` nor contacts of
ellipsoids with boxes and meshes: `for_simulator` changes what it must and says what differs.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Sequence
from typing import Literal

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from handsim.errors import UnknownNameError
from handsim.types import Array

Simulator = Literal["mjx", "warp"]
SIMULATORS: tuple[Simulator, ...] = ("mjx", "warp")

NO_NOSLIP = "noslip is off: what is held creeps by some 0.2 mm/s"
CAPSULES = "segments of the hand are capsules: as long and as thick, but less pointed; same inertia"
NO_SELF_CONTACT = "the hand does not touch itself"
BROADER = 0.1
"""How much broader than thick an ellipsoid is that becomes two capsules side by side, relative."""

_ELLIPSOID = mujoco.mjtGeom.mjGEOM_ELLIPSOID
_WITHOUT_CONTACT = (mujoco.mjtGeom.mjGEOM_BOX, mujoco.mjtGeom.mjGEOM_MESH)
"""What MJX has no contact of an ellipsoid with."""


def for_simulator(spec: mujoco.MjSpec, simulator: Simulator) -> tuple[str, ...]:
    """Make a hand or a scene one that a simulator takes as it is.

    Parameters
    ----------
    spec
        Of `build_hand`, `build_arm` or `build_scene`; changed in place.
    simulator
        ``mjx``: MJX with JAX (mujoco-mjx). ``warp``: mujoco_warp, which needs no change.

    Returns
    -------
    tuple of str
        What differs from the original, one phrase each.

    Raises
    ------
    UnknownNameError
        If there is no such simulator.
    """
    if simulator not in SIMULATORS:
        raise UnknownNameError("simulator", simulator, SIMULATORS)
    if simulator == "warp":
        return ()
    spec.option.noslip_iterations = 0
    touching = [geom for geom in spec.geoms if geom.contype or geom.conaffinity]
    if not any(geom.type in _WITHOUT_CONTACT for geom in touching):
        return (NO_NOSLIP,)
    ellipsoids = [geom for geom in touching if geom.type == _ELLIPSOID]
    _keep_inertia(spec, {geom.parent.name for geom in ellipsoids})
    for geom in ellipsoids:
        _as_capsules(geom)
    return NO_NOSLIP, CAPSULES, NO_SELF_CONTACT


def capsules_of(semi_axes: Sequence[float]) -> tuple[Array, Array, Array]:
    """Return capsules that are as long, as broad and as thick as an ellipsoid.

    Parameters
    ----------
    semi_axes : (3,) [m]

    Returns
    -------
    size : (2,) [m]
        Radius and half the length of the cylinder between the caps.
    axis : (3,)
        Along the capsules, in the ellipsoid's frame.
    places : (1 or 2, 3) [m]
        Their centres: one, or two side by side where the ellipsoid is broad.
    """
    thin, middle, long = np.argsort(semi_axes, kind="stable")
    radius = semi_axes[thin]
    axes = np.eye(3)
    beside = semi_axes[middle] - radius
    sides = np.array([-1.0, 1.0]) if beside > BROADER * radius else np.zeros(1)
    size = np.array([radius, max(semi_axes[long] - radius, 1e-6)])
    return size, axes[long], sides[:, None] * beside * axes[middle]


def _keep_inertia(spec: mujoco.MjSpec, names: set[str]) -> None:
    """Give bodies the mass and inertia that they have by their geoms."""
    model = spec.compile()
    for name in names:
        body, compiled = spec.body(name), model.body(name)
        body.explicitinertial = True
        body.mass = compiled.mass[0]
        body.ipos, body.iquat, body.inertia = compiled.ipos, compiled.iquat, compiled.inertia


def _as_capsules(geom: mujoco.MjsGeom) -> None:
    """Make an ellipsoid one capsule, or two, that touch all but their own kind."""
    size, axis, places = capsules_of(geom.size)
    turn = Rotation.from_quat(geom.quat, scalar_first=True)
    along = Rotation.align_vectors([axis], [[0.0, 0.0, 1.0]])[0]
    places = np.array(geom.pos) + turn.apply(places)
    shape = {
        "type": mujoco.mjtGeom.mjGEOM_CAPSULE,
        "size": [*size, 0.0],
        "quat": (turn * along).as_quat(scalar_first=True),
        # Others have 1 and 1.
        "contype": 2,
        "conaffinity": 1,
    }
    for name, value in (shape | {"pos": places[0]}).items():
        setattr(geom, name, value)
    for place in places[1:]:
        geom.parent.add_geom(
            geom.classname,
            name=f"{geom.name}_beside",
            pos=place,
            friction=geom.friction,
            material=geom.material,
            group=geom.group,
            **shape,
        )
