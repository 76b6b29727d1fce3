"""How near palm, elbow and timing come to a person's reaches, each reach left out.

    python -m tests.benchmarks.reach [DIR] [--first N]

DIR holds recordings with the palm's pose, elbow, shoulder and torso as channels (the reaches for a
pillow that are shipped, by default), or one file of markers, which is imported and cut.

The joint of the shoulder is not where its marker is. It is taken for the point, fixed to the torso,
about which the elbow moves on a sphere whose radius is the length of the upper arm. That is 0.186
of a stature of which the forearm measured is 0.146. The torso is known by its own markers' middle
and the shoulder's marker, and upright; where it has none, it is taken not to turn.
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

import handsim
from handsim.arm.arm_geometry import FOREARM_OF_STATURE, HAND_OF_STATURE, UPPER_ARM_OF_STATURE, Seat
from handsim.arm.chain import angles_at, matrices, places, swivel_of
from handsim.arm.reaching_arm import ReachingArm
from handsim.arm.swivel import USUAL, fit_swivel, towards_mouth
from handsim.hand.kinematics import Kinematics
from handsim.learning.demonstration import demonstrations_of
from handsim.learning.guide.predictor import GuideSettings, PathPredictor
from handsim.learning.movement.progress import ProgressLaw, minimum_jerk
from handsim.learning.subspace import PostureSubspace
from handsim.learning.transport.coupling import hand_law, widest_of
from handsim.learning.transport.transport import learn_transport
from handsim.navigation.paths import arc_length, at_arc_length, path_error
from handsim.recordings.points.beside_hand import elbow_centre
from handsim.recordings.points.palm_path import wrist_path
from handsim.recordings.statistics import reach_statistics

SHIPPED = handsim.data_folder("assets") / "people" / "pillow"
NO_TABLE = Seat(height=1.0)
"""Where the table of these recordings was is not known."""


UNITS = {
    "arrived": "share",
    "proved": "share",
    "hand's progress": "share",
    "peak speed": "of the duration",
    "widest": "of the duration",
}


@dataclass(frozen=True)
class Person:
    """Arm of a person: lengths [m] and the shoulder joint from its marker, in the torso's frame."""

    upper_arm: float
    forearm: float
    joint: np.ndarray
    left_over: float

    @property
    def arm(self) -> ReachingArm:
        """handsim's own arm of these lengths."""
        length = HAND_OF_STATURE * self.forearm / FOREARM_OF_STATURE
        return ReachingArm(handsim.HandSize(length, 0.45 * length), NO_TABLE)


@dataclass(frozen=True)
class Reach:
    """A reach: time [s], wrist, shoulder joint and elbow (n, 3) [m], palm (n, 3, 3), statistics."""

    time: np.ndarray
    wrist: np.ndarray
    shoulder: np.ndarray
    elbow: np.ndarray
    palm: np.ndarray
    quat: np.ndarray
    widest_at: float
    fastest_at: float


def recordings_of(folder: Path) -> handsim.RecordingSet:
    """Read a folder of recordings, or import and cut files of markers."""
    if (folder / "experiments.csv").is_file():
        return handsim.read_recordings(folder)
    files = sorted([*folder.glob("*.tsv"), *folder.glob("*.c3d")])
    if not files:
        sys.exit(f"{folder}: neither experiments.csv nor *.tsv or *.c3d in it")
    return handsim.cut_recordings(handsim.import_recordings(files, "markers")).recordings


def place(recording: handsim.Recording, name: str) -> np.ndarray:
    """A channel of places, (n, 3) [m]."""
    return np.stack([recording.channels[f"{name}_{axis}_m"] for axis in "xyz"], axis=1)


def torso_axes(recording: handsim.Recording) -> np.ndarray:
    """Upright axes with x from the torso's markers to the shoulder's, (n, 3, 3)."""
    if "torso_x_m" not in recording.channels:
        return np.tile(np.eye(3), (len(recording.time), 1, 1))
    ahead = place(recording, "shoulder") - place(recording, "torso")
    ahead[:, 2] = 0.0
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    up = np.broadcast_to([0.0, 0.0, 1.0], ahead.shape)
    return np.stack([ahead, np.cross(up, ahead), up], axis=2)


