"""`handsim tasks`, `objects` and `hands`: what there is, from the data that the commands use."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.cli.listing.rule_words import _WAYS, rule_in_words
from handsim.hand.population import PRESETS as SIZES
from handsim.robot_hands.presets import PRESETS as ROBOT_HANDS
from handsim.tasks.table_one import TASK_NAMES, TASKS, task_by_name
from handsim.tasks.task import PassRule, Step

LISTS = ("tasks", "objects", "hands")

SENTENCES = {
    "cube-raise": "It is lifted by at least 100 mm and held for 3 s, slipping less than 20 mm and "
    "tilting less than 30 deg in the hand.",
    "tall-glass-drink": "It is lifted by at least 100 mm, turned by at least 30 deg with its top "
    "towards the person, and held for 3 s, slipping less than 20 mm and tilting less than 30 deg "
    "in the hand.",
    "cup-side-rotate": "It is lifted by at least 100 mm, turned by at least 45 deg "
    "counter-clockwise seen from above, and held for 3 s, slipping less than 20 mm and tilting "
    "less than 30 deg in the hand.",
    "mouse-slide": "It slides at least 60 mm on the table to the left (within 20 deg and 15 mm of "
    "that way), never more than 10 mm above it; it is held for 1 s, slipping less than 20 mm and "
    "tilting less than 30 deg in the hand.",
    "mouse-left-click": "Its left button goes past 1 deg while the index finger presses it, moving "
    "less than 10 mm and tilting less than 10 deg on the table; then it is held for 1 s.",
    "scissors-use": "Its blade goes from 30 down to 10 deg while the thumb presses it and the "
    "index or middle finger presses the main body, moving less than 20 mm and tilting less than "
    "30 deg on the table; then it is held for 1 s.",
    "pen-write": "It is lifted by at least 50 mm and held for 1 s, and its front end draws at "
    "least 50 mm within 3 mm of the table, to the right and away (within 20 deg and 15 mm of that "
    "way), slipping less than 20 mm and tilting less than 30 deg in the hand.",
}


@pytest.mark.parametrize("name", SENTENCES)
def test_rules_are_plain_sentences(name):
    assert rule_in_words(task_by_name(name)) == SENTENCES[name]


def test_a_sentence_follows_its_rule():
    rule = PassRule("turn", lift=0.123, hold=4.5, slip=0.006, tilt_deg=7.0, angle_deg=89.0)
    said = rule_in_words(replace(task_by_name("cube-raise"), rule=rule))
    assert [float(number) for number in re.findall(r"[\d.]+\d", said)] == [123, 89, 4.5]
    assert "less than 6 mm" in said and "less than 7 deg" in said


@pytest.mark.parametrize("turned", range(0, 360, 45))
def test_ways_are_those_of_someone_who_sits_at_minus_x(turned):
    way = Rotation.from_euler("z", turned, degrees=True).apply([1.0, 0.0, 0.0])
    axis = np.cross([0.0, 0.0, 1.0], way)  # about which what is on top goes that way
    tipped = Rotation.from_rotvec(0.1 * axis).apply([0.0, 0.0, 1.0])
    assert tipped[:2] @ way[:2] > 0.09
    tips = replace(task_by_name("cup-drink"), steps=(Step(1.0, axis=tuple(axis), angle_deg=40.0),))
    assert f"with its top {_WAYS[turned // 45]}, and" in rule_in_words(tips)
    slides = replace(task_by_name("mouse-slide"), steps=(Step(1.0, shift=tuple(0.05 * way)),))
    assert f"on the table {_WAYS[turned // 45]} (" in rule_in_words(slides)


def test_the_ways_that_are_named_lie_where_they_say():
    """The person looks to +x; left is +y."""
    assert (_WAYS[0], _WAYS[2], _WAYS[4], _WAYS[6]) == (
        "away from the person", "to the left", "towards the person", "to the right",
    )  # fmt: skip
    for i, (side, depth) in {1: ("left", "away"), 3: ("left", "back"), 5: ("right", "back"),
                             7: ("right", "away")}.items():  # fmt: skip
        assert _WAYS[i] == f"to the {side} and {depth}"


def test_tasks_are_those_of_the_table(run):
    said = run("tasks", "--json").json()
    assert tuple(each["name"] for each in said["tasks"]) == TASK_NAMES
    assert [each["name"] for each in said["variants"]] == ["phone-today-view"]
    click = said["tasks"][6]
    assert (click["number"], click["object"], click["action"]) == (7, "mouse", "click")
    assert click["grasp"] == {"kind": "rest", "fingers": ["thumb", "ring", "little"],
                              "width_m": 0.060}  # fmt: skip
    assert click["rule"]["sentence"] == rule_in_words(TASKS[6])
    assert click["rule"]["pressed"] == [{"body": "right_button", "fingers": ["middle"]}]
    assert (click["rule"]["hold_s"], click["rule"]["slip_m"]) == (1.0, 0.010)


def test_objects_have_their_size_mass_and_tasks(run):
    said = run("objects", "--json").json()
    assert len(said["objects"]) == 13
    assert [each["name"] for each in said["variants"]] == ["phone-today"]
    of_objects = [task for each in said["objects"] for task in each["tasks"]]
    assert sorted(of_objects) == sorted(TASK_NAMES)
    by_name = {each["name"]: each for each in said["objects"]}
    assert by_name["tall-glass"]["size_m"] == pytest.approx([0.064, 0.064, 0.145], abs=5e-4)
    assert by_name["jar"]["size_m"] == pytest.approx([0.072, 0.072, 0.104], abs=5e-4)  # with lid
    assert by_name["jar"]["mass_kg"] == pytest.approx(0.264)
    assert (by_name["mouse"]["n_pieces"], by_name["cube"]["n_pieces"]) == (4, 1)
    assert by_name["mouse"]["hinges"] == ["left_button", "right_button"]


def test_hands_are_those_that_can_be_built_and_read(run, tmp_path):
    said = run("hands", "--json").json()
    assert {each["name"] for each in said["sizes"]} == set(SIZES)
    woman = next(each for each in said["sizes"] if each["name"] == "woman-5")
    assert (woman["length_m"], woman["breadth_m"]) == (0.165, 0.072)
    assert (said["length_range_m"], said["breadth_range_m"]) == ([0.12, 0.26], [0.05, 0.12])
    assert [each["name"] for each in said["robot_hands"]] == [each.name for each in ROBOT_HANDS]
    assert said["robot_hands"][0]["knuckles"] == {"little": "LFJ4"}
    options = re.search(r"woman-5 .*?(--hand-length .*)", run("hands").out)[1].split()
    assert run("hand", "build", "-o", tmp_path, *options).code == 0


def test_names_of_robot_hands_stand_apart_from_their_links(run):
    lines = run("hands").out.splitlines()
    for hand in ROBOT_HANDS:
        first = re.escape(hand.palm[0])
        assert any(re.match(rf"[* ] {hand.name}  +{first}, ", line) for line in lines), hand.name


@pytest.mark.parametrize("columns", [80, 100, 250])
@pytest.mark.parametrize("command", LISTS)
def test_lines_fit_a_terminal(run, monkeypatch, command, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    result = run(command)
    assert (result.code, result.err) == (0, "")
    lines = result.out.splitlines()
    assert max(len(line) for line in lines) <= min(columns, 100)
    assert not any(line.endswith((" ", "-")) for line in lines)


def test_every_name_is_listed(run):
    known = {"tasks": TASK_NAMES, "objects": {t.object_name for t in TASKS}, "hands": SIZES}
    for command, names in known.items():
        words = run(command).out.replace(",", " ").split()
        assert set(names) <= set(words)
