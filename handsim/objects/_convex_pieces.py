"""Decomposition of a concave mesh into convex pieces by CoACD, in a process of its own.

CoACD is native code that can crash or run without end on a mesh that crosses itself; a child
process turns that into an error.
"""

import math
import os
import signal
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.errors import InputError, MissingToolError
from handsim.types import Array

SETTINGS: dict[str, Any] = {
    "threshold": 0.05,
    "mcts_iterations": 30,
    "mcts_nodes": 8,
    "resolution": 600,
    "max_ch_vertex": 64,
    "max_convex_hull": 64,
}
"""Settings of CoACD (X. Wei et al. 2022, ACM Trans. Graph. 41(4):42): a cup in 9 s where
60 iterations and a resolution of 1000 take 14 s, with the same excess volume."""

MODES = {"off": 60.0, "auto": 12.0}
"""How the mesh is prepared, in turn, and how long each may take [s of the processor, so that a busy
machine refuses no other meshes]. CoACD's repair of what crosses itself can run without end, and is
seldom needed: it comes second, where the first crashed."""
PATIENCE = 10.0
"""How many times as long by the clock a process may take that gets no processor, or cannot be
limited."""


def decompose(vertices: Array, faces: npt.NDArray[np.integer], seed: int) -> list[Array]:
    """Return the vertices of each convex piece.

    The same mesh and seed give the same pieces, whatever the number of threads allowed.

    Parameters
    ----------
    vertices : (n, 3) [m]
    faces : (m, 3)
    seed

    Raises
    ------
    MissingToolError
        If ``coacd`` is not installed.
    InputError
        If no decomposition is found within the times of `MODES`.
    """
    if find_spec("coacd") is None:
        raise MissingToolError("a concave mesh needs coacd; run: pip install 'handsim[assets]'")
    with tempfile.TemporaryDirectory() as folder:
        given, made = Path(folder) / "given.npz", Path(folder) / "made.npz"
        np.savez(given, vertices=vertices, faces=faces, seed=seed)
        for mode, limit in MODES.items():
            _run(mode, limit, given, made)
            if made.is_file():
                break
        else:
            raise InputError("the mesh cannot be decomposed; it may cross itself, repair it")
        with np.load(made) as pieces:
            return [pieces[f"piece_{i}"] for i in range(len(pieces.files))]


def _run(mode: str, limit: float, given: Path, made: Path) -> None:
    """Decompose in a process of its own; there is no file ``made`` if that crashes."""
    module = [sys.executable, "-m", "handsim.objects._convex_pieces"]
    too_long = InputError(f"the mesh was not decomposed within {limit:g} s; simplify it")
    try:
        ended = subprocess.run(
            [*module, mode, str(limit), str(given), str(made)],
            timeout=PATIENCE * limit,
            capture_output=True,
            check=False,
            env=os.environ | {"OMP_NUM_THREADS": "1"},
        )
    except subprocess.TimeoutExpired:
        raise too_long from None
    over = getattr(signal, "SIGXCPU", None)
    if over is not None and ended.returncode == -over:
        raise too_long


def main() -> None:
    """Decompose a mesh: mode, limit [s], its file, and that for the pieces on the command line."""
    mode, limit = sys.argv[1:3]
    given, made = (Path(name) for name in sys.argv[3:])
    if find_spec("resource") is not None:
        import resource

        most = math.ceil(float(limit))
        resource.setrlimit(resource.RLIMIT_CPU, (most, most + 1))

    import coacd

    coacd.set_log_level("error")
    with np.load(given) as mesh:
        parts = coacd.run_coacd(
            coacd.Mesh(mesh["vertices"], mesh["faces"]),
            preprocess_mode=mode,
            seed=int(mesh["seed"]),
            **SETTINGS,
        )
    pieces = {f"piece_{i}": np.array(vertices) for i, (vertices, _) in enumerate(parts)}
    half = made.with_suffix(".half.npz")
    np.savez(half, allow_pickle=False, **pieces)
    half.replace(made)


if __name__ == "__main__":
    main()
