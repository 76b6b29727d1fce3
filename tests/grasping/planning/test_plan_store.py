"""Plans on disk: they come back to the bit, and nothing is overwritten that cannot be read."""

import json
from base64 import b64encode
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.errors import FileError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan, Pose
from handsim.grasping.planning import plan_store as module
from handsim.grasping.planning.plan_key import PlanKey
from handsim.grasping.planning.plan_store import PlanStore, StoredPlan, plan_store
from handsim.joints import N_JOINTS
from handsim.learning.controller import GraspController
from handsim.types import MEDIAN_HAND, HandSize

KEY = PlanKey("t", "o", "h", "s", "p")
SCHEMA_1 = Path(__file__).parents[2] / "data" / "schemas" / "plans-1.json"


@pytest.fixture
def plan() -> GraspPlan:
    generator = np.random.default_rng(0)
    return GraspPlan(
        palm=Pose(generator.normal(size=3), Rotation.random(rng=1).as_quat(scalar_first=True)),
        retreat=generator.normal(size=3),
        q_start=generator.normal(size=N_JOINTS),
        q_goal=generator.normal(size=N_JOINTS),
        squeeze=float(generator.uniform(0, 2)),
        grip=float(generator.uniform(1, 20)),
        arrive=float(generator.uniform(0, 1)),
        z_goal=generator.normal(size=3),
    )


def bits(plan: GraspPlan) -> bytes:
    numbers = (plan.palm.pos, plan.palm.quat, plan.retreat, plan.q_start, plan.q_goal,
               [plan.squeeze, plan.grip, plan.arrive],
               [] if plan.z_goal is None else plan.z_goal)  # fmt: skip
    return np.concatenate(numbers).tobytes()


def test_plans_come_back_to_the_bit(tmp_path, plan):
    store = PlanStore(tmp_path / "plans" / "a.json")
    assert store.entries() == {}
    store.add("cube-raise", StoredPlan(plan, True, KEY, 1))
    scripted = replace(plan, z_goal=None)
    store.add("jar-move", StoredPlan(scripted, False, None, 2))
    back = store.entries()
    assert list(back) == ["cube-raise", "jar-move"]
    assert bits(back["cube-raise"].plan) == bits(plan)
    assert bits(back["jar-move"].plan) == bits(scripted)
    assert back["jar-move"].plan.z_goal is None
    assert [(e.held, e.key, e.attempts) for e in back.values()] == [
        (True, KEY, 1),
        (False, None, 2),
    ]
    assert bits(store.read()["cube-raise"]) == bits(plan)
    content = store.path.read_bytes()
    store.add("jar-move", back["jar-move"])
    assert store.path.read_bytes() == content


def test_what_a_robot_was_told_comes_back_to_the_bit(tmp_path, plan):
    mapped = np.random.default_rng(1).normal(size=(7, 3))
    store = PlanStore(tmp_path / "a.json")
    store.add("cube-raise", StoredPlan(plan, True, KEY, mapped=mapped))
    store.add("jar-move", StoredPlan(plan, True, KEY))
    back = store.entries()
    assert back["cube-raise"].mapped.shape == mapped.shape
    assert back["cube-raise"].mapped.tobytes() == mapped.tobytes()
    assert back["jar-move"].mapped is None
    assert "mapped" not in json.loads(store.path.read_text())["plans"]["jar-move"]


def mapped_to(shape, content):
    return setting("mapped", {"shape": shape, "float64_base64": content})


ONE, NO_NUMBER = (b64encode(np.array([x])).decode() for x in (1.0, np.nan))


def test_hands_and_controllers_have_files_of_their_own(tmp_path):
    stores = [
        plan_store(tmp_path, "a", Conditions()),
        plan_store(tmp_path, "b", Conditions()),
        plan_store(tmp_path, "a", Conditions(hand=HandSize(0.18))),
        plan_store(tmp_path, "a", Conditions(hand=HandSize(breadth=0.09))),
        plan_store(tmp_path, "a", Conditions(hand=HandSize(side="left"))),
        plan_store(tmp_path, "a", Conditions(base="free")),
    ]
    assert len({store.path for store in stores}) == 6
    assert plan_store(tmp_path, "a", Conditions(seed=5, friction=0.5)) == stores[0]
    noise = Conditions(hand=HandSize(MEDIAN_HAND.length * (1 + 1e-15)))
    assert plan_store(tmp_path, "a", noise) == stores[0]


def damaged(change):
    """A store whose file was changed by hand."""

    def _damage(content):
        change(content["plans"]["cube-raise"])

    return _damage


