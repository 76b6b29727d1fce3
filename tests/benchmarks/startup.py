"""CPU time of commands that should answer at once, beside that of importing NumPy and SciPy.

    python -m tests.benchmarks.startup [--runs N]

Each runs in a process of its own, once before it is measured, so that modules are compiled and in
memory as they are for a user. Given are medians of user and system time.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

YARDSTICK = ("-c", "import numpy, scipy")
HANDSIM = ("-c", "from handsim.cli import main; main()")
COMMANDS = (
    "--help",
    "tasks",
    "objects",
    "hands",
    "recordings info",
    "postures --task cube-raise -o postures.csv",
    "evaluate",
    "render postures.csv -o postures.png",
)


def cpu_seconds(words: tuple[str, ...], folder: Path, environment: dict[str, str]) -> float:
    """CPU time of one process of Python and its children [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, *words],
        cwd=folder, env=environment, check=True, capture_output=True,
    )  # fmt: skip
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=9, help="of each command, beside the first")
    runs = parser.parse_args().runs
    root = str(Path(__file__).parents[2])
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(filter(None, (root, os.environ.get("PYTHONPATH")))),
            "PYTHONDONTWRITEBYTECODE": "",
            "PYTHONPYCACHEPREFIX": str(Path(folder) / "compiled"),
            "XDG_CACHE_HOME": str(Path(folder) / "cache"),
            "MUJOCO_GL": "",
        }
        print("| | CPU s | times the first line |\n|---|---|---|")
        first = None
        for name in (YARDSTICK[-1], *COMMANDS):
            words = YARDSTICK if name == YARDSTICK[-1] else (*HANDSIM, *name.split())
            cpu_seconds(words, Path(folder), environment)
            taken = [cpu_seconds(words, Path(folder), environment) for _ in range(runs)]
            median = statistics.median(taken)
            first = first or median
            print(f"| `{name}` | {median:.2f} | {median / first:.1f} |", flush=True)


if __name__ == "__main__":
    main()
