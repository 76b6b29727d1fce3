"""Learning time and peak memory against recordings, components and coefficients.

Run: .venv/bin/python tests/benchmarks/scale.py [--recordings N ...] [--repeats N]

Each row is learned in a fresh process, so that its peak is its own. The recordings are the
built-in 24 over and over, each time with its ends moved, its speed changed and tremor added.
"""

import argparse
import json
import resource
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

from handsim.files import data_folder
from handsim.learning.direction.learner import DirectionLearner
from handsim.learning.learn import learn_controller
from handsim.learning.subspace import PostureSubspace
from handsim.recordings.folder import read_recordings
from handsim.recordings.recording import Recording, RecordingSet

MOVED = np.deg2rad(5.0)  # deviation of each joint at the start and at the end
TREMOR = np.deg2rad(0.5)
SPEED = 0.2  # deviation of the logarithm of the duration
DEFAULT = (24, 100, 300, 1000, 5000)
SHAPES = ((8, 8, 8), (16, 14, 12), (20, 18, 15))  # besides the default, (13, 11, 10)


@dataclass(frozen=True)
class Size:
    """What is learned: recordings, components and coefficients per dimension (None: default)."""

    recordings: int
    components: int = 3
    shape: tuple[int, ...] | None = None


@dataclass(frozen=True)
class Cost:
    """What it took: seconds, CPU seconds, and the peak of resident memory with and without us."""

    coefficients: int
    seconds: float
    cpu: float
    peak_mb: float
    before_mb: float


def varied(recording: Recording, rng: np.random.Generator, name: str) -> Recording:
    """The same movement another time: other ends, another speed, a little tremor."""
    stretch = float(np.exp(SPEED * rng.normal()))
    frames = max(10, round(len(recording.time) * stretch))
    here = np.linspace(0.0, 1.0, len(recording.time))
    there = np.linspace(0.0, 1.0, frames)
    q = np.column_stack([np.interp(there, here, column) for column in recording.q.T])
    start, end = MOVED * rng.normal(size=(2, q.shape[1]))
    ramp = there[:, None]
    q += start + ramp * (end - start)
    q += TREMOR * np.sin(2.0 * np.pi * (3.0 * ramp + rng.uniform(size=q.shape[1])))
    time = np.linspace(0.0, stretch * recording.duration, frames)
    return replace(recording, name=name, time=time, q=q)


def made_recordings(count: int, seed: int = 0) -> RecordingSet:
    """The built-in recordings, as often as it takes; the first round is as recorded."""
    own = read_recordings(Path(data_folder("assets")) / "experiments")
    rng = np.random.default_rng(seed)
    more = [
        varied(own[i % len(own)], rng, f"{own[i % len(own)].name}-{i // len(own)}")
        for i in range(len(own), count)
    ]
    return RecordingSet(tuple([*own, *more][:count]))


def peak_mb() -> float:
    """Greatest resident memory of this process so far.

    Where the kernel says it, by its word: what getrusage says includes that of the process that
    started this one.
    """
    status = Path("/proc/self/status")
    if status.is_file():
        peaks = [line for line in status.read_text().splitlines() if line.startswith("VmHWM")]
        return int(peaks[0].split()[1]) / 2**10
    unit = 2**20 if sys.platform == "darwin" else 2**10  # macOS counts in bytes
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit


def learn_here(size: Size) -> Cost:
    """Learn once in this process."""
    learn_controller(made_recordings(4))  # what is imported late is not learning
    recordings = made_recordings(size.recordings)
    before = peak_mb()
    began, cpu = perf_counter(), process_time()
    if size.shape is None:
        learned = learn_controller(recordings, n_components=size.components)
        coefficients = learned.summary["n_coefficients"]
    else:
        subspace = PostureSubspace(size.components).fit(np.vstack([r.q for r in recordings]))
        paths = [subspace.transform(r.q) for r in recordings]
        coefficients = DirectionLearner(shape=size.shape).fit(paths).n_coefficients_
    return Cost(coefficients, perf_counter() - began, process_time() - cpu, peak_mb(), before)


def learn_elsewhere(size: Size, repeats: int) -> Cost:
    """Learn in fresh processes; the fastest counts."""
    command = [sys.executable, __file__, "--child", str(size.recordings), str(size.components)]
    command += [str(m) for m in size.shape or ()]
    outputs = [
        subprocess.run(command, check=True, capture_output=True, text=True).stdout
        for _ in range(repeats)
    ]
    return min((Cost(**json.loads(output)) for output in outputs), key=lambda cost: cost.cpu)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recordings", type=int, nargs="+", default=DEFAULT)
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--child", type=int, nargs="+", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.child:
        recordings, components, *shape = arguments.child
        print(json.dumps(vars(learn_here(Size(recordings, components, tuple(shape) or None)))))
        return
    sizes = [Size(n) for n in arguments.recordings]
    sizes += [Size(100, 3, shape) for shape in SHAPES]
    sizes += [Size(n, components) for components in (2, 4, 5) for n in arguments.recordings]
    print("| recordings | components | coefficients | s | CPU s | peak, MB | of it learning, MB |")
    print("|---|---|---|---|---|---|---|")
    for size in sizes:
        cost = learn_elsewhere(size, arguments.repeats)
        cells = (size.recordings, size.components, cost.coefficients, f"{cost.seconds:.2f}",
                 f"{cost.cpu:.2f}", f"{cost.peak_mb:.0f}",
                 f"{cost.peak_mb - cost.before_mb:.0f}")  # fmt: skip
        print("| " + " | ".join(map(str, cells)) + " |", flush=True)


if __name__ == "__main__":
    main()
