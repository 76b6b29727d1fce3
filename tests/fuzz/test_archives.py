"""Controllers and rollouts: archives of strangers."""

import io
import json
import warnings
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st

from handsim.baseline import read_baseline
from handsim.errors import FileError, HandsimError
from handsim.files import data_folder, read_archive, write_archive
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.demonstrator import demonstrate
from handsim.grasping.planning.plan_store import PlanStore
from handsim.grasping.rollout_file import read_rollout, write_rollout
from handsim.tasks.table_one import task_by_name
from handsim.viewing.film.rollout_clips import rollout_clip

from .conftest import Content, damaged_bytes, search

BASELINE = (Path(__file__).parents[1] / "data" / "schemas" / "baseline-2.npz").read_bytes()
CONTROLLER = (data_folder("assets") / "controller.npz").read_bytes()
VALUES = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.lists(st.floats(), max_size=4)
    | st.dictionaries(st.text(max_size=4), st.integers(), max_size=2)
)


@pytest.fixture(scope="module")
def rollout(tmp_path_factory) -> bytes:
    """A rollout of few frames."""
    path = tmp_path_factory.mktemp("rollout") / "r.npz"
    write_rollout(demonstrate(task_by_name("cube-raise"), Conditions()), path)
    header, arrays = unpack(path.read_bytes())
    short = {
        name: value[:5] if not name.startswith("asset:") else value
        for name, value in arrays.items()
    }
    return pack(header, short)


def unpack(data: bytes) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    with np.load(io.BytesIO(data)) as stored:
        arrays = dict(stored)
    return json.loads(str(arrays.pop("header"))), arrays


def pack(header: Any, arrays: dict[str, np.ndarray]) -> Content:
    stream = io.BytesIO()
    np.savez(stream, header=np.array(json.dumps(header)), **arrays)
    return Content(stream.getvalue())


@st.composite
def damaged_archive(draw: st.DrawFn, original: bytes) -> Content:
    """An archive that is whole, with other values in it."""
    header, arrays = unpack(original)
    for _ in range(draw(st.integers(1, 2))):
        if draw(st.booleans()):
            damage_table(draw, header)
        else:
            name = draw(st.sampled_from(sorted(arrays)))
            array = damaged_array(draw, arrays.pop(name))
            if array is not None:
                arrays[name] = array
    return pack(header, arrays)


def damage_table(draw: st.DrawFn, table: Any) -> None:
    """Replace or remove a value of a table, or of the tables and lists in it."""
    key = draw(st.sampled_from(sorted(table) if isinstance(table, dict) else range(len(table))))
    if isinstance(table[key], dict | list) and table[key] and draw(st.booleans()):
        damage_table(draw, table[key])
    elif draw(st.integers(0, 4)) == 0:
        del table[key]
    else:
        table[key] = draw(VALUES)


def damaged_array(draw: st.DrawFn, array: np.ndarray) -> np.ndarray | None:
    """An array of other values, another type or shape, or none."""
    kind = draw(st.sampled_from(["value", "value", "type", "rows", "axis", "gone", "scale"]))
    if kind == "value" and array.size and array.dtype.kind == "f":
        array = array.copy()
        array.flat[draw(st.integers(0, array.size - 1))] = draw(st.floats())
    elif kind == "scale" and array.dtype.kind == "f":
        with np.errstate(all="ignore"):
            array = array * draw(st.sampled_from([-1.0, 0.0, 1e-200, 1e200]))
    elif kind == "type":
        array = array.astype(draw(st.sampled_from(["f4", "i8", "?", "U8", "c16"])))
    elif kind == "rows":
        array = array[: draw(st.integers(0, 3))]
    elif kind == "axis":
        array = draw(st.sampled_from([array[None], array.T, array.ravel()]))
    return None if kind == "gone" else array


def test_controllers_of_other_values(sandbox):
    def check(data: bytes) -> None:
        sandbox.fresh()
        path = sandbox.inputs / "c.npz"
        path.write_bytes(data)
        out = sandbox.outputs / "p.csv"
        if sandbox.run("postures", path, "--task", "cube-raise", "-o", out) == 0:
            sandbox.run("evaluate", path, "--json")

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", np.exceptions.ComplexWarning)
        search(check, damaged_archive(CONTROLLER), 60 * sandbox.cases)
    assert {0, 2} <= set(sandbox.codes)


def test_controllers_of_other_bytes(sandbox):
    def check(data: bytes) -> None:
        sandbox.fresh()
        path = sandbox.inputs / "c.npz"
        path.write_bytes(data)
        sandbox.run("postures", path, "--task", "cube-raise", "-o", sandbox.outputs / "p.csv")

    search(check, damaged_bytes(CONTROLLER), 60 * sandbox.cases)
    assert 2 in sandbox.codes


def check_rollout(path: Path) -> bool:
    """Whether a rollout can be drawn; if not, it must have been said in one line."""
    try:
        rollout_clip(read_rollout(path))
    except HandsimError as error:
        assert "\n" not in str(error)
        assert str(path) in str(error) or "rollout of" in str(error)
        return False
    return True


@pytest.mark.parametrize("damage", [damaged_archive, damaged_bytes])
def test_rollouts(sandbox, rollout, damage):
    drawn = []

    def check(data: bytes) -> None:
        sandbox.fresh()
        path = sandbox.inputs / "r.npz"
        path.write_bytes(data)
        drawn.append(check_rollout(path))

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", np.exceptions.ComplexWarning)
        search(check, damage(rollout), 40 * sandbox.cases)
    assert set(drawn) == {False, True}


