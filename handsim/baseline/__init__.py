"""Baselines: kept results of a controller, with which later results are compared.

In: a controller, plans and recordings. Out: a file with the results of all cases (movements and
grasps), a hash of everything that they depend on, and the environment in which they were made. A
check runs the same cases again and reports what differs. May import all rooms but `cli`.
"""

from handsim.baseline.comparison import compare
from handsim.baseline.environment import Environment
from handsim.baseline.findings import Report
from handsim.baseline.results import Cases, Results, cases_for, run_cases
from handsim.baseline.store import Baseline, read_baseline, write_baseline
from handsim.baseline.tolerances import Tolerances

__all__ = [
    "Baseline",
    "Cases",
    "Environment",
    "Report",
    "Results",
    "Tolerances",
    "cases_for",
    "compare",
    "read_baseline",
    "run_cases",
    "write_baseline",
]
