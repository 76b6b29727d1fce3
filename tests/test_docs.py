"""What the documentation shows runs, and what it says of files and calls is so."""

import importlib
import inspect
import json
import re
import shlex
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer

import handsim
from handsim.cli import app

DOCS = Path(__file__).parents[1] / "docs"
pytestmark = pytest.mark.skipif(not DOCS.is_dir(), reason="no docs beside the tests")

PAGES = {
    str(path.relative_to(DOCS)): path.read_text(encoding="utf-8")
    for path in sorted([*DOCS.glob("*.md"), *DOCS.glob("howto/*.md")])
}
BLOCK = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
WITH_PYTHON = [name for name, text in PAGES.items() if BLOCK.search(text)]
NEEDS = {"howto/inverse_kinematics.md": "mink", "howto/cluster.md": "distributed"}
"""Packages that a page shows and handsim itself does not use."""
COMMANDS = {
    command.strip()
    for text in PAGES.values()
    for line in re.findall(r"^    (handsim .*)", text, re.MULTILINE)
    for command in line.split("&&")
}


def python_of(text: str) -> str:
    """The Python of a page, on the lines that it has there, so that errors name them."""
    lines = [""] * len(text.splitlines())
    for block in BLOCK.finditer(text):
        first = text[: block.start(1)].count("\n")
        code = block[1].splitlines()
        lines[first : first + len(code)] = code
    return "\n".join(lines)


@pytest.mark.parametrize("page", WITH_PYTHON)
def test_the_python_of_a_page_runs(page: str, tmp_path: Path) -> None:
    """As a reader would paste it, block by block, in an empty folder."""
    if page in NEEDS:
        pytest.importorskip(NEEDS[page], reason=f"{page} shows {NEEDS[page]}")
    script = tmp_path / "page.py"
    script.write_text(python_of(PAGES[page]), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, script.name], cwd=tmp_path, capture_output=True, text=True, timeout=300,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]


def test_pages_with_python_are_found() -> None:
    assert {"start.md", "developers.md", *(p for p in PAGES if p.startswith("howto/"))} - {
        "howto/index.md"
    } <= set(WITH_PYTHON)


@pytest.mark.parametrize("line", sorted(COMMANDS))
def test_the_command_lines_are_understood(line: str) -> None:
    name, *words = shlex.split(line, comments=True)
    command: Any = typer.main.get_command(app)
    while hasattr(command, "commands"):
        name, *words = words
        command = command.commands[name]
    assert not words or command.make_context(name, words).params


def named_in(text: str) -> set[str]:
    return set(re.findall(r"`([^`\n]+)`", text))


def section(page: str, title: str) -> str:
    """The text of a page under a heading of the second level."""
    found = re.search(rf"^## {re.escape(title)}$(.*?)(?=^## |\Z)", PAGES[page], re.M | re.S)
    assert found, title
    return found[1]


def archive(path: Path) -> tuple[dict[str, Any], set[str]]:
    """Metadata and names of the arrays of an ``.npz`` file."""
    with zipfile.ZipFile(path) as members:
        names = {name.removesuffix(".npy") for name in members.namelist()}
    header = json.loads(str(np.load(path)["header"]))
    return header, {re.sub(r"_\d+$", "_{i}", name) for name in names - {"header"}}


@pytest.mark.parametrize(
    "title, file",
    [
        ("Controllers", "controller.npz"),
        ("Transports", "people/transport.npz"),
        ("Baselines", "baseline.npz"),
    ],
)
def test_every_field_of_an_archive_is_described(title: str, file: str) -> None:
    header, arrays = archive(handsim.data_folder("assets") / file)
    said = named_in(section("formats.md", title))
    assert arrays | header.keys() - {"kind", "schema"} <= said


def test_every_field_of_a_rollout_is_described() -> None:
    from handsim.grasping.conditions import Conditions
    from handsim.grasping.rollout_file import _ARRAYS
    from handsim.tasks.rules import Outcome

    said = named_in(section("formats.md", "Rollouts"))
    assert set(_ARRAYS) <= said
    assert Conditions().as_dict().keys() <= said
    assert Outcome.__dataclass_fields__.keys() <= said


