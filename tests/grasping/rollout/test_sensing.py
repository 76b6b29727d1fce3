"""Sensors of object, palm and table, beside the contacts that MuJoCo lists."""
# pyright: reportAttributeAccessIssue=false

import mujoco
import numpy as np
import pytest

from handsim.grasping.conditions import Conditions
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.sensing import SLOTS, Sensors, Touch, contacts_of
from handsim.joints import CONTACT_PARTS, FINGERS
from handsim.tasks.table_one import task_by_name

from .in_hand import laid_onto_table, pushed_into


@pytest.fixture(
    params=["tall-glass-drink free", "scissors-use arm", "jar-unscrew free"], scope="module"
)
def touching(request) -> Scene:
    name, base = request.param.split()
    return Scene.build(task_by_name(name), Conditions(base=base))


@pytest.fixture(scope="module")
def click() -> Scene:
    return Scene.build(task_by_name("mouse-left-click"), Conditions(base="free"))


def sensed(scene: Scene) -> np.ndarray:
    """Values of the sensors of one simulation, (1, n_values)."""
    return scene.hand.data.sensordata[None, Sensors(scene.hand.model).first :]


def listed(scene: Scene):
    """Yield part, body touched and what MuJoCo lists of each contact of the hand.

    These are the force (3,) that the hand presses with in the world, its normal part [N] and the
    overlap [m].
    """
    model, data = scene.hand.model, scene.hand.data
    hand, wrench = model.body("forearm").rootid[0], np.zeros(6)
    for i, contact in enumerate(data.contact):
        bodies = [model.body(int(model.geom_bodyid[geom])) for geom in contact.geom]
        of_hand = [int(body.rootid[0]) == hand for body in bodies]
        if sum(of_hand) != 1:
            continue
        mujoco.mj_contactForce(model, data, i, wrench)
        sign = 1.0 if of_hand[0] else -1.0  # normals point from the first geom to the second
        force = sign * contact.frame.reshape(3, 3).T @ wrench[:3]
        part = bodies[of_hand.index(True)].name.split("_")[0]
        touched = bodies[of_hand.index(False)]
        normal = sign * contact.frame[:3]
        yield part if part in FINGERS else "palm", touched, force, normal, -contact.dist


def of_object(scene: Scene) -> Touch:
    """How hand and object touch by MuJoCo's list."""
    force, press, deepest = np.zeros(6), np.zeros((6, 3)), 0.0
    root = scene.hand.model.body("object").id
    for part, touched, pushed, normal, overlap in listed(scene):
        if int(touched.rootid[0]) != root:
            continue
        column = CONTACT_PARTS.index(part)
        force[column] += pushed @ normal
        press[column] += (pushed @ normal) * normal
        deepest = max(deepest, overlap)
    return Touch(force, press, np.array(deepest))


