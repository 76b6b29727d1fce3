"""An MJCF made ready for MuJoCo: parts included, meshes in memory, pictures of surfaces dropped."""

import xml.etree.ElementTree as ET
from collections.abc import Collection
from pathlib import Path, PurePath

from handsim.errors import FileError
from handsim.robot_hands.reading._assets import Assets
from handsim.robot_hands.reading._xml_text import check, parse

_DROPPED = ("keyframe", "size", "statistic", "custom")
"""Sections that a hand needs not: postures, sizes of buffers, what other programs are told."""
MOST_INCLUDED = 50
"""Most files that may be included."""


def prepare_mjcf(
    root: ET.Element, path: Path, assets: Assets, unknown: Collection[tuple[str, str]] = ()
) -> None:
    """Change an MJCF in place.

    Parameters
    ----------
    root, path, assets
    unknown
        Attributes of elements that are left out.

    Raises
    ------
    FileError
        If a file that it includes is missing, or it names one in another way.
    """
    _include(root, path, assets)
    check(root, path)
    mesh_folders, texture_needed = _folders_of_meshes(root), False
    _drop(root, unknown)
    for asset in root.iter("asset"):
        _meshes(asset, mesh_folders, assets, path)
        for texture in asset.findall("texture"):
            if any(key.startswith("file") for key in texture.attrib):
                asset.remove(texture)
                texture_needed = True
    if texture_needed:
        _without_textures(root)
    _refuse_files(root, path, assets)
    _bind_joints(root)
    compiler = root.find("compiler")
    if compiler is None:
        compiler = ET.SubElement(root, "compiler")
    compiler.set("balanceinertia", "true")
    for key, least in (("boundmass", "1e-5"), ("boundinertia", "1e-9")):
        if compiler.get(key) is None:
            compiler.set(key, least)


def _drop(root: ET.Element, unknown: Collection[tuple[str, str]]) -> None:
    """Take out what a hand needs not, skies among it."""
    for section in _DROPPED:
        for element in root.findall(section):
            root.remove(element)
    for element in root.iter():
        element.attrib.pop("user", None)  # numbers that mean something to the user's program alone
        for attribute, tag in unknown:
            if element.tag == tag:
                element.attrib.pop(attribute, None)
        for sky in element.findall("texture[@type='skybox']"):
            element.remove(sky)


def _bind_joints(root: ET.Element) -> None:
    """Let joints follow each other whose tendon is held at its length: that is the same.

    With ``c1 (q1 - q1*) + c2 (q2 - q2*) = a`` about the reference posture, the first follows the
    second; or the other way round, where it alone has an actuator.
    """
    tendons = {fixed.get("name"): fixed for part in root.iter("tendon") for fixed in part}
    moved = {each.get("joint") for part in root.findall("actuator") for each in part}
    for held in [each for part in root.iter("equality") for each in part.findall("tendon")]:
        fixed = tendons.get(held.get("tendon1"))
        ends = [] if fixed is None or fixed.tag != "fixed" else fixed.findall("joint")
        try:
            ways = {each.get("joint", ""): float(each.get("coef", "")) for each in ends}
            length = float(held.get("polycoef", "0").split()[0])
        except (ValueError, IndexError):
            continue
        if held.get("tendon2") or len(ends) != 2 or len(ways) != 2 or 0.0 in ways.values():
            continue
        follows, leads = ways
        if follows in moved and leads not in moved:
            follows, leads = leads, follows
        slope = -ways[leads] / ways[follows]
        held.tag = "joint"
        del held.attrib["tendon1"]
        held.set("joint1", follows)
        held.set("joint2", leads)
        held.set("polycoef", f"{length / ways[follows]:.9g} {slope:.9g} 0 0 0")


def _include(root: ET.Element, path: Path, assets: Assets) -> None:
    """Put the content of included files in place of their names."""
    seen: set[Path] = {path.resolve()}
    waiting = [root]
    while waiting:
        parent = waiting.pop()
        for at, child in enumerate([*parent]):
            if child.tag != "include":
                waiting.append(child)
                continue
            name = child.get("file", "")
            file = assets.folders.find(name) if name else None
            if file is None:
                raise FileError(
                    f"{path}: it includes '{name[:80]}', which is not in its folder; put it there"
                )
            if file in seen or len(seen) > MOST_INCLUDED:
                raise FileError(f"{path}: it includes '{name[:80]}' more than once; give one file")
            seen.add(file)
            part = parse(assets.folders.read(file), file)
            place = [*parent].index(child)
            parent.remove(child)
            for offset, element in enumerate(part):
                parent.insert(place + offset, element)
            waiting.append(parent)
            del at
            break


def _folders_of_meshes(root: ET.Element) -> tuple[str, ...]:
    """Return the folders that names of meshes are relative to; take them out of the compiler."""
    found: list[str] = []
    for compiler in root.findall("compiler"):
        for key in ("meshdir", "assetdir", "texturedir", "strippath"):
            value = compiler.attrib.pop(key, None)
            if value and key in ("meshdir", "assetdir"):
                found.append(value)
    return tuple(found)


def _meshes(asset: ET.Element, within: tuple[str, ...], assets: Assets, path: Path) -> None:
    for mesh in asset.findall("mesh"):
        file = mesh.get("file")
        if file is None:
            continue
        mesh.attrib.pop("content_type", None)
        if mesh.get("name") is None:
            mesh.set("name", PurePath(file).stem)
        stored = assets.mesh(file, within, mesh.get("name", ""))
        mesh.set("file", stored)
        if stored.rpartition(".")[0] in assets.placeholders:
            mesh.set("scale", "1 1 1")
            mesh.set("inertia", "convex")
            for key in ("maxhullvert", "smoothnormal", "refpos", "refquat", "material"):
                mesh.attrib.pop(key, None)


def _without_textures(root: ET.Element) -> None:
    """Materials keep their colours alone."""
    for material in root.iter("material"):
        material.attrib.pop("texture", None)
        for layer in material.findall("layer"):
            material.remove(layer)
    kept = {texture.get("name") for texture in root.iter("texture")}
    for element in root.iter("geom"):
        if element.get("texture") not in kept:
            element.attrib.pop("texture", None)


def _refuse_files(root: ET.Element, path: Path, assets: Assets) -> None:
    """Refuse what still names a file: MuJoCo would open it by itself."""
    for element in root.iter():
        for key, value in element.attrib.items():
            if key.startswith("file") and value not in assets.content:
                raise FileError(
                    f"{path}: <{element.tag}> names the file '{value[:80]}'; "
                    "only meshes and included parts are read"
                )
