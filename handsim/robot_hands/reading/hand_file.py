"""Read a robot hand from MJCF or URDF: with its own link names, mended where its authors erred.

Everything that the file names is read here, from the user's folders alone, and handed to MuJoCo in
memory. What was mended or left out is said in notes.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import mujoco

from handsim.errors import FileError
from handsim.robot_hands.reading._assets import Assets
from handsim.robot_hands.reading._folders import UserFolders
from handsim.robot_hands.reading._mending import (
    add_servos,
    give_names,
    keep_least_masses,
    mend_inertia,
)
from handsim.robot_hands.reading._mjcf_text import prepare_mjcf
from handsim.robot_hands.reading._urdf_text import prepare_urdf
from handsim.robot_hands.reading._xml_text import parse
from handsim.silence import quiet_compile, unheard_warnings
from handsim.wording import number_of

SUFFIXES = (".xml", ".mjcf", ".urdf")
"""Files that are taken for hands; what is inside decides what they are."""
_TRIES = 16
"""How many broken meshes and unknown settings are left out before the file is refused."""
_SMALLEST = 1e-9
"""Least size of a shape [m]."""
_UNKNOWN = re.compile(r"unrecognized attribute: '(\w+)' Element '(\w+)'")
_OF_THE_SIMULATION = frozenset(
    ["option", "flag", "size", "visual", "global", "quality", "headlight", "map", "scale", "rgba"]
)
"""Elements that say nothing of the hand: what MuJoCo has no longer is left out of them."""
_OF_COMPILERS = frozenset(("convexhull", "exactmeshinertia"))
"""The same of a compiler's attributes."""


@dataclass(frozen=True)
class HandFile:
    """A robot hand that MuJoCo compiles.

    Attributes
    ----------
    spec, model
        The hand, its meshes included, and compiled.
    speeds
        Largest speeds of joints by name, where the file says them [rad/s; m/s for slides].
    notes
        What was mended or left out, a line each.
    placeholders
        Names of meshes that stand for missing ones.
    """

    spec: mujoco.MjSpec
    model: mujoco.MjModel
    speeds: dict[str, float]
    notes: tuple[str, ...]
    placeholders: frozenset[str] = frozenset()


def read_hand_file(path: Path | str, folders: Sequence[Path] = ()) -> HandFile:
    """Read a robot hand.

    Parameters
    ----------
    path
        MJCF (``.xml``, ``.mjcf``) or URDF.
    folders
        Where meshes of ``package://`` may be besides the folders about the file: packages, or
        folders of packages.

    Raises
    ------
    FileError
        If it cannot be read; one line that says what to do.
    InputError
        If one of the folders is none.
    """
    file = Path(path)
    if not file.is_file():
        raise FileError(f"{file}: no such file; give the robot hand as MJCF or URDF")
    places = UserFolders(file, folders)
    content = places.read(file)
    broken: frozenset[str] = frozenset()
    unknown: frozenset[tuple[str, str]] = frozenset()
    convert, reason = False, ""
    for _ in range(_TRIES):
        root = parse(content, file)
        assets = Assets(places, broken, convert)
        try:
            return _read(root, file, assets, unknown)
        except ValueError as error:
            if isinstance(error, FileError):
                raise
            reason = " ".join(str(error).split())[:200]
            if old := _old_settings(reason) - unknown:
                unknown |= old
                continue
            culprits = {
                name.rpartition(".")[0]
                for name in assets.content
                if name.rpartition(".")[0] in reason
            } or _named(reason, root)
            if not assets.content or (not culprits and convert):
                break
            if convert:
                broken = broken | culprits
            convert = True
    raise FileError(f"{file}: MuJoCo cannot read it ({reason}); correct the file")


def _named(reason: str, root: ET.Element) -> set[str]:
    """Return the stored names of meshes that an error names by those of the file."""
    named = set(re.findall(r"mesh '([^']+)'", reason)) | set(re.findall(r'name "([^"]+)"', reason))
    named |= set(re.findall(r"name '([^']+)'", reason))
    return {
        mesh.get("file", "").rpartition(".")[0]
        for mesh in root.iter("mesh")
        if mesh.get("name") in named and mesh.get("file")
    }


def _old_settings(reason: str) -> frozenset[tuple[str, str]]:
    """Return the attribute and the element that an error is about, if the hand needs it not."""
    found = _UNKNOWN.search(reason)
    if found is None:
        return frozenset()
    attribute, element = found.groups()
    of_compiler = element == "compiler" and attribute in _OF_COMPILERS
    return frozenset({(attribute, element)} if of_compiler or element in _OF_THE_SIMULATION else ())


def _read(
    root: ET.Element, file: Path, assets: Assets, unknown: frozenset[tuple[str, str]]
) -> HandFile:
    """Make one attempt; a ValueError that is no FileError is MuJoCo's."""
    speeds: dict[str, float] = {}
    if root.tag == "robot":
        speeds = prepare_urdf(root, file, assets)
    elif root.tag == "mujoco":
        prepare_mjcf(root, file, assets, unknown)
    else:
        raise FileError(
            f"{file}: its root is <{str(root.tag)[:40]}>; give <mujoco> (MJCF) or <robot> (URDF)"
        )
    with unheard_warnings():
        text = ET.tostring(root, encoding="unicode")
        spec = mujoco.MjSpec.from_string(text, assets=assets.content)
    give_names(spec)
    notes = mend_inertia(spec)
    for mesh in spec.meshes:
        if root.tag == "robot":  # whatever the direction of its triangles
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    model = quiet_compile(spec)
    if model.nv == 0:
        raise FileError(f"{file}: nothing in it moves; give a hand with joints")
    _check_sizes(file, model)
    notes += add_servos(spec, model)
    model = quiet_compile(spec)
    keep_least_masses(spec, model)
    notes += _of_meshes(assets)
    if unknown:
        old = ", ".join(sorted(attribute for attribute, _ in unknown))
        notes.append(f"settings of another version of MuJoCo are left out: {old}")
    placeholders = frozenset(mesh.name for mesh in spec.meshes if _is_placeholder(mesh, assets))
    return HandFile(spec, model, speeds, tuple(notes), placeholders)


def _check_sizes(file: Path, model: mujoco.MjModel) -> None:
    """Refuse shapes so small that a file of a scene would have them as 0."""
    sizes = model.geom_size[(model.geom_size > 0.0) & (model.geom_size < _SMALLEST)]
    if len(sizes):
        raise FileError(
            f"{file}: a shape of {sizes[0]:g} m, smaller than {_SMALLEST:g}; mend its size or "
            "leave it out"
        )


def _is_placeholder(mesh: mujoco.MjsMesh, assets: Assets) -> bool:
    return str(mesh.file).rpartition(".")[0] in assets.placeholders


def _of_meshes(assets: Assets) -> list[str]:
    if not assets.missing:
        return []
    first, reason = next(iter(assets.missing.items()))
    outside = " (outside the hand's folders)" if assets.folders.outside else ""
    what = number_of(len(assets.missing), "mesh is", "meshes are")
    return [f"{what} left out, the first '{first[:80]}': {reason}{outside}"]
