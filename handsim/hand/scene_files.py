"""What lies beside a model's file, as in MuJoCo's Menagerie: keyframes, and scenes to see it in.

``scene_right.xml`` includes the model and ``keyframes_right.xml``. ``scene_both.xml`` attaches both
sides, names begin with ``right_`` and ``left_``, coordinates and actuators of the right one come
first.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from handsim.files import read_text, write_text
from handsim.types import SIDES, Array, Side

Keyframes = Mapping[str, tuple[Array, Array]]
"""Joint positions and actuator targets by the keyframe's name, each (n,) [rad]."""

_SCENE = """<mujoco model="{title} scene">
{models}
  <include file="keyframes_{which}.xml"/>

  <statistic center="{centre}" extent="{extent:g}"/>

  <visual>
    <headlight ambient="{ambient}" diffuse="{diffuse}" specular="0 0 0"/>
    <global azimuth="{azimuth:g}" elevation="{elevation:g}"/>
    <quality shadowsize="4096"/>
  </visual>

  <asset>
    <texture name="sky" type="skybox" builtin="gradient" rgb1="0.93 0.95 0.98" rgb2="0.75 0.8 0.86" width="64" height="384"/>
{assets}
  </asset>

  <worldbody>
    <light name="above" directional="true" pos="0.3 {light:g} 1" dir="-0.3 {shine:g} -1" diffuse="0.5 0.5 0.5"/>
{bodies}
  </worldbody>
</mujoco>
"""  # noqa: E501  (MJCF has one element a line)


@dataclass(frozen=True)
class Surroundings:
    """What is around a model in its scene, and from where it is seen.

    Attributes
    ----------
    kind
        Of the model: ``hand`` for ``right_hand.xml``.
    root
        The body of the model that is attached where both sides are in a scene.
    apart
        How far either side then is from the middle [m].
    centre, extent, azimuth, elevation
        What is looked at, of a right model (3,) [m], how large it is [m], and from where [deg].
    ambient, diffuse
        Of the light from the camera.
    assets, bodies
        MJCF of a table or a floor.
    include
        A further file of what both sides share.
    """

    kind: str
    root: str
    apart: float
    centre: tuple[float, float, float]
    extent: float
    azimuth: float
    elevation: float
    ambient: float
    diffuse: float
    assets: tuple[str, ...]
    bodies: tuple[str, ...]
    include: str | None = None

    def scene(self, side: Side) -> str:
        """Return the scene of one side."""
        mirror = 1.0 if side == "right" else -1.0
        model = f'  <include file="{side}_{self.kind}.xml"/>'
        x, y, z = self.centre
        return self._text(side, f"{side} {self.kind}", model, (x, mirror * y, z), mirror, ())

    def scene_of_both(self, option: str) -> str:
        """Return the scene of both sides, which is to have the options of the models."""
        models = ['  <compiler angle="radian"/>', f"  {option}", "", "  <asset>"]
        models += [f'    <model name="{side}" file="{side}_{self.kind}.xml"/>' for side in SIDES]
        models.append("  </asset>")
        if self.include:
            models = [f'  <include file="{self.include}"/>', *models]
        attached: list[str] = []
        for side, y in zip(SIDES, (0.0 - self.apart, self.apart), strict=True):
            attached += [
                f'    <frame pos="0 {y:g} 0">',
                f'      <attach model="{side}" body="{self.root}" prefix="{side}_"/>',
                "    </frame>",
            ]
        centre = (self.centre[0], 0.0, self.centre[2])
        title = f"both {self.kind}s"
        return self._text("both", title, "\n".join(models), centre, 1.0, attached)

    def _text(
        self,
        which: str,
        title: str,
        models: str,
        centre: tuple[float, float, float],
        mirror: float,
        attached: tuple[str, ...] | list[str],
    ) -> str:
        both = which == "both"
        return _SCENE.format(
            title=title,
            models=models,
            which=which,
            centre=_numbers(np.array(centre)),
            extent=self.extent + 2 * self.apart if both else self.extent,
            ambient=_numbers(np.full(3, self.ambient)),
            diffuse=_numbers(np.full(3, self.diffuse)),
            azimuth=180 if both else mirror * self.azimuth,
            elevation=self.elevation,
            light=mirror * 0.5,
            shine=-mirror * 0.5,
            assets="\n".join(f"    {line}" for line in self.assets),
            bodies="\n".join([*(f"    {line}" for line in self.bodies), *attached]),
        )


def write_beside(folder: Path, side: Side, around: Surroundings, keyframes: Keyframes) -> None:
    """Write the keyframes and the scene of one side beside its model.

    Raises
    ------
    FileError
        If a file cannot be written.
    """
    write_text(folder / f"keyframes_{side}.xml", keyframes_text(keyframes))
    write_text(folder / f"scene_{side}.xml", around.scene(side))


def write_both(folder: Path, around: Surroundings, keyframes: Mapping[Side, Keyframes]) -> None:
    """Write the scene of both sides, whose models lie in the folder, and keyframes for it.

    Raises
    ------
    FileError
        If a file cannot be read or written.
    """
    right, left = (keyframes[side] for side in SIDES)
    together = {
        name: (np.concatenate([qpos, left[name][0]]), np.concatenate([ctrl, left[name][1]]))
        for name, (qpos, ctrl) in right.items()
    }
    option = re.search(r"<option [^>]*/>", read_text(folder / f"right_{around.kind}.xml"))
    assert option is not None  # set_physics sets some
    write_text(folder / "keyframes_both.xml", keyframes_text(together))
    write_text(folder / "scene_both.xml", around.scene_of_both(option.group()))


def keyframes_text(keyframes: Keyframes) -> str:
    """Return MJCF to be included by a scene, with the digits that MuJoCo writes."""
    rows = [
        f'    <key name="{name}" qpos="{_numbers(qpos)}" ctrl="{_numbers(ctrl)}"/>'
        for name, (qpos, ctrl) in keyframes.items()
    ]
    return "\n".join(["<mujoco>", "  <keyframe>", *rows, "  </keyframe>", "</mujoco>", ""])


def _numbers(values: Array) -> str:
    return " ".join(f"{value:.6g}" for value in values + 0.0)
