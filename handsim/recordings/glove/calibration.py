"""Calibrations of gloves: angle = gain x count + offset for each sensor, kept as a TOML file.

The file says of each of the 22 joints by what it is known: ``postures`` (least squares over held
postures), ``ranges`` (its range of motion over the counts that were seen), ``held`` (the sensor did
not move, its angle is taken as constant) or ``none`` (the glove has no such sensor).
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, cast

import numpy as np

from handsim.errors import FileError, InputError
from handsim.files import write_text
from handsim.joints import JOINT_INDEX, JOINTS, N_JOINTS
from handsim.recordings.columns.sections import quoted, read_sections
from handsim.types import Array
from handsim.wording import number_of

KIND, SCHEMA = "handsim glove calibration", 1
How = Literal["postures", "ranges", "held", "none"]
HOWS: tuple[How, ...] = ("postures", "ranges", "held", "none")
COARSE = 2.5
"""Gain above which a joint was not moved through its range; usual are 0.5 to 1.5 [deg/count]."""
_BEYOND, _MARGIN = 0.05, 0.25
_KEYS = ("joint", "sensor", "by", "gain_deg", "offset_deg", "residual_deg", "counts")


@dataclass(frozen=True)
class GloveCalibration:
    """What turns the counts of a glove into angles.

    Attributes
    ----------
    source
        Files by which it was made.
    how : 22
        By what each joint is known.
    gain : (22,) [deg per count]
    offset : (22,) [deg]
        Angle at 0 counts.
    residual : (22,) [deg]
        Rms error over the frames of the postures; NaN where not known by postures.
    counts : (22, 2)
        Least and greatest count that were seen.
    """

    source: str
    how: tuple[How, ...]
    gain: Array
    offset: Array
    residual: Array
    counts: Array

    def __post_init__(self) -> None:
        """Check the shapes, and make the arrays read-only."""
        for name in ("gain", "offset", "residual", "counts"):
            values = np.array(getattr(self, name), dtype=float)
            if values.shape != ((N_JOINTS, 2) if name == "counts" else (N_JOINTS,)):
                raise InputError(f"calibration: {name} of shape {values.shape}; give one a joint")
            if name in ("gain", "offset") and not np.isfinite(values).all():
                raise InputError(f"calibration: {name} holds NaN or infinite values; correct it")
            values.flags.writeable = False
            object.__setattr__(self, name, values)
        if len(self.how) != N_JOINTS:
            raise InputError(f"calibration: {len(self.how)} joints; {N_JOINTS} are needed")

    @property
    def rms(self) -> float:
        """Rms residual over the joints that are known by postures [deg]; NaN without any."""
        known = self.residual[np.isfinite(self.residual)]
        return float(np.sqrt(np.mean(known**2))) if known.size else np.nan

    @property
    def summary(self) -> str:
        """How the calibration was made and how good it is, in a line."""
        parts = [
            f"{number_of(self.how.count(how), 'joint')} by {how}"
            for how in ("postures", "ranges")
            if how in self.how
        ]
        held = [j.name for j, how in zip(JOINTS, self.how, strict=True) if how == "held"]
        parts += [f"rms residual {self.rms:.2g} deg"] if np.isfinite(self.rms) else []
        parts += ["residual not known"] if not np.isfinite(self.rms) else []
        coarse = [
            JOINTS[i].name
            for i, how in enumerate(self.how)
            if how == "ranges" and self.gain[i] > COARSE
        ]
        if coarse:
            parts.append(f"coarse, moved little or not through the whole range: {' '.join(coarse)}")
        return ", ".join([*parts, *([f"held constant: {', '.join(held)}"] if held else [])])

    def angles(self, counts: Array) -> Array:
        """Return angles (n, 22) [deg] of counts (n, 22); NaN where the glove has no sensor."""
        angles = self.gain * counts + self.offset
        held = np.array([how == "held" for how in self.how])
        none = np.array([how == "none" for how in self.how])
        angles[:, held] = self.offset[held]
        angles[:, none] = np.nan
        return angles


def calibrated(calibration: GloveCalibration, counts: Array, where: str) -> tuple[Array, list[str]]:
    """Return angles (n, 22) [deg] of counts (n, 22), and the notes that say by what.

    Raises
    ------
    InputError
        If the calibration knows nothing of a sensor that the file has.
    """
    measured = [bool(np.isfinite(column).any()) for column in counts.T]
    unknown = [
        joint.name
        for joint, how, there in zip(JOINTS, calibration.how, measured, strict=True)
        if there and how == "none"
    ]
    if unknown:
        raise InputError(
            f"{where}: the calibration ({calibration.source}) has no {', '.join(unknown)}; "
            "calibrate with files of this glove"
        )
    notes = [f"counts calibrated by {calibration.source}: {calibration.summary}"]
    low, high = calibration.counts.T
    margin = _MARGIN * (high - low)
    with np.errstate(invalid="ignore"):
        beyond = ((counts < low - margin) | (counts > high + margin)).mean(axis=0)
    far = [f"{JOINTS[i].name} ({100 * beyond[i]:.0f} %)" for i in np.flatnonzero(beyond > _BEYOND)]
    if far:
        notes.append(f"frames far beyond the calibrated counts: {', '.join(far)}")
    return calibration.angles(counts), notes


def write_calibration(calibration: GloveCalibration, path: Path) -> None:
    """Write a calibration as TOML, as a whole or not at all."""
    lines = [
        "# angle [deg] = gain_deg * count + offset_deg; residual_deg: rms over the postures",
        f"kind = {quoted(KIND)}",
        f"schema = {SCHEMA}",
        f"source = {quoted(calibration.source)}",
    ]
    for i, joint in enumerate(JOINTS):
        lines += [
            "",
            "[[sensor]]",
            f"joint = {quoted(joint.name)}",
            f"sensor = {quoted(joint.sensor)}",
            f"by = {quoted(calibration.how[i])}",
        ]
        if calibration.how[i] == "none":
            continue
        lines += [
            f"gain_deg = {float(calibration.gain[i])!r}",
            f"offset_deg = {float(calibration.offset[i])!r}",
        ]
        if np.isfinite(calibration.residual[i]):
            lines.append(f"residual_deg = {float(calibration.residual[i])!r}")
        if np.isfinite(calibration.counts[i]).all():
            low, high = (float(count) for count in calibration.counts[i])
            lines.append(f"counts = [{low!r}, {high!r}]")
    write_text(Path(path), "\n".join(lines) + "\n")


def calibration_of_counts(path: Path | None, units: str | None) -> GloveCalibration | None:
    """Read the calibration of a glove, if one was given and the values may be counts.

    Raises
    ------
    FileError
        As `read_calibration`.
    InputError
        If they were said to be angles.
    """
    calibration = read_calibration(path) if path else None
    if calibration and units in ("deg", "rad"):
        raise InputError(f"units {units} and a calibration of counts; give one of the two")
    return calibration


def read_calibration(path: Path) -> GloveCalibration:
    """Read a calibration.

    Raises
    ------
    FileError
        If it is missing, no calibration, of a newer schema, or leaves a joint out.
    """
    content = read_sections(Path(path), ("kind", "schema", "source", "sensor"))
    if content.text("kind") != KIND:
        raise FileError(f"{path}: is no glove calibration; make one with `recordings calibrate`")
    schema = content.number("schema", 0)
    if schema != SCHEMA:
        raise FileError(f"{path}: schema {schema:g} is not {SCHEMA}; update handsim to read it")
    how: dict[int, How] = {}
    gain, offset = np.zeros(N_JOINTS), np.zeros(N_JOINTS)
    residual, counts = np.full(N_JOINTS, np.nan), np.full((N_JOINTS, 2), np.nan)
    for section in content.sections("sensor", _KEYS):
        name = section.text("joint", "", tuple(JOINT_INDEX))
        joint = JOINT_INDEX.get(name)
        if joint is None or joint in how:
            raise FileError(f"{section.where}: joint '{name}' is none, or there twice; correct it")
        how[joint] = cast("How", section.text("by", "none", HOWS))
        gain[joint] = section.number("gain_deg", 0.0)
        offset[joint] = section.number("offset_deg", 0.0)
        residual[joint] = section.number("residual_deg", 0.0) if "residual_deg" in section else (
            np.nan
        )  # fmt: skip
        counts[joint] = section.pair("counts")
    missing = [joint.name for i, joint in enumerate(JOINTS) if i not in how]
    if missing:
        raise FileError(f"{path}: no [[sensor]] for {', '.join(missing)}; calibrate again")
    return GloveCalibration(
        source=content.text("source"),
        how=tuple(how[i] for i in range(N_JOINTS)),
        gain=gain,
        offset=offset,
        residual=residual,
        counts=counts,
    )
