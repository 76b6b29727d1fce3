"""What a grasping task is: the grasp, what the hand then does, and what counts as success.

World frame: z up, table top at z = 0; the person sits at -x and looks to +x, right is -y. Grasps
are written for the right hand in the object frame (`handsim.objects.object`); `Task.for_side`
mirrors them for the left.

A hand that opposes thumb and fingers points along ``opposition`` with its palm facing along
``approach``: alignment starts from these two and the grasp point.
"""

from dataclasses import dataclass, replace
from typing import Literal

from handsim.joints import Finger
from handsim.objects.catalogue import OBJECTS
from handsim.objects.grasp import Grasp
from handsim.objects.mirror import mirrored, mirrored_grasp, reflected, reflected_axis
from handsim.objects.object import GraspObject, Vec3
from handsim.types import Side

Action = Literal[
    "drink", "move", "rotate", "slide", "click", "use", "raise", "write", "unscrew", "operate",
    "read", "view", "staple",
]  # fmt: skip
RuleKind = Literal["carry", "turn", "slide", "joint", "trace"]


@dataclass(frozen=True)
class Step:
    """One movement of the grasped object, or of the hand on it, after the squeeze.

    Attributes
    ----------
    shift
        Displacement of the grasp point in the world [m].
    axis, angle_deg
        Turn about the grasp point; the axis is in the world.
    flex
        Fingers that flex by ``angle_deg`` at MCP instead of a turn of the hand.
    seconds
        Duration [s].
    """

    seconds: float
    shift: Vec3 = (0.0, 0.0, 0.0)
    axis: Vec3 = (0.0, 0.0, 1.0)
    angle_deg: float = 0.0
    flex: tuple[Finger, ...] = ()


@dataclass(frozen=True)
class Pressed:
    """A body of the object, and the fingers of which at least one has to press it."""

    fingers: tuple[Finger, ...]
    body: str


@dataclass(frozen=True)
class PassRule:
    """What a trial must show.

    Attributes
    ----------
    kind
        ``carry``: lifted and held; ``turn``: carried, and turned about the action's axis by
        ``angle_deg``; ``slide``: displaced on the table by ``distance``; ``joint``: hinge ``joint``
        passed ``angle_deg``, upwards if it starts below and downwards if above; ``trace``: the
        object's front end moved ``distance`` along the table within 3 mm of it.
    lift
        Least height gained [m]; for ``slide`` the most.
    hold
        Time it stays there [s].
    slip, tilt_deg
        Largest displacement [m] and turn of the object in the hand.
    pressed
        What is to be pressed when the hinge passes its angle.
    table_force
        Most that hand and forearm press on the table [N].
    """

    kind: RuleKind
    lift: float = 0.10
    hold: float = 3.0
    slip: float = 0.02
    tilt_deg: float = 30.0
    angle_deg: float = 0.0
    distance: float = 0.0
    joint: str | None = None
    pressed: tuple[Pressed, ...] = ()
    table_force: float = 15.0

    @property
    def lifted(self) -> bool:
        """Whether the object's weight is carried by the hand."""
        return self.kind in ("carry", "turn", "trace")


@dataclass(frozen=True)
class Task:
    """One row of Table I.

    Attributes
    ----------
    number
        Its number in the table.
    name
        As on the command line.
    object_name
        Key of `handsim.objects.mjcf.OBJECTS`.
    grasp
        In the object frame, for the right hand unless mirrored.
    action, steps
        What the hand does once it holds the object.
    rule
        What counts as success.
    yaw_deg
        How the object stands on the table: its front's angle from +x, counter-clockwise.
    place
        Where on the table it stands, x and y [m].
    start_deg
        Angles of its hinges before the grasp, by name, where they are not 0.
    own_object
        The object itself where it is not a built-in one. For a left hand it is the mirror image of
        what lies on the table, and `handed` (`handsim.tasks.lift.lift_task`).
    mirrored
        Whether the object's mirror image is grasped in its place.
    """

    number: int
    name: str
    object_name: str
    grasp: Grasp
    action: Action
    steps: tuple[Step, ...]
    rule: PassRule
    yaw_deg: float = 0.0
    place: tuple[float, float] = (0.0, 0.0)
    start_deg: tuple[tuple[str, float], ...] = ()
    own_object: GraspObject | None = None
    mirrored: bool = False

    @property
    def object(self) -> GraspObject:
        """What is grasped."""
        usual = self.own_object or OBJECTS[self.object_name]
        return mirrored(usual) if self.mirrored else usual

    def for_side(self, side: Side) -> "Task":
        """Return the task for that hand; the left one's is the mirror image across y = 0.

        What is `handed` is mirrored as well: a hammer lies turned over, and scissors are a pair for
        left-handers. Everything else is its own mirror image, but for what people have one kind of:
        the mouse's left button stays on the left and is pressed by the finger that lies there, and
        a thread keeps its direction.
        """
        if side == "right":
            return self
        steps = tuple(_mirror_step(step, self.action) for step in self.steps)
        pressed = tuple(
            replace(each, fingers=tuple(map(self._mirror_finger, each.fingers)))
            for each in self.rule.pressed
        )
        rule = replace(self.rule, pressed=pressed)
        return replace(
            self,
            grasp=mirrored_grasp(self.grasp),
            steps=steps,
            rule=rule,
            yaw_deg=-self.yaw_deg,
            place=(self.place[0], -self.place[1]),
            mirrored=self.mirrored != self.object.handed,
        )

    def _mirror_finger(self, finger: Finger) -> Finger:
        """Return the finger that lies on the same button in the other hand."""
        return _OTHER.get(finger, finger) if self.action == "click" else finger


_OTHER: dict[Finger, Finger] = {"index": "middle", "middle": "index"}
"""Which finger lies on a button of the mouse when the other hand is on it."""


def _mirror_step(step: Step, action: Action) -> Step:
    """Mirror displacement and turn (an axial vector) across y = 0."""
    axis = step.axis if action == "unscrew" else reflected_axis(step.axis)
    swap = action == "click"
    flex = tuple(_OTHER.get(finger, finger) if swap else finger for finger in step.flex)
    return replace(step, shift=reflected(step.shift), axis=axis, flex=flex)
