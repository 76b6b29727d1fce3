"""What a sweep goes through."""

import pytest

from handsim.errors import InputError
from handsim.grasping.conditions import Conditions, perturb
from handsim.grasping.sweep.spec import (
    MAX_RUNS,
    SweepHand,
    SweepSpec,
    hand_preset,
    sampled_hands,
)
from handsim.hand.population import PRESETS
from handsim.tasks.table_one import TASKS, task_by_name
from handsim.types import HandSize

CUBE, JAR = task_by_name("cube-raise"), task_by_name("jar-move")


def test_all_combinations_are_there_once_and_in_order():
    spec = SweepSpec(
        tasks=(CUBE, JAR),
        controllers=("a", "b"),
        hands=(hand_preset("woman-5"), hand_preset("man-95")),
        sides=("right", "left"),
        frictions=(0.5, None),
        mass_scales=(0.5, 2.0, None),
        seeds=(0, 5),
    )
    runs = list(spec.runs())
    assert len(runs) == len(set(runs)) == spec.n_runs == 2 * 2 * 2 * 2 * 2 * 3 * 2
    assert [run.number for run in runs] == list(range(spec.n_runs))
    assert {run.controller for run in runs[: len(runs) // 2]} == {"a"}
    assert [run.seed for run in runs[:4]] == [0, 5, 0, 5]


def test_conditions_are_those_of_a_perturbed_trial_but_for_what_is_asked():
    hand = SweepHand("small", 0.17, 0.075)
    spec = SweepSpec(tasks=(CUBE,), hands=(hand,), sides=("left",), seeds=(0, 9))
    nominal, perturbed = (run.conditions for run in spec.runs())
    assert nominal == Conditions(hand=HandSize(0.17, 0.075, "left"))
    assert perturbed == perturb(nominal, 9)
    asked = SweepSpec(
        tasks=(CUBE,), hands=(hand,), sides=("left",), frictions=(0.3,), mass_scales=(2.0,),
        seeds=(0, 9),
    )  # fmt: skip
    for run in asked.runs():
        assert (run.conditions.friction, run.conditions.mass_scale) == (0.3, 2.0)
        assert run.usual == nominal
    assert run.conditions.object_offset == perturbed.object_offset


def test_hands_are_drawn_from_the_population_and_stay_the_same():
    hands = sampled_hands("woman", 200, seed=3)
    assert hands == sampled_hands("woman", 200, seed=3)
    assert hands[:5] != sampled_hands("woman", 5, seed=4)
    assert len({hand.name for hand in hands}) == 200
    mean = sum(hand.length for hand in hands) / 200
    assert mean == pytest.approx(PRESETS["woman-50"].length, abs=0.002)
    assert all(round(hand.breadth, 4) == hand.breadth for hand in hands)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"tasks": ()}, "tasks: none"),
        ({"seeds": ()}, "seeds: none"),
        ({"tasks": (CUBE, CUBE)}, "tasks: cube-raise is there twice"),
        ({"seeds": (1, 2, 1)}, "seeds: 1 is there twice"),
        ({"hands": (hand_preset("man-5"),) * 2}, "hands: man-5 is there twice"),
        ({"frictions": (0.01,)}, "friction of 0.01 is outside 0.05 to 3"),
        ({"frictions": (float("nan"),)}, "friction of nan"),
        ({"mass_scales": (-1.0,)}, "mass_scale of -1 is outside"),
        ({"seeds": (-1,)}, "seed of -1 is outside"),
        ({"hands": (SweepHand("giant", 2.0, 0.09),)}, "hand length 2 m is outside 0.12 to 0.26"),
        ({"tasks": TASKS, "seeds": tuple(range(MAX_RUNS // 20))}, "split the sweep"),
    ],
)
def test_what_cannot_be_swept_is_refused_before_anything_runs(values, words):
    with pytest.raises(InputError, match=words):
        SweepSpec(**{"tasks": (CUBE,), **values})
