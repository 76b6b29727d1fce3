"""CPU time of learning beside that of another version of the package, in the same run.

Run: python -m tests.benchmarks.learning_time CHECKOUT [FOLDER ...] [--rounds N]

CHECKOUT is the folder of the other version's repository. A FOLDER holds recordings; one person at
a time is learned. Without folders the 24 built-in experiments are taken. Both versions learn in
processes of their own, one BLAS thread each, in turns; the least time of all rounds counts.
"""

import argparse
import csv
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from handsim.files import data_folder

HERE = Path(__file__).resolve().parents[2]
CHILD = """
import sys, time, warnings
from pathlib import Path
warnings.simplefilter("ignore")
try:
    from handsim.recordings.folder import read_recordings
except ImportError:  # version 0.1
    from handsim.motion.recording import read_recordings
from handsim import learn_controller
recordings = read_recordings(Path(sys.argv[1]))
def seconds(**asked):
    began = time.process_time()
    learn_controller(recordings, **asked)
    return time.process_time() - began
seconds()
print(*(min(seconds(**asked) for _ in range(2)) for asked in ({}, {"certified": True})))
"""
"""Learns twice as each version does by default, and certified; the first call imports modules."""
NEWER = ("side", "object_")
"""Beginnings of columns of experiments.csv that version 0.1 does not read."""


def of_each_person(folder: Path, into: Path) -> Iterator[tuple[str, Path]]:
    """Copy the recordings of each person, in the columns that all versions read."""
    with (folder / "experiments.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    columns = [name for name in rows[0] if not name.startswith(NEWER)]
    for subject in dict.fromkeys(row["subject"] for row in rows):
        own = into / f"{folder.name}-{subject}"
        own.mkdir()
        with (own / "experiments.csv").open("w", encoding="utf-8", newline="") as file:
            table = csv.DictWriter(file, columns, extrasaction="ignore", lineterminator="\n")
            table.writeheader()
            for row in rows:
                if row["subject"] == subject:
                    table.writerow(row)
                    shutil.copy(folder / row["file"], own)
        yield own.name, own


def learning_times(checkout: Path, recordings: Path) -> tuple[float, float]:
    """Return the CPU times [s] of a checkout: by default, and certified."""
    one = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1")
    environment: Mapping[str, str] = os.environ | one | {"PYTHONPATH": str(checkout)}
    said = subprocess.run(
        [sys.executable, "-c", CHILD, str(recordings)],
        env=environment, cwd=checkout, check=True, capture_output=True, text=True,
    ).stdout  # fmt: skip
    default, certified = map(float, said.split())
    return default, certified


def main(arguments: list[str] | None = None) -> None:
    """Print a table: theirs and ours, by default and certified, and the ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("checkout", type=Path)
    parser.add_argument("folders", type=Path, nargs="*")
    parser.add_argument("--rounds", type=int, default=3)
    asked = parser.parse_args(arguments)
    folders = asked.folders or [data_folder("assets") / "experiments"]
    print(
        "| recordings | theirs, CPU s | theirs, certified | ours, certified by default | ratio | "
    )
    print("|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as kept:
        for folder in folders:
            for name, recordings in of_each_person(folder, Path(kept)):
                theirs, proven, ours = [], [], []
                for _ in range(asked.rounds):
                    default, certified = learning_times(asked.checkout.resolve(), recordings)
                    theirs.append(default)
                    proven.append(certified)
                    ours += learning_times(HERE, recordings)
                first, second, third = min(theirs), min(proven), min(ours)
                print(
                    f"| {name} | {first:.2f} | {second:.2f} | {third:.2f} "
                    f"| {third / first:.2f}, certified {third / second:.2f} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