def test_every_field_of_a_plan_is_described() -> None:
    said = named_in(section("formats.md", "Plans"))
    for file in (handsim.data_folder("assets") / "plans").glob("*.json"):
        content = json.loads(file.read_text())
        plan = next(iter(content["plans"].values()))
        assert content.keys() | plan.keys() | plan["key"].keys() <= said


def test_every_column_and_key_of_a_sweep_is_described() -> None:
    from handsim.grasping.sweep.file import _READERS, POPULATION_KEYS
    from handsim.grasping.sweep.runner import COLUMNS
    from handsim.grasping.sweep.table import KEYS

    said = named_in(section("formats.md", "Sweeps"))
    assert {*_READERS, *POPULATION_KEYS, *COLUMNS, *KEYS} <= said


def test_every_quantity_of_an_export_is_described() -> None:
    from handsim.exports.export_sources import read_sources
    from handsim.exports.hdf5_file import RAW

    said = named_in(section("formats.md", "Exports"))
    kept = sorted((Path(__file__).parent / "data" / "schemas").glob("rollout-*.npz"))
    one = handsim.data_folder("assets") / "experiments" / "cube-raise.csv"
    folder = one.parent
    for episode in read_sources([*kept, one, folder]):
        assert {quantity.name for quantity in episode.quantities} <= said
        assert {"name", "kind", "task", "sentence", *episode.facts} <= said
    assert set(RAW) <= said


def test_every_column_of_recordings_is_described() -> None:
    from handsim.recordings.folder import INDEX_COLUMNS, SAID_COLUMNS
    from handsim.recordings.posture_file import CHANNEL, DIP_JOINTS

    said = named_in(section("formats.md", "Recordings"))
    assert {*INDEX_COLUMNS, *SAID_COLUMNS, *DIP_JOINTS, "time_s", f"{CHANNEL}<name>"} <= said


def toml_of(title: str) -> list[dict[str, Any]]:
    """The examples in TOML under a heading of the page on formats."""
    blocks = re.findall(r"^```toml\n(.*?)^```", section("formats.md", title), re.M | re.S)
    assert blocks, title
    return [tomllib.loads(block) for block in blocks]


def test_the_map_of_columns_shows_every_key() -> None:
    from handsim.recordings.columns.column_map import _COLUMN_KEYS, _LABEL_KEYS

    (shown,) = toml_of("Maps of columns")
    assert {key for column in shown["column"] for key in column} == set(_COLUMN_KEYS)
    assert tuple(shown["recording"]) == _LABEL_KEYS
    assert set(shown["time"]) == {"column", "unit", "rate_hz"}


def test_the_map_of_markers_is_read_and_every_role_is_named(tmp_path: Path) -> None:
    from handsim.recordings.points.marker_map import read_marker_map
    from handsim.recordings.points.marker_roles import ROLES

    text = section("formats.md", "Maps of markers")
    block = re.search(r"^```toml\n(.*?)^```", text, re.M | re.S)
    assert block
    (tmp_path / "map.toml").write_text(block[1])
    read = read_marker_map(tmp_path / "map.toml")
    assert read.roles["thumb_tip"] == "thumb_tip"
    assert read.own_places["M17"].body == "index_middle"
    fingers = ("index_", "middle_", "ring_", "little_")
    shown = {f"index_{r.partition('_')[2]}" if r.startswith(fingers) else r for r in ROLES}
    assert shown <= named_in(text)


def test_every_key_of_a_calibration_is_described() -> None:
    from handsim.recordings.glove.calibration import _KEYS, HOWS, KIND

    text = section("formats.md", "Calibrations of gloves")
    assert {*_KEYS, *HOWS, "kind", "schema", "source"} <= named_in(text)
    assert KIND in text
    assert set(toml_of("Calibrations of gloves")[0]["posture"][0]) == {
        "file", "name", "rows", "angles",
    }  # fmt: skip


def test_every_column_of_a_table_of_times_is_described() -> None:
    from handsim.recordings.cutting.times import COLUMNS

    assert {*COLUMNS, "object", "task"} <= named_in(section("formats.md", "Times of reaches"))


