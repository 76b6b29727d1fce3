"""Draw the sheet of all objects: ``python assets/objects/sheet.py assets/objects.png``.

MuJoCo takes its OpenGL from the environment variable ``MUJOCO_GL``.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import argparse
from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from handsim.objects.mjcf import OBJECTS
from handsim.tasks.scene import build_scene
from handsim.viewing.film.video import write_image

Picture = npt.NDArray[np.uint8]

COLUMNS = 5
WIDTH, HEIGHT = 320, 280
"""Of one object's picture."""


def portrait(name: str) -> Picture:
    """Return one object as it rests on the table, (HEIGHT, WIDTH, 3)."""
    model = build_scene(name, None).compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=50)
    camera = mujoco.MjvCamera()
    shown = model.geom_group == 2
    shown[model.geom("table_top").id] = False
    reach = np.linalg.norm(model.geom_aabb[shown, 3:], axis=1).max()
    camera.lookat = data.geom_xpos[shown].mean(axis=0)
    camera.distance, camera.azimuth, camera.elevation = 0.10 + 2.6 * reach, -130.0, -32.0
    with mujoco.Renderer(model, HEIGHT, WIDTH) as renderer:
        renderer.update_scene(data, camera)
        renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
        picture = Image.fromarray(renderer.render())
    ImageDraw.Draw(picture).text((10, 8), name, fill=(30, 30, 30), font_size=18)
    return np.asarray(picture)


def sheet() -> Picture:
    """Return the portraits of all objects in rows of `COLUMNS`."""
    pictures = [portrait(name) for name in OBJECTS]
    blank = np.full_like(pictures[0], 255)
    pictures += [blank] * (-len(pictures) % COLUMNS)
    rows = [np.hstack(pictures[i : i + COLUMNS]) for i in range(0, len(pictures), COLUMNS)]
    return np.vstack(rows)


def main() -> None:
    """Write the sheet to the file named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    write_image(sheet(), parser.parse_args().file)


if __name__ == "__main__":
    main()
