"""Calibrate a glove by held postures, or by the ranges of motion.

**Postures.** The person holds a few postures, a file each. Of each its angles are stated, by a name
of `POSTURES` or by the user. Gain and offset of a sensor are the least squares over the frames of
all postures that state its joint, each posture with the same weight, those
in which the sensor is at an end of its counts (0 or 255) left out; the residual is the rms error
over them, the jitter of holding included. With two postures of different angles the means are met
exactly, so that the residual tells the jitter alone.

**Ranges.** Least and greatest count over recordings in which each joint was moved through its whole
range are taken for the ends of `RANGES`. That is cruder: how far off it is cannot be told from the
files.

Counts grow with flexion, spreading, opposition and cupping in the maker's sensors; by postures the
sign is found, by ranges it is taken so.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import numpy as np

from handsim.errors import FileError, InputError, UnknownNameError
from handsim.joints import FINGERS, JOINT_INDEX, JOINT_NAMES, JOINTS, N_JOINTS
from handsim.recordings.columns.sections import Section, read_sections
from handsim.recordings.glove.calibration import GloveCalibration, How
from handsim.recordings.glove.counts import check_counts, read_raw
from handsim.types import Array
from handsim.wording import number_of

MIN_COUNTS = 5.0
"""Least travel of a sensor [counts] by which it is calibrated."""
_MOST_HELD = 10.0  # difference of angles that a sensor may leave unseen [deg]
_END = 255.0  # of the counts of 8 bits
_SPREAD_FLEXIONS = {f"{finger}_{place}": 0.0 for finger in FINGERS[1:]
                    for place in ("mcp", "pip", "dip")}  # fmt: skip
_FIST = {"mcp": 85.0, "pip": 110.0, "dip": 65.0}
POSTURES: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        # On a table: fingers together, thumb beside the index finger, wrist straight.
        "flat": dict.fromkeys(JOINT_NAMES, 0.0),
        # Fingers closed into the palm. Total active motion of a finger, American Society for
        # Surgery of the Hand: 85 + 110 + 65 = 260 deg. The thumb is not judged.
        "fist": {f"{f}_{place}": a for f in FINGERS[1:] for place, a in _FIST.items()},
        # On a table, everything spread as far as it goes: upper ends of the ranges in
        # `handsim.joints`, of the thumb 50 deg (AAOS, Joint Motion, 1965: radial abduction).
        "spread": {
            **_SPREAD_FLEXIONS,
            "index_abduction": 25.0,
            "ring_abduction": 20.0,
            "little_abduction": 30.0,
            "thumb_abduction": 50.0,
        },
        # Thumb bent across the palm: MCP 50, IP 80 deg (AAOS, 1965).
        "thumb-bent": {"thumb_mcp": 50.0, "thumb_ip": 80.0},
        # Thumb stretched out in front of the palm, at a right angle to it.
        "thumb-opposed": {"thumb_rotation": 90.0, "thumb_mcp": 0.0, "thumb_ip": 0.0},
        # Tips of thumb and little finger together, palm cupped: upper end of the range.
        "cupped": {"palm_arch": 20.0},
        # Wrist: AAOS, 1965, as in `handsim.joints`.
        "wrist-flexed": {"wrist_flexion": 80.0, "wrist_deviation": 0.0},
        "wrist-extended": {"wrist_flexion": -70.0, "wrist_deviation": 0.0},
        "wrist-radial": {"wrist_deviation": 20.0, "wrist_flexion": 0.0},
        "wrist-ulnar": {"wrist_deviation": -30.0, "wrist_flexion": 0.0},
    }
)
"""Angles of postures that can be held without an instrument [deg]; joints left out are not used."""
RANGES: Array = np.array(
    [
        (0.0 if joint.motion == "flexion" and joint.finger else joint.lower_deg, joint.upper_deg)
        for joint in JOINTS
    ]
)
"""Ends to which counts are spread, (22, 2) [deg]: the joint ranges, fingers from straight on."""


@dataclass(frozen=True)
class HeldPosture:
    """Counts of a posture that was held, and its angles.

    Attributes
    ----------
    name
    counts : (n, 22)
        NaN without a sensor.
    angles
        Joint to angle [deg]; joints left out are not used.
    """

    name: str
    counts: Array
    angles: Mapping[str, float]


def calibrate_postures(postures: Sequence[HeldPosture]) -> GloveCalibration:
    """Fit gain and offset of each sensor to held postures.

    Sensors whose joint has the same angle in all postures, or that moved less than `MIN_COUNTS`,
    are held at that angle, and the calibration says so.

    Raises
    ------
    InputError
        If there are fewer than two postures, or flexions of the fingers cannot be told by them.
    """
    if len(postures) < 2:
        raise InputError(
            f"{number_of(len(postures), 'posture')}; hold at least 2, such as flat and fist"
        )
    how: list[How] = []
    gain, offset = np.zeros(N_JOINTS), np.zeros(N_JOINTS)
    residual, seen = np.full(N_JOINTS, np.nan), np.full((N_JOINTS, 2), np.nan)
    for joint, name in enumerate(JOINT_NAMES):
        columns = [(p.counts[:, joint], p.angles[name]) for p in postures if name in p.angles]
        columns = [(c[np.isfinite(c)], angle) for c, angle in columns]
        columns = _within([(c, angle) for c, angle in columns if c.size])
        if not any(np.isfinite(p.counts[:, joint]).any() for p in postures):
            how.append("none")
            continue
        if columns:
            seen[joint] = _seen(np.concatenate([c for c, _ in columns]))
        fit = _fit(columns)
        if fit is None:
            offset[joint] = _held(name, [angle for _, angle in columns])
            how.append("held")
            continue
        gain[joint], offset[joint], residual[joint] = fit
        how.append("postures")
    made = GloveCalibration(", ".join(p.name for p in postures), tuple(how), gain, offset,
                            residual, seen)  # fmt: skip
    return _checked(made, "hold postures that bend them by known angles, such as flat and fist")


def calibrate_ranges(counts: Sequence[Array], source: str) -> GloveCalibration:
    """Spread the counts that were seen over the ranges of motion.

    Parameters
    ----------
    counts : (n, 22) each
        NaN without a sensor.
    source
        Names of the files.

    Raises
    ------
    InputError
        If a flexion of the fingers moved less than `MIN_COUNTS`.
    """
    if not counts:
        raise InputError("no recordings to calibrate by; give at least one")
    seen = np.array([_seen(np.concatenate([each[:, j] for each in counts]))
                     for j in range(N_JOINTS)])  # fmt: skip
    travel = seen[:, 1] - seen[:, 0]
    moved = travel >= MIN_COUNTS
    there = np.isfinite(travel)
    safe = np.where(moved, travel, 1.0)
    gain = np.where(moved, (RANGES[:, 1] - RANGES[:, 0]) / safe, 0.0)
    offset = np.where(moved, RANGES[:, 0] - gain * np.where(there, seen[:, 0], 0.0), 0.0)
    how: list[How] = [
        "ranges" if m else ("held" if t else "none") for m, t in zip(moved, there, strict=True)
    ]
    made = GloveCalibration(source, tuple(how), gain, offset, np.full(N_JOINTS, np.nan), seen)
    return _checked(made, "move every joint through its whole range in the files")


def postures_of_files(files: Sequence[Path]) -> list[HeldPosture]:
    """Read files that are named as the postures that they hold, such as ``flat.txt``.

    Raises
    ------
    FileError
        If a file is no raw file, or named as no posture.
    """
    held: list[HeldPosture] = []
    for file in map(Path, files):
        name = next((n for n in sorted(POSTURES, key=len, reverse=True)
                     if file.stem.lower().replace("_", "-").startswith(n)), None)  # fmt: skip
        if name is None:
            raise FileError(
                f"{file}: is named as none of the postures {', '.join(POSTURES)}; rename it, say "
                "its angles by --postures FILE.toml, or calibrate by --ranges"
            )
        held.append(HeldPosture(file.name, _counts(file, None), POSTURES[name]))
    return held


def postures_of_table(path: Path, files: Sequence[Path]) -> list[HeldPosture]:
    """Read the postures of a TOML file.

    ::

        [[posture]]
        file = "flat.txt"           # beside the TOML file, or among the files named
        name = "flat"               # angles of `POSTURES`; may be left out
        rows = [10, 200]            # first and last row of the file that count; all if left out
        angles = { index_mcp = 5 }  # further or other angles [deg]

    Raises
    ------
    FileError
        If the TOML file or one that it names is missing or damaged.
    """
    content = read_sections(path, ("posture",))
    held: list[HeldPosture] = []
    for section in content.sections("posture", ("file", "name", "rows", "angles")):
        named = section.text("file")
        file = next((f for f in files if named in (f.name, f.stem)), path.parent / named)
        known = section.text("name")
        if known and known not in POSTURES:
            raise FileError(
                f"{section.where}: {UnknownNameError('posture', known, tuple(POSTURES))}"
            )
        stated = section.section("angles", JOINT_NAMES)
        angles = {**POSTURES.get(known, {}), **{j: stated.number(j, 0.0) for j in stated.values}}
        if not angles:
            raise FileError(f"{section.where}: states no angles; give a name or angles")
        beyond = next((j for j, a in angles.items() if abs(a) > 180), None)
        if beyond is not None:
            raise FileError(f"{section.where}: {beyond} = {angles[beyond]:g} deg is beyond +-180")
        rows = section.pair("rows")
        held.append(HeldPosture(file.name, _counts(file, rows, section), angles))
    if not held:
        raise FileError(f"{path}: names no [[posture]]; give at least 2")
    return held


def counts_of_files(files: Sequence[Path]) -> list[Array]:
    """Return the counts of raw files, (n, 22) each.

    Raises
    ------
    FileError
        If one is no raw file.
    """
    return [_counts(Path(file), None) for file in files]


def _counts(file: Path, rows: tuple[float, float] | None, section: Section | None = None) -> Array:
    if file.suffix.lower() == ".mat":
        from handsim.recordings.importers.ninapro.mat_file import glove_counts

        values = glove_counts(file)
        numbers = np.arange(1, len(values) + 1)
    else:
        raw = read_raw(file)
        check_counts(raw)
        values, numbers = raw.values, raw.table.numbers
    if rows is None or not np.isfinite(rows).all():
        return values
    inside = (numbers >= rows[0]) & (numbers <= rows[1])
    if not inside.any():
        where = f"{section.where}: " if section else ""
        raise FileError(f"{where}{file}: has no rows {rows[0]:g} to {rows[1]:g}; correct them")
    return values[inside]


def _seen(counts: Array) -> tuple[float, float]:
    known = counts[np.isfinite(counts)]
    return (float(known.min()), float(known.max())) if known.size else (np.nan, np.nan)


def _held(name: str, angles: Sequence[float]) -> float:
    """Return the angle of a sensor that hardly moved."""
    if angles and max(angles) - min(angles) > _MOST_HELD:
        raise InputError(
            f"{name}: stated angles from {min(angles):g} to {max(angles):g} deg, but the sensor "
            f"moved by less than {MIN_COUNTS:g} counts; correct the angles, or look after the "
            "sensor"
        )
    return float(np.mean(angles)) if angles else 0.0


def _within(columns: list[tuple[Array, float]]) -> list[tuple[Array, float]]:
    """Leave out postures in which a sensor is at the end of its counts, if two others are left."""
    inside = [(c, angle) for c, angle in columns if 0 < np.median(c) < _END]
    return inside if len(inside) >= 2 else columns


def _fit(columns: Sequence[tuple[Array, float]]) -> tuple[float, float, float] | None:
    """Gain, offset and rms residual of a sensor; None if the postures do not tell them."""
    angles = np.array([angle for _, angle in columns])
    if len(columns) < 2 or np.ptp(angles) < 1.0:
        return None
    means = np.array([c.mean() for c, _ in columns])
    if np.ptp(means) < MIN_COUNTS:
        return None
    x = np.concatenate([c for c, _ in columns])
    y = np.concatenate([np.full(len(c), angle) for c, angle in columns])
    weight = np.concatenate([np.full(len(c), 1 / (len(c) * len(columns))) for c, _ in columns])
    # The means of the postures are fitted: jitter of counts would flatten the gain.
    gain, offset = (float(value) for value in np.polyfit(means, angles, 1))
    return gain, offset, float(np.sqrt((weight * (gain * x + offset - y) ** 2).sum()))


def _checked(made: GloveCalibration, remedy: str) -> GloveCalibration:
    """Check that the flexions that grasping needs are known."""
    needed = [f"{finger}_{place}" for finger in FINGERS[1:] for place in ("mcp", "pip")]
    unknown = [name for name in needed if made.how[JOINT_INDEX[name]] in ("held", "none")]
    if unknown:
        raise InputError(
            f"{made.source}: {', '.join(unknown)} cannot be calibrated: moved by less than "
            f"{MIN_COUNTS:g} counts, or the same angle throughout; {remedy}"
        )
    return made