@pytest.mark.parametrize(
    "evil",
    [
        '<include file="{secret}"/>',
        '<asset><mesh name="x" file="{secret}"/></asset>',
        '<asset><texture name="x" type="2d" file="{secret}"/></asset>',
        '<asset><texture name="x" type="cube" fileup="{secret}"/></asset>',
        '<asset><hfield name="x" file="{secret}" size="1 1 1 1"/></asset>',
        '<asset><hfield name="x" nrow="100000" ncol="100000" size="1 1 1 1"/></asset>',
        '<asset><model name="x" file="{secret}"/></asset>',
        '<asset><texture name="x" type="2d" builtin="flat" width="99999" height="99999"/></asset>',
        '<worldbody><replicate count="1000000000"><geom size="1"/></replicate></worldbody>',
        '<extension><plugin plugin="mujoco.elasticity.cable"/></extension>',
        '<size memory="900G"/>',
        '<size nkey="2000000000"/>',
    ],
)
def test_a_rollout_reads_no_other_file_and_takes_no_memory(tmp_path, rollout, evil):
    secret = tmp_path / "secret.xml"
    secret.write_text("<mujoco><worldbody><site name='told'/></worldbody></mujoco>")
    header, arrays = unpack(rollout)
    header["model_xml"] = header["model_xml"].replace(
        "</mujoco>", evil.format(secret=secret) + "</mujoco>"
    )
    path = tmp_path / "r.npz"
    path.write_bytes(pack(header, arrays))
    assert not check_rollout(path)


def test_entities_are_refused(tmp_path, rollout):
    header, arrays = unpack(rollout)
    entity = f'<!DOCTYPE mujoco [<!ENTITY x SYSTEM "file://{tmp_path}/secret">]>'
    header["model_xml"] = entity + header["model_xml"]
    path = tmp_path / "r.npz"
    path.write_bytes(pack(header, arrays))
    assert not check_rollout(path)


@pytest.mark.parametrize("shape", [(2**40,), (2**20, 2**20), (-1,), (2**62, 2**62)])
@pytest.mark.parametrize("member", ["coefficients", "header"])
def test_claims_of_terabytes_are_not_believed(sandbox, shape, member):
    """Neither those of the archive's directory nor those in a member of it."""
    sandbox.fresh()
    path = sandbox.inputs / "c.npz"
    described = {"descr": "<f8", "fortran_order": False, "shape": shape}
    with zipfile.ZipFile(io.BytesIO(CONTROLLER)) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == f"{member}.npy":
                stream = io.BytesIO()
                np.lib.format.write_array_header_1_0(stream, described)
                content = stream.getvalue() + bytes(64)
            new.writestr(name, content)
    assert (
        sandbox.run("postures", path, "--task", "cube-raise", "-o", sandbox.outputs / "p.csv") == 2
    )


def test_a_bomb_is_not_unpacked(tmp_path):
    path = tmp_path / "c.npz"
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
        archive.open("header.npy", "w", force_zip64=True) as stream,
    ):
        for _ in range(600):
            stream.write(bytes(2**20))
    with pytest.raises(FileError, match="limit"):
        read_archive(path, "controller", 1)


def test_pickles_are_not_opened(tmp_path):
    path = tmp_path / "c.npz"
    np.savez(path, header=np.array([{"kind": "controller"}], dtype=object))
    with pytest.raises(FileError, match="Python objects"):
        read_archive(path, "controller", 1)


def test_plans_of_other_values(sandbox):
    """Plans lie beside a controller, where anyone may have put them."""
    stored = next((data_folder("assets") / "plans").glob("*.json")).read_text()

    def check(text: bytes) -> None:
        sandbox.fresh()
        path = sandbox.inputs / "plans.json"
        path.write_bytes(text)
        try:
            PlanStore(path).read()
        except FileError as error:
            assert "\n" not in str(error)

    search(check, damaged_bytes(stored[:4000].encode()), 20 * sandbox.cases)
    search(check, VALUES.map(lambda value: json.dumps(value).encode()), 10 * sandbox.cases)
    for content in ({"schema": 1}, {"schema": 2, "owner": "x"}):
        plans = VALUES.map(lambda value: {"plans": {"a": value}})
        nested = plans.map(lambda plans, content=content: json.dumps(content | plans).encode())
        search(check, nested, 5 * sandbox.cases)


def test_what_was_written_is_read_again(tmp_path):
    write_archive(tmp_path / "a.npz", "rollout", 1, {}, {"time": np.zeros((0, 3))})
    with pytest.raises(FileError, match="not a whole"):
        read_rollout(tmp_path / "a.npz")


@pytest.mark.parametrize("damage", [damaged_archive, damaged_bytes])
def test_baselines(sandbox, damage):
    read = []

    def check(data: bytes) -> None:
        sandbox.fresh()
        path = sandbox.inputs / "b.npz"
        path.write_bytes(data)
        try:
            read_baseline(path)
        except FileError as error:
            assert str(path) in str(error)
            read.append(False)
        else:
            read.append(True)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", np.exceptions.ComplexWarning)
        search(check, damage(BASELINE), 15 * sandbox.cases)
    assert set(read) == {False, True}
