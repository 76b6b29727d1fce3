"""Models that come out of a file: a stranger's must neither read other files nor fill the memory.

MuJoCo opens every file that a model names, and some of its elements (``replicate``, ``composite``,
``hfield``, plugins) make as much of a few characters as they are asked to. Only the elements and
attributes that scenes of this package consist of are let through, which excludes all of those.
"""

import xml.etree.ElementTree as ET
from collections.abc import Mapping

from handsim.errors import InputError

_PLACE = "name class pos quat"
_TENDON = (
    "name class group limited range margin stiffness damping frictionloss springlength armature"
    " solreflimit solimplimit solreffriction solimpfriction actuatorfrclimited actuatorfrcrange"
)
_ALLOWED: dict[str, str] = {
    "mujoco": "model",
    "compiler": "angle autolimits",
    "option": "timestep gravity cone impratio integrator iterations noslip_iterations tolerance",
    "statistic": "center extent",
    "visual": "",
    "global": "offheight offwidth",
    "headlight": "ambient diffuse specular",
    "map": "zfar znear",
    "default": "class",
    "asset": "",
    "texture": "name type builtin colorspace rgb1 rgb2 width height mark markrgb random",
    "material": (
        "name class texture texrepeat texuniform rgba shininess specular reflectance emission"
        " metallic roughness"
    ),
    "mesh": "name class vertex face inertia file scale refpos refquat smoothnormal maxhullvert",
    "worldbody": "",
    "frame": f"{_PLACE} childclass",
    "body": f"{_PLACE} childclass gravcomp mocap",
    "inertial": "pos quat mass diaginertia fullinertia",
    "freejoint": "name group align",
    "joint": (
        f"{_PLACE} armature axis damping frictionloss group joint1 joint2 limited polycoef range"
        " ref solimplimit solref solimp solreflimit springref stiffness type margin"
        " actuatorfrcrange actuatorfrclimited actuatorgravcomp solreffriction solimpfriction"
        " joint coef"
    ),
    "geom": (
        f"{_PLACE} conaffinity condim contype density friction group margin gap mass material mesh"
        " priority rgba size solref solimp solmix type fromto shellinertia fluidshape fluidcoef"
        " geom sidesite"
    ),
    "site": f"{_PLACE} group size type rgba material fromto site",
    "camera": f"{_PLACE} fovy mode target resolution",
    "light": f"{_PLACE} diffuse ambient dir specular type castshadow mode target",
    "contact": "",
    "exclude": "name body1 body2",
    "pair": "name class geom1 geom2 condim friction solref solimp margin gap",
    "equality": "",
    "weld": "name class body1 body2 relpose solref solimp torquescale anchor site1 site2",
    "connect": "name class body1 body2 anchor solref solimp site1 site2",
    "tendon": f"{_TENDON} width rgba material",
    "fixed": _TENDON,
    "spatial": f"{_TENDON} width rgba material",
    "pulley": "divisor",
    "actuator": "",
    "general": (
        "name class biasprm biastype ctrllimited ctrlrange dynprm dyntype forcelimited forcerange"
        " gainprm gaintype gear input joint tendon site refsite group actlimited actrange actearly"
        " lengthrange"
    ),
    "position": ("name class joint kp kv ctrlrange forcerange ctrllimited forcelimited gear group"),
    "sensor": "",
    "actuatorfrc": "name actuator",
    "jointpos": "name joint",
    "jointvel": "name joint",
    "touch": "name site",
    "framepos": "name objtype objname reftype refname",
    "framequat": "name objtype objname reftype refname",
    "keyframe": "",
    "key": "name time qpos qvel act ctrl mpos mquat",
}
"""Attributes that each element may have."""
MAX_PIXELS = 1024 * 6144
"""Largest texture."""


def trusted_xml(xml: str, assets: Mapping[str, bytes]) -> str:
    """Return a model's XML as it was understood here, if it may be given to MuJoCo.

    What is returned is written anew, so that MuJoCo cannot read it otherwise than it was checked.

    Parameters
    ----------
    xml
        As stored.
    assets
        The files stored with it, which are the only ones it may name.

    Raises
    ------
    InputError
        If it is no XML, or holds what scenes of this package do not.
    """
    if "<!DOCTYPE" in xml or "<!ENTITY" in xml:
        raise InputError("its model declares entities, which no model needs; remove them")
    try:
        root = ET.fromstring(xml)
    except ET.ParseError as error:
        raise InputError(f"its model is not XML ({error}); make it again") from error
    for element in root.iter():
        if element.tag not in _ALLOWED:
            raise InputError(
                f"its model holds <{element.tag}>, which could read files or fill the memory;"
                " only elements of scenes made by handsim are accepted"
            )
        other = set(element.attrib) - set(_ALLOWED[element.tag].split())
        if other:
            raise InputError(
                f"its model's <{element.tag}> has the attribute {min(other)};"
                " only those of scenes made by handsim are accepted"
            )
        if element.get("file", "") not in ("", *assets):
            raise InputError(
                f"its model names the file '{element.get('file')}', which is not stored with it;"
                " a rollout holds all that it needs"
            )
    for texture in root.iter("texture"):
        _check_texture(texture)
    return ET.tostring(root, encoding="unicode")


def _check_texture(texture: ET.Element) -> None:
    width, height = texture.get("width", "0"), texture.get("height", "0")
    small = width.isdecimal() and height.isdecimal() and len(width + height) < 12
    if not small or int(width) * int(height) > MAX_PIXELS:
        raise InputError(
            f"its model has a texture of {width} x {height} pixels; {MAX_PIXELS} in all are the"
            " limit"
        )
