"""Simulated grasps as clips, with what was measured drawn onto them."""

from dataclasses import replace

import numpy as np

from handsim.errors import UnknownNameError
from handsim.grasping.gripping.need import LEAST
from handsim.grasping.rollout.record import Rollout
from handsim.joints import CONTACT_PARTS
from handsim.tasks.grip_rules import MAX_MARGIN
from handsim.tasks.table_one import task_by_name
from handsim.viewing.film.clip import Clip, Overlay
from handsim.viewing.film.force_bars import ForceBars
from handsim.viewing.film.overlay import Caption, SubspaceInset, Verdict
from handsim.viewing.film.person_clip import person_clip
from handsim.viewing.stage.framing import Room

BESIDE = ("chair", "side")
"""Views that are shown beside the usual one: in films the first, in contact sheets all."""
SCALE_IN_SHEETS, BARS_IN_SHEETS = 1.35, 1.15
"""Factors on letters in contact sheets, which are looked at as a whole; bars have room for less."""
ROOM, ROOM_IN_SHEETS = Room(0.24, 0.05, 0.97, 0.64), Room(0.05, 0.12, 0.95, 0.64)
"""What is left free by caption, bars and insets; mirrored for a left hand."""
PAUSE_S = 1.0
"""How long a film shows the end, and the verdict on it [s]."""


def rollout_clip(rollout: Rollout, measurements: bool = True) -> Clip:
    """Make a clip of a rollout.

    Parameters
    ----------
    rollout
        As recorded; nothing is simulated again.
    measurements
        Whether to draw contact forces, the position in the subspace and a second view as well as
        the caption. The second view of a robot hand is the person's hand that it follows.
    """
    time = rollout.time - rollout.time[0]
    phases = tuple((phase.start - float(rollout.time[0]), phase.name) for phase in rollout.phases)
    verdict = verdict_of(rollout)
    left_hand = rollout.conditions.hand.side == "left"  # its arm comes from the right
    overlays: list[Overlay] = [Caption((f"{rollout.task}, {rollout.driver}",), phases, verdict)]
    in_sheets: list[Overlay] = [Caption((), phases, verdict, SCALE_IN_SHEETS)]
    if measurements and np.any(rollout.contact_force):
        need = rollout.outcome.need_n
        limit = force_limit(rollout)
        bars = ForceBars(time, rollout.contact_force, CONTACT_PARTS, need, limit)
        overlays.append(bars)
        in_sheets.append(replace(bars, scale=BARS_IN_SHEETS, at_right=not left_hand))
    if measurements and rollout.z.shape[1] >= 2:
        overlays.append(SubspaceInset(time, rollout.z, below_caption=not left_hand))
    model = rollout.model()
    drawn_on = measurements and len(overlays) > 1
    return Clip(
        model,
        time,
        rollout.qpos,
        tuple(overlays),
        in_sheets=tuple(in_sheets),
        beside=BESIDE if measurements else (),
        companion=person_clip(rollout, model) if measurements else None,
        inset_below_caption=left_hand,
        pause=PAUSE_S,
        room=ROOM if drawn_on else Room(),
        room_in_sheets=ROOM_IN_SHEETS if drawn_on else Room(),
    )


def verdict_of(rollout: Rollout) -> Verdict:
    """Return how a rollout was judged, and from when on it shows.

    A success is known at the end of the hold, which is the end of the record. A failure is known
    when the object is lost: touched for the last time before the end. Where it is touched to the
    end, or never, the end tells.
    """
    end = float(rollout.time[-1] - rollout.time[0])
    if rollout.outcome.success:
        return Verdict(end, "held", good=True)
    touched = np.flatnonzero(rollout.contact_force.sum(axis=1) > 0)
    lost = int(touched[-1]) + 1 if len(touched) else len(rollout.time)
    time = float(rollout.time[lost] - rollout.time[0]) if lost < len(rollout.time) else end
    return Verdict(time, f"failed: {rollout.outcome.reason}", good=False)


def force_limit(rollout: Rollout) -> float:
    """Return the most that a part may press [N], 0 where no limit is asked for.

    That is for lifted tasks. Of a task that is not in Table I a need beyond the least tells that
    its object was lifted.
    """
    need = rollout.outcome.need_n
    try:
        lifted = task_by_name(rollout.task).rule.lifted
    except UnknownNameError:
        lifted = need > LEAST
    return MAX_MARGIN * need if lifted else 0.0
