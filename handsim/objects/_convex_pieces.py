"""Decomposition of a concave mesh into convex pieces by CoACD, in a process of its own.

CoACD is native code that can crash or run without end on a mesh that crosses itself; a child
process turns that into an error.
"""

import os
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
    "preprocess_mode": "auto",  # repairs what is closed but crosses itself
    "mcts_iterations": 30,
    "mcts_nodes": 8,
    "resolution": 600,
    "max_ch_vertex": 64,
    "max_convex_hull": 64,
}
"""Settings of CoACD (X. Wei et al. 2022, ACM Trans. Graph. 41(4):42): a cup in 9 s rather than
the 18 s of the defaults, with the same excess volume."""

TIME_LIMIT = 120.0
"""After which a decomposition is given up [s]."""


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
        If no decomposition is found within `TIME_LIMIT`.
    """
    if find_spec("coacd") is None:
        raise MissingToolError("a concave mesh needs decomposition; run pip install coacd")
    with tempfile.TemporaryDirectory() as folder:
        given, made = Path(folder) / "given.npz", Path(folder) / "made.npz"
        np.savez(given, vertices=vertices, faces=faces, seed=seed)
        command = [sys.executable, "-m", "handsim.objects._convex_pieces", str(given), str(made)]
        try:
            subprocess.run(
                command,
                timeout=TIME_LIMIT,
                capture_output=True,
                check=False,
                env=os.environ | {"OMP_NUM_THREADS": "1"},
            )
        except subprocess.TimeoutExpired:
            raise InputError(
                f"the mesh was not decomposed within {TIME_LIMIT:g} s; simplify it"
            ) from None
        if not made.is_file():
            raise InputError("the mesh cannot be decomposed; it may cross itself, repair it")
        with np.load(made) as pieces:
            return [pieces[f"piece_{i}"] for i in range(len(pieces.files))]


def main() -> None:
    """Decompose the mesh in the first file named on the command line into the second."""
    import coacd

    given, made = (Path(name) for name in sys.argv[1:])
    coacd.set_log_level("error")
    with np.load(given) as mesh:
        parts = coacd.run_coacd(
            coacd.Mesh(mesh["vertices"], mesh["faces"]), seed=int(mesh["seed"]), **SETTINGS
        )
    pieces = {f"piece_{i}": np.array(vertices) for i, (vertices, _) in enumerate(parts)}
    half = made.with_suffix(".half.npz")
    np.savez(half, allow_pickle=False, **pieces)
    half.replace(made)


if __name__ == "__main__":
    main()
