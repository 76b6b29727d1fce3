"""Names of palm and fingertips of published hands. The files are the user's own.

Names alone: where the frames are in the links is measured on the file itself, since files of the
same hand differ in it. Link names were taken from the vendors' and common public descriptions of
these hands (MuJoCo Menagerie, dex-urdf, Adroit, OpenAI Gym, the makers' ROS packages).
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from handsim.joints import FINGERS, Finger

_PREFIX = r"(?:.*[/:])?(?:(?:rh|lh|r|l|right|left|robot\d*|hand)[_.\-]*)*(?:hand_)?"
"""What makers and users put before names of links: side, number of the robot, name of the hand."""


@dataclass(frozen=True)
class Preset:
    """A published hand by its names, without what stands before them.

    Attributes
    ----------
    name
        Of the hand, or of the hands that share these names.
    palm
        Names of the link of the palm, the first that is there.
    fingertips
        Names of the last link of each finger, the first that is there.
    knuckles
        Joints at which fingers begin, where that is not the first of their own.
    joints
        Joints that must be there, to tell hands apart whose links have the same names.
    others
        Links that must not be there, for the same reason: those of fingers that the hand has not.
    """

    name: str
    palm: tuple[str, ...]
    fingertips: Mapping[Finger, tuple[str, ...]]
    knuckles: Mapping[Finger, str] = field(default_factory=dict[Finger, str])
    joints: tuple[str, ...] = ()
    others: tuple[str, ...] = ()


def _all(*names: str) -> dict[Finger, tuple[str, ...]]:
    """Return the names for thumb to little finger; those of one finger are parted by ``|``."""
    return {f: tuple(n.split("|")) for f, n in zip(FINGERS, names, strict=False) if n}


_ANATOMIC = _all("thdistal", "ffdistal", "mfdistal", "rfdistal", "lfdistal")
_INSPIRE = _all(
    "thumb_distal|thumb_4", "index_intermediate|index_2|index_distal",
    "middle_intermediate|middle_2|middle_distal", "ring_intermediate|ring_2|ring_distal",
    "pinky_intermediate|little_2|pinky_distal|little_distal",
)  # fmt: skip

PRESETS: tuple[Preset, ...] = (
    Preset("Shadow", ("palm",), _ANATOMIC, {"little": "LFJ4"}, ("LFJ5", "FFJ4")),
    # Adroit took links and joints from Shadow's first models, which counted the joints from 0.
    Preset("Shadow or Adroit", ("palm",), _ANATOMIC, {"little": "LFJ3"}, ("LFJ4", "FFJ0")),
    Preset(
        "Shadow",
        ("palm",),
        _all("thdistal", "ffdistal", "mfdistal", "rfdistal"),
        others=("lfdistal",),
    ),
    Preset("Allegro", ("palm",), _all("th_tip", "ff_tip", "mf_tip", "rf_tip"), others=("lf_tip",)),
    Preset(
        "Allegro",
        ("base_link", "palm", "palm_link"),
        _all(
            "link_15.0_tip|link_15_tip|link_15.0|link_15",
            "link_3.0_tip|link_3_tip|link_3.0|link_3",
            "link_7.0_tip|link_7_tip|link_7.0|link_7",
            "link_11.0_tip|link_11_tip|link_11.0|link_11",
        ),
    ),
    Preset(
        "LEAP",
        ("palm_lower", "palm"),
        _all("thumb_fingertip", "fingertip", "fingertip_2", "fingertip_3"),
    ),
    Preset("LEAP", ("palm", "palm_lower"), _all("th_ds", "if_ds", "mf_ds", "rf_ds")),
    Preset(
        "Ability",
        ("thumb_base", "base"),
        _all("thumb_L2", "index_L2", "middle_L2", "ring_L2", "pinky_L2"),
    ),
    Preset("Inspire", ("base_link", "palm", "palm_link", "base"), _INSPIRE),
    Preset("SVH", ("e1", "base_link"), _all("c", "t", "s", "r", "q"), joints=("Thumb_Opposition",)),
    Preset(
        "Barrett",
        ("base_link", "palm_link", "bh_base_link", "bhand_palm_link"),
        _all(
            "finger_3_dist_link|bh_finger_33_link|finger_3/dist_link|finger_33_link",
            "finger_1_dist_link|bh_finger_13_link|finger_1/dist_link|finger_13_link",
            "finger_2_dist_link|bh_finger_23_link|finger_2/dist_link|finger_23_link",
        ),
    ),
)
"""The first that fits is taken."""


@dataclass(frozen=True)
class NamedLinks:
    """Names in a file that play the parts of a hand.

    Attributes
    ----------
    hand
        Whose names these are. Other hands may have taken them over.
    palm
        A body; empty where none of the names is there.
    fingertips
        Bodies.
    knuckles
        Joints.
    """

    hand: str
    palm: str
    fingertips: Mapping[Finger, str]
    knuckles: Mapping[Finger, str]


def recognise(bodies: Sequence[str], joints: Sequence[str]) -> NamedLinks | None:
    """Return the published hand whose names these are, or None.

    Parameters
    ----------
    bodies, joints
        Names in the file.
    """
    for preset in PRESETS:
        tips: dict[Finger, str] = {
            f: _find(names, bodies) for f, names in preset.fingertips.items()
        }
        knuckles: dict[Finger, str] = {
            f: _find((name,), joints) for f, name in preset.knuckles.items()
        }
        needed = [_find((name,), joints) for name in preset.joints]
        if _find(preset.others, bodies):
            continue
        if all(tips.values()) and all(knuckles.values()) and all(needed):
            return NamedLinks(preset.name, _find(preset.palm, bodies), tips, knuckles)
    return None


def _find(names: Sequence[str], among: Sequence[str]) -> str:
    """Return the first of the names that is there, with whatever stands before it."""
    for name in names:
        pattern = re.compile(_PREFIX + re.escape(name), re.IGNORECASE)
        found = next((each for each in among if len(each) < 200 and pattern.fullmatch(each)), "")
        if found:
            return found
    return ""
