"""How far results may move, and how far another environment may move them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from numbers import Real

from handsim.errors import InputError, UnknownNameError

MEASURES = {
    "lift_m": 0.0005,
    "peak_slip_m": 0.001,
    "peak_tilt_deg": 1.0,
    "hold_s": 0.02,
    "penetration_m": 0.0005,
}
"""How far the measures of a grasp may move, in their own units."""


@dataclass(frozen=True)
class Tolerances:
    """How far results may move.

    The defaults go by what `tests/benchmarks/environments.py` measures. From one BLAS kernel
    (Haswell, Sandybridge, Nehalem), thread count, SIMD of numpy or set of elementary functions to
    the next, a controller learned again has the same coefficients to the bit, movements differ by
    less than 1e-12 deg, the readings of the 24 grasps not at all, and their measures by 3 um of
    lift, 0.5 um of slip and 0.003 deg of tilt at most: hundreds of times less than is tolerated.
    Between MuJoCo 4.0 and 3.17 movements do not differ, no verdict does, and 22 of the 24 grasps
    stay within the tolerances; a screwdriver tips by 6.3 deg more in one than in the other, and
    a stapler is held for 0.02 s longer, which is told as a difference of environment or as
    a change. Movements have 0.001 deg, which leaves room for last digits and is far below what
    a change of the controller does.

    Attributes
    ----------
    replayed_deg, relearned_deg, simulated_deg
        Largest deviation of a joint in a movement of the controller, in one of a controller
        learned again, and in a grasp [deg].
    measures
        By name of the measure, in its own unit; those left out have their usual one.

    Raises
    ------
    InputError
        If one is negative, not finite or no number.
    UnknownNameError
        If there is no such measure.
    """

    replayed_deg: float = 0.001
    relearned_deg: float = 0.001
    simulated_deg: float = 5.0
    measures: Mapping[str, float] = field(default_factory=lambda: dict(MEASURES))

    def __post_init__(self) -> None:
        """Check all of them."""
        for name in ("replayed_deg", "relearned_deg", "simulated_deg"):
            _check(name, getattr(self, name))
        for name, value in self.measures.items():
            if name not in MEASURES:
                raise UnknownNameError("measure", name, tuple(MEASURES))
            _check(name, value)

    @classmethod
    def of(
        cls, tolerance_deg: float | None = None, grasp_tolerance_deg: float | None = None
    ) -> "Tolerances":
        """Return those named as on the command line; None leaves the usual ones.

        Parameters
        ----------
        tolerance_deg
            Of movements, of the controller and of one learned again.
        grasp_tolerance_deg
            Of the joints in a grasp.
        """
        usual = cls()
        moved = usual.replayed_deg if tolerance_deg is None else tolerance_deg
        grasped = usual.simulated_deg if grasp_tolerance_deg is None else grasp_tolerance_deg
        return cls(replayed_deg=moved, relearned_deg=moved, simulated_deg=grasped)

    def of_answer(self, name: str) -> float:
        """Return the limit of the joints of a trace, by its name [deg]."""
        kind = name.partition("/")[0]
        return {"grasp": self.simulated_deg, "relearned": self.relearned_deg}.get(
            kind, self.replayed_deg
        )

    def of_measure(self, name: str) -> float:
        """Return the limit of a measure; 0 for one that is not known."""
        return self.measures.get(name, MEASURES.get(name, 0.0))


def _check(name: str, value: object) -> None:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(f"tolerance {name} of {value!r}; give a number, 0 or more")
    if not 0 <= float(value) < float("inf"):
        raise InputError(f"tolerance {name} of {float(value):g}; give a finite number, 0 or more")


ENVIRONMENT_LIMITS = Tolerances(
    replayed_deg=0.1,
    relearned_deg=0.1,
    simulated_deg=10.0,
    measures={
        "lift_m": 0.001,
        "peak_slip_m": 0.002,
        "peak_tilt_deg": 10.0,
        "hold_s": 0.05,
        "penetration_m": 0.001,
    },
)
"""How far another environment may move the results of one controller.

These are the differences measured between MuJoCo 4.0 and 3.17, rounded up to 1, 2 or 5 of the next
decimal, and at least twice the tolerances. Movements did not differ at all; they have a tenth of a
step of the glove."""