def measured(recordings: handsim.RecordingSet) -> Person:
    """Find the arm's lengths and the shoulder joint; the marker of the elbow is on its outside."""
    wrists = np.vstack([wrist_path(each)[0] for each in recordings])
    marks = np.vstack([place(each, "shoulder") for each in recordings])
    axes = np.vstack([torso_axes(each) for each in recordings])
    markers = np.vstack([place(each, "elbow") for each in recordings])
    elbows, joint = markers, np.zeros(3)
    upper_arm = forearm = left_over = 0.0
    for _ in range(4):
        forearm = float(np.median(np.linalg.norm(wrists - elbows, axis=1)))
        upper_arm = forearm * UPPER_ARM_OF_STATURE / FOREARM_OF_STATURE
        seen = np.einsum("nji,nj->ni", axes, elbows - marks)

        joint, left_over = centre_of(seen, upper_arm)
        elbows = elbow_centre(markers, marks + axes @ joint, wrists, recordings[0].hand.side)
    return Person(upper_arm, forearm, joint, left_over)


def centre_of(places: np.ndarray, radius: float) -> tuple[np.ndarray, float]:
    """Centre (3,) of a sphere [m], near the origin, and rms distance from it.

    As sure as it is to be within 10 cm of its marker, places are to be within 5 mm of the sphere:
    the elbow moves too little to tell without.
    """
    near = 0.05 * len(places) ** 0.5

    def off(p: np.ndarray) -> np.ndarray:
        return np.append(np.linalg.norm(places - p, axis=1) - radius, near * p)

    found = least_squares(off, np.array([0.0, 0.0, 0.05]))
    return found.x, float(np.sqrt(np.mean(found.fun[: len(places)] ** 2)))


def reach_of(recording: handsim.Recording, person: Person) -> Reach:
    """Places of one reach."""
    wrist, quat = wrist_path(recording)
    shoulder = place(recording, "shoulder") + torso_axes(recording) @ person.joint
    elbow = elbow_centre(place(recording, "elbow"), shoulder, wrist, recording.hand.side)
    said = reach_statistics(recording)
    time = recording.time - recording.time[0]
    return Reach(
        time, wrist, shoulder, elbow, matrices(quat), quat, said.aperture_at, said.peak_speed_at
    )


def rms(difference: np.ndarray) -> float:
    """Root of the mean square of rows' lengths, in mm."""
    return 1000 * float(np.sqrt(np.mean(np.sum(np.atleast_2d(difference) ** 2, axis=-1))))


def elbow_with(reach: Reach, swivel: np.ndarray, person: Person) -> np.ndarray:
    """Elbow (n, 3) [m] at a swivel, for the shoulder and wrist recorded."""
    lengths = person.upper_arm, person.forearm
    where = reach.wrist - reach.shoulder
    return angles_at(where, reach.palm, swivel, *lengths)[1] + reach.shoulder


def elbow_of_arm(reach: Reach, person: Person) -> np.ndarray:
    """Elbow (n, 3) [m] of the arm with its own choice of the swivel, the wrist free."""
    arm = person.arm
    base = arm.geometry.shoulder(arm.seat)
    found = arm.posture(reach.wrist - reach.shoulder + base, reach.quat)
    got = places(np.hstack([found.arm, found.wrist]), person.upper_arm, person.forearm)
    return got.elbow + reach.shoulder


def palm_scores(reaches: list[Reach], i: int) -> dict[str, float]:
    """Errors of the palm's path, with a transport learned from the others."""
    others = [each for j, each in enumerate(reaches) if j != i]
    transport = learn_transport([each.wrist for each in others], [each.time for each in others])
    one, ends = reaches[i], reaches[i].wrist[[0, -1]]
    duration = float(one.time[-1])
    made = transport.reach(ends[0], ends[1], duration=duration)
    even = np.linspace(0.0, 1.0, 1001)
    fastest = even[np.argmax(np.gradient(made.law.covered(even * duration)))]
    line = at_arc_length(ends, minimum_jerk(one.time, duration))
    return {
        "path, learned": 1000 * path_error(made.path.points, one.wrist),
        "path, straight": 1000 * path_error(ends, one.wrist),
        "over time, learned": rms(made.at(one.time) - one.wrist),
        "over time, straight with minimum jerk": rms(line - one.wrist),
        "arrived": float(made.path.arrived),
        "proved": float(made.proved),
        "peak speed, learned": abs(float(fastest) - one.fastest_at),
        "peak speed, minimum jerk": abs(0.5 - one.fastest_at),
    }


