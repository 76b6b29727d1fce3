"""What a marker may be: a place on the hand, on the arm or the body, on an object, or nothing."""

from collections.abc import Mapping
from dataclasses import dataclass

from handsim.errors import UnknownNameError
from handsim.hand.anthropometry import CMC, LENGTHS, MCP, RADII, palm_body, segment_names
from handsim.joints import FINGERS, Finger
from handsim.recordings.fitting.hand_points import HandPoint
from handsim.types import MEDIAN_HAND

BODY_ROLES = ("forearm", "elbow", "shoulder", "torso")
OTHER_ROLES = ("object", "ignore")
MARKER_NOISE = 0.004
"""Standard deviation of what is left over at a marker: skin moves under it by millimetres [m]."""
BACK_OF_HAND = 0.22
"""Height of a marker on the back of the hand over the joints' centres, / hand breadth: half of the
33 mm of Pheasant & Haslegrave (2006) and the marker's radius."""
_PALM_SPREAD = (0.060, 0.060, 0.006)
_SPREADS = {"tip": (0.010, 0.004, 0.006), "middle": (0.015, 0.004, 0.006)}
_JOINT_SPREAD = (0.006, 0.004, 0.006)


def _finger_roles(finger: Finger) -> dict[str, HandPoint]:
    """Return the places of a finger that have names, all on its back."""
    segments, lengths, radii = segment_names(finger), LENGTHS[finger], RADII[finger][-3:]

    def on(place: str, segment: int, part: float) -> HandPoint:
        at = (part * lengths[segment], 0.0, radii[segment])
        spread = _SPREADS.get(place, _JOINT_SPREAD)
        return HandPoint(f"{finger}_{place}", segments[segment], at, spread, MARKER_NOISE)

    made = [on("tip", 2, 0.7)]
    if finger == "thumb":
        made += [on("middle", 1, 0.5), on("ip", 1, 0.95), on("mcp", 0, 0.95), on("cmc", 0, 0.1)]
    else:
        made += [on("dip", 1, 0.95), on("middle", 0, 0.8), on("pip", 0, 0.95)]
        body = palm_body(finger)
        x, y = MCP[finger]
        if body == "palm_ulnar":  # its frame begins between the middle and ring carpometacarpals
            x, y = x - CMC["ring"][0], y - CMC["ring"][1] / 2
        knuckle = (x, y, RADII[finger][0])
        made.append(HandPoint(f"{finger}_mcp", body, knuckle, _JOINT_SPREAD, MARKER_NOISE))
    return {each.name: each for each in made}


HAND_ROLES: Mapping[str, HandPoint] = {
    "palm": HandPoint("palm", "palm", (0.25, 0.0, BACK_OF_HAND), _PALM_SPREAD, MARKER_NOISE),
    **{name: point for finger in FINGERS for name, point in _finger_roles(finger).items()},
}
"""Places on the hand by role. ``palm`` is anywhere on its back; ``<finger>_middle`` is about the
finger's middle knuckle, just before the PIP joint."""
ROLES: tuple[str, ...] = (*HAND_ROLES, *BODY_ROLES, *OTHER_ROLES)


@dataclass(frozen=True)
class MarkerRoles:
    """What each marker of a recording is.

    Attributes
    ----------
    roles
        Role by name of marker, one of `ROLES`.
    own_places
        Markers on the hand whose place was given instead of a role.
    notes
        How the roles were found.
    """

    roles: Mapping[str, str]
    own_places: Mapping[str, HandPoint]
    notes: tuple[str, ...] = ()

    def on_hand(self) -> dict[str, HandPoint]:
        """Return the markers on the hand and where they should be."""
        by_role = {
            name: HandPoint(name, each.body, each.place, each.spread, each.noise)
            for name, role in self.roles.items()
            if (each := HAND_ROLES.get(role)) is not None
        }
        return {**by_role, **self.own_places}

    def named(self, role: str) -> list[str]:
        """Return the markers of a role."""
        return [name for name, each in self.roles.items() if each == role]


def check_role(role: str) -> str:
    """Return a role, or say which there are."""
    if role not in ROLES:
        raise UnknownNameError("role of a marker", role, ROLES)
    return role


def own_place(name: str, body: str, place_mm: tuple[float, float, float]) -> HandPoint:
    """Return a marker at a place given in the frame of its body [mm], on a hand of median size."""
    x, y, z = (value / 1000 for value in place_mm)
    scaled = (x / MEDIAN_HAND.length, y / MEDIAN_HAND.breadth, z / MEDIAN_HAND.breadth)
    return HandPoint(name, body, scaled, (0.003, 0.003, 0.003), MARKER_NOISE)
