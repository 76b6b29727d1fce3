"""The environment on record is the one in force."""

import os
import subprocess
import sys
from dataclasses import fields, replace

import pytest

from handsim.baseline.environment import Environment, differences

HERE = Environment.here()


def elsewhere(**variables: str) -> Environment:
    """Return the environment of a process that is started with these variables."""
    code = "from handsim.baseline.environment import *; print(repr(Environment.here()))"
    done = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | variables,
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    return eval(done.stdout, {"Environment": Environment})


def test_all_of_it_is_known_and_repeats():
    assert all(getattr(HERE, field.name) for field in fields(Environment))
    assert Environment.here() == HERE
    assert differences(HERE, HERE) == ()


@pytest.mark.skipif("x86_64" not in HERE.system, reason="kernels of other processors")
@pytest.mark.skipif("openblas" not in HERE.blas, reason="kernels of another BLAS")
def test_kernel_threads_simd_and_libm_are_on_record():
    threads = "2" if HERE.blas_threads == "1" else "1"
    other = elsewhere(
        OPENBLAS_CORETYPE="Nehalem",
        NPY_DISABLE_CPU_FEATURES="X86_V3 X86_V4 AVX512_ICL AVX512_SPR",
        GLIBC_TUNABLES="glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F",
        OPENBLAS_NUM_THREADS=threads,
        OMP_NUM_THREADS=threads,
    )
    assert other.blas_kernel == "Nehalem"
    # One core has one thread, and there are processors and libraries without the others.
    changed = {f.name for f in fields(other) if getattr(other, f.name) != getattr(HERE, f.name)}
    assert changed <= {"blas_kernel", "blas_threads", "simd", "libm"}
    assert len(changed) > 1


def test_every_field_is_told_by_name():
    for field in fields(Environment):
        (line,) = differences(HERE, replace(HERE, **{field.name: "other"}))
        assert line.endswith(f" {getattr(HERE, field.name)} in the baseline, other here")
    (line,) = differences(HERE, replace(HERE, simd=""))
    assert line.endswith("none here")


def test_versions_of_an_old_baseline_are_an_environment():
    old = Environment.stored({
        "scikit-learn": "1.9", "platform": "Linux x86_64", "mujoco": "4.0", "handsim": "0.1.0"
    })  # fmt: skip
    assert old == Environment(scikit_learn="1.9", system="Linux x86_64", mujoco="4.0")
    *told, unknown = differences(old, replace(HERE, mujoco="3.17.0", system="Linux x86_64"))
    assert told[-1] == "mujoco 4.0 in the baseline, 3.17.0 here"
    assert unknown.startswith("the baseline does not say of which processor, python, numpy,")
