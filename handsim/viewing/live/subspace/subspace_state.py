"""What is shown of the subspace, as values: start, destination, place on the way, and their values.

Nothing here knows of a page, so that all of it can be tried without a browser.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from handsim.errors import HandsimError, InputError
from handsim.learning.controller import GraspController
from handsim.navigation.paths import at_arc_length
from handsim.recordings.recording import Recording
from handsim.types import Array, Mask
from handsim.wording import number_of

FIELDS = ("none", "φ", "β")
"""What may be drawn of the navigation function about the destination."""


@dataclass(frozen=True, eq=False)
class SubspaceFrame:
    """Where the subspace's box is on the page: its first three components along x, y and z.

    Attributes
    ----------
    low, high : (n,) [rad]
        Corners of the box.
    size
        Length of its longest shown side on the page [m].
    """

    low: Array
    high: Array
    size: float = 0.3

    @property
    def scale(self) -> float:
        """Length on the page of a radian [m]."""
        return self.size / float((self.high - self.low)[:3].max())

    def to_page(self, z: Array) -> Array:
        """Return places on the page (m, 3) [m] of points (m, n) [rad], the box's middle at 0."""
        shown = self.scale * (z - 0.5 * (self.low + self.high))[:, :3]
        return np.pad(shown, ((0, 0), (0, 3 - shown.shape[1])))

    def to_subspace(self, place: Array, rest: Array) -> Array:
        """Return the point (n,) [rad] at a place (3,) [m] within the box; others as in ``rest``."""
        n = min(3, len(rest))
        z = rest.copy()
        z[:n] = np.asarray(place, float)[:n] / self.scale + 0.5 * (self.low + self.high)[:n]
        return np.clip(z, self.low, self.high)


@dataclass(frozen=True, eq=False)
class SubspaceState:
    """Start and destination [rad], the share of the way between them, and what is drawn about it.

    ``at`` names where the hand is: at the start, at the destination, or on the way.
    """

    start: Array
    goal: Array
    share: float = 0.0
    at: str = "start"
    field: str = "none"
    recording: str = "none"

    def moved(self, start: Array, goal: Array, share: float) -> "SubspaceState":
        """Return the state after a look at the controls: the hand is where one of them moved."""
        at = self.at
        if not np.allclose(goal, self.goal, atol=1e-6):
            at = "goal"
        elif not np.allclose(start, self.start, atol=1e-6):
            at = "start"
        elif abs(share - self.share) > 1e-6:
            at = "way"
        return replace(self, start=start, goal=goal, share=share, at=at)

    def place(self, path: Array) -> Array:
        """Return where the hand is (n,) [rad], with the path (m, n) from start to destination."""
        if self.at == "way":
            return at_arc_length(path, np.array([self.share]))[0]
        return self.goal if self.at == "goal" else self.start


def way(controller: GraspController, state: SubspaceState) -> tuple[Array, str]:
    """Return the controller's path (m, n) [rad], or a straight line and why there is none."""
    try:
        found = controller.path(state.start, state.goal)
    except HandsimError as error:
        return np.array([state.start, state.goal]), str(error)
    return found.points, "" if found.arrived else f"the path does not arrive: {found.reason}"


def carried_over(
    state: SubspaceState, controller: GraspController, other: GraspController
) -> tuple[SubspaceState, str]:
    """Return the state of another controller with the same postures, and what could not be kept.

    Start and destination are projected onto the other's components and kept in its workspace.
    """
    if other.subspace is controller.subspace:
        return state, ""
    obstacle = other.navigation.obstacle
    places: list[Array] = []
    lost = 0.0
    for z in (state.start, state.goal):
        q = controller.subspace.inverse_transform(z)
        place = np.clip(other.subspace.transform(q), obstacle.lower, obstacle.upper)
        lost = max(lost, float(np.abs(other.subspace.inverse_transform(place) - q).max()))
        places.append(place)
    apart = np.rad2deg(lost)
    said = f"Its ends are up to {apart:.0f} deg from the first one's." if apart >= 1 else ""
    return replace(state, start=places[0], goal=places[1]), said


def seen_from(controller: GraspController, other: GraspController, z: Array) -> Array:
    """Return points (m, n) [rad] of another controller's subspace in that of the first."""
    if other.subspace is controller.subspace:
        return z
    return controller.subspace.transform(other.subspace.inverse_transform(z))


def ghost_posture(recording: Recording, path: Array, share: float) -> Array:
    """Return the recorded posture (22,) [rad] at a share of its way (m, n) in the subspace."""
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    row = int(np.searchsorted(length, share * length[-1]))
    return recording.q[min(row, len(path) - 1)]


def state_values(state: SubspaceState) -> dict[str, str]:
    """Return all that is needed to show the same again, by the names that links have for it."""
    return {
        "start": _degrees(state.start),
        "goal": _degrees(state.goal),
        "share": f"{state.share:.3f}",
        "at": state.at,
        "field": state.field,
        "recording": state.recording,
    }


def read_state(
    given: Mapping[str, str], usual: SubspaceState, low: Array, high: Array
) -> SubspaceState:
    """Read what `state_values` gave, or a part of it; what is left out stays as usual.

    Raises
    ------
    InputError
        If a value makes no sense, or a place has the wrong number of components.
    """
    places = {
        name: _place(name, given[name], low, high) for name in ("start", "goal") if name in given
    }
    at, drawn = given.get("at", usual.at), given.get("field", usual.field)
    if at not in ("start", "goal", "way") or drawn not in FIELDS:
        raise InputError(f"a hand at '{at}' with field '{drawn}'; copy the whole text of a view")
    try:
        share = float(given.get("share", usual.share))
    except ValueError:
        share = np.nan
    if not 0.0 <= share <= 1.0:
        raise InputError(f"share '{given['share']}' of the way; give 0 to 1")
    recording = given.get("recording", usual.recording)
    return replace(usual, **places, share=share, at=at, field=drawn, recording=recording)


def _degrees(z: Array) -> str:
    return ",".join(f"{angle:.2f}" for angle in np.rad2deg(z))


def _place(name: str, text: str, low: Array, high: Array) -> Array:
    try:
        z = np.deg2rad([float(part) for part in text.split(",")])
    except ValueError:
        z = np.array([np.nan])
    inside: Mask = (z >= low) & (z <= high) if z.shape == low.shape else np.zeros(1, bool)
    if not inside.all():
        raise InputError(
            f"{name} '{text[:60]}'; give {number_of(len(low), 'angle')} within the workspace"
        )
    return z
