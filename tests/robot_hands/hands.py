"""Hands as their makers write them, made up: URDF of fingers along x that bend towards -z."""

from dataclasses import dataclass

INERTIA = (
    '<inertial><mass value="0.02"/>'
    '<inertia ixx="{0}" iyy="{1}" izz="{2}" ixy="0" ixz="0" iyz="0"/></inertial>'
)
GOOD = INERTIA.format(2e-6, 4e-6, 4e-6)
BAD = INERTIA.format(1e-4, 1e-6, 1e-6)
"""A + B < C: no body is so."""


@dataclass(frozen=True)
class Joint:
    """A joint of a URDF and the link that it carries: a box along x of this length."""

    name: str
    parent: str
    child: str
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] = (0.0, 1.0, 0.0)
    limits: tuple[float, float] | None = (0.0, 1.5)
    mimic: tuple[str, float, float] | None = None
    length: float = 0.0
    kind: str = "revolute"


def words(numbers) -> str:
    return " ".join(f"{number:.6g}" for number in numbers)


def urdf(joints: list[Joint], base: str = "base", inertia: str = GOOD, visual: str = "") -> str:
    """The file of a hand; links without length have no shape, as tips and palms often have."""
    parts = [
        f'<link name="{base}">{inertia}<collision><origin xyz="0.04 0 0"/>'
        '<geometry><box size="0.08 0.08 0.02"/></geometry></collision></link>'
    ]
    for joint in joints:
        shape = ""
        if joint.length:
            shape = (
                f'{inertia}<collision><origin xyz="{joint.length / 2} 0 0"/><geometry>'
                f'<box size="{joint.length} 0.014 0.014"/></geometry></collision>{visual}'
            )
        parts.append(f'<link name="{joint.child}">{shape}</link>')
        limit, mimic = "", ""
        if joint.limits:
            low, high = joint.limits
            limit = f'<limit lower="{low}" upper="{high}" effort="1" velocity="2"/>'
        if joint.mimic:
            leader, slope, offset = joint.mimic
            mimic = f'<mimic joint="{leader}" multiplier="{slope}" offset="{offset}"/>'
        parts.append(
            f'<joint name="{joint.name}" type="{joint.kind}"><parent link="{joint.parent}"/>'
            f'<child link="{joint.child}"/>'
            f'<origin xyz="{words(joint.xyz)}" rpy="{words(joint.rpy)}"/>'
            f'<axis xyz="{words(joint.axis)}"/>{limit}{mimic}</joint>'
        )
    return '<?xml version="1.0"?><robot name="hand">' + "".join(parts) + "</robot>"


def finger(
    name: str,
    y: float,
    palm: str = "base",
    names: tuple[str, str, str] = ("proximal", "distal", "tip"),
    slope: float = 1.05,
    offset: float = 0.0,
    upper: float = 1.6,
) -> list[Joint]:
    """A finger of two links, the outer one following the inner, and a tip that is fixed."""
    inner, outer, tip = (f"{name}_{part}" for part in names)
    return [
        Joint(f"{name}_1", palm, inner, (0.09, y, 0.0), length=0.05),
        Joint(
            f"{name}_2", inner, outer, (0.05, 0.0, 0.0), limits=(0.0, upper),
            mimic=(f"{name}_1", slope, offset), length=0.04,
        ),
        Joint(f"{name}_fix", outer, tip, (0.04, 0.0, 0.0), limits=None, kind="fixed"),
    ]  # fmt: skip


def thumb(name: str = "thumb", side: float = 1.0, palm: str = "base") -> list[Joint]:
    """A thumb that swings across the palm and bends."""
    return [
        Joint(
            f"{name}_yaw", palm, f"{name}_base", (0.02, 0.04 * side, -0.01), axis=(1, 0, 0),
            limits=(0.0, 1.6) if side < 0 else (-1.6, 0.0),
        ),
        Joint(
            f"{name}_1", f"{name}_base", f"{name}_proximal", rpy=(1.571 * side, 0.0, 0.9 * side),
            length=0.05,
        ),
        Joint(
            f"{name}_2", f"{name}_proximal", f"{name}_distal", (0.05, 0.0, 0.0),
            mimic=(f"{name}_1", 0.8, 0.0), length=0.03,
        ),
        Joint(
            f"{name}_fix", f"{name}_distal", f"{name}_tip", (0.03, 0.0, 0.0), limits=None,
            kind="fixed",
        ),
    ]  # fmt: skip


def five_fingers(side: float = 1.0, **options) -> list[Joint]:
    joints = thumb(side=side)
    for name, y in (("index", 0.03), ("middle", 0.01), ("ring", -0.01), ("pinky", -0.03)):
        joints += finger(name, y * side, **options)
    return joints
