"""Baselines: what a controller did, kept, so that a change of it is noticed and named.

A baseline asks a controller for movements and grasps and keeps its answers together with a hash of
everything that they depend on and the environment that they were made in. A check asks the same
again.
"""

from handsim.baseline.comparison import compare
from handsim.baseline.environment import Environment
from handsim.baseline.findings import Report
from handsim.baseline.results import Cases, Results, answer, cases_for
from handsim.baseline.store import Baseline, read_baseline, write_baseline
from handsim.baseline.tolerances import Tolerances

__all__ = [
    "Baseline",
    "Cases",
    "Environment",
    "Report",
    "Results",
    "Tolerances",
    "answer",
    "cases_for",
    "compare",
    "read_baseline",
    "write_baseline",
]
