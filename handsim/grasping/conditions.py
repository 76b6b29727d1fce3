"""What a run is made with, apart from controller and plan."""

from dataclasses import asdict, dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from handsim.errors import InputError
from handsim.hand.anthropometry import HandGeometry
from handsim.hand.mjcf import FRICTION
from handsim.tasks.scene import HAND_FRICTION_RANGE
from handsim.types import MEDIAN_HAND, Base, HandSize

LIMITS: dict[str, tuple[float, float]] = {
    "seed": (0, 2**63 - 1),
    "friction": HAND_FRICTION_RANGE,
    "mass_scale": (1e-3, 1e3),
    "shake": (0.0, 100.0),
    "bias": (0.0, np.pi),
    "drift": (0.0, np.pi),
    "latency": (0.0, 1.0),
    "lost": (0.0, 0.99),
}
"""What is simulated; far beyond what hands and objects are like, so that limits can be sought."""
MAX_OFFSET = 3.2
"""Largest displacement [m] and turn [rad] of the object; half a turn and more."""


@dataclass(frozen=True)
class Conditions:
    """Hand, friction, mass and disturbances of one run.

    Attributes
    ----------
    seed
        Seed of the glove's noise and of the perturbations.
    nominal
        True when nothing was perturbed.
    hand
        Its size and side.
    base
        What carries it; ``mounted`` is for robot hands alone.
    friction
        Sliding friction of the hand.
    mass_scale
        Factor on the object's mass.
    object_offset
        Displacement of the object from where the plan expects it, (x [m], y [m], yaw [rad]).
    shake
        Amplitude of the base's acceleration during the hold [m/s^2].
    bias, drift
        How far each sensor of the glove is off, to one side or the other [rad], and how much more
        every second [rad/s].
    latency
        Age of the readings and forces that the controller gets [s], in steps of 10 ms.
    lost
        Share of readings that do not come.

    Raises
    ------
    InputError
        If one is outside what is simulated (`LIMITS`), or the size is that of no hand.
    """

    seed: int = 0
    nominal: bool = True
    hand: HandSize = MEDIAN_HAND
    base: Base = "arm"
    friction: float = FRICTION[0]
    mass_scale: float = 1.0
    object_offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    shake: float = 0.0
    bias: float = 0.0
    drift: float = 0.0
    latency: float = 0.0
    lost: float = 0.0

    def __post_init__(self) -> None:
        """Check all values."""
        HandGeometry(self.hand)
        if self.base not in get_args(Base):
            raise InputError(f"base '{self.base}' is unknown; give 'arm', 'free' or 'mounted'")
        for name, (low, high) in LIMITS.items():
            value = getattr(self, name)
            if not low <= value <= high:
                raise InputError(f"{name} of {value:g} is outside {low:g} to {high:g}")
        if not np.abs(self.object_offset).max() <= MAX_OFFSET:
            raise InputError(
                f"object_offset of {self.object_offset} is beyond {MAX_OFFSET:g} m or rad"
            )

    def as_dict(self) -> dict[str, Any]:
        """Return the conditions as they stand in files, length, breadth and side one by one."""
        values = asdict(self)
        hand = values.pop("hand")
        return {
            "seed": values.pop("seed"),
            "nominal": values.pop("nominal"),
            "hand_length": hand["length"],
            "hand_breadth": hand["breadth"],
            "side": hand["side"],
            **values,
        }


@dataclass(frozen=True)
class Perturbation:
    """Ranges of what a perturbed trial varies, each uniform.

    Attributes
    ----------
    position, yaw
        Object pose, each way, (x and y) [m] and [rad].
    friction
        Lower and upper end of the hand's tangential friction coefficient.
    mass
        Relative change of the object's mass, each way.
    shake
        Amplitude of the base's acceleration during the hold [m/s^2].
    bias
        How far each sensor of the glove is off at least [rad]; more where the conditions say so.
    """

    position: float = 0.003
    yaw: float = np.deg2rad(3.0)
    friction: tuple[float, float] = (0.5, 0.8)
    mass: float = 0.2
    shake: float = 2.0
    bias: float = 0.0


Hard = Literal["pose", "friction", "mass", "shake", "bias", "latency"]
"""What can be made hard, one thing at a time (`made_hard`)."""
HARD_POSE = Perturbation(position=0.010, yaw=float(np.deg2rad(10.0)))
"""Object pose of trials that are hard in it; the rest of the trial is nominal."""
HARD: dict[Hard, dict[str, float]] = {
    "pose": {},
    "friction": {"friction": 0.3},
    "mass": {"mass_scale": 2.0},
    "shake": {"shake": 5.0},
    "bias": {"bias": float(np.deg2rad(3.0))},
    "latency": {"latency": 0.050},
}
"""What else is changed in such trials."""


def made_hard(conditions: Conditions, seed: int, name: Hard) -> Conditions:
    """Return the conditions of a trial that is hard in one thing and nominal in all others."""
    hard = replace(conditions, seed=seed, nominal=False, **HARD[name])
    if name != "pose":
        return hard
    return replace(hard, object_offset=perturb(conditions, seed, HARD_POSE).object_offset)


def perturb(conditions: Conditions, seed: int, ranges: Perturbation | None = None) -> Conditions:
    """Return the conditions of a perturbed trial; the same seed gives the same trial."""
    ranges = ranges or Perturbation()
    generator = np.random.default_rng(seed)
    x, y = generator.uniform(-ranges.position, ranges.position, 2)
    yaw = generator.uniform(-ranges.yaw, ranges.yaw)
    return replace(
        conditions,
        seed=seed,
        nominal=False,
        friction=float(generator.uniform(*ranges.friction)),
        mass_scale=float(1 + generator.uniform(-ranges.mass, ranges.mass)),
        object_offset=(float(x), float(y), float(yaw)),
        shake=ranges.shake,
        bias=max(conditions.bias, ranges.bias),
    )


def trial_conditions(
    conditions: Conditions, n_trials: int, hard: Hard | None = None
) -> list[Conditions]:
    """Return the nominal conditions, then those of ``n_trials`` perturbed runs.

    The perturbed runs have the seeds after that of the nominal one. Where something is made
    ``hard``, they are perturbed in that alone.
    """
    seeds = range(conditions.seed + 1, conditions.seed + 1 + n_trials)
    if hard is not None:
        return [conditions, *(made_hard(conditions, seed, hard) for seed in seeds)]
    return [conditions, *(perturb(conditions, seed) for seed in seeds)]
