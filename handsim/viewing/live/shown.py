"""What the page shows: controllers with names, and the camera's places."""

from collections.abc import Callable
from dataclasses import dataclass

from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.learning.controller import GraspController
from handsim.recordings.recording import Recording

PlanSource = Callable[[str, Conditions], GraspPlan | None]
"""Returns the plan of a task under conditions, or None where none is known."""
View = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Position of the camera and the point that it looks at [m]."""
SPACING = 0.20
"""Between hands side by side [m]."""


@dataclass(frozen=True, eq=False)
class ShownController:
    """A controller on the page.

    Attributes
    ----------
    name
        What it is called there.
    controller
    plans
        Source of the plans of its grasps.
    recordings
        Those of its person, shown in the subspace and as ghosts.
    """

    name: str
    controller: GraspController
    plans: PlanSource
    recordings: tuple[Recording, ...] = ()
