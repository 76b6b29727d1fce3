"""Units that files are in, guessed."""

import pytest

from handsim.objects.meshes.units import guess_unit


@pytest.mark.parametrize(
    ("longest", "unit"),
    [
        (0.12, "m"), (0.3, "m"), (0.03, "m"),
        (122.0, "mm"), (30.0, "mm"), (210.0, "mm"),
        (12.2, "cm"), (10.0, "cm"),
        (4.8, "inch"), (8.3, "inch"),
        (1.22, "dm"), (0.9, "dm"),
    ],
)  # fmt: skip
def test_the_unit_that_makes_a_thing_for_a_hand_is_guessed(longest: float, unit: str) -> None:
    guess = guess_unit(longest, 0.3 * longest**3)
    assert guess.name == unit
    assert 0 < guess.share <= 1 and guess.other != unit


def test_the_mass_decides_where_the_size_leaves_two_units() -> None:
    """A bottle of half a litre, 21 cm high, that is in inches or in centimetres."""
    inches, litres = 21 / 2.54, 0.575e-3
    assert guess_unit(inches, litres / 0.0254**3, 0.5).name == "inch"
    assert guess_unit(21.0, litres / 0.01**3, 0.5).name == "cm"
    assert guess_unit(2.1, litres / 0.1**3, 0.5).name == "dm"
    assert guess_unit(2.1, litres / 0.1**3).name != "dm"
