"""The same answers with other BLAS kernels, thread counts, SIMD and elementary functions.

Each environment is a child process (see `benchmarks/environments.py`), so that what would go wrong
on another machine goes wrong here. Some are sampled; the slow test takes all of them.
"""

import importlib.util
import os
import platform
import sys
from collections import deque
from pathlib import Path

import numpy as np
import pytest

from handsim.baseline.comparison import compare
from handsim.baseline.findings import Report

_source = Path(__file__).parent / "benchmarks" / "environments.py"
_spec = importlib.util.spec_from_file_location("environments", _source)
assert _spec
assert _spec.loader
environments = importlib.util.module_from_spec(_spec)
sys.modules["environments"] = environments  # dataclasses look themselves up there
_spec.loader.exec_module(environments)

TASKS = ("cube-raise", "pen-move")
N_MOVEMENTS = 16
X86 = platform.machine() in ("x86_64", "AMD64")
USUAL = environments.Variant("as it is, 1 thread", environments.threads(1))
OLD = environments.Variant(
    "Sandybridge, 2 threads, numpy without SIMD, libm without FMA",
    environments.kernel("Sandybridge")
    | environments.NO_SIMD
    | environments.NO_FMA
    | environments.threads(2),
)
SAMPLED = [OLD] if X86 else [environments.Variant("as it is, 2 threads", environments.threads(2))]


def answers_of(variants, folder: Path, tasks=TASKS, n_movements=N_MOVEMENTS):
    """Have each environment answer, as many at once as there are cores."""
    waiting, running, read = deque(variants), {}, {}
    while waiting or running:
        while waiting and len(running) < (os.cpu_count() or 1):
            variant = waiting.popleft()
            into = folder / str(len(read) + len(running))
            into.mkdir(parents=True)
            chosen = [part for task in tasks for part in ("--task", task)]
            chosen += ["--movements", str(n_movements)]
            running[variant] = into, variant.start(str(_source), "--answer", str(into), *chosen)
        variant, (into, process) = next(iter(running.items()))
        _, said = process.communicate()
        del running[variant]
        assert process.returncode == 0, f"{variant.name}: {said}"
        read[variant] = environments.read(into)
    return read


@pytest.fixture(scope="module")
def sampled(tmp_path_factory):
    return answers_of([USUAL, *SAMPLED], tmp_path_factory.mktemp("environments"))


def check_learning(one, other) -> None:
    """Coefficients the same to the bit, the same digest, movements within 0.001 deg."""
    (before, learned), (after, again) = one, other
    assert environments.off(learned, again) == 0.0
    assert again.digest == learned.digest
    report = reported(before, after, "relearned/")
    assert report.ok, report.as_text()
    assert len(report.changes) == len(before.cases.starts)


def check_answers(one, other) -> None:
    """Movements and grasps of one controller within their tolerances, verdicts the same."""
    before, after = one[0], other[0]
    for kind, n in (("movement/", len(before.cases.starts)), ("grasp/", len(TASKS))):
        report = reported(before, after, kind)
        assert report.ok, report.as_text()
        assert len(report.changes) >= n
    assert after.results.inputs == before.results.inputs
    for name, trace in before.results.traces.items():
        assert after.results.traces[name].verdict == trace.verdict, name


def reported(before, after, kind: str) -> Report:
    """Compare the answers of one kind."""
    results = [
        type(one.results)(
            {name: trace for name, trace in one.results.traces.items() if name.startswith(kind)},
            one.results.inputs,
        )
        for one in (before, after)
    ]
    return compare(*results, environments=(before.environment, after.environment))


@pytest.mark.parametrize("variant", SAMPLED, ids=lambda variant: variant.name)
def test_learning_gives_one_answer(sampled, variant):
    check_learning(sampled[USUAL], sampled[variant])


@pytest.mark.parametrize("variant", SAMPLED, ids=lambda variant: variant.name)
def test_answers_of_one_controller_are_the_same(sampled, variant):
    check_answers(sampled[USUAL], sampled[variant])


@pytest.mark.skipif(not X86, reason="kernels of other processors")
def test_the_sampled_environments_are_others(sampled):
    usual, old = sampled[USUAL][0].environment, sampled[OLD][0].environment
    assert old.blas_kernel == "Sandybridge"
    assert old.libm != usual.libm or "glibc" not in usual.libm
    assert old.simd != usual.simd or len(usual.simd.split()) == 1


def test_what_was_learned_elsewhere_is_not_just_anything(sampled):
    """What is compared with moves its hand, and holds what it grasps."""
    baseline, learned = sampled[USUAL]
    verdicts = {t.verdict for t in baseline.results.traces.values()}
    assert verdicts - {"clipped"} == {"arrived", "held"}  # a movement may end at a joint's limit
    assert np.abs(learned.navigation.obstacle.chi.coefficients).max() > 0.1
    moved = [np.ptp(t.q, axis=0).max() for t in baseline.results.traces.values()]
    assert min(moved) > 0.05


@pytest.mark.slow
def test_all_environments_that_can_be_had(tmp_path):
    variants, refused = environments.variants()
    assert set(refused) < set(environments.KERNELS) or not X86
    tasks = tuple(environments.built_in_plans())
    read = answers_of(variants, tmp_path, tasks, 48)
    first, *others = read.values()
    for variant, other in zip(variants[1:], others, strict=True):
        kernel = variant.variables.get("OPENBLAS_CORETYPE")
        assert kernel in (None, other[0].environment.blas_kernel)
        check_learning(first, other)
        check_answers(first, other)
