"""The six-axis protocol: what is held stays, what is not falls away as it must."""

from dataclasses import replace

import numpy as np
import pytest

from handsim.hand.tasks import task_by_name
from handsim.simulation.conditions import Conditions
from handsim.simulation.demonstrator import demonstrate
from handsim.simulation.six_axis import (
    ACCELERATION,
    MASS,
    TIMESTEP,
    SixAxisOutcome,
    _protocol_model,
    six_axis,
)
from handsim.simulation.trials import Outcome

FAR = (0.0, 0.3, 0.0)
"""So far from where the plan expects it that the hand does not come near the object."""


@pytest.fixture(scope="module")
def cube():
    return demonstrate(task_by_name("cube-raise"), Conditions())


def test_a_cube_in_the_hand_stays_there(cube):
    for hard in (False, True):
        outcome = six_axis(cube, hard=hard)
        assert outcome.success
        assert len(outcome.shift_m) == len(outcome.turn_deg) == 6
        assert 0 < max(outcome.shift_m) < 0.02
    # Contacts that creep let more happen.
    assert max(six_axis(cube, hard=True).shift_m) > max(six_axis(cube).shift_m)


@pytest.mark.parametrize("name", ["cube-raise", "jar-unscrew"])
def test_what_nothing_holds_falls_away_as_a_free_mass_does(name):
    """The jar too, which a weld holds in its task as the other hand would."""
    outcome = six_axis(demonstrate(task_by_name(name), Conditions(object_offset=FAR)))
    assert outcome.reason == "slipped"
    # From rest, x after n steps is a dt^2 n (n + 1) / 2; the pull ends beyond 5 cm.
    n = np.arange(100)
    x = ACCELERATION * TIMESTEP**2 * n * (n + 1) / 2
    np.testing.assert_allclose(outcome.shift_m, x[x >= 0.05][0], rtol=0.02)
    assert max(outcome.turn_deg) < 1 if name == "cube-raise" else True


def test_the_jar_is_held_by_the_hand_alone():
    run = demonstrate(task_by_name("jar-unscrew"), Conditions())
    model = _protocol_model(run, hard=False)
    weld = model.equality("object_held").id
    assert run.model().eq_active0[weld]
    assert not model.eq_active0[weld]
    assert max(six_axis(run).shift_m) > 0.005  # a weld would give less than a millimetre


def test_the_object_weighs_what_the_protocol_says(cube):
    model = _protocol_model(cube, hard=False)
    assert model.body_subtreemass[model.body("object").id] == pytest.approx(MASS)
    np.testing.assert_array_equal(model.opt.gravity, 0.0)
    hand = model.geom("index_distal_geom")
    np.testing.assert_allclose(hand.friction[:2], (0.6, 0.02))
    assert model.geom("table").contype == 0
    assert (model.opt.impratio, model.opt.noslip_iterations) == (10.0, 2)
    hard = _protocol_model(cube, hard=True)
    assert (hard.opt.impratio, hard.opt.noslip_iterations) == (1.0, 0)


def test_the_worst_of_the_six_decides():
    kept = SixAxisOutcome((0.01,) * 6, (3.0,) * 6, 0.001)
    assert kept.success
    assert kept.reason is None
    assert replace(kept, shift_m=(0.01,) * 5 + (0.05,)).reason == "slipped"
    assert replace(kept, turn_deg=(15.0,) + (3.0,) * 5).reason == "tilted"
    assert replace(kept, penetration_m=0.0101).reason == "penetrated"
    assert replace(kept, shift_m=(0.01,) * 5 + (np.inf,)).reason == "unstable"


def test_a_run_that_diverged_holds_nothing(cube, tmp_path, monkeypatch, capfd):
    unstable = Outcome(False, "unstable", 0.0, 0.0, 0.0, 0.0, 0, 0.0)
    assert six_axis(replace(cube, outcome=unstable)).reason == "unstable"
    monkeypatch.chdir(tmp_path)
    broken = cube.qpos.copy()
    broken[:, -1] = np.nan
    assert six_axis(replace(cube, qpos=broken)).reason == "unstable"
    assert capfd.readouterr() == ("", "")
    assert not list(tmp_path.iterdir())  # MuJoCo's log
