"""What a robot hand is to match: a person's fingertips in n postures, scaled to the robot."""

from dataclasses import dataclass

import numpy as np

from handsim.joints import Finger
from handsim.types import Array


@dataclass(frozen=True)
class Targets:
    """Of n postures and k fingers, in the frame of the palm.

    Attributes
    ----------
    points : (n, k, 3) [m]
        Where fingertips would be if each finger moved as the person's about where it is rooted.
    openings : (n, k, 3) [m]
        From the thumb's fingertip to the others; 0 without a thumb.
    vectors : (n, k, 3) [m]
        As long as the openings, but turned as the robot's fingers are further apart at their roots.
    directions, backs : (n, k, 3)
        Unit vectors out of the fingers, and out of the backs of their tips.
    nearness : (n, k)
        1 where thumb and finger touch, falling to 0 the further they are apart; 0 for the thumb.
    counted : (n, k)
        How much openings count; 0 leaves one out.
    """

    points: Array
    openings: Array
    vectors: Array
    directions: Array
    backs: Array
    nearness: Array
    counted: Array

    def __getitem__(self, chosen: object) -> "Targets":
        """Return those of some postures."""
        return Targets(*(getattr(self, name)[chosen] for name in Targets.__annotations__))


def openings_of(points: Array, fingers: tuple[Finger, ...]) -> Array:
    """Return fingertips relative to the thumb's, (..., k, 3); 0 where there is no thumb.

    Parameters
    ----------
    points : (..., k, 3)
    fingers
        k names.
    """
    if "thumb" not in fingers:
        return np.zeros_like(points)
    thumb = fingers.index("thumb")
    return points - points[..., thumb : thumb + 1, :]


def turned_openings(openings: Array, shift: Array) -> Array:
    """Return openings (n, k, 3) of the same length, turned as if shifted by (k, 3) [m]."""
    long = np.linalg.norm(openings, axis=2, keepdims=True)
    moved = openings + shift
    size = np.linalg.norm(moved, axis=2, keepdims=True)
    return np.where(size > 1e-9, moved * (long / np.maximum(size, 1e-9)), openings)