def elbow_scores(reaches: list[Reach], i: int, person: Person) -> dict[str, float]:
    """Errors of the height of the elbow, by laws fitted to the others."""
    own = [each.wrist - each.shoulder for each in reaches]
    swivels = [swivel_of(r.elbow - r.shoulder, w) for r, w in zip(reaches, own, strict=True)]
    others = [j for j in range(len(reaches)) if j != i]
    geometry, one = person.arm.geometry, reaches[i]
    fitted = fit_swivel([own[j] / geometry.reach for j in others], [swivels[j] for j in others])
    n = len(own[i])
    elbows = {
        "fitted law": elbow_with(one, fitted.swivel(own[i], geometry), person),
        "mean of the others": elbow_with(one, np.full(n, fitted.constant), person),
        "the constant of handsim": elbow_with(one, np.full(n, USUAL), person),
        "towards the mouth": elbow_with(one, towards_mouth(own[i], geometry.stature), person),
        "handsim's arm, 7 joints": elbow_of_arm(one, person),
        "lowest (swivel 0)": elbow_with(one, np.zeros(n), person),
        "as recorded (the arm's lengths alone)": elbow_with(one, swivels[i], person),
    }
    apart = {name: elbow - one.elbow for name, elbow in elbows.items()}
    heights = {f"height, {name}": rms(each[:, 2:]) for name, each in apart.items()}
    return heights | {f"place, {name}": rms(each) for name, each in apart.items()}


def aperture_scores(recordings: handsim.RecordingSet, i: int) -> dict[str, float]:
    """When the hand is widest on a path learned from the others, coupled and not."""
    one, others = recordings[i], recordings.without(i)
    subspace = PostureSubspace(3).fit(np.vstack([each.q for each in others]))
    predictor = PathPredictor.of(demonstrations_of(others, subspace), GuideSettings())
    ends = subspace.transform(one.q[[0, -1]])
    postures = subspace.inverse_transform(predictor.path(ends[0], ends[1], one.object))
    hand = Kinematics(one.hand)
    widest = widest_of(hand.aperture(postures))
    said, even = reach_statistics(one).aperture_at, np.linspace(0.0, 1.0, 1001)
    time = one.time - one.time[0]
    duration = float(time[-1])
    laws = {
        "coupled": hand_law(ProgressLaw(duration), widest),
        "minimum jerk": ProgressLaw(duration),
    }
    own = arc_length(subspace.transform(one.q))
    scores = {"widest at, recorded": said}
    for name, law in laws.items():
        when = float(np.interp(max(widest, 0.02), law.covered(even * duration), even))
        covered = np.sqrt(np.mean((law.covered(time) - own / own[-1]) ** 2))
        scores |= {
            f"widest at, {name}": when,
            f"widest, {name}": abs(when - said),
            f"hand's progress, {name}": float(covered),
        }
    return scores


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=SHIPPED)
    parser.add_argument("--first", type=int, help="leave out only the first so many")
    asked = parser.parse_args()
    recordings = recordings_of(asked.folder)
    person = measured(recordings)
    reaches = [reach_of(each, person) for each in recordings]
    usual = np.rad2deg(
        np.median(
            np.concatenate([swivel_of(r.elbow - r.shoulder, r.wrist - r.shoulder) for r in reaches])
        )
    )
    sys.stdout.write(
        f"{len(reaches)} reaches; forearm {1000 * person.forearm:.0f} mm, upper arm taken as "
        f"{1000 * person.upper_arm:.0f} mm, elbow on its sphere within "
        f"{1000 * person.left_over:.1f} mm, median swivel {usual:.0f} deg\n"
    )
    rows: list[dict[str, float]] = []
    for i in range(len(reaches) if asked.first is None else asked.first):
        rows.append(
            palm_scores(reaches, i)
            | elbow_scores(reaches, i, person)
            | aperture_scores(recordings, i)
        )
        sys.stderr.write(f"{i + 1} of {len(reaches)} left out\n")
    print_table(rows)


def print_table(rows: list[dict[str, float]]) -> None:
    """Print means and medians over the reaches left out."""
    sys.stdout.write("\n| each reach left out | mean | median | unit |\n|---|---|---|---|\n")
    for name in rows[0]:
        values = np.array([row[name] for row in rows])
        unit = next((unit for start, unit in UNITS.items() if name.startswith(start)), "mm")
        mean, median = np.nanmean(values), np.nanmedian(values)
        digits = 1 if unit == "mm" else 2
        sys.stdout.write(f"| {name} | {mean:.{digits}f} | {median:.{digits}f} | {unit} |\n")


if __name__ == "__main__":
    main()
