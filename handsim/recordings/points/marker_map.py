"""Which marker is what: from a TOML file, or by likeness of names.

The file::

    side = "right"             # of the hand; may be left out
    unit = "mm"                # of the coordinates: m, cm or mm; may be left out
    wrist = true               # its angles from one marker at the elbow; false: they stay 0

    [markers]
    hand_top = "palm"          # a role: palm, <finger>_tip, _middle, _dip, _pip, _mcp (the thumb:
    thumb_tip = "thumb_tip"    # _tip, _middle, _ip, _mcp, _cmc), forearm, elbow, shoulder, torso,
    cup1 = "object"            # object, ignore
    M17 = { body = "index_middle", place_mm = [12, 0, 9] }   # in the frame of a body of the hand

Markers that the file does not name are ignored.
"""

import re
import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from handsim.errors import FileError, InputError, UnknownNameError
from handsim.files import read_text
from handsim.hand.kinematics import Kinematics
from handsim.recordings.fitting.hand_points import HandPoint
from handsim.recordings.points.marker_roles import HAND_ROLES, MarkerRoles, check_role, own_place
from handsim.types import SIDES, Side

LENGTH_UNITS: Mapping[str, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001}
"""Metres of a unit."""
_FINGER_WORDS = {
    "thumb": "thumb", "index": "index", "fore": "index", "pointer": "index", "middle": "middle",
    "long": "middle", "ring": "ring", "little": "little", "pinky": "little", "pinkie": "little",
    "small": "little",
}  # fmt: skip
_PLACE_WORDS = {
    "tip": "tip", "nail": "tip", "end": "tip", "fingertip": "tip", "distal": "tip", "dip": "dip",
    "pip": "pip", "ip": "ip", "mcp": "mcp", "knuckle": "mcp", "base": "mcp", "root": "mcp",
    "cmc": "cmc", "middle": "middle", "mid": "middle",
}  # fmt: skip
_PART_WORDS = {
    "hand": "palm", "palm": "palm", "dorsum": "palm", "metacarpal": "palm", "forearm": "forearm",
    "wrist": "forearm", "radius": "forearm", "ulna": "forearm", "elbow": "elbow",
    "epicondyle": "elbow", "shoulder": "shoulder", "acromion": "shoulder", "back": "torso",
    "chest": "torso", "torso": "torso", "trunk": "torso", "sternum": "torso", "spine": "torso",
    "head": "ignore", "hip": "ignore", "pelvis": "ignore", "knee": "ignore", "foot": "ignore",
}  # fmt: skip
_OBJECT_WORDS = frozenset({"object", "obj", "target", "item"})


@dataclass(frozen=True)
class MarkerMap:
    """What a map file says.

    Attributes
    ----------
    roles
        As in `MarkerRoles`.
    own_places
    side, metres_per_unit
        None where it says nothing.
    wrist
        Whether the wrist's angles are taken from the elbow's markers; None where nothing is said:
        from two or more, which show where the joint's centre is.
    """

    roles: Mapping[str, str]
    own_places: Mapping[str, HandPoint]
    side: Side | None
    metres_per_unit: float | None
    wrist: bool | None = None


def read_marker_map(path: Path) -> MarkerMap:
    """Read a map file.

    Raises
    ------
    FileError
        If it is missing, no TOML, or says what is not understood; the message names the entry.
    """
    try:
        content = tomllib.loads(read_text(path))
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise FileError(f"{path}: not readable as TOML ({str(error).splitlines()[0]})") from error
    unknown = sorted(set(content) - {"side", "unit", "wrist", "markers"})
    if unknown:
        raise FileError(
            f"{path}: '{unknown[0]}' is not understood; give side, unit, wrist and markers"
        )
    markers = content.get("markers")
    if not isinstance(markers, dict) or not markers:
        raise FileError(f"{path}: holds no table [markers]; give one with a line for each marker")
    side, unit = content.get("side"), content.get("unit")
    if side is not None and side not in SIDES:
        raise FileError(f"{path}: side = {side!r}; give right or left")
    if unit is not None and unit not in LENGTH_UNITS:
        raise FileError(f"{path}: unit = {unit!r}; give m, cm or mm")
    wrist = content.get("wrist")
    if wrist is not None and not isinstance(wrist, bool):
        raise FileError(f"{path}: wrist = {wrist!r}; give true or false")
    roles: dict[str, str] = {}
    places: dict[str, HandPoint] = {}
    for name, said in markers.items():
        try:
            if isinstance(said, str):
                roles[name] = check_role(said)
            else:
                places[name] = _own_place(name, said)
        except InputError as error:
            raise FileError(f"{path}: marker {name}: {error}") from error
    factor = None if unit is None else LENGTH_UNITS[unit]
    return MarkerMap(roles, places, side, factor, wrist)