def test_sensors_tell_what_the_contacts_are(touching):
    model, data = touching.hand.model, touching.hand.data
    sensors, touched = Sensors(model), 0
    for seed in range(30):
        pushed_into(touching, seed)
        touch, crowded = sensors.contacts(sensed(touching))
        exact, known = contacts_of(model, data), of_object(touching)
        for ours, theirs in zip(exact, known, strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9)
        # Friction carries too, and there may be any number of contacts.
        root = model.body("object").id
        upwards = [f[2] for _, body, f, *_ in listed(touching) if int(body.rootid[0]) == root]
        carried = sensors.carried(sensed(touching))
        assert carried.shape == (1,)
        assert carried[0] == pytest.approx(sum(upwards), rel=1e-9, abs=1e-9)
        if crowded[0]:
            assert data.ncon > SLOTS
            continue
        touched += bool(exact.force.any())
        # Objects of several bodies have their contacts summed in another order.
        np.testing.assert_allclose(touch.force[0], exact.force, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(touch.press[0], exact.press, rtol=1e-12, atol=1e-12)
        assert touch.penetration[0] == exact.penetration
        np.testing.assert_allclose(
            sensors.finger_forces(sensed(touching))[0], exact.force[:5], rtol=1e-12, atol=1e-12
        )
    assert touched >= 5


def test_touch_of_many_samples_is_that_of_each(touching):
    sensors, rows = Sensors(touching.hand.model), []
    for seed in range(6):
        pushed_into(touching, seed)
        rows.append(sensed(touching)[0].copy())
    block = np.array(rows).reshape(2, 3, -1)
    touch, crowded = sensors.contacts(block)
    shapes = [each.shape for each in (*touch, crowded)]
    assert shapes == [(2, 3, 6), (2, 3, 6, 3), (2, 3), (2, 3)]
    force, overlap = sensors.table(block)
    assert force.shape == overlap.shape == (2, 3)
    for i, row in enumerate(rows):
        alone, _ = sensors.contacts(row[None])
        for together, own in zip(touch, alone, strict=True):
            np.testing.assert_array_equal(together[i // 3, i % 3], own[0])


def test_forces_on_the_object_are_along_its_vectors(touching):
    """The sum of normal forces is at least as long as their vector, and pushes the object away."""
    model, data = touching.hand.model, touching.hand.data
    for seed in range(20):
        pushed_into(touching, seed)
        exact = contacts_of(model, data)
        assert (np.linalg.norm(exact.press, axis=1) <= exact.force + 1e-9).all()
        assert (exact.force >= 0).all()


def test_sensed_poses_are_those_of_the_bodies(touching):
    model, data = touching.hand.model, touching.hand.data
    pushed_into(touching, 2)
    mujoco.mj_forward(model, data)
    sensors = Sensors(model)
    poses = {k: v[0] for k, v in sensors.poses(sensed(touching)).items()}
    grasp_object, palm = data.body("object"), data.body("palm")
    np.testing.assert_array_equal(poses["object_pos"], grasp_object.xipos)
    np.testing.assert_array_equal(poses["object_quat"], grasp_object.xquat)
    np.testing.assert_array_equal(poses["object_origin"], grasp_object.xpos)
    axes = np.column_stack([poses[f"object_{axis}"] for axis in "xyz"])
    np.testing.assert_array_equal(axes, grasp_object.xmat.reshape(3, 3))
    np.testing.assert_array_equal(poses["palm_pos"], palm.xpos)
    np.testing.assert_array_equal(poses["palm_quat"], palm.xquat)
    assert sensed(touching)[0, sensors.height] == grasp_object.xipos[2]
    held = palm.xmat.reshape(3, 3).T @ (grasp_object.xipos - palm.xpos)
    np.testing.assert_allclose(sensors.held(sensed(touching)), held[None], rtol=0, atol=1e-12)


def test_where_the_object_was_held_stays_when_it_moves_on(touching):
    """It is compared with where it is at the next reading."""
    pushed_into(touching, 5)
    sensors, values = Sensors(touching.hand.model), sensed(touching)
    held = sensors.held(values)
    before = held.copy()
    pushed_into(touching, 6)
    assert not np.array_equal(sensors.held(values), before)
    np.testing.assert_array_equal(held, before)


def test_numbers_for_loops_are_those_of_arrays(touching):
    sensors, several = Sensors(touching.hand.model), 0
    for seed in range(30):
        pushed_into(touching, seed)
        values = sensed(touching)
        force, press = sensors.touching(values[0])
        touch, _ = sensors.contacts(values)
        np.testing.assert_allclose(force, touch.force[0], rtol=1e-12)
        np.testing.assert_allclose(press, touch.press[0], rtol=1e-12, atol=1e-12)
        several += sum(each > 0 for each in force) > 1
        poses = [value[0].tolist() for value in sensors.poses(values).values()]
        assert sensors.posed(values[0]) == [number for pose in poses for number in pose]
        assert len(poses) == 8
    assert several > 1


@pytest.mark.parametrize("depth", [-0.001, 0.0005, 0.002, 0.008, 0.020])
def test_what_the_hand_presses_on_the_table_is_the_sum_of_its_contacts(click, depth):
    """At 20 mm what presses the hardest is not what overlaps the most."""
    height = click.hand.model.geom("table").pos[2]
    try:
        laid_onto_table(click, depth)
        force, overlap = Sensors(click.hand.model).table(sensed(click))
        on_table = [
            (pushed[2], deep) for _, body, pushed, _, deep in listed(click) if body.name == "world"
        ]
    finally:
        click.hand.model.geom("table").pos[2] = height
    assert bool(on_table) == (depth > 0)
    assert force[0] == pytest.approx(-sum(each[0] for each in on_table), rel=1e-9)
    assert overlap[0] == pytest.approx(max([0.0, *(each[1] for each in on_table)]), rel=1e-9)
    if depth > 0:
        assert overlap[0] == pytest.approx(depth, rel=0.05)
        assert force[0] > 0.5


def test_an_object_on_the_table_is_not_the_hand(click):
    """Nor is a hand on the object."""
    mujoco.mj_resetData(click.hand.model, click.hand.data)
    mujoco.mj_step(click.hand.model, click.hand.data, nstep=50)
    assert click.hand.data.ncon > 0
    force, overlap = Sensors(click.hand.model).table(sensed(click))
    assert (force[0], overlap[0]) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("name", "pressed"),
    [
        ("mouse-left-click", [(("index",), "left_button")]),
        ("scissors-use", [(("thumb",), "blade"), (("index", "middle"), "object")]),
    ],
)
def test_what_is_pressed_is_pressed_by_the_fingers_that_are_named(name, pressed):
    """The hardest of them counts, and no other finger and no other body."""
    scene = Scene.build(task_by_name(name), Conditions(base="free"))
    sensors = Sensors(scene.hand.model)
    assert sensors.n_pressed == len(pressed)
    seen = np.zeros(len(pressed), dtype=int)
    for seed in range(80):
        pushed_into(scene, seed)
        found = sensors.pressed(sensed(scene))[0]
        for i, (fingers, body) in enumerate(pressed):
            forces = [
                sum(
                    (p for part, b, p, *_ in listed(scene) if part == finger and b.name == body),
                    start=np.zeros(3),
                )
                for finger in fingers
            ]
            expected = max(float(np.linalg.norm(force)) for force in forces)
            assert found[i] == pytest.approx(expected, rel=1e-6, abs=1e-9)
            seen[i] += expected > 0
    assert (seen >= 2).all()


def test_only_tasks_that_name_what_is_pressed_have_sensors_for_it(touching):
    sensors = Sensors(touching.hand.model)
    assert sensors.n_pressed == len(touching.task.rule.pressed)
    assert sensors.pressed(sensed(touching)).shape == (1, sensors.n_pressed)


def made_up(scene: Scene, **values) -> np.ndarray:
    """Values of sensors in which those of some names are set, (1, n_values)."""
    model, row = scene.hand.model, sensed(scene)[0].copy()
    first = Sensors(model).first
    for name, value in values.items():
        sensor = model.sensor(f"seen_{name}")
        start = int(sensor.adr[0]) - first
        row[start : start + int(sensor.dim[0])] = value
    return row[None]


def test_of_the_fingers_that_are_named_the_hardest_counts():
    scene = Scene.build(task_by_name("scissors-use"), Conditions(base="free"))
    sensors = Sensors(scene.hand.model)
    for index, middle in (([0, 3, 4], [1, 0, 0]), ([1, 0, 0], [0, 3, 4])):
        values = made_up(
            scene, pressed_0_thumb=[2, 0, 0], pressed_1_index=index, pressed_1_middle=middle
        )
        np.testing.assert_allclose(sensors.pressed(values), [[2.0, 5.0]])


def test_what_is_above_the_table_does_not_overlap_with_it(click):
    sensors = Sensors(click.hand.model)
    force, overlap = sensors.table(made_up(click, table_force=[1, 2, -7], table_overlap=0.004))
    assert (force[0], overlap[0]) == (7.0, 0.0)
    assert sensors.table(made_up(click, table_overlap=-0.003))[1][0] == 0.003


def test_forces_of_fingers_are_the_same_bits_for_one_simulation_and_for_many(touching):
    sensors = Sensors(touching.hand.model)
    many = np.random.default_rng(0).uniform(0.0, 9.0, (40, sensed(touching).shape[1]))
    assert (many[:, sensors._felt[: len(FINGERS)]] > 2.0).mean() > 0.5  # of the contacts found
    alone = [sensors.finger_forces(row[None])[0] for row in many]
    np.testing.assert_array_equal(sensors.finger_forces(many), alone)


def test_forces_of_a_finger_are_added_in_pairs(touching):
    """Of 1e16 and ones: added one by one the ones would be lost."""
    sensors = Sensors(touching.hand.model)
    slots = np.array([np.r_[place] for place in sensors._pushes])
    assert slots.shape == (len(FINGERS), SLOTS)
    assert SLOTS == 8
    generator, apart = np.random.default_rng(1), 0
    for _ in range(20):
        values = np.zeros((2, sensed(touching).shape[1]))
        pushes = 10.0 ** generator.uniform(-3, 3, (2, len(FINGERS), SLOTS))
        pushes[1, 0] = 1e16, *[1.0] * 7
        values[:, slots] = pushes
        values[:, slots[:, 0] - 1] = SLOTS  # contacts found
        a, b, c, d, e, f, g, h = np.moveaxis(pushes, 2, 0)
        expected = ((a + b) + (c + d)) + ((e + f) + (g + h))
        found = sensors.finger_forces(values)
        assert [[type(force) for force in run] for run in found] == [[float] * 5] * 2
        np.testing.assert_array_equal(found, expected)
        one_by_one = a + b + c + d + e + f + g + h
        apart += int((one_by_one != expected).sum())
        assert found[1][0] == 1e16 + 6.0
        assert one_by_one[1, 0] == 1e16
    assert apart > 40
