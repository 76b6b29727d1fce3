"""A movement of a model, with what is drawn over it."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np

from handsim.errors import InputError
from handsim.types import Array, Frame
from handsim.viewing.stage.framing import Room


class Overlay(Protocol):
    """Something drawn onto the frames of a clip."""

    def draw(self, frame: Frame, time: float) -> None:
        """Draw onto a frame, in place, as of ``time`` [s] since the clip's start."""
        ...


@dataclass(frozen=True, eq=False)
class Clip:
    """A movement of a model. Clips compare by identity, as MuJoCo's models do.

    Attributes
    ----------
    model
        The model that moves.
    time : (n,) [s]
        Increasing.
    qpos : (n, nq)
        MuJoCo's positions in the order of the model.
    overlays
        Drawn onto each frame, in order.
    in_sheets
        Drawn onto each picture of a contact sheet instead; by default it has its time alone.
    beside
        Cameras whose views stand beside the usual one, ``view``: of the first as an inset in
        films, of all as further rows in contact sheets. Another camera is shown alone.
    companion
        Another movement, shown beside the usual view: as the inset of films, in place of a camera,
        and as the last row of contact sheets.
    inset_below_caption
        Whether the inset is at the upper left instead of the lower right: an arm comes from there.
    pause
        How long a film shows the last state [s].
    room, room_in_sheets
        What the overlays leave free of films and of contact sheets; hand and object are there.
    """

    model: mujoco.MjModel
    time: Array
    qpos: Array
    overlays: tuple[Overlay, ...] = ()
    in_sheets: tuple[Overlay, ...] = ()
    beside: tuple[str, ...] = ()
    companion: "Clip | None" = None
    inset_below_caption: bool = False
    pause: float = 0.0
    room: Room = Room()  # noqa: RUF009
    room_in_sheets: Room = Room()  # noqa: RUF009

    def __post_init__(self) -> None:
        """Check that the arrays belong together and to the model.

        Raises
        ------
        InputError
            If they do not.
        """
        n, nq = len(self.time), self.model.nq
        if n == 0 or self.qpos.shape != (n, nq):
            raise InputError(f"qpos of shape {self.qpos.shape} for {n} times; give ({n}, {nq})")
        if not np.all(np.diff(self.time) > 0):
            raise InputError("time of a movement does not increase; sort it")

    @property
    def duration(self) -> float:
        """Time from the first to the last state [s]."""
        return float(self.time[-1] - self.time[0])

    @property
    def shown(self) -> float:
        """Time that a film of it lasts [s]."""
        return self.duration + self.pause
