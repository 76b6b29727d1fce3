"""A transport in a file, and the one that is shipped: learned from 20 reaches of a person."""

from functools import cache
from pathlib import Path

import numpy as np

from handsim.errors import FileError, InputError
from handsim.files import data_folder, read_archive, write_archive
from handsim.learning._stored_navigation import (
    check_navigation,
    check_numbers,
    check_shape,
    content_of_navigation,
    navigation_of,
)
from handsim.learning.movement.progress import check_duration
from handsim.learning.transport.transport import N_CONTROL, Transport, certified_transport
from handsim.types import Side

KIND, SCHEMA = "transport", 1
SHIPPED = "people/transport.npz"


@cache
def shipped_transport(side: Side = "right") -> Transport:
    """Return what was learned from the reaches that are shipped, for a right or a left hand."""
    return load_transport(data_folder("assets") / SHIPPED).for_side(side)


def save_transport(transport: Transport, path: Path) -> None:
    """Write the transport of a right hand to an ``.npz`` without pickles."""
    metadata, arrays = content_of_navigation(transport.navigation)
    metadata |= {"duration": transport.duration, "n_reaches": transport.n_reaches}
    arrays |= {"rises": np.array(transport.rises), "progress": transport.progress}
    write_archive(path, KIND, SCHEMA, metadata, arrays)


def load_transport(path: Path) -> Transport:
    """Read a transport. What is proved of it is proved anew.

    Raises
    ------
    FileError
        If the file is missing, damaged, of another kind or of a newer schema.
    """
    metadata, arrays = read_archive(path, KIND, SCHEMA)
    try:
        check_numbers(arrays)
        check_navigation(3, metadata, arrays)
        check_shape("rises", arrays, 2)
        check_shape("progress", arrays, N_CONTROL)
        return certified_transport(
            navigation_of(3, metadata, arrays),
            (float(arrays["rises"][0]), float(arrays["rises"][1])),
            arrays["progress"],
            check_duration(metadata["duration"]),
            int(metadata["n_reaches"]),
        )
    except (KeyError, ValueError, TypeError, IndexError, InputError) as error:
        raise FileError(
            f"{path}: not a whole transport ({type(error).__name__}: {error}); learn it again"
        ) from error
