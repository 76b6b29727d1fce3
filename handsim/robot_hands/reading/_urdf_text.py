"""A URDF made ready for MuJoCo: links kept, meshes in memory, leftovers of xacro refused."""

import xml.etree.ElementTree as ET
from pathlib import Path

from handsim.errors import FileError
from handsim.robot_hands.reading._assets import Assets

_COMPILER = {
    "fusestatic": "false",  # tips and palms are often links that are fixed
    "discardvisual": "false",
    "strippath": "false",
    "balanceinertia": "true",
    "boundmass": "1e-5",
    "boundinertia": "1e-9",
}
_MOVED = ("revolute", "continuous", "prismatic")
_KINDS = (*_MOVED, "fixed", "floating", "planar")


def prepare_urdf(root: ET.Element, path: Path, assets: Assets) -> dict[str, float]:
    """Change a URDF in place; return the largest speeds of its joints [rad/s or m/s].

    Raises
    ------
    FileError
        If it is xacro, or names links or joints that it does not have.
    """
    _refuse_xacro(root, path)
    speeds = _check_joints(root, path)
    for own in root.findall("mujoco"):
        root.remove(own)
    for mesh in root.iter("mesh"):
        name = mesh.get("filename", "")
        if not name:
            raise FileError(f"{path}: a <mesh> without filename; give one")
        stored = assets.mesh(name, scale=mesh.get("scale", ""))
        mesh.set("filename", stored)
        if stored.rpartition(".")[0] in assets.placeholders:
            mesh.attrib.pop("scale", None)
    for texture in [*root.iter("texture")]:
        texture.attrib.pop("filename", None)
    for material in root.iter("material"):
        for texture in material.findall("texture"):
            material.remove(texture)
    ET.SubElement(ET.SubElement(root, "mujoco"), "compiler", _COMPILER)
    return speeds


def _refuse_xacro(root: ET.Element, path: Path) -> None:
    for element in root.iter():
        tag = str(element.tag)
        left = next((v for v in element.attrib.values() if "${" in v or "$(" in v), None)
        if "xacro" in tag or left is not None:
            shown = left if left is not None else tag.rpartition("}")[2]
            raise FileError(
                f"{path}: '{shown[:60]}' is xacro and no URDF; run "
                "`xacro FILE.xacro > FILE.urdf` and give that"
            )


def _check_joints(root: ET.Element, path: Path) -> dict[str, float]:
    """Refuse a tree that is none; return the speeds."""
    links = [link.get("name", "") for link in root.findall("link")]
    joints = {joint.get("name", ""): joint for joint in root.findall("joint")}
    if len(set(links)) < len(links) or len(joints) < len(root.findall("joint")):
        raise FileError(f"{path}: two links or two joints share a name; give each its own")
    speeds: dict[str, float] = {}
    children: set[str] = set()
    for name, joint in joints.items():
        kind = joint.get("type", "")
        if kind not in _KINDS:
            raise FileError(f"{path}: joint '{name[:60]}' is of type '{kind[:40]}'; URDF has none")
        ends = [getattr(joint.find(end), "attrib", {}).get("link", "") for end in _ENDS]
        unknown = next((end for end in ends if end not in links), None)
        if unknown is not None:
            raise FileError(
                f"{path}: joint '{name[:60]}' names link '{unknown[:60]}', which is none"
            )
        if ends[1] in children:
            raise FileError(f"{path}: link '{ends[1][:60]}' hangs on two joints; a URDF is a tree")
        children.add(ends[1])
        mimic = joint.find("mimic")
        if mimic is not None:
            _check_mimic(joint, mimic, joints, path)
        limit = joint.find("limit")
        try:
            speed = float("nan" if limit is None else limit.get("velocity", "nan"))
        except ValueError:
            speed = float("nan")
        if kind in _MOVED and speed > 0:
            speeds[name] = speed
    return speeds


_ENDS = ("parent", "child")


def _check_mimic(
    joint: ET.Element, mimic: ET.Element, joints: dict[str, ET.Element], path: Path
) -> None:
    """Refuse a leader that is not there; one that does not move holds its follower fast."""
    leader = joints.get(mimic.get("joint", ""))
    if leader is None or leader is joint:
        raise FileError(
            f"{path}: joint '{joint.get('name', '')[:60]}' mimics "
            f"'{mimic.get('joint', '')[:60]}', which is no other joint; correct the name"
        )
    if leader.get("type") not in _MOVED or joint.get("type") not in _MOVED:
        joint.remove(mimic)
