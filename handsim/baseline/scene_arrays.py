"""Arrays of a compiled model that take part in its physics, in groups.

All arrays of the model are taken, except those that `LEFT_OUT` names with a reason. An array that
fits no group is in the group `OTHER`, so that none is forgotten.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from fnmatch import fnmatchcase
from functools import cache
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

LEFT_OUT: dict[str, tuple[str, ...]] = {
    "it is only seen": (
        "cam_*", "light_*", "mat_*", "tex_*", "skin_*", "*_rgba", "*_matid", "*_group",
        "geom_castshadow", "mesh_normal*", "mesh_texcoord*", "mesh_facenormal",
        "mesh_facetexcoord", "flex_texcoord*", "flex_elemtexcoord", "flex_flatskin",
        "tendon_width",
    ),
    "it says what something is called or where its file lay": (
        "name_*", "names_map", "*_pathadr", "text_*", "numeric_*", "tuple_*", "*_user",
    ),
    "it is made of the geometry to find contacts sooner": ("bvh_*", "*_bvhadr", "*_bvhnum"),
    "it is made of a mesh's triangles, by each version of MuJoCo in another order": ("mesh_poly*",),
}  # fmt: skip
"""Names of arrays that are left out, by the reason; a star stands for anything."""

GROUPS: dict[str, tuple[str, ...]] = {
    "friction": ("geom_friction", "geom_condim", "geom_priority", "pair_*friction"),
    "masses": (
        "body_mass", "body_inertia", "body_ipos", "body_iquat", "body_subtreemass",
        "body_gravcomp",
    ),
    "geometry": (
        "geom_size", "geom_pos", "geom_quat", "geom_type", "geom_dataid", "geom_rbound",
        "geom_aabb", "body_pos", "body_quat", "site_pos", "site_quat", "site_size", "mesh_*",
        "hfield_*",
    ),
    "contacts": (
        "geom_sol*", "geom_contype", "geom_conaffinity", "geom_margin", "geom_gap", "pair_*",
        "exclude_*", "body_contype", "body_conaffinity", "body_margin",
    ),
    "joints": (
        "jnt_*", "dof_damping*", "dof_armature", "dof_frictionloss", "dof_sol*", "qpos0",
        "qpos_spring",
    ),
    "actuators": ("actuator_*",),
    "equalities": ("eq_*",),
    "sensors": ("sensor_*",),
}  # fmt: skip
"""Groups of arrays, the first that fits; all the rest is the group `OTHER`."""
SOLVER, OTHER = "solver", "other"
_STATISTICS = ("meaninertia",)
"""Of the model's statistics those that the solver uses; the others are for cameras."""


def scene_arrays(model: mujoco.MjModel) -> dict[str, list[npt.NDArray[Any]]]:
    """Return the arrays of a model that have a part in its physics, and its options, by group.

    Each array follows its name. One in which nothing is set (all zero, or of indices all -1) is
    not there at all: a version of MuJoCo that has more arrays or options than another compiles
    the same scene, until one of them is used.
    """
    groups: dict[str, list[npt.NDArray[Any]]] = {name: [] for name in (*GROUPS, SOLVER, OTHER)}
    for name in sorted(dir(model)):
        array = None if is_left_out(name) else getattr(model, name)
        if isinstance(array, np.ndarray) and _is_set(name, array):
            groups[group_of(name)] += [_letters(name), array]
    for source, names in ((model.opt, sorted(dir(model.opt))), (model.stat, _STATISTICS)):
        for name in names:
            value = getattr(source, name)
            if not (name.startswith("_") or callable(value)) and _is_set(name, value):
                groups[SOLVER] += [_letters(name), np.atleast_1d(value)]
    return groups


@cache
def group_of(name: str) -> str:
    """Return the group of an array."""
    for group, patterns in GROUPS.items():
        if _fits(name, patterns):
            return group
    return OTHER


@cache
def is_left_out(name: str) -> bool:
    """Whether an array has no part in physics."""
    return name.startswith("_") or any(_fits(name, patterns) for patterns in LEFT_OUT.values())


def _fits(name: str, patterns: tuple[str, ...]) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns)


def _is_set(name: str, values: npt.ArrayLike) -> bool:
    nothing = -1 if name.endswith(("id", "adr")) else 0
    return bool((np.asarray(values) != nothing).any())


def _letters(name: str) -> npt.NDArray[np.uint8]:
    return np.frombuffer(name.encode(), dtype=np.uint8)
