"""Inputs change with all that answers depend on, and not with the last bits."""

from dataclasses import fields, replace
from fnmatch import fnmatchcase

import mujoco
import numpy as np
import pytest

from handsim.baseline.inputs import (
    controller_inputs,
    grasp_inputs,
    recording_inputs,
)
from handsim.baseline.scene_arrays import GROUPS, LEFT_OUT, OTHER, group_of, is_left_out
from handsim.grasping.conditions import Conditions
from handsim.grasping.rollout import glove
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.learning.transport.stored import shipped_transport
from handsim.navigation.bspline import TensorBSpline
from handsim.tasks.table_one import task_by_name
from handsim.types import MEDIAN_HAND

TASK = "scissors-use"  # has hinges, meshes and
FREE = Conditions(base="free")  # an equality: what leads the hand


@pytest.fixture(scope="module")
def scene():
    return Scene.build(task_by_name(TASK), FREE)


def changed(before: dict[str, str], after: dict[str, str]) -> set[str]:
    """Name the inputs that differ, without the task."""
    return {
        name.removesuffix(f"/{TASK}")
        for name in (*before, *after)
        if before.get(name) != after.get(name)
    }


def arrays_of(model) -> list[str]:
    """Name all arrays of a compiled model, as MuJoCo has them."""
    return [
        name
        for name in dir(model)
        if not name.startswith("_") and isinstance(getattr(model, name), np.ndarray)
    ]


def perturb(array: np.ndarray) -> None:
    """Change one number as little as matters."""
    one = array.reshape(-1)[-1:]
    if array.dtype == bool:
        one[:] = ~one
    elif array.dtype.kind == "f":
        one[:] = one * 1.001 if one[0] else 1e-5
    else:
        one[:] = one + 1


def test_every_array_of_the_model_with_a_part_in_physics_is_an_input(scene, plans):
    model, (plan,) = scene.hand.model, plans.values()
    before = grasp_inputs(scene, plan)
    assert grasp_inputs(scene, plan) == before
    seen = {}
    for name in arrays_of(model):
        array = getattr(model, name)
        if not array.size or is_left_out(name):
            continue
        kept = array.copy()
        perturb(array)
        seen[name] = changed(before, grasp_inputs(scene, plan))
        array[...] = kept
    assert {name: names for name, names in seen.items() if len(names) != 1} == {}
    assert set.union(*seen.values()) == {f"scene {group}" for group in (*GROUPS, OTHER)}
    assert seen["body_quat"] == seen["geom_quat"] == {"scene geometry"}
    assert seen["jnt_pos"] == {"scene joints"}
    assert seen["eq_data"] == seen["eq_active0"] == {"scene equalities"}
    assert len(seen) > 150
    assert grasp_inputs(scene, plan) == before


def test_every_option_is_an_input(scene, plans):
    option, (plan,) = scene.hand.model.opt, plans.values()
    before = grasp_inputs(scene, plan)
    names = [name for name in dir(option) if not name.startswith("_")]
    assert {"timestep", "cone", "gravity", "disableflags", "o_solref", "tolerance"} <= set(names)
    for name in names:
        value = getattr(option, name)
        if isinstance(value, np.ndarray):
            kept = value.copy()
            perturb(value)
        else:
            kept = value
            setattr(option, name, value + (1 if isinstance(value, int) else 0.001 * value or 1e-5))
        assert changed(before, grasp_inputs(scene, plan)) == {"scene solver"}, name
        if isinstance(value, np.ndarray):
            value[...] = kept
        else:
            setattr(option, name, kept)
    statistic = scene.hand.model.stat
    statistic.meaninertia *= 1.001
    assert changed(before, grasp_inputs(scene, plan)) == {"scene solver"}
    statistic.meaninertia /= 1.001


