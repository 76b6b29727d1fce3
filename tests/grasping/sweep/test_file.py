"""TOML files of sweeps: what they may say, and what is said of those that do not."""

import pytest

from handsim.errors import FileError
from handsim.grasping.sweep.file import read_sweep
from handsim.grasping.sweep.spec import SweepHand, SweepSpec, sampled_hands
from handsim.hand.population import PRESETS
from handsim.tasks.table_one import TASKS


@pytest.fixture
def read(tmp_path):
    def _read(text: str) -> SweepSpec:
        path = tmp_path / "sweep.toml"
        path.write_text(text)
        return read_sweep(path)

    return _read


def test_the_least_that_can_be_said(read):
    spec = read('tasks = ["cube-raise"]')
    assert spec == SweepSpec(tasks=spec.tasks)
    assert [task.name for task in spec.tasks] == ["cube-raise"]
    assert spec.controllers == ("built-in",)
    assert [hand.name for hand in spec.hands] == ["man-50"]
    assert spec.seeds == (0,)


def test_everything_that_can_be_said(read):
    spec = read(
        """
        tasks = "all"
        controllers = ["demonstrator", "people, and more.npz"]
        hands = ["woman-5", {length = 0.19, breadth = 0.085}]
        sides = ["left", "right"]
        frictions = [0.4, 1]
        mass_scales = [0.5]
        seeds = [0, 100, 9223372036854775807]

        [[population]]
        sex = "woman"
        count = 3
        seed = 1

        [[population]]
        sex = "man"
        count = 2
        """
    )
    assert spec.tasks == TASKS
    assert spec.controllers == ("demonstrator", "people, and more.npz")
    assert spec.hands[:2] == (
        SweepHand("woman-5", PRESETS["woman-5"].length, PRESETS["woman-5"].breadth),
        SweepHand("0.19x0.085", 0.19, 0.085),
    )
    assert spec.hands[2:] == sampled_hands("woman", 3, 1) + sampled_hands("man", 2, 0)
    assert spec.sides == ("left", "right")
    assert spec.frictions == (0.4, 1.0)
    assert spec.seeds == (0, 100, 2**63 - 1)


def test_a_number_of_seeds_begins_with_the_nominal_run(read):
    assert read('tasks = "all"\nseeds = 3').seeds == (0, 1, 2)


def test_a_population_stands_in_place_of_the_usual_hand(read):
    spec = read('tasks = "all"\npopulation = {sex = "man", count = 2}')
    assert spec.hands == sampled_hands("man", 2, 0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", 'tasks are missing; add tasks = "all"'),
        ('tasks = "all" seeds', "not a TOML file .*line 1"),
        ("tasks = " + "[" * 10_000, "not a TOML file"),
        ("seeds = " + "9" * 5000, "not a TOML file"),
        ('tasks = "cube-raise"', "tasks is 'cube-raise'; give a list of names"),
        ("tasks = []", "tasks: none is given"),
        ("tasks = [1]", "tasks holds 1; give names"),
        ('tasks = ["cube-rase"]', "unknown task 'cube-rase'; did you mean cube-raise"),
        ('tasks = "all"\nfriction = [1]', "unknown key 'friction'; did you mean frictions"),
        ('tasks = "all"\ncolour = 1', "unknown key 'colour'; known are tasks, controllers"),
        ('tasks = "all"\nfrictions = 0.5', "frictions is 0.5; give a list of numbers"),
        ('tasks = "all"\nfrictions = [true]', "frictions holds True"),
        ('tasks = "all"\nfrictions = [nan]', "friction of nan is outside"),
        ('tasks = "all"\nmass_scales = [1e9]', r"mass_scale of 1e\+09 is outside 0.001 to 1000"),
        ('tasks = "all"\nseeds = 0', "seeds of 0 is outside 1 to"),
        ('tasks = "all"\nseeds = 1.5', "seeds is 1.5; give a whole number"),
        ('tasks = "all"\nseeds = true', "seeds is True"),
        ('tasks = "all"\nseeds = [-1]', "seed of -1 is outside"),
        ('tasks = "all"\nseeds = 1000000', "split the sweep"),
        ('tasks = "all"\nsides = ["middle"]', "sides: 'middle' is not one of right, left"),
        ('tasks = "all"\nhands = ["woman-51"]', "unknown hand size 'woman-51'"),
        ('tasks = "all"\nhands = [{length = 0.19}]', "hands: breadth is missing"),
        ('tasks = "all"\nhands = [{length = 19, breadth = 0.09}]', "19 m is outside 0.12"),
        ('tasks = "all"\nhands = [{lenght = 0.19}]', "hands: unknown key 'lenght'; .* length"),
        ('tasks = "all"\nhands = [["man-5"]]', r"hands holds \['man-5'\]"),
        ('tasks = "all"\ncontrollers = [""]', "controllers: '' is not the name of a file"),
        ('tasks = "all"\ncontrollers = ["a\\nb"]', "is not the name of a file"),
        ('tasks = "all"\npopulation = 3', "population is 3; give a list of tables"),
        ('tasks = "all"\npopulation = {count = 3}', "population: sex is missing; give woman"),
        ('tasks = "all"\npopulation = {sex = "man"}', "population: count of 0 is outside 1"),
        (
            'tasks = "all"\npopulation = {sex = "man", count = 1, seed = -1}',
            "population: seed of -1",
        ),
        ('tasks = "all"\npopulation = {sex = "man", n = 1}', "population: unknown key 'n'"),
    ],
)
def test_what_is_wrong_is_named_with_file_key_value_and_remedy(read, text, words):
    with pytest.raises(FileError, match=words) as told:
        read(text)
    assert "sweep.toml: " in str(told.value)
    assert len(str(told.value).splitlines()) == 1
    assert len(str(told.value)) < 500


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(FileError, match="no such file"):
        read_sweep(tmp_path / "none.toml")
