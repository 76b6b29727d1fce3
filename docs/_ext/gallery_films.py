"""Films of the tasks, made when the documentation is built: ``python gallery_films.py FOLDER``.

Each task is grasped once by the built-in controller with its plans, as `handsim grasp` does. What
is made stays in the folder and is made again only where what it hangs on has changed. This is a
process of its own since one that has rendered must not be forked, as Sphinx does to read pages.
"""

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import handsim
from handsim.errors import MissingToolError, RenderingError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.grasper import ControllerGrasper
from handsim.grasping.planning.plan_store import shipped_plans
from handsim.grasping.rollout.record import Rollout, current_versions
from handsim.learning.controller import GraspController
from handsim.tasks.table_one import TASKS
from handsim.tasks.task import Task

Grasp = Callable[[Task], Rollout]
Draw = Callable[[Rollout, Path, Path], None]
"""Makes a film and its still."""

SIZE, FPS = (320, 240), 10.0
STILL_AT = 0.6
"""Which share of a film has passed at its still: the thing is in the hand there."""
INDEX = "gallery.json"
WITHOUT_PART = ("cli", "testing", "baseline", "environments", "exports")
"""Rooms that neither grasping nor viewing imports."""


def content_digest() -> str:
    """Return a digest of what the films hang on: code, models, assets and versions."""
    package = Path(handsim.__file__).parent
    code = (p for p in package.rglob("*.py") if p.relative_to(package).parts[0] not in WITHOUT_PART)
    data = (p for n in ("models", "assets") for p in data_folder(n).rglob("*") if p.is_file())
    digest = sha256(repr(sorted(current_versions().items())).encode())
    for path in sorted({Path(__file__), *code, *data}):
        if "__pycache__" not in path.parts:
            digest.update(path.name.encode() + b"\0" + sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def read_gallery(folder: Path) -> dict[str, Any] | None:
    """Return what was made in a folder, None where it is not of what there is now or not whole."""
    try:
        found = json.loads((folder / INDEX).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    files = [folder / f"{name}{suffix}" for name in found["tasks"] for suffix in (".mp4", ".png")]
    whole = all(path.is_file() for path in files)  # where nothing rendered, it is tried again
    return found if whole and found["digest"] == content_digest() else None


def make_gallery(folder: Path, tasks: Sequence[Task], grasp: Grasp, draw: Draw) -> dict[str, Any]:
    """Grasp each task, film it, and write down how it was judged.

    Where nothing renders, the reason stands in place of all films; verdicts need no pictures.

    Parameters
    ----------
    folder
        Films and stills of before are removed from it.
    tasks, grasp, draw
    """
    folder.mkdir(parents=True, exist_ok=True)
    for path in (folder / INDEX, *folder.glob("*.mp4"), *folder.glob("*.png")):
        path.unlink(missing_ok=True)
    found: dict[str, Any] = {"digest": content_digest(), "no_films": "", "tasks": {}}
    for task in tasks:
        rollout = grasp(task)
        outcome = rollout.outcome
        found["tasks"][task.name] = {
            "held": outcome.success,
            "reason": outcome.reason,
            "detail": outcome.detail,
        }
        if not found["no_films"]:
            try:
                draw(rollout, folder / f"{task.name}.mp4", folder / f"{task.name}.png")
            except (MissingToolError, RenderingError) as error:
                found["no_films"] = str(error)
    (folder / INDEX).write_text(json.dumps(found, indent=1), encoding="utf-8")
    return found


def built_in_grasp() -> Grasp:
    """Return what grasps a task with the built-in controller; no plan is stored."""
    learned = GraspController.load(data_folder("assets") / "controller.npz")
    conditions = Conditions()
    plans = shipped_plans(learned.digest, conditions)
    grasper = ControllerGrasper(learned, "plan", shared=(plans,), hints=(plans,))
    return lambda task: grasper(task, conditions)


def film(rollout: Rollout, path: Path, still: Path) -> None:
    """Write a small film of a grasp, and a picture of it."""
    from handsim.viewing.film.clips import render_clips
    from handsim.viewing.film.offscreen import View
    from handsim.viewing.film.rollout_clips import rollout_clip
    from handsim.viewing.film.video import write_image, write_video

    view = View(width=SIZE[0], height=SIZE[1], fps=FPS, quick=True)
    clip = replace(rollout_clip(rollout, measurements=False), beside=())
    frames = list(render_clips([clip], view))
    write_video(frames, path, FPS)
    write_image(frames[int(STILL_AT * (len(frames) - 1))], still)


def main(folder: Path) -> None:
    """Make what is not there yet."""
    if read_gallery(folder) is None:
        sys.stderr.write(f"filming {len(TASKS)} tasks, which takes about a minute\n")
        make_gallery(folder, TASKS, built_in_grasp(), film)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