def test_what_is_left_out_has_no_part_in_physics():
    """The same steps to the bit with all colours, cameras, lights and names' places changed."""
    states = []
    for spoil in (False, True):
        model = Scene.build(task_by_name(TASK), Conditions()).hand.model
        # Trees of bounding boxes, and which of a mesh's triangles lie in one plane, do have a part
        # in it, but follow from what is hashed.
        followed = ("bvh_*", "*_bvhadr", "*_bvhnum", "mesh_poly*", "mesh_facenormal")
        spoilt = 0
        for name in arrays_of(model):
            if is_left_out(name) and not any(fnmatchcase(name, pattern) for pattern in followed):
                array = getattr(model, name)
                if spoil and array.dtype.kind == "f" and array.size:
                    array += 0.37
                    spoilt += 1
        data = mujoco.MjData(model)
        mujoco.mj_step(model, data, nstep=150)
        states.append((data.qpos.copy(), data.qvel.copy(), data.sensordata.copy(), spoilt))
    for plain, other in zip(*states, strict=True):
        if isinstance(plain, np.ndarray):
            np.testing.assert_array_equal(plain, other)
    assert states[1][-1] > 15


def test_each_group_and_each_reason_fits_some_array(scene):
    names = arrays_of(scene.hand.model)
    grouped = {group_of(name) for name in names if not is_left_out(name)}
    assert grouped == {*GROUPS, OTHER}
    for patterns in (*LEFT_OUT.values(), *GROUPS.values()):
        for pattern in patterns:
            if pattern != "geom_castshadow":  # not every version has it
                assert any(fnmatchcase(name, pattern) for name in names), pattern


PERTURBED = {
    "seed": 1, "nominal": False, "hand_length": 0.18, "hand_breadth": 0.08, "side": "left",
    "friction": 0.81, "mass_scale": 1.01, "object_offset": (0.0, 0.0, 0.3), "shake": 0.1,
    "base": "arm", "bias": 0.01, "drift": 0.01, "latency": 0.01, "lost": 0.01,
}  # fmt: skip


def perturbed(field):
    """Conditions of which one value in the files is another."""
    of_hand = {"hand_length": "length", "hand_breadth": "breadth", "side": "side"}
    if field in of_hand:
        return replace(FREE, hand=replace(MEDIAN_HAND, **{of_hand[field]: PERTURBED[field]}))
    return replace(FREE, **{field: PERTURBED[field]})


def test_all_conditions_are_tried():
    assert set(PERTURBED) == set(Conditions().as_dict())


@pytest.mark.parametrize("field", PERTURBED)
def test_every_field_of_the_conditions_is_an_input(field, scene, plans):
    (plan,) = plans.values()
    other = Scene.build(task_by_name(TASK), perturbed(field))
    names = changed(grasp_inputs(scene, plan), grasp_inputs(other, plan))
    assert f"condition/{field}" in names
    expected = {"object_offset": "scene geometry", "friction": "scene friction",
                "mass_scale": "scene masses", "side": "task",
                "base": "scene joints"}.get(field)  # fmt: skip
    assert expected is None or expected in names


def test_a_yaw_of_the_object_is_named(scene, plans):
    (plan,) = plans.values()
    turned = Scene.build(task_by_name(TASK), replace(FREE, object_offset=(0.0, 0.0, 0.3)))
    before, after = grasp_inputs(scene, plan), grasp_inputs(turned, plan)
    assert after["condition/object_offset"] == "0, 0, 0.3"
    assert {"condition/object_offset", "scene geometry"} <= changed(before, after)


def test_every_field_of_the_plan_that_is_stored_is_an_input(scene, plans):
    (plan,) = plans.values()
    before = grasp_inputs(scene, plan)
    assert {field.name for field in fields(plan)} - {*plan.stored} == {"transport"}
    for name, value in plan.stored.items():
        other = value.moved(np.array([1e-4, 0, 0])) if name == "palm" else (
            np.ones(3) if value is None else value + 1e-4
        )  # fmt: skip
        after = grasp_inputs(scene, replace(plan, **{name: other}))
        assert changed(before, after) == {"plan"}, name