def _own_place(name: str, said: Any) -> HandPoint:
    body = said.get("body") if isinstance(said, dict) else None
    place = said.get("place_mm") if isinstance(said, dict) else None
    if (
        not isinstance(body, str)
        or not isinstance(place, list)
        or len(place) != 3
        or not all(isinstance(each, int | float) and abs(each) <= 1000 for each in place)
    ):
        raise InputError(
            "give a role in quotes, or { body = 'index_middle', place_mm = [12, 0, 9] }"
        )
    if body not in Kinematics().names:
        raise UnknownNameError("body", body, Kinematics().names)
    return own_place(name, body, (float(place[0]), float(place[1]), float(place[2])))


def roles_of_map(path: Path, content: MarkerMap, names: Sequence[str]) -> MarkerRoles:
    """Return the roles that a map gives to the markers of a recording.

    Raises
    ------
    FileError
        If the map names a marker that the recording does not have.
    """
    named = [*content.roles, *content.own_places]
    missing = [name for name in named if name not in names]
    if missing:
        raise FileError(
            f"{path}: marker {missing[0]} is not in the recording, which has "
            f"{', '.join(names)[:300]}; correct its name"
        )
    notes = (f"markers by {path.name}",)
    return MarkerRoles(content.roles, content.own_places, notes)


def roles_by_name(names: Sequence[str]) -> MarkerRoles:
    """Return the roles that names of markers suggest.

    Names of which no word is known are an object's if three or more of them begin alike.
    """
    roles = {name: _role_by_name(name) for name in names}
    unknown = [name for name, role in roles.items() if role == ""]
    families = Counter(_words(name)[0] for name in unknown if _words(name))
    family = next((first for first, count in families.most_common() if count >= 3), None)
    for name in unknown:
        words = _words(name)
        is_object = bool(words) and (words[0] == family or bool(_OBJECT_WORDS & set(words)))
        roles[name] = "object" if is_object else "ignore"
    said = ", ".join(f"{name} as {role}" for name, role in roles.items() if name != role)
    return MarkerRoles(roles, {}, (f"markers by their names: {said}" if said else "",))


def _words(name: str) -> list[str]:
    """Words of a name in small letters: Index_MCP, rightIndexTip, hand:R_thumb 2."""
    spaced = re.sub(r"([a-z])([A-Z])", r"\1 \2", name.rsplit(":", maxsplit=1)[-1])
    return re.findall(r"[a-z]+", spaced.lower())


def _role_by_name(name: str) -> str:
    """Return a role, or nothing where no word is known."""
    words = [word for word in _words(name) if word not in ("right", "left", "r", "l", "finger")]
    finger = next((_FINGER_WORDS[w] for w in words if w in _FINGER_WORDS and w != "middle"), None)
    rest = [word for word in words if word not in _FINGER_WORDS or word == "middle"]
    if finger is None and "middle" in rest:
        finger = "middle"
        rest.remove("middle")
    if finger is not None:
        place = next((_PLACE_WORDS[word] for word in rest if word in _PLACE_WORDS), "")
        if f"{finger}_{place}" in HAND_ROLES:
            return f"{finger}_{place}"
    return next((_PART_WORDS[word] for word in words if word in _PART_WORDS), "")


def side_by_name(names: Sequence[str]) -> Side | None:
    """Return the side that names of arm markers agree in; None if they do not say."""
    sides: set[Side] = set()
    for name in names:
        words = _words(name)
        sides |= {"right"} if {"right", "r"} & set(words[:1]) else set()
        sides |= {"left"} if {"left", "l"} & set(words[:1]) else set()
    return sides.pop() if len(sides) == 1 else None
