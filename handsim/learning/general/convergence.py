"""What is proved of a field's destinations."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handsim.navigation.certificate import certify
from handsim.navigation.function import NavigationFunction
from handsim.navigation.proof.destination import certify_destination
from handsim.result import Result
from handsim.types import Array


@dataclass(frozen=True)
class Convergence(Result):
    """Whether paths are proved to arrive at each of the destinations of a field.

    Attributes
    ----------
    certified
        Whether that holds for every destination.
    everywhere
        Whether it holds for every start in the workspace, not for all but a set of measure zero.
    reasons
        One line for each destination: what is proved, or why nothing is.
    """

    certified: bool
    everywhere: bool
    reasons: tuple[str, ...]


def convergence(navigation: NavigationFunction, goals: Sequence[Array]) -> Convergence:
    """Try to prove that paths arrive, for all destinations at once or else one by one."""
    box = certify(navigation, np.array(goals))
    if box.certified:
        return Convergence(True, True, (box.reason,) * len(goals))
    proofs = [certify_destination(navigation, goal) for goal in goals]
    return Convergence(
        all(proof.certified for proof in proofs),
        all(proof.everywhere for proof in proofs),
        tuple(proof.reason for proof in proofs),
    )
