"""The libraries that write for others; none of them is needed for anything else."""

from importlib import import_module
from typing import Any

from handsim.errors import MissingToolError

_EXTRAS = {"pandas": "export", "pyarrow": "export", "h5py": "export", "rerun": "rerun"}
_PACKAGES = {"rerun": "rerun-sdk"}


def library(name: str) -> Any:
    """Import a library, or a module of one.

    Parameters
    ----------
    name
        Such as ``pandas`` or ``pyarrow.parquet``.

    Raises
    ------
    MissingToolError
        If it is not installed; the message says how it is.
    """
    package = name.partition(".")[0]
    try:
        return import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] != package:
            raise  # something that the library itself lacks
        raise MissingToolError(
            f"this export needs {_PACKAGES.get(package, package)}; run: "
            f"pip install 'handsim[{_EXTRAS[package]}]'"
        ) from error
