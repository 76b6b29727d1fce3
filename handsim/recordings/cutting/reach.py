"""What cutting finds: a reach, when it was, how sure that is and what else it might be."""

from dataclasses import dataclass

from handsim.errors import InputError

CERTAIN = 0.7
"""Confidence from which on a reach is cut out; under it, two readings are nearly as likely."""


@dataclass(frozen=True)
class CutOptions:
    """What can be said about how a person moves.

    Attributes
    ----------
    rest_speed
        Share of a reach's peak speed under which the hand stands still; a reach starts and ends
        there. None is 0.2 where the palm is followed, which never quite stands still in the air,
        and 0.08 where only the joints are.
    longest_pause_s
        A stop on the way that is shorter is a pause within a reach; a longer one ends it [s].
    channel
        The reach ends exactly where this channel first moves. None looks for ``label`` and
        ``object_x_m`` to ``object_z_m`` by itself.

    Raises
    ------
    InputError
        If a value is outside its limits.
    """

    rest_speed: float | None = None
    longest_pause_s: float = 1.0
    channel: str | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        for name, value, least, greatest in (
            ("rest_speed", self.rest_speed, 0.01, 0.5),
            ("longest_pause_s", self.longest_pause_s, 0.05, 60.0),
        ):
            if value is not None and not least <= value <= greatest:
                raise InputError(f"{name} is {value:g}; give {least:g} to {greatest:g}")

    def rest_share(self, *, palm: bool) -> float:
        """Return the share of the peak speed under which the hand stands still."""
        if self.rest_speed is not None:
            return self.rest_speed
        return 0.2 if palm else 0.08


@dataclass(frozen=True)
class Reach:
    """One reach in a recording; times are the recording's own.

    Attributes
    ----------
    recording
        Name of the recording.
    start_s, end_s
        Where the hand leaves its rest, and where it has grasped [s].
    hold_end_s
        Where it lets go and returns, or moves on; the end of the recording if it does not [s].
    confidence
        Estimated probability that this reading is right, 0 to 1, where the alternative is the
        second reading or that there is no reach. 1 for times given by hand.
    reason
        What decided, or what speaks against it.
    second
        Start and end of the second reading [s], where there is one.
    """

    recording: str
    start_s: float
    end_s: float
    hold_end_s: float
    confidence: float
    reason: str
    second: tuple[float, float] | None = None

    @property
    def certain(self) -> bool:
        """Whether it is sure enough to be cut out."""
        return self.confidence >= CERTAIN
