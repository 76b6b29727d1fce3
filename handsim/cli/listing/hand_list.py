"""`handsim hands`: people's hands that can be built, and robot hands known by name."""

from typing import TYPE_CHECKING, Any

from handsim.cli.console import JsonFlag, say, say_json, say_wrapped

if TYPE_CHECKING:
    from handsim.robot_hands.presets import Preset

_OR = "*"
"""Marks hands whose links have one of several names."""


def hands(json: JsonFlag = False) -> None:
    """List the hands: people's by size, robots' by name."""
    from handsim.hand.anthropometry import HAND_BREADTH_RANGE, HAND_LENGTH_RANGE
    from handsim.hand.population import PRESETS as SIZES
    from handsim.robot_hands.presets import PRESETS as ROBOT_HANDS

    robots = [_as_dict(each) for each in ROBOT_HANDS]
    if json:
        sizes = [
            {"name": n, "length_m": s.length, "breadth_m": s.breadth} for n, s in SIZES.items()
        ]
        say_json(
            {
                "sizes": sizes,
                "length_range_m": HAND_LENGTH_RANGE,
                "breadth_range_m": HAND_BREADTH_RANGE,
                "robot_hands": robots,
            }
        )
        return
    say("People's hands: percentiles of adults, right or left")
    for name, size in SIZES.items():
        options = f"--hand-length {size.length:g} --hand-breadth {size.breadth:g}"
        say(f"  {name:<10}{_mm(size.length)} x {_mm(size.breadth)} mm   {options}")
    say_wrapped(
        "These are options of `handsim grasp` and `handsim hand build`; --side left mirrors them. "
        "SWEEP.toml of `handsim sweep` takes the names. "
        f"Lengths from {_mm(HAND_LENGTH_RANGE[0])} to {_mm(HAND_LENGTH_RANGE[1])} mm and breadths "
        f"from {_mm(HAND_BREADTH_RANGE[0])} to {_mm(HAND_BREADTH_RANGE[1])} mm can be built.",
        indent=2,
    )
    say("")
    say_wrapped(
        "Robot hands known by name, and the links and joints that their files need; side and maker "
        "may stand before a name"
    )
    width = 2 + max(len(each["name"]) for each in robots)
    for each in robots:
        _show(each, width)
    say_wrapped(f"{_OR} or other names, which --json lists", indent=2)
    say_wrapped(
        "`handsim hand inspect FILE -o sheet.png` reads MJCF or URDF, draws where palm and "
        "fingertips are, and writes sheet.toml. It reads other hands as well: correct sheet.toml "
        "where the picture is wrong, and give it by --map. `handsim grasp --hand FILE` lets the "
        "hand follow a controller.",
        indent=2,
    )


def _show(robot: dict[str, Any], width: int) -> None:
    tips = ", ".join(names[0] for names in robot["fingertips"].values())
    joints = [*robot["knuckles"].values(), *robot["joints"]]
    needed = f"; joints {', '.join(joints)}" if joints else ""
    several = any(len(names) > 1 for names in (robot["palm"], *robot["fingertips"].values()))
    text = f"{robot['palm'][0]}, {tips}{needed}"
    first = f"{_OR if several else '':<2}{robot['name']:<{width}}"
    say_wrapped(text, indent=len(first), first=first)


def _as_dict(preset: "Preset") -> dict[str, Any]:
    """Return what is known of a robot hand: for each link the names it may have, without prefix."""
    return {
        "name": preset.name,
        "palm": list(preset.palm),
        "fingertips": {finger: list(names) for finger, names in preset.fingertips.items()},
        "knuckles": dict(preset.knuckles),
        "joints": list(preset.joints),
    }


def _mm(length: float) -> str:
    return f"{1000 * length:.0f}"
