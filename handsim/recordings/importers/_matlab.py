"""Variables of MATLAB 5 files, whose claims are compared with what is there before it is read.

SciPy's reader allocates a cell array as large as its header says: forty bytes that claim 50000 x
50000 cells take 20 GB. Layout of the files: MathWorks, "MAT-File Format" (level 5).
"""

import struct
import zlib
from collections.abc import Iterator, Sequence
from io import BytesIO
from math import prod
from pathlib import Path
from typing import Any

from handsim.errors import FileError
from handsim.files import MAX_ARCHIVE_BYTES, is_file

_HEADER_BYTES = 128
_MATRIX, _COMPRESSED = 14, 15
_CELL, _CHAR, _NUMBERS = 1, 4, range(6, 16)
_MAX_DEPTH = 4
_ORDERS = {b"IM": "<", b"MI": ">"}


def read_variables(path: Path, names: Sequence[str]) -> dict[str, Any]:
    """Read those of the named variables that a MATLAB 5 file holds.

    Raises
    ------
    FileError
        If the file is missing, damaged, too large, or holds other than numbers, text and cells.
    """
    if not is_file(path):
        raise FileError(f"{path}: no such file; check the path")
    from scipy.io import loadmat

    try:
        if path.stat().st_size > MAX_ARCHIVE_BYTES:
            raise ValueError(f"larger than {MAX_ARCHIVE_BYTES} bytes")
        data = path.read_bytes()
        _check(data)
        content = loadmat(BytesIO(data), variable_names=list(names))
    except Exception as error:  # loadmat raises a dozen different classes
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise FileError(
            f"{path}: not a readable MATLAB 5 file ({reason}); download it again"
        ) from error
    return {name: content[name] for name in names if name in content}


def _check(data: bytes) -> None:
    order = _ORDERS.get(data[126:128])
    if order is None:
        raise ValueError("its header is that of another format")
    room = MAX_ARCHIVE_BYTES
    for kind, content in _elements(memoryview(data)[_HEADER_BYTES:], order):
        if kind != _COMPRESSED:
            _check_matrix(kind, content, order, 0)
            continue
        unpacker = zlib.decompressobj()
        unpacked = unpacker.decompress(content, room)
        room -= len(unpacked)
        if not unpacker.eof:
            raise ValueError(f"unpacks to more than {MAX_ARCHIVE_BYTES} bytes, or is cut off")
        for inner_kind, inner in _elements(memoryview(unpacked), order):
            _check_matrix(inner_kind, inner, order, 0)


def _elements(data: memoryview, order: str) -> Iterator[tuple[int, memoryview]]:
    """Kind and content of each element; a small one has its content in the tag."""
    at = 0
    while at + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        if kind >> 16:
            yield kind & 0xFFFF, data[at + 4 : at + 4 + min(kind >> 16, 4)]
            at += 8
            continue
        if at + 8 + size > len(data):
            raise ValueError(f"an element of {size} bytes is cut off")
        yield kind, data[at + 8 : at + 8 + size]
        at += 8 + size + (-size % 8 if kind != _COMPRESSED else 0)


def _check_matrix(kind: int, content: memoryview, order: str, depth: int) -> None:
    if kind != _MATRIX:
        raise ValueError(f"an element of kind {kind} where a variable was expected")
    if not content:
        return  # an empty cell
    parts = _elements(content, order)
    (_, flags), (_, sizes) = next(parts), next(parts)
    dimensions = struct.unpack(f"{order}{len(sizes) // 4}i", sizes)
    array_class = struct.unpack_from(f"{order}I", flags)[0] & 0xFF
    if array_class not in (_CELL, _CHAR, *_NUMBERS) or depth > _MAX_DEPTH:
        raise ValueError(f"an array of class {array_class}, which no recording needs")
    if min(dimensions) < 0 or prod(dimensions) > len(content):
        raise ValueError(f"an array of {dimensions} values in {len(content)} bytes")
    next(parts)  # its name
    if array_class == _CELL:
        for inner_kind, inner in parts:
            _check_matrix(inner_kind, inner, order, depth + 1)
