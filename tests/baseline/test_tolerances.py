"""Tolerances are numbers of things that exist."""

import numpy as np
import pytest

from handsim.baseline.tolerances import ENVIRONMENT_LIMITS, MEASURES, Tolerances
from handsim.errors import InputError, UnknownNameError

FIELDS = ("replayed_deg", "relearned_deg", "simulated_deg")


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, "1", None, True])
def test_fields_are_checked(field, value):
    with pytest.raises(InputError, match=rf"tolerance {field} of .* 0 or more") as refused:
        Tolerances(**{field: value})
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, "1", None, True])
def test_measures_are_checked(value):
    with pytest.raises(InputError, match=r"tolerance lift_m of .* 0 or more"):
        Tolerances(measures={"lift_m": value})


def test_measures_have_names():
    with pytest.raises(UnknownNameError, match="did you mean lift_m"):
        Tolerances(measures={"lift": 0.1})


def test_measures_left_out_have_their_usual_tolerance():
    some = Tolerances(measures={"lift_m": 0.0})
    assert some.of_measure("lift_m") == 0.0
    assert some.of_measure("hold_s") == MEASURES["hold_s"]
    assert some.of_measure("width_m") == 0.0


def test_movements_are_the_same_on_every_machine():
    assert (Tolerances().replayed_deg, Tolerances().relearned_deg) == (0.001, 0.001)


def test_another_environment_explains_more_than_is_tolerated():
    usual = Tolerances()
    assert all(getattr(ENVIRONMENT_LIMITS, field) > getattr(usual, field) for field in FIELDS)
    assert all(ENVIRONMENT_LIMITS.of_measure(m) > usual.of_measure(m) for m in MEASURES)