def test_how_the_palm_comes_in_is_an_input(scene, plans):
    (plan,) = plans.values()
    usual = replace(plan, transport=shipped_transport())
    before, after = (grasp_inputs(scene, replace(plan, transport=None)), grasp_inputs(scene, usual))
    assert changed(before, after) == {"transport"}
    assert before[f"transport/{scene.task.name}"] == "straight"
    faster = replace(usual, transport=replace(shipped_transport(), progress=np.ones(16)))
    assert changed(after, grasp_inputs(scene, faster)) == {"transport"}


def test_task_schedule_and_glove_are_inputs(scene, plans, monkeypatch):
    (plan,) = plans.values()
    before = grasp_inputs(scene, plan)
    task = scene.task
    slower = replace(task.steps[0], seconds=task.steps[0].seconds + 0.1)
    for change, names in (
        ({"rule": replace(task.rule, hold=2.9)}, {"task", "schedule"}),
        ({"rule": replace(task.rule, slip=0.021)}, {"task"}),
        ({"grasp": replace(task.grasp, width=task.grasp.width + 1e-4)}, {"task"}),
        ({"steps": (slower, *task.steps[1:])}, {"task", "schedule"}),
        ({"yaw_deg": 1.0}, {"task"}),
    ):
        other = replace(scene, task=replace(task, **change))
        assert changed(before, grasp_inputs(other, plan)) == names
    noisy = replace(glove.DataGlove(), noise=0.01)
    monkeypatch.setattr("handsim.baseline.inputs.DataGlove", lambda: noisy)
    assert changed(before, grasp_inputs(scene, plan)) == {"glove"}


def with_coefficients(controller, coefficients):
    obstacle = controller.navigation.obstacle
    spline = TensorBSpline(obstacle.chi.basis, coefficients)
    navigation = replace(controller.navigation, obstacle=replace(obstacle, chi=spline))
    return replace(controller, navigation=navigation)


def test_noise_of_the_last_bits_is_no_input_and_one_percent_is(controller):
    before = controller_inputs(controller)
    coefficients = controller.navigation.obstacle.chi.coefficients
    noise = np.random.default_rng(0).uniform(-1e-12, 1e-12, coefficients.shape)
    assert controller_inputs(with_coefficients(controller, coefficients + noise)) == before
    flat = np.abs(coefficients).ravel()
    for index in (flat.argmin(), flat.argmax(), 100):
        other = coefficients.copy()
        other.flat[index] *= 1.01
        after = controller_inputs(with_coefficients(controller, other))
        assert changed(before, after) == {"controller/coefficients"}


def test_all_of_a_controller_is_an_input(controller):
    before = controller_inputs(controller)
    first = controller.demonstrations[0]
    others = controller.demonstrations[1:]
    for change, name in (
        ({"duration": first.duration + 0.1}, "controller/demonstrations"),
        ({"q_goal": first.q_goal + 1e-4}, "controller/q_goal"),
    ):
        other = replace(controller, demonstrations=(replace(first, **change), *others))
        assert name in changed(before, controller_inputs(other))
    sharper = replace(controller.navigation, k=controller.navigation.k + 0.01)
    other = replace(controller, navigation=sharper)
    assert changed(before, controller_inputs(other)) == {"controller/k"}
    assert changed(before, controller_inputs(replace(controller, method="pde"))) == {
        "controller/method"
    }


def test_all_of_a_recording_is_an_input(recordings):
    first = recordings[0]
    before = recording_inputs(recordings[:1])
    for change in (
        {"q": first.q + 1e-5}, {"time": first.time * 1.001}, {"task": "other"}, {"object": "other"},
        {"hand": replace(first.hand, length=first.hand.length + 1e-4)},
        {"hand": replace(first.hand, breadth=first.hand.breadth + 1e-4)},
    ):  # fmt: skip
        assert recording_inputs([replace(first, **change)]) != before
