"""How far answers are apart from one environment to another: BLAS kernels, threads, libraries.

Run: .venv/bin/python tests/benchmarks/environments.py [--tasks N] [--python OTHER/bin/python ...]

Each environment is a child process that learns from the built-in recordings, moves, and grasps by
the built-in plans; all are compared with the first. A kernel counts only where it is in force, and
where the processor runs it. ``--python`` takes interpreters with other versions of the libraries
and handsim installed.
The tolerances of `handsim.baseline.tolerances` come from the line "rounded up".
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from pathlib import Path

import numpy as np

from handsim.baseline import Baseline, Environment, Results, cases_for, run_cases
from handsim.baseline.comparison import deviation_deg
from handsim.baseline.environment import differences
from handsim.baseline.results import Cases
from handsim.baseline.store import read_baseline, write_baseline
from handsim.baseline.tolerances import MEASURES, Tolerances
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.plan_store import shipped_plans
from handsim.learning.controller import GraspController
from handsim.learning.learn import learn_like
from handsim.recordings.folder import read_recordings

ROOT = Path(__file__).resolve().parents[2]
KERNELS = ("Haswell", "SkylakeX", "Zen", "Sandybridge", "Nehalem")
NO_SIMD = {"NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR"}
NO_FMA = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F"}
"""The library of elementary functions then takes its code without fused multiplication."""
KINDS = ("movement", "relearned", "grasp")

PROBE = """
import numpy, scipy.linalg, threadpoolctl
a = numpy.random.default_rng(0).normal(size=(300, 300))
b = a @ a.T + numpy.eye(300)
numpy.linalg.svd(b), scipy.linalg.eigh(b), scipy.linalg.cho_factor(b)
print(*{i["architecture"] for i in threadpoolctl.threadpool_info() if i["user_api"] == "blas"})
"""


@dataclass(frozen=True, eq=False)
class Variant:
    """One environment: an interpreter and the variables that it is started with."""

    name: str
    variables: Mapping[str, str] = field(default_factory=dict)
    python: str = sys.executable

    def start(self, *arguments: str) -> "subprocess.Popen[str]":
        """Start Python in this environment."""
        kept = {k: v for k, v in os.environ.items() if k not in (*NO_SIMD, *NO_FMA)}
        kept |= {"PYTHONPATH": str(ROOT)} | dict(self.variables)
        command = [self.python, *arguments]
        return subprocess.Popen(
            command, env=kept, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE
        )


def threads(n: int) -> dict[str, str]:
    return {"OMP_NUM_THREADS": str(n), "OPENBLAS_NUM_THREADS": str(n)}


def kernel(name: str) -> dict[str, str]:
    return {"OPENBLAS_CORETYPE": name}


def why_not(name: str) -> str | None:
    """Say why a kernel cannot be had here, if so."""
    process = Variant(name, kernel(name)).start("-c", PROBE)
    said, _ = process.communicate()
    if process.returncode:
        return "the processor does not run it"
    if said.split() != [name]:
        return f"the library has no such kernel, it takes {said.strip() or 'none'}"
    return None


def variants(pythons: tuple[str, ...] = ()) -> tuple[list[Variant], dict[str, str]]:
    """Return the environments that can be had here, the usual one first, and why others cannot."""
    refused = {name: why for name in KERNELS if (why := why_not(name))}
    made = [Variant("as it is, 1 thread", threads(1)), Variant("as it is, 2 threads", threads(2))]
    made += [
        Variant(f"{name}, {n} thread{'s' * (n > 1)}", kernel(name) | threads(n))
        for name in KERNELS
        if name not in refused
        for n in (1, 2)
    ]
    if platform.machine() in ("x86_64", "AMD64"):
        made += [
            Variant("numpy without SIMD", NO_SIMD | threads(1)),
            Variant("libm without FMA", NO_FMA | threads(1)),
        ]
    made += [Variant(python, threads(1), python) for python in pythons]
    return made, refused


def answer_here(folder: Path, tasks: tuple[str, ...], n_movements: int | None) -> None:
    """Learn, move and grasp in this process; write answers and learned controller to a folder."""
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    learned = learn_like(controller, read_recordings(data_folder("assets") / "experiments"))
    plans = built_in_plans()
    asked = cases_for(controller, {task: plans[task] for task in tasks})
    names = list(asked.starts)[:n_movements]
    starts, goals = ({n: ends[n] for n in names} for ends in (asked.starts, asked.goals))
    cases = Cases(starts, goals, asked.plans)
    moved = Cases(cases.starts, cases.goals, {})
    again = run_cases(learned, moved).traces
    results = run_cases(controller, cases)
    relearned = {name.replace("movement/", "relearned/"): t for name, t in again.items()}
    results = Results(results.traces | relearned, results.inputs)
    made = Baseline(cases, results, True, Environment.here(), version("handsim"), ("measured",))
    write_baseline(made, folder / "baseline.npz")
    learned.save(folder / "controller.npz")


def built_in_plans():
    digest = GraspController.load(data_folder("assets") / "controller.npz").digest
    return shipped_plans(digest, Conditions()).read()


def apart(before: Baseline, after: Baseline) -> dict[str, float]:
    """Return the greatest deviation [deg] of each kind of answer and of each measure.

    Grasps that fail are left out, and counted where their verdict differs.
    """
    most = dict.fromkeys((*KINDS, *MEASURES, "verdicts"), 0.0)
    for name, old in before.results.traces.items():
        new = after.results.traces[name]
        most["verdicts"] += old.verdict != new.verdict
        if old.verdict not in ("held", "arrived"):
            continue
        kind = name.partition("/")[0]
        most[kind] = max(most[kind], float(deviation_deg(old, new)[1].max()))
        for measure, value in old.measures.items():
            most[measure] = max(most[measure], abs(new.measures[measure] - value))
    return most


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tasks", type=int, default=24, help="how many grasps, all by default")
    parser.add_argument("--python", action="append", default=[], help="another interpreter")
    parser.add_argument("--json", type=Path, help="file to write all deviations to")
    parser.add_argument("--movements", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--answer", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--task", action="append", default=[], help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.answer:
        answer_here(given.answer, tuple(given.task), given.movements)
        return
    tasks = tuple(built_in_plans())[: given.tasks]
    made, refused = variants(tuple(given.python))
    for name, why in refused.items():
        print(f"{name}: {why}")
    names = ("coefficients", *KINDS, *MEASURES, "verdicts")
    print(f"{'':<28} " + " ".join(f"{name:>13}" for name in names))
    first, rows = None, {}
    for variant in made:
        baseline, learned = run(variant, tasks)
        if first is None:
            first = baseline, learned
            print(json.dumps(asdict(baseline.environment)))
            continue
        rows[variant.name] = {"coefficients": off(first[1], learned)} | apart(first[0], baseline)
        show(variant.name, rows[variant.name], names)
        here = differences(first[0].environment, baseline.environment)
        print("    " + ("; ".join(here).replace(" in the baseline", "") or "no difference"))
    greatest = {name: max(row[name] for row in rows.values()) for name in names}
    show("greatest", greatest, names)
    show("rounded up", {name: rounded_up(value) for name, value in greatest.items()}, names)
    limits = Tolerances()
    usual = {kind: limits.of_answer(kind) for kind in KINDS} | MEASURES
    show("tolerance", usual | {"coefficients": 1e-6, "verdicts": 0.0}, names)
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1) + "\n")


def run(variant: Variant, tasks: tuple[str, ...]) -> tuple[Baseline, GraspController]:
    """Have an environment answer."""
    with tempfile.TemporaryDirectory() as folder:
        chosen = [part for task in tasks for part in ("--task", task)]
        process = variant.start(__file__, "--answer", folder, *chosen)
        _, said = process.communicate()
        if process.returncode:
            raise SystemExit(f"{variant.name}: {said}")
        return read(Path(folder))


def read(folder: Path) -> tuple[Baseline, GraspController]:
    """Read what `answer_here` wrote."""
    return read_baseline(folder / "baseline.npz"), GraspController.load(folder / "controller.npz")


def off(one: GraspController, other: GraspController) -> float:
    """Return the greatest difference of coefficients; infinite where there are others."""
    a, b = (c.navigation.obstacle.chi.coefficients for c in (one, other))
    return float(np.abs(a - b).max()) if a.shape == b.shape else np.inf


def rounded_up(value: float) -> float:
    """Return the next of 1, 2 and 5 times a power of ten."""
    if not value > 0:
        return 0.0
    power = 10.0 ** np.floor(np.log10(value))
    return next(float(step * power) for step in (1, 2, 5, 10) if value <= step * power * 1.0001)


def show(name: str, row: Mapping[str, float], names: tuple[str, ...]) -> None:
    print(f"{name[-28:]:<28} " + " ".join(f"{row[each]:>13.3g}" for each in names), flush=True)


if __name__ == "__main__":
    main()
