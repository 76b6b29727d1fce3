"""What a policy is paid for: success by the task's rules, and a little for being on the way."""

from collections.abc import Sequence
from math import exp, sqrt

from handsim.environments.observing import Felt
from handsim.joints import CONTACT_PARTS, FINGERS
from handsim.tasks.grip_rules import LEAST_PRESS, MAX_MARGIN, working
from handsim.tasks.task import Task

SUCCESS = 10.0
"""Reward of a run that succeeds, at its end."""
NEAR = 0.1
"""Distance of the fingertips from the grasp point at which its part falls to 1/e [m]."""
PARTS: tuple[str, ...] = ("distance", "contact", "opposition", "margin")
"""Names of the parts of the dense reward."""
_THUMB = CONTACT_PARTS.index("thumb")


class DenseReward:
    """The part of the reward that every reading gives.

    It is the mean of four parts between 0 and 1, over the number of readings: a whole run gives at
    most 1, and a success by the rules `SUCCESS` more.

    - ``distance``: exp(-d / `NEAR`), where d is the mean distance of the tips of the thumb and of
      the fingers that the task's grasp uses from the grasp point.
    - ``contact``: share of these fingers that press the object with `LEAST_PRESS` or more.
    - ``opposition``: minus the cosine between what the thumb presses and what the rest of the hand
      presses, where both press with `LEAST_PRESS` or more and it is positive; otherwise 0. Fingers
      that work and do not hold are left aside, as in the rules.
    - ``margin``: the greatest force of a part beside the need, up to 1; where the object is lifted
      it falls again, as `MAX_MARGIN` over it, beyond `MAX_MARGIN`.

    Parameters
    ----------
    task
        For the hand's side.
    need : [N]
        Least force a side.
    """

    def __init__(self, task: Task, need: float) -> None:
        fingers = {"thumb", *task.grasp.fingers}
        self._fingers = [i for i, finger in enumerate(FINGERS) if finger in fingers]
        aside = {_THUMB, *working(task)}
        self._rest = [i for i in range(len(CONTACT_PARTS)) if i not in aside]
        self._need, self._lifted = need, task.rule.lifted

    def parts(self, felt: Felt) -> dict[str, float]:
        """Return the four parts at a reading, each 0 to 1."""
        force, away, n = felt.force, felt.away, len(self._fingers)
        distance, touching = 0.0, 0
        for i in self._fingers:
            distance += away[i]
            touching += force[i] >= LEAST_PRESS
        margin = max(force) / self._need
        if margin > 1.0:
            margin = MAX_MARGIN / margin if self._lifted and margin > MAX_MARGIN else 1.0
        opposition = self._opposition(felt.press) if force[_THUMB] >= LEAST_PRESS else 0.0
        found = (exp(-distance / (n * NEAR)), touching / n, opposition, margin)
        return dict(zip(PARTS, found, strict=True))

    def _opposition(self, press: Sequence[Sequence[float]]) -> float:
        a, b, c = press[_THUMB]
        x = y = z = 0.0
        for i in self._rest:
            along = press[i]
            x, y, z = x + along[0], y + along[1], z + along[2]
        size, other = sqrt(a * a + b * b + c * c), sqrt(x * x + y * y + z * z)
        if min(size, other) < LEAST_PRESS:
            return 0.0
        return min(max(-(a * x + b * y + c * z) / (size * other), 0.0), 1.0)
