"""Words by which people and makers name fingers, joints and units, and what a header means by them.

Known are CyberGlove's names (``IndexPIJ``, ``ThumbRotate``, ``PalmArch``), those of game engines
and other gloves (``Index_MCP_Flex``, ``index_proximal_flexion``, ``ThumbCMCSpread``), of anatomy by
numbers (``MCP2-3_A``, ``CMC5_F``), numbered fingers (``Finger2_Joint1``), and German and French.
"""

import re
import unicodedata
from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal, TypeVar

from handsim.types import Side

AngleUnit = Literal["deg", "rad", "counts"]
Key = TypeVar("Key", bound=str)

_FINGERS = {
    "thumb": "thumb thmb th daumen pouce pollex",
    "index": "index ind idx zeige zeigefinger pointer pointing fore forefinger ff",
    "middle": "middle mid mittel mittelfinger majeur medius long mf",
    "ring": "ring ringfinger annulaire annular rf",
    "little": "little pinky pinkie pink small klein kleiner kleinerfinger auriculaire petit lf",
}
_KINDS = {
    "mcp": "mcp mpj mp mcpj inner proximal knuckle base grundgelenk metacarpophalangeal",
    "pip": "pip pij pipj intermediate medial mittelgelenk",
    "dip": "dip dij dipj outer distal endgelenk",
    "ip": "ip ipj interphalangeal",
    "cmc": "cmc tmc carpometacarpal metacarpal trapeziometacarpal sattelgelenk",
    "spread": "ab abd abduction adduction add aa abad abdadd spread splay spreizung spreizen "
    "abspreizung ecart ecartement lateral",
    "rotation": "rotate rotation rot roll opposition tmj oppo opp twist",
    "flexion": "flex flexion flx bend bending curl stretch beugung flexions fe flexext pitch "
    "extension ext streckung",
    "deviation": "yaw dev deviation radial ulnar rud rad_uln",
    "wrist": "wrist handgelenk poignet carpus carpal wr",
    "palm": "palm palmar arch palmarch hohlhand woelbung wolbung handwolbung paume voute",
}
_SIDES: dict[Side, str] = {
    "left": "left lh lefthand links linke gauche",
    "right": "right rh righthand rechts rechte droite",
}
_OTHER_WORDS = (
    "pos position x y z w qx qy qz qw quat acc accel gyro emg force pressure vel velocity speed "
    "temperature temp tip target cmd command torque current error status contact mag elbow "
    "shoulder object load"
)
_OTHER_THINGS = frozenset(_OTHER_WORDS.split())
_NOISE_WORDS = (
    "joint angle angles sensor sens glove hand finger fingers digit value raw the of j channel ch "
    "gelenk winkel doigt articulation cg data"
)
_NOISE = frozenset(_NOISE_WORDS.split())
_UNITS: dict[AngleUnit, str] = {
    "deg": "deg degree degrees grad ° º",
    "rad": "rad radian radians",
    "counts": "count counts raw adc",
}
_OPPOSITE = frozenset({"extension", "ext", "streckung", "adduction", "add"})
_ALONG = frozenset({"flexion", "flex", "abduction", "abd", "beugung"})


def _words(table: Mapping[Key, str]) -> dict[str, Key]:
    return {word: key for key, words in table.items() for word in words.split()}


_FINGER_OF, _KIND_OF, _SIDE_OF = _words(_FINGERS), _words(_KINDS), _words(_SIDES)
_UNIT_OF = _words(_UNITS)
_KNOWN = frozenset({*_FINGER_OF, *_KIND_OF, *_SIDE_OF, *_NOISE})
_PARTS = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z°º]+|[A-Z]+|\d+")
_PAIRS = {("index", "middle"): "index", ("middle", "ring"): "ring", ("ring", "little"): "little",
          ("thumb", "index"): "thumb"}  # fmt: skip
_BY_NUMBER = ("thumb", "index", "middle", "ring", "little")
_PLACES = ("mcp", "pip", "dip")
_THUMB: tuple[tuple[str, dict[str, float]], ...] = (
    ("spread", {"thumb_abduction": 1.0}),
    ("rotation", {"thumb_rotation": 1.0}),
    ("dip", {"thumb_ip": 1.0}),
    ("pip", {"thumb_ip": 0.6, "thumb_mcp": 0.5}),
    ("cmc", {"thumb_rotation": 0.7}),
    ("mcp", {"thumb_mcp": 1.0}),
)


def words_of(header: str) -> list[str]:
    """Return the words of a name, lower case, without accents; ``IndexPIJ`` has two."""
    bare = unicodedata.normalize("NFKD", header.replace("ß", "ss"))
    bare = "".join(c for c in bare if not unicodedata.combining(c))
    found: list[str] = []
    for part in _PARTS.findall(bare):
        word = part.lower()
        found += [word] if word in _KNOWN or word in _OTHER_THINGS else _segments(word)
    return found


def _segments(word: str) -> list[str]:
    """Split a word into known ones if they are all of it; the longest first."""
    if len(word) > 40:
        return [word]
    for end in range(len(word) - 1, 1, -1):
        if word[:end] in _KNOWN:
            rest = word[end:]
            further = [rest] if rest in _KNOWN or rest in _UNIT_OF else _segments(rest)
            if all(each in _KNOWN or each in _UNIT_OF for each in further):
                return [word[:end], *further]
    return [word]


