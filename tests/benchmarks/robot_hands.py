"""How well and how fast movements are mapped to published robot hands.

``python -m tests.benchmarks.robot_hands FOLDER [RECORDINGS...]`` prints a table. FOLDER holds the
hands: all MJCF and URDF files below it that are no scenes. Recordings are the built-in ones and
those of further folders.
"""

import argparse
import time
from pathlib import Path

import numpy as np

import handsim
from handsim.errors import HandsimError
from handsim.recordings.recording import RecordingSet


def hands_in(folder: Path) -> list[Path]:
    """Files of hands, scenes left out."""
    files = [p for p in folder.rglob("*") if p.suffix.lower() in (".xml", ".mjcf", ".urdf")]
    return sorted(p for p in files if not p.name.startswith("scene"))


def row(hand: Path, folder: Path, name: str, recordings: RecordingSet) -> str:
    """A line of the table: means and largest values over all postures."""
    robot = handsim.RobotHand(hand)
    retargeters: dict[handsim.HandSize, handsim.Retargeter] = {}
    parts, seconds = [], 0.0
    for recording in recordings:
        size = recording.hand
        retargeter = retargeters.setdefault(size, handsim.Retargeter(robot, size))
        start = time.process_time()
        parts.append(retargeter.retarget(recording.q))
        seconds += time.process_time() - start
    opening, vector, depth, matched = (
        np.concatenate([getattr(part, what) for part in parts])
        for what in ("opening_error", "vector_error", "penetration", "matched")
    )
    return (
        f"| {hand.relative_to(folder)} | {len(robot.lower)} | {name} | {len(depth)} "
        f"| {1e3 * opening[:, 1:].mean():.2f} | {1e3 * opening.max():.1f} "
        f"| {1e3 * vector[:, 1:].mean():.1f} | {1e3 * depth.max():.2f} | {matched.mean():.1%} "
        f"| {len(depth) / seconds:.0f} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("recordings", type=Path, nargs="*")
    given = parser.parse_args()
    sets = {"built-in": handsim.read_recordings(handsim.data_folder("assets") / "experiments")}
    sets |= {folder.name: handsim.read_recordings(folder) for folder in given.recordings}
    print(
        "| hand | coordinates | recordings | postures | opening error, mean [mm] | largest | as "
        "vectors, mean | overlap, largest [mm] | matched | postures a second of processor time |"
    )
    print("|" + "---|" * 10)
    for hand in hands_in(given.folder):
        for name, recordings in sets.items():
            try:
                print(row(hand, given.folder, name, recordings), flush=True)
            except HandsimError as error:
                print(f"| {hand.name} | {error} |" + " |" * 8)


if __name__ == "__main__":
    main()
