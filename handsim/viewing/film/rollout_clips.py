"""Simulated grasps as clips, with what was measured drawn onto them."""

import numpy as np

from handsim.grasping.rollout.record import Rollout
from handsim.joints import CONTACT_PARTS
from handsim.viewing.film.clips import Clip, Overlay
from handsim.viewing.film.overlay import Caption, ForceBars, SubspaceInset


def rollout_clip(rollout: Rollout, measurements: bool = True) -> Clip:
    """Make a clip of a rollout.

    Parameters
    ----------
    rollout
        As recorded; nothing is simulated again.
    measurements
        Whether to draw contact forces and the position in the subspace as well as the caption.
    """
    time = rollout.time - rollout.time[0]
    verdict = "success" if rollout.outcome.success else f"failed: {rollout.outcome.reason}"
    phases = tuple((phase.start - float(rollout.time[0]), phase.name) for phase in rollout.phases)
    overlays: list[Overlay] = [Caption((f"{rollout.task}, {rollout.driver}", verdict), phases)]
    if measurements and np.any(rollout.contact_force):
        overlays.append(ForceBars(time, rollout.contact_force, CONTACT_PARTS))
    if measurements and rollout.z.shape[1] >= 2:
        overlays.append(SubspaceInset(time, rollout.z))
    return Clip(rollout.model(), time, rollout.qpos, tuple(overlays))