def unit_of(header: str, row_unit: str = "") -> AngleUnit | None:
    """Return the unit of an angle that the row of units or a header says; None if neither does."""
    for text in (row_unit, *re.findall(r"[\[(]([^\])]*)[\])]", header)):
        unit = _UNIT_OF.get(text.strip("[]() ").lower())
        if unit is not None:
            return unit
    words = re.split(r"[\s_\-./:]+", header.strip().lower())
    return _UNIT_OF.get(words[-1]) if len(words) > 1 else None


def side_of(header: str) -> Side | None:
    """Return the side that a name says, by a word or by an L or R that stands alone."""
    words = words_of(header)
    for word in words:
        if word in _SIDE_OF:
            return _SIDE_OF[word]
    ends: dict[str, Side] = {"l": "left", "r": "right"}
    return ends.get(words[0]) or ends.get(words[-1]) if len(words) > 1 else None


def turned_around(header: str) -> bool:
    """Whether a name says extension or adduction, and not what is positive in this project."""
    words = set(words_of(header))
    return bool(words & _OPPOSITE) and not words & _ALONG


def likeness(header: str, thumb_number: int = 1) -> Mapping[str, float]:
    """Return how like a name is to those of joints: joint to score, 1 for one that says it.

    Parameters
    ----------
    header
    thumb_number
        Number of the thumb where fingers are numbered; 0 where the numbers leave it out and start
        at 1 with the index finger, or count from 0.
    """
    words = [w for w in words_of(header) if w not in _SIDE_OF and w not in _UNIT_OF]
    other = any(word in _OTHER_THINGS for word in words)
    last = {"a": "spread", "f": "flexion"}.get(words[-1] if words else "")
    kinds = {_KIND_OF[w] for w in words if w in _KIND_OF} | ({last} if last else set())
    fingers = [_FINGER_OF[w] for w in words if w in _FINGER_OF]
    numbers = [int(w) for w in words if w.isdecimal() and len(w) < 3]
    sure = 1.0
    if not fingers and numbers and ("finger" in words or kinds & {*_PLACES, "ip", "cmc", "spread"}):
        sure = 0.75 if "finger" in words or thumb_number != 1 else 0.9
        count = 2 if "spread" in kinds and "finger" not in words else 1
        places = [n - thumb_number for n in numbers[:count]]
        fingers = [_BY_NUMBER[p] for p in places if 0 <= p < len(_BY_NUMBER)]
        numbers = numbers[count:]
    scores = _of_hand(kinds, fingers)
    if not scores and fingers:
        scores = _of_finger(kinds, fingers, numbers, words)
    factor = sure * (0.3 if other else 1.0)
    return MappingProxyType({name: round(score * factor, 3) for name, score in scores.items()})


def _of_hand(kinds: set[str], fingers: list[str]) -> dict[str, float]:
    """Scores of the joints that are no finger's."""
    if "wrist" in kinds and not fingers:
        if kinds & {"deviation", "spread"}:
            return {"wrist_deviation": 1.0}
        return {"wrist_flexion": 1.0 if "flexion" in kinds else 0.4}
    if "palm" in kinds and not set(fingers) - {"little"}:
        return {"palm_arch": 1.0}
    return {}


def _of_finger(
    kinds: set[str], fingers: list[str], numbers: list[int], words: list[str]
) -> dict[str, float]:
    finger = fingers[0]
    if finger == "thumb":
        return _of_thumb(kinds, numbers)
    if fingers == ["little"] and "cmc" in kinds:
        return {"palm_arch": 0.9}
    if "spread" in kinds or "deviation" in kinds:
        return _of_spreading(fingers)
    if kinds >= {"mcp", "ip"} and "proximal" in words:
        place = "pip"
    else:
        place = next((place for place in ("dip", "pip", "mcp") if place in kinds), None)
    if place is None and fingers[1:] == ["middle"]:  # "index middle": middle joint of the index
        place = "pip"
    if place is not None:
        return {f"{finger}_{place}": 1.0}
    if len(numbers) == 1 and 1 <= numbers[0] <= 3:
        return {f"{finger}_{_PLACES[numbers[0] - 1]}": 0.7}
    return {f"{finger}_mcp": 0.4}


def _of_spreading(fingers: list[str]) -> dict[str, float]:
    pair = next((f for p, f in _PAIRS.items() if set(fingers[:2]) == set(p)), None)
    if pair is None and fingers[0] == "middle":
        return {"index_abduction": 0.5}  # the reference, unless there is none of the index
    return {f"{pair or fingers[0]}_abduction": 1.0}


def _of_thumb(kinds: set[str], numbers: list[int]) -> dict[str, float]:
    if "ip" in kinds and "mcp" not in kinds:
        kinds = kinds | {"dip"}
    said = next((scores for kind, scores in _THUMB if kind in kinds), None)
    if said is not None:
        return said
    if len(numbers) == 1 and 1 <= numbers[0] <= 3:
        return {f"thumb_{('rotation', 'mcp', 'ip')[numbers[0] - 1]}": 0.7}
    return {"thumb_mcp": 0.4}