def setting(name, value):
    return damaged(lambda entry: entry.update({name: value}))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c.update(schema=3), "newer than 2; update handsim"),
        (lambda c: c.update(schema="2"), "delete it"),
        (lambda c: c.update(schema=0), "delete it"),
        (lambda c: c.update(owner="0123"), "plans of another controller or hand"),
        (lambda c: c.pop("owner"), "delete it"),
        (lambda c: c["plans"].update({"jar-move": c["plans"]["cube-raise"]}), "'jar-move' is of"),
        (damaged(lambda entry: entry.pop("z_goal_rad")), "z_goal_rad"),
        (damaged(lambda entry: entry["key"].pop("physics")), "physics"),
        (setting("z_goal_rad", [0.1, float("nan"), 0.2]), "3 numbers"),
        (setting("z_goal_rad", []), "1 numbers"),
        (setting("z_goal_rad", [0.1] * 6), "5 numbers"),
        (setting("z_goal_rad", 0.1), "not a file of plans"),
        (setting("q_goal_rad", [float("nan")] * N_JOINTS), "22 numbers"),
        (setting("q_start_rad", [0.0] * 21), "22 numbers"),
        (setting("palm_pos_m", [1e4, 0.0, 0.0]), "below 1000"),
        (setting("palm_quat_wxyz", [0.0, 0.0, 0.0, 0.0]), "quaternion"),
        (setting("squeeze", float("inf")), "3 numbers"),
        (setting("grip_n", float("nan")), "3 numbers"),
        (setting("grip_n", 0.0), "grip 0 N"),
        (setting("grip_n", "strong"), "not a file of plans"),
        (setting("squeeze", -0.1), "squeeze -0.1"),
        (setting("arrive", 0.0), "arrival 0"),
        (setting("arrive", 1.1), "arrival 1.1"),
        (setting("held", "yes"), "held of"),
        (setting("attempts", -1), "attempts of"),
        (setting("attempts", 1.5), "attempts of"),
        (mapped_to([1, 2], ONE), "reshape"),
        (mapped_to([1], ONE), "not a file of plans"),
        (mapped_to([-1, 1], ONE), "shape [-1, 1]"),
        (mapped_to([1.0, 1], ONE), "shape [1.0, 1]"),
        (mapped_to([1, 1], NO_NUMBER), "below 1000"),
        (mapped_to([1, 1], ONE[1:]), "not a file of plans"),
        (mapped_to([1, 1], "no base 64"), "not a file of plans"),
        (mapped_to([1, 1], 3), "not a file of plans"),
        (setting("mapped", None), "not a file of plans"),
        (setting("palm_pos_m", [10**400, 0, 0]), "not a file of plans"),
        (lambda c: c.update(plans=[1, 2]), "not a file of plans"),
        (lambda c: c["plans"].update({"cube-raise": 3}), "not a file of plans"),
    ],
)
def test_what_is_no_plan_of_ours_is_refused_and_stays(tmp_path, plan, change, words):
    store = plan_store(tmp_path, "a", Conditions())
    store.add("cube-raise", StoredPlan(plan, True, KEY))
    content = json.loads(store.path.read_text())
    change(content)
    store.path.write_text(json.dumps(content))
    before = store.path.read_bytes()
    for attempt in (
        store.entries,
        store.read,
        lambda: store.add("pen-move", StoredPlan(plan, True)),
    ):
        with pytest.raises(FileError) as refused:
            attempt()
        assert words in str(refused.value)
        assert str(store.path) in str(refused.value)
        assert "\n" not in str(refused.value)
    assert store.path.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == [store.path.name]


def test_where_nothing_can_be_written_it_is_said_and_nothing_left(tmp_path, plan, monkeypatch):
    (tmp_path / "c.plans").write_text("a file, and no folder")
    blocked = plan_store(tmp_path / "c.plans", "a", Conditions())
    assert blocked.entries() == {}
    with pytest.raises(FileError, match=r"json: cannot be written \("):
        blocked.add("cube-raise", StoredPlan(plan, True, KEY))

    def full(path, text):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(module, "write_text", full)
    store = plan_store(tmp_path, "a", Conditions())
    with pytest.raises(FileError, match=r"cannot be written \(No space left on device\)"):
        store.add("cube-raise", StoredPlan(plan, True, KEY))
    assert not store.path.exists()


def test_plans_of_schema_1_are_read_without_keys_and_written_as_schema_2(tmp_path):
    store = PlanStore(tmp_path / "p.json", "me")
    store.path.write_bytes(SCHEMA_1.read_bytes())
    before = store.entries()["cube-raise"]
    stored = json.loads(SCHEMA_1.read_text())["plans"]["cube-raise"]
    assert (before.key, before.plan.z_goal, before.held) == (None, None, False)  # not said
    assert before.plan.q_goal.tobytes() == np.deg2rad(stored["q_goal_deg"]).tobytes()
    store.add("jar-move", StoredPlan(before.plan, True, KEY))
    after = store.entries()
    assert bits(after["cube-raise"].plan) == bits(before.plan)
    assert (after["cube-raise"].key, after["jar-move"].key) == (None, KEY)
    assert json.loads(store.path.read_text())["schema"] == 2


def test_plans_that_say_no_grip_or_arrival_have_the_usual_ones(tmp_path, plan):
    """As those that were made before fingers held with a force."""
    store = plan_store(tmp_path, "a", Conditions())
    store.add("cube-raise", StoredPlan(plan, True, KEY))
    content = json.loads(store.path.read_text())
    assert content["plans"]["cube-raise"]["grip_n"] == plan.grip
    del content["plans"]["cube-raise"]["grip_n"], content["plans"]["cube-raise"]["arrive"]
    store.path.write_text(json.dumps(content))
    read = store.read()["cube-raise"]
    assert (read.grip, read.arrive) == (3.0, 0.85)
    assert bits(replace(read, grip=plan.grip, arrive=plan.arrive)) == bits(plan)


def test_shipped_plans_lead_where_their_controller_can_go():
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    store = plan_store(data_folder("assets") / "plans", controller.digest, Conditions())
    entries = store.entries()
    assert len(entries) >= 24
    for each in entries.values():
        assert each.key is not None
        assert each.plan.z_goal is not None
        controller.navigation.check_goal(each.plan.z_goal)
