"""The committed models are those that the code writes.

Names, structure and order are compared as they are, numbers as numbers: they come out of MuJoCo's
compiler and a search by its collisions, whose last bit hangs on the processor.
"""

from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import pytest

from handsim.files import data_folder
from handsim.hand.export import write_hand
from handsim.types import SIDES, HandSize

FOLDER = data_folder("models") / "hand"
RELATIVE, ABSOLUTE = 2e-5, 1e-8
"""MuJoCo writes six digits, the last of which may round the other way."""


def differences(made: Element, kept: Element) -> list[str]:
    """What tells two elements apart, with all that is in them."""
    where = f"<{kept.tag} name={kept.get('name')}>"
    if made.tag != kept.tag or [*made.attrib] != [*kept.attrib] or len(made) != len(kept):
        return [f"{where}: of another structure"]
    found = [
        f"{where}: {key} is {made.attrib[key]}, not {value}"
        for key, value in kept.attrib.items()
        if not same(made.attrib[key].split(), value.split())
    ]
    return found + [each for pair in zip(made, kept, strict=True) for each in differences(*pair)]


def same(made: list[str], kept: list[str]) -> bool:
    """Whether words are the same and numbers are as near as their digits tell."""
    try:
        numbers = [float(word) for word in kept]
        return [float(word) for word in made] == pytest.approx(numbers, RELATIVE, ABSOLUTE)
    except ValueError:
        return made == kept


@pytest.fixture(scope="module", params=SIDES)
def side(request) -> str:
    return request.param


@pytest.fixture(scope="module")
def made(side, tmp_path_factory) -> Path:
    written = write_hand(HandSize(side=side), tmp_path_factory.mktemp("hand"))
    assert written.name == f"{side}_hand.xml"
    return written.parent


@pytest.fixture(scope="module")
def kept(side) -> str:
    return (FOLDER / f"{side}_hand.xml").read_text()


@pytest.mark.parametrize(
    ("name", "element", "more_than"), [("{}_hand", "<joint ", 22), ("keyframes_{}", "<key ", 10)]
)
def test_committed_models_are_those_the_code_writes(made, side, name, element, more_than):
    texts = [(folder / f"{name.format(side)}.xml").read_text() for folder in (made, FOLDER)]
    assert texts[1].count(element) > more_than
    assert differences(*map(ElementTree.fromstring, texts)) == []


def test_committed_scenes_are_those_the_code_writes(made, side):
    name = f"scene_{side}.xml"
    assert (made / name).read_text() == (FOLDER / name).read_text()


@pytest.mark.parametrize(
    ("before", "after", "word"),
    [
        ('damping="0.01"', 'damping="0.010001"', "damping"),
        ('name="ring_middle"', 'name="ring_midle"', "name"),
        ('size="0.09665 ', 'size="0.09665 0.1 ', "size"),
        (' class="{side}_hand_wrist"', "", "structure"),
    ],
)
def test_what_is_another_model_is_told(kept, side, before, after, word):
    changed = kept.replace(before.replace("{side}", side), after, 1)
    found = differences(*map(ElementTree.fromstring, (changed, kept)))
    assert [word in each for each in found] == [True]


def test_a_last_digit_that_rounds_the_other_way_is_no_difference(kept):
    changed = kept.replace('"-1.22173 1.39626"', '"-1.22174 1.39626"', 1)
    assert changed != kept
    assert differences(*map(ElementTree.fromstring, (changed, kept))) == []
