"""Where results were computed: processor, libraries, and their settings.

Processors and BLAS kernels differ in the order of their sums, and in whether a product and a sum
are rounded together. Results then differ in their last bits, and what is computed from them may
differ in more.
"""

import hashlib
import math
import platform
import struct
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_info

LABELS = {
    "scikit_learn": "scikit-learn",
    "blas": "BLAS",
    "blas_kernel": "BLAS kernel",
    "blas_threads": "BLAS threads",
    "simd": "SIMD of numpy",
}
"""Names for people, where they are not those of the fields."""
_WITH_BLAS = ("scipy.linalg",)
"""Modules that load a BLAS of their own, which is found only when they are imported."""
_FUNCTIONS: tuple[Callable[[float], float], ...] = (
    math.exp, math.expm1, math.sin, math.cos, math.tan, math.atan, math.sinh,
)  # fmt: skip
_POINTS = 4000
"""Points at which each function is computed: one result in a thousand differs with fused
multiplication."""


@dataclass(frozen=True)
class Environment:
    """What the last bits of a result depend on; fields that are not known are empty.

    Attributes
    ----------
    processor, system
        Model of the processor; operating system and machine.
    python, numpy, scipy, scikit_learn, mujoco
        Versions.
    blas, blas_kernel, blas_threads
        Libraries of linear algebra with their versions, the kernels that they chose, and how many
        threads they may take, each once.
    simd
        Extensions of the processor that numpy found and uses.
    libm
        Library of elementary functions, and a checksum of what they return: with and without
        fused multiplication one version returns other last bits.
    """

    processor: str = ""
    system: str = ""
    python: str = ""
    numpy: str = ""
    scipy: str = ""
    scikit_learn: str = ""
    mujoco: str = ""
    blas: str = ""
    blas_kernel: str = ""
    blas_threads: str = ""
    simd: str = ""
    libm: str = ""

    @classmethod
    def here(cls) -> "Environment":
        """Return that of this process."""
        for module in _WITH_BLAS:
            import_module(module)
        found = [library for library in threadpool_info() if library["user_api"] == "blas"]
        return cls(
            processor=_processor(),
            system=f"{platform.system()} {platform.machine()}",
            python=platform.python_version(),
            numpy=version("numpy"),
            scipy=version("scipy"),
            scikit_learn=version("scikit-learn"),
            mujoco=version("mujoco"),
            blas=_each_once(f"{library['internal_api']} {library['version']}" for library in found),
            blas_kernel=_each_once(library.get("architecture", "") for library in found),
            blas_threads=_each_once(library["num_threads"] for library in found),
            simd=_simd(),
            libm=_libm(),
        )

    @classmethod
    def stored(cls, values: Mapping[str, Any]) -> "Environment":
        """Return what is known of an environment that was stored by field, or by package."""
        by_field = {str(name).replace("-", "_"): str(value) for name, value in values.items()}
        by_field.setdefault("system", by_field.get("platform", ""))
        return cls(**{name: by_field.get(name, "") for name in _names()})


def differences(before: Environment, now: Environment) -> tuple[str, ...]:
    """Return a line for each difference, and one for all that the first does not know."""
    lines: list[str] = []
    unknown: list[str] = []
    for name in _names():
        label, old, new = LABELS.get(name, name), getattr(before, name), getattr(now, name)
        if not old and new:
            unknown.append(label)
        elif old != new:
            lines.append(f"{label} {old} in the baseline, {new or 'none'} here")
    if unknown:
        lines.append(f"the baseline does not say of which {', '.join(unknown)} it is")
    return tuple(lines)


def _names() -> tuple[str, ...]:
    return tuple(field.name for field in fields(Environment))


def _each_once(values: Any) -> str:
    return ", ".join(sorted({str(value) for value in values}))


def _processor() -> str:
    """Return the model's name as Linux tells it, elsewhere what Python knows."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def _simd() -> str:
    extensions: dict[str, Any] = np.show_config(mode="dicts") or {}  # pyright: ignore[reportAssignmentType]
    extensions = extensions.get("SIMD Extensions", {})
    return " ".join([*extensions.get("baseline", ()), *extensions.get("found", ())])


def _libm() -> str:
    name = " ".join(filter(None, platform.libc_ver())) or sys.platform
    values = [f(8.0 * (2 * i / _POINTS - 1) + 1e-3) for f in _FUNCTIONS for i in range(_POINTS)]
    checksum = hashlib.sha256(struct.pack(f"{len(values)}d", *values)).hexdigest()[:8]
    return f"{name} {checksum}"
