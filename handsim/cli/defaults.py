"""Controllers, recordings and plans that commands use where none are named."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from handsim.errors import InputError, UnknownNameError
from handsim.files import data_folder
from handsim.types import MEDIAN_HAND, Array, HandSize, Side
from handsim.wording import number_of

if TYPE_CHECKING:
    from handsim.grasping.conditions import Conditions
    from handsim.grasping.planning.grasper import ControllerGrasper
    from handsim.learning.controller import GraspController
    from handsim.learning.transport.transport import Transport
    from handsim.recordings.recording import RecordingSet


MOST_NOTES = 5
"""Lines about what was done to recordings that a command says; `recordings info` says them all."""


def recordings_or_built_in(
    folder: Path | None,
    accept: Sequence[str] | None = None,
    learned: "GraspController | None" = None,
) -> "RecordingSet":
    """Read recordings that can be what they say; by default the built-in synthetic experiments.

    What was done to them and what is unlikely about them is said on standard error.

    Parameters
    ----------
    folder
    accept
        Kinds of anomalies that are right all the same.
    learned
        A controller that was learned in spite of some, which are then accepted too.

    Raises
    ------
    ImplausibleError
        If they cannot be.
    """
    from handsim.cli.console import note
    from handsim.cli.waiting import fraction_done
    from handsim.recordings.folder import read_recordings, stored_notes
    from handsim.recordings.plausibility import check_plausible, lines_of

    with fraction_done("reading") as progress:
        recordings = read_recordings(folder_or_built_in(folder), progress)
    known = stored_notes(folder) if folder is not None else frozenset[str]()
    for line in said_of(recordings, known):
        note(line)
    n_left = sum(recording.hand.side == "left" for recording in recordings)
    if n_left:
        note(f"{n_left} of {len(recordings)} recordings of a left hand, taken as its mirror image")
    accepted = {*(accept or ()), *(learned.accepted if learned is not None else ())}
    for line in lines_of(check_plausible(recordings, accepted)):
        note(line)
    return recordings


def folder_or_built_in(folder: Path | None) -> Path:
    """Return a folder of recordings; by default that of the built-in experiments."""
    return folder or data_folder("assets") / "experiments"


def said_of(recordings: "RecordingSet", known: frozenset[str] = frozenset()) -> list[str]:
    """Return what was done to recordings, a line for each thing done.

    Parameters
    ----------
    recordings
    known
        What need not be said again, since it was said when the folder was written.
    """
    names: dict[str, list[str]] = {}
    for recording in recordings:
        for said in (each for each in recording.notes if each not in known):
            names.setdefault(said, []).append(recording.name)
    lines = [
        f"recording '{of[0]}'" + (f" and {len(of) - 1} more" if of[1:] else "") + f": {said}"
        for said, of in names.items()
    ]
    if len(lines) > MOST_NOTES:
        left = number_of(len(lines) - MOST_NOTES + 1, "more note")
        more = f"{left}; `handsim recordings info` shows them"
        lines = [*lines[: MOST_NOTES - 1], more]
    return lines


def controller_or_built_in(path: Path | None) -> "GraspController":
    """Load a controller; by default the one learned from the built-in experiments."""
    from handsim.learning.controller import GraspController

    return GraspController.load(path or data_folder("assets") / "controller.npz")


def plan_folder(controller: Path | None) -> Path:
    """Return the folder of the plans of a controller: beside it, or in the package."""
    from handsim.grasping.planning.plan_store import shipped_folder

    if controller is None:
        return shipped_folder()
    return controller.with_suffix(".plans")


PEOPLE, STRAIGHT = "people", "straight"
"""Names of the transport that comes with the package, and of straight lines."""


@dataclass(frozen=True)
class PalmTransport:
    """How the palm comes in, and what an answer says of it.

    Attributes
    ----------
    learned
        None: straight.
    said
    """

    learned: "Transport | None" = None
    said: "dict[str, object]" = field(default_factory=dict[str, object])

    @classmethod
    def of(cls, name: str | None) -> "PalmTransport":
        """Return the transport of a name, or learn it from a folder of recordings.

        None is `PEOPLE`. What it is learned from is said on standard error.

        Raises
        ------
        InputError
            If too few of the recordings hold a reach of the palm.
        """
        from handsim.learning.transport.stored import shipped_transport

        if name == STRAIGHT:
            return cls(None, {"transport": None})
        asked = name or PEOPLE
        learned = shipped_transport() if asked == PEOPLE else _learned_from(Path(asked))
        certified = learned.certificate.certified
        of = {"recordings": asked, "n_reaches": learned.n_reaches, "certified": certified}
        return cls(learned, {"transport": of})

    def by(self, grasper: "ControllerGrasper") -> "ControllerGrasper":
        """Return a grasper whose palm comes in so."""
        return replace(grasper, transport=self.learned)


def _learned_from(folder: Path) -> "Transport":
    """Learn how palms come to things from a folder of recordings, and say what was learned."""
    from handsim.cli.console import note
    from handsim.cli.waiting import fraction_done
    from handsim.learning.transport.recorded import recorded_transport

    with fraction_done("learning the transport") as progress:
        learned = recorded_transport(recordings_or_built_in(folder), progress=progress)
    proved = "proven to arrive" if learned.certificate.certified else "NOT proven to arrive"
    reaches = number_of(learned.n_reaches, "recorded reach", "recorded reaches")
    note(f"the palm comes in as in {reaches}, {proved}")
    return learned


def planning_grasper(
    path: Path | None, conditions: "Conditions", *, replay: bool = False
) -> "ControllerGrasper":
    """Return a grasper that uses and stores the plans of a controller.

    Plans are looked up beside the controller, then among the built-in ones, since a controller
    learned elsewhere from the built-in experiments equals the built-in one
    (`GraspController.digest`). For any other controller, searches begin with the built-in plans.
    For another hand they begin with the plans of the usual one, carried over to it.
    """
    from handsim.cli.console import note
    from handsim.cli.waiting import fraction_done
    from handsim.grasping.planning.grasper import ControllerGrasper
    from handsim.grasping.planning.plan_store import (
        plan_store,
        shipped_folder,
        shipped_plans,
        usual_store,
    )

    learned = controller_or_built_in(path)
    own = plan_store(plan_folder(path), learned.digest, conditions)
    shared = () if path is None else (shipped_plans(learned.digest, conditions),)
    if not replay and not any(store.path.is_file() for store in (own, *shared)):
        _say_if_unkept(own.path.parent)
    built_in = learned if path is None else controller_or_built_in(None)
    hints = (
        shipped_plans(built_in.digest, conditions),
        *usual_store(plan_folder(path), learned.digest, conditions),
        *usual_store(shipped_folder(), built_in.digest, conditions),
    )
    mode = "replay" if replay else "plan"
    return ControllerGrasper(learned, mode, own, hints, shared, note, fraction_done)


@cache
def _say_if_unkept(folder: Path) -> None:
    """Say once, before plans are made, that they cannot be kept in a folder.

    They are used all the same, and made again by the next command.
    """
    from handsim.cli.console import note
    from handsim.errors import FileError
    from handsim.files import check_output_folder

    try:
        check_output_folder(folder)
    except FileError as error:
        note(f"plans that are made now are used, but not kept: {error}")


def planned_destinations(learned: "GraspController", path: Path | None) -> Array | None:
    """Return the destinations (m, n) [rad] of the plans stored for a controller, None if none."""
    import numpy as np

    from handsim.grasping.conditions import Conditions
    from handsim.grasping.planning.plan_store import plan_store

    plans = plan_store(plan_folder(path), learned.digest, Conditions()).read().values()
    goals = [plan.z_goal for plan in plans if plan.z_goal is not None]
    return np.array(goals) if goals else None


def grasper_without(
    name: str, path: Path | None, folder: Path | None, conditions: "Conditions"
) -> "ControllerGrasper":
    """Return a grasper with a controller learned again without the recordings of an object.

    A controller file does not hold its recordings, which therefore have to be named unless they are
    the built-in ones. Plans are stored where those of the whole controller are. Searches begin with
    no plan of another controller, since that one was learned with the object.

    Parameters
    ----------
    name
        The object.
    path
        The whole controller, whose settings are used. None is the built-in one; where recordings
        are given, None is one learned from them with the default settings.
    folder
        The recordings of the whole controller; by default the built-in ones.
    conditions
        With the hand that grasps.

    Raises
    ------
    InputError
        If the controller was not learned from these recordings, or if none are left.
    UnknownNameError
        If no recording is of that object.
    """
    from handsim.cli.console import note
    from handsim.cli.waiting import fraction_done
    from handsim.grasping.planning.grasper import ControllerGrasper
    from handsim.grasping.planning.plan_store import plan_store, usual_store
    from handsim.learning.learn import learn_controller, learn_like

    kept = None if path is None and folder is not None else controller_or_built_in(path)
    recordings = recordings_or_built_in(folder, learned=kept)
    objects = tuple(dict.fromkeys(recording.object for recording in recordings))
    if name not in objects:
        raise UnknownNameError("recorded object", name, objects)
    others = recordings.without_object(name)
    if path is None and folder is not None:
        learned = learn_controller(others).controller
        plans = folder.resolve().with_name(f"{folder.resolve().name}.plans")
    else:
        whole = controller_or_built_in(path)
        _check_learned_from(whole, recordings, path, folder)
        learned = learn_like(whole, others)
        plans = plan_folder(path)
    store = plan_store(plans, learned.digest, conditions)
    hints = usual_store(plans, learned.digest, conditions)
    return ControllerGrasper(learned, "plan", store, hints, note=note, planning=fraction_done)


def _check_learned_from(
    learned: "GraspController", recordings: "RecordingSet", path: Path | None, folder: Path | None
) -> None:
    """Compare the postures at both ends of the recordings with those that a controller keeps."""
    import numpy as np

    from handsim.learning.demonstration import demonstrations_of

    given = demonstrations_of(recordings, learned.subspace)
    kept = learned.demonstrations
    same = len(given) == len(kept) and all(
        a.name == b.name
        and np.array_equal(a.q_start, b.q_start)
        and np.array_equal(a.q_goal, b.q_goal)
        for a, b in zip(given, kept, strict=True)
    )
    if not same:
        raise InputError(
            f"{path or 'the built-in controller'} was not learned from "
            f"{folder or 'the built-in experiments'}; name its recordings with --recordings"
        )


def hand_size(length: float | None, breadth: float | None, side: Side) -> HandSize:
    """Return a size of hand; what is left out is that of a man of median size."""
    return HandSize(
        MEDIAN_HAND.length if length is None else length,
        MEDIAN_HAND.breadth if breadth is None else breadth,
        side,
    )