def test_the_table_of_anomalies_has_every_kind_with_its_severity() -> None:
    from handsim.recordings import _faults
    from handsim.recordings.plausibility import KINDS

    text = section("howto/recordings.md", "Can it be right?")
    rows = dict(re.findall(r"^\| `([\w-]+)` \| (error|warning|error or warning) \|", text, re.M))
    assert tuple(rows) == KINDS
    made: dict[str, set[str]] = {}
    for kind, severity in re.findall(
        r'\*\("([\w-]+)", "(error|warning)"', inspect.getsource(_faults)
    ):
        made.setdefault(kind, set()).add(severity)
    assert {kind: set(said.split(" or ")) for kind, said in rows.items()} == made


def test_the_table_of_formats_has_them_all() -> None:
    from handsim.recordings.importers.import_files import FORMATS

    text = section("howto/recordings.md", "Which format is mine")
    assert set(re.findall(r"^\| [^|`]+ \| `([\w-]+)` \|", text, re.M)) == {*FORMATS, "--format"}


WALK = re.compile(r"^\| (\d+) \| `([\w.]+)` \| `([\w.]+)` \| (\d*) ?\|", re.MULTILINE)
WALKS = {
    "From `z_goal` to the actuators": (12, 9),
    "From a CSV to the coefficients of the spline": (12, 9),
    "From a hand length to geoms": (8, 3),
}
"""The most calls and modules."""


@pytest.mark.parametrize("title", WALKS)
def test_a_walk_is_as_the_code_is(title: str) -> None:
    """Each function is there and named by the one that it is called from; no walk is too long."""
    text = PAGES["developers.md"]
    found = re.search(rf"^### {re.escape(title)}$(.*?)(?=^##|\Z)", text, re.M | re.S)
    assert found
    steps = WALK.findall(found[1])
    assert [int(number) for number, *_ in steps] == list(range(1, len(steps) + 1))
    modules = {module for _, module, _, _ in steps}
    assert f"{len(steps)} calls in {len(modules)} modules" in found[1]
    assert len(steps) <= WALKS[title][0] and len(modules) <= WALKS[title][1]
    bodies = [inspect.getsource(inspect.unwrap(named(*step[1:3]))) for step in steps]
    for _, _, name, caller in steps[1:]:
        *owner, last = name.split(".")
        called = owner[-1] if last == "__post_init__" else last
        if last == "__call__":
            called = "grasp"  # what a grasper is called where any will do
        assert re.search(rf"\b{called}\b", bodies[int(caller) - 1]), (name, caller)


def named(module: str, name: str) -> Any:
    """The function of that name; of a property or cached property, what computes it."""
    value: Any = importlib.import_module(f"handsim.{module}")
    for part in name.split("."):
        value = inspect.getattr_static(value, part)
    return getattr(value, "func", getattr(value, "__func__", getattr(value, "fget", value)))


def test_the_theory_has_every_equation_and_its_lines_exist() -> None:
    text = PAGES["theory.md"]
    for number in range(1, 10):
        assert f"({number})" in text
    for role in re.findall(r"\{py:(?:obj|func|class|meth|mod)\}`(?:[^`<]*<)?~?([\w.]+)>?`", text):
        module, rest = role, []
        while True:
            try:
                value: Any = importlib.import_module(module)
                break
            except ModuleNotFoundError:
                module, _, last = module.rpartition(".")
                rest.insert(0, last)
        for part in rest:
            value = getattr(value, part)


def test_the_built_pages_take_the_public_names_from_the_stub(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(str(DOCS / "_ext"))
    extension: Any = importlib.import_module("handsim_docs")
    names = [name for name, _ in extension.public_names()]
    assert set(names) == set(handsim.__all__)
    for name, module in extension.public_names():
        full = extension.defined_in(name, module)
        assert getattr(importlib.import_module(full.rpartition(".")[0]), name) is getattr(
            handsim, name
        )
        assert extension.summary_of(full), full
    rooms = {p.parent for p in Path(handsim.__file__).parent.rglob("__init__.py")}
    known = {Path(handsim.__file__).parent.joinpath(*r.split(".")) for r in extension.ROOMS}
    assert rooms - {Path(handsim.__file__).parent} == known
    assert extension.task_table().count("\n") == 1 + 25
