"""What each part of the direction learner is worth, in training and on trials left out.

Run: .venv/bin/python tests/benchmarks/learning_variants.py [--folds N] [name ...]
Without --folds nothing is left out.
"""

import argparse
import sys
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from learning_data import SUBJECTS, Subject, load, ratio, roll_out

from handsim.learning.direction.learner import DirectionLearner

VARIANTS: dict[str, dict[str, Any]] = {
    "as it is": {},
    "gamma_d of the paper": {"metric_ridge": None},
    "recordings as they are": {"averaging": 0.0},
    "both as in the paper": {"metric_ridge": None, "averaging": 0.0},
    "averaged over twice the reach": {"averaging": 0.5},
    "metric ridge x 10": {"metric_ridge": 1e-2},
    "metric ridge / 10": {"metric_ridge": 1e-4},
    "no refinement by roll-out": {"n_refinements": 0},
    "2 refinements": {"n_refinements": 2},
    "8 refinements": {"n_refinements": 8},
    "no descent condition": {"descent": 0.0},
    "smoothness x 5": {"smoothness": 2.5e-4},
    "smoothness / 5": {"smoothness": 1e-5},
    "knots by variance (the paper)": {"knot_rule": "variance"},
    "knots by deviation": {"knot_rule": "deviation"},
    "equal knots": {"knot_rule": "equal"},
    "3072 coefficients": {"shape": (16, 16, 12)},
    "certified": {"certified": True},
}


def left_out(subject: Subject, folds: int, options: dict[str, Any]) -> tuple[float, int]:
    """Ratio and arrivals over trials left out one at a time, ``folds`` of them evenly spread."""
    chosen = np.linspace(0, len(subject.paths) - 1, folds).round().astype(int)
    rollouts, paths = [], []
    for i in chosen:
        others = subject.paths[:i] + subject.paths[i + 1 :]
        directions = DirectionLearner(**options).fit(others).navigation_.directions
        paths.append(subject.paths[i])
        rollouts += roll_out(directions, [subject.paths[i]])
    return ratio(rollouts, paths), sum(r.arrived for r in rollouts)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--folds", type=int, default=0)
    parser.add_argument("names", nargs="*")
    arguments = parser.parse_args()
    subjects = [load(number) for number in SUBJECTS]
    print(
        "| variant | training, subjects 1 to 4 | mean | arrive | CPU s | left out | mean | arrive |"
    )
    print("|---|---|---|---|---|---|---|---|")
    for name in arguments.names or VARIANTS:
        options = VARIANTS[name]
        ratios, arrivals, seconds, out = [], 0, [], []
        for subject in subjects:
            began = process_time()
            directions = DirectionLearner(**options).fit(subject.paths).navigation_.directions
            seconds.append(process_time() - began)
            rollouts = roll_out(directions, subject.paths)
            ratios.append(ratio(rollouts, subject.paths))
            arrivals += sum(r.arrived for r in rollouts)
            if arguments.folds:
                out.append(left_out(subject, arguments.folds, options))
        cells = [" ".join(f"{r:.2f}" for r in ratios), f"{np.mean(ratios):.3f}", str(arrivals)]
        cells += [f"{np.mean(seconds):.1f}", " ".join(f"{r:.2f}" for r, _ in out)]
        cells += [f"{np.mean([r for r, _ in out]):.3f}" if out else ""]
        cells += [str(sum(n for _, n in out)) if out else ""]
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
