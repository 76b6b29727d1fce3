"""How well single drawn shapes are followed: the LASA handwriting, 7 demonstrations a shape.

Run: .venv/bin/python tests/benchmarks/handwriting.py [NAME ...]

The data (S. M. Khansari-Zadeh and A. Billard) is not part of this repository; the script looks for
it under ../shared/data/handwriting. The mean path has the mean departure of all demonstrations from
the straight line between its own ends. It is no field, and no worse than what demonstrations that
begin at one place have in common.
"""

import sys
from pathlib import Path
from time import process_time

import numpy as np

import handsim
from handsim.navigation.flow import follow
from handsim.navigation.paths import N_COMPARED, at_arc_length, path_error

DATA = Path(__file__).parents[2] / "../shared/data/handwriting"
N_STARTS = 200


def of_mean_path(paths: list[np.ndarray]) -> float:
    """Error of the mean path over that of the straight line."""
    s = np.linspace(0.0, 1.0, N_COMPARED)
    even = np.array([at_arc_length(path, s) for path in paths])
    straight = even[:, :1] + s[:, None] * (even[:, -1:] - even[:, :1])
    made = straight + (even - straight).mean(axis=0)
    errors, lines = (
        [path_error(a, b) for a, b in zip(each, even, strict=True)] for each in (made, straight)
    )
    return float(np.mean(errors) / np.mean(lines))


def arrivals(learner: handsim.NavigationLearner) -> int:
    """Of 200 starts at random in the workspace, how many arrive."""
    navigation = learner.navigation_
    low, high = navigation.obstacle.lower, navigation.obstacle.upper
    starts = np.random.default_rng(1).uniform(low, high, (N_STARTS, len(low)))
    goal = (learner.goals_[0] - learner.centre_) * learner.scale_
    return sum(path.arrived for path in follow(navigation.directions, starts, goal))


def main() -> None:
    if not DATA.is_dir():
        sys.exit(f"{DATA}: the handwriting is not there; see the docstring")
    files = [
        file for file in sorted(DATA.glob("*.npz")) if file.stem in (sys.argv[1:] or file.stem)
    ]
    print("| shape | mean path | ours | arrive | proved for | random starts | CPU s | made by |")
    print("|---|---|---|---|---|---|---|---|")
    rows = []
    for file in files:
        paths = list(np.load(file)["pos"].astype(float))
        began = process_time()
        learner = handsim.NavigationLearner().fit(paths)
        seconds = process_time() - began
        scores, proof = learner.evaluate(paths), learner.certificate_
        who = ("every start" if proof.everywhere else "almost every") if proof.certified else "none"
        rows.append((of_mean_path(paths), scores.ratio, seconds))
        cells = (
            file.stem,
            f"{rows[-1][0]:.2f}",
            f"{scores.ratio:.2f}",
            f"{scores.n_arrived} of {scores.n_paths}",
            who,
            f"{arrivals(learner)} of {N_STARTS}",
            f"{seconds:.1f}",
            learner.origin_,
        )
        print("|", " | ".join(cells), "|", flush=True)
    a, b, seconds = np.mean(rows, axis=0)
    print(f"| **mean** | {a:.2f} | **{b:.3f}** | | | | {seconds:.1f} | |")


if __name__ == "__main__":
    main()
