"""Baselines: what a controller did, kept, so that a change of it is noticed and named.

A baseline asks a controller for movements and grasps and keeps its answers together with a hash of
everything that they depend on. A check asks the same again.
"""

from handsim.baseline.comparison import Report, Tolerances, compare
from handsim.baseline.outputs import Outputs, Questions, answer, questions_for
from handsim.baseline.store import Baseline, read_baseline, write_baseline

__all__ = [
    "Baseline",
    "Outputs",
    "Questions",
    "Report",
    "Tolerances",
    "answer",
    "compare",
    "questions_for",
    "read_baseline",
    "write_baseline",
]
