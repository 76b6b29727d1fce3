"""What an importer is: a layout's name, what it reads, and which options it has a use for."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Literal

from handsim.errors import InputError
from handsim.recordings.recording import RecordingSet
from handsim.types import HandSize, Side

Units = Literal["deg", "rad", "counts"]
UNITS: tuple[Units, ...] = ("deg", "rad", "counts")
UNKNOWN_HAND = HandSize(0.19, 0.085)
"""Size of a hand that the files do not give: means of adult men."""


@dataclass(frozen=True)
class ImportOptions:
    """What a user may say about files beside their layout; None or 0 where nothing was said.

    Attributes
    ----------
    subject
        Number of the subject, from 1.
    side
        Side of the recorded hand.
    units
        Of the angles.
    column_map
        TOML file that says what each column or marker is.
    calibration
        File that turns raw counts into angles.
    hand
        Size of the recorded hand.
    bridge_s
        Longest gap that is bridged [s].
    rate_hz
        Sampling rate, where the files hold no times.
    object, task
        What was grasped and what for, where the files do not say.
    unwrap
        Whether jumps of 360 deg are taken out.
    """

    subject: int | None = None
    side: Side | None = None
    units: Units | None = None
    column_map: Path | None = None
    calibration: Path | None = None
    hand: HandSize | None = None
    bridge_s: float = 0.0
    rate_hz: float | None = None
    object: str = ""
    task: str = ""
    unwrap: bool = False

    def __post_init__(self) -> None:
        """Check the numbers; names of files may be text."""
        for name in ("column_map", "calibration"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, Path(getattr(self, name)))
        if not 0 <= self.bridge_s <= 10:  # also true of NaN
            raise InputError(f"gaps of {self.bridge_s:g} s to bridge; give 0 to 10 s")
        if self.rate_hz is not None and not 1 <= self.rate_hz <= 100_000:
            raise InputError(f"a rate of {self.rate_hz:g} Hz; give 1 to 100000 Hz")
        if self.units is not None and self.units not in UNITS:
            raise InputError(f"units '{self.units}'; give one of {', '.join(UNITS)}")

    @property
    def said(self) -> set[str]:
        """Names of the options that differ from their defaults."""
        return {each.name for each in fields(self) if getattr(self, each.name) != each.default}


Reader = Callable[[Sequence[Path], ImportOptions], RecordingSet]
"""From files and options to recordings; raises `FileError` or `InputError`."""


@dataclass(frozen=True)
class Layout:
    """A layout of files and what reads it.

    Attributes
    ----------
    name
        By which it is asked for.
    summary
        What files these are, in a line.
    read
        Reads them.
    options
        Fields of `ImportOptions` that it has a use for; others are refused.
    """

    name: str
    summary: str
    read: Reader
    options: frozenset[str] = frozenset()

    def __call__(self, files: Sequence[Path], options: ImportOptions) -> RecordingSet:
        """Read files, if the layout has a use for what was said about them.

        Raises
        ------
        InputError
            If an option was given that it has no use for, or no file.
        """
        useless = sorted(options.said - self.options)
        if useless:
            raise InputError(
                f"format {self.name} has no use for {', '.join(useless)}; it takes "
                f"{', '.join(sorted(self.options)) or 'no options'}"
            )
        if not files:
            raise InputError(f"no files for format {self.name}; name at least one")
        return self.read(files, options)
