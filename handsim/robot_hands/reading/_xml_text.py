"""The XML of a hand, checked for what no hand needs and what would read or take too much."""

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

from handsim.errors import FileError

MOST_ELEMENTS = 20_000
MOST_DEPTH = 200
MOST_COPIES = 100
"""Most copies of a ``<replicate>``."""
_BARRED = ("composite", "flexcomp", "flex", "extension", "plugin", "skin", "hfield")
"""Elements that no rigid hand needs; some of them name files or make thousands of bodies."""
LARGEST = 1e6
"""Largest number that can be meant, in any unit of a hand's file."""
_NUMBERS = re.compile(r"^[\s,\-+.\deEinfaINFA]*$")
_NO_SIZES = ("name", "class", "childclass", "file", "filename", "content_type", "rgba", "user")


def parse(content: bytes, path: Path) -> ET.Element:
    """Return the root of a hand's XML.

    Raises
    ------
    FileError
        If it is no XML, has entities, or is too large.
    """
    if b"<!DOCTYPE" in content or b"<!ENTITY" in content:
        raise FileError(f"{path}: it declares a DOCTYPE or entities; take them out of the file")
    try:
        root = ET.fromstring(content)
    except (ET.ParseError, ValueError, LookupError) as error:  # LookupError: unknown encodings
        reason = str(error).splitlines()[0][:120]
        raise FileError(f"{path}: no XML ({reason}); give an MJCF or URDF file") from error
    check(root, path)
    return root


def check(root: ET.Element, path: Path) -> None:
    """Refuse what is too large, too deep or barred.

    Raises
    ------
    FileError
        In one line.
    """
    for count, (element, depth) in enumerate(_walk(root)):
        if count >= MOST_ELEMENTS or depth > MOST_DEPTH:
            raise FileError(
                f"{path}: more than {MOST_ELEMENTS} elements or {MOST_DEPTH} levels; "
                "give the hand alone"
            )
        tag = str(element.tag)
        if tag in _BARRED:
            raise FileError(f"{path}: <{tag}> is not read; give the hand's rigid bodies alone")
        if tag == "replicate" and not _at_most(element.get("count", "1"), MOST_COPIES):
            raise FileError(f"{path}: <replicate> of more than {MOST_COPIES}; give fewer copies")
        for key, value in element.attrib.items():
            if key not in _NO_SIZES and not _sane(value):
                raise FileError(
                    f"{path}: {key}='{value[:40]}' of <{tag[:40]}> has a number that is not finite "
                    f"or above {LARGEST:g}; correct it"
                )


def _sane(value: str) -> bool:
    """Tell whether a value, where it is numbers, has only finite ones of a sensible size."""
    if len(value) > 200 or not _NUMBERS.match(value):
        return len(value) <= 2_000_000
    for part in value.replace(",", " ").split():
        try:
            number = float(part)
        except ValueError:
            continue
        if not math.isfinite(number) or abs(number) > LARGEST:
            return False
    return True


def _at_most(text: str, limit: int) -> bool:
    try:
        return 0 <= int(text) <= limit
    except ValueError:
        return False


def _walk(root: ET.Element) -> Iterator[tuple[ET.Element, int]]:
    """Yield all elements with their depth, without recursion."""
    waiting = [(root, 0)]
    while waiting:
        element, depth = waiting.pop()
        yield element, depth
        waiting += [(child, depth + 1) for child in element]
