"""What commands use where a folder or a file is left out."""

from pathlib import Path
from typing import TYPE_CHECKING

from handsim.files import data_folder
from handsim.learning.controller import GraspController
from handsim.motion.recording import RecordingSet, read_recordings

if TYPE_CHECKING:
    from handsim.simulation.conditions import Conditions
    from handsim.simulation.grasping import ControllerGrasper


def recordings_or_built_in(folder: Path | None) -> RecordingSet:
    """Read a folder of recordings; by default the built-in synthetic experiments."""
    return read_recordings(folder or data_folder("assets") / "experiments")


def controller_or_built_in(path: Path | None) -> GraspController:
    """Load a controller; by default the one learned from the built-in experiments."""
    return GraspController.load(path or data_folder("assets") / "controller.npz")


def plan_folder(controller: Path | None) -> Path:
    """Return where the plans of a controller are kept: beside it, or with the package."""
    if controller is None:
        return data_folder("assets") / "plans"
    return controller.with_suffix(".plans")


def planning_grasper(
    path: Path | None, conditions: "Conditions", *, replay: bool = False
) -> "ControllerGrasper":
    """Return what grasps with a controller; its plans are stored, the built-in ones are hints."""
    from handsim.simulation.grasping import ControllerGrasper
    from handsim.simulation.plan_store import PlanStore, plan_key

    learned, built_in = controller_or_built_in(path), controller_or_built_in(None)
    own = plan_folder(path) / f"{plan_key(learned.digest, conditions)}.json"
    hint = plan_folder(None) / f"{plan_key(built_in.digest, conditions)}.json"
    return ControllerGrasper(
        learned, "replay" if replay else "plan", PlanStore(own), (PlanStore(hint),)
    )
