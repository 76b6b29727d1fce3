"""What the README shows runs: its Python, and its command lines with the options they name."""

import re
import shlex
from pathlib import Path
from typing import Any

import pytest
import typer

import handsim
from handsim.baseline.check import record_baseline
from handsim.baseline.store import write_baseline
from handsim.cli import app

README = Path(__file__).parents[1] / "README.md"
TEXT = README.read_text(encoding="utf-8") if README.is_file() else ""
PYTHON = re.findall(r"^```python\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL)
COMMANDS = [
    command.strip().removesuffix("`")
    for line in re.findall(r"^    (handsim (?:.*\\\n)*.*)", TEXT, re.MULTILINE)
    for command in line.replace("\\\n", " ").split("&&")
] + re.findall(r"`(handsim [^`|]*)`", TEXT)

pytestmark = pytest.mark.skipif(not TEXT, reason="no README.md beside the tests")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to work in, with three recordings by the name that the README gives them."""
    everything = handsim.read_recordings(handsim.data_folder("assets") / "experiments")
    few = [each.object in ("cube", "screwdriver", "ashtray") for each in everything]
    handsim.write_recordings(everything[few], tmp_path / "FOLDER")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_python_runs_block_by_block(folder: Path) -> None:
    """As a reader would paste them one after the other."""
    assert len(PYTHON) == 2
    names: dict[str, Any] = {}
    for block in PYTHON:
        if "controller-baseline.npz" in block:  # the command line above it makes the file
            made = record_baseline(names["controller"])
            write_baseline(made, folder / "controller-baseline.npz")
        exec(compile(block, "README.md", "exec"), names)
    movement = names["movement"]
    assert movement.arrived
    assert movement.q.shape == (len(movement.time), 22)
    assert names["goal"].object == "screwdriver"


@pytest.mark.parametrize("line", sorted(set(COMMANDS)))
def test_the_command_lines_are_understood(line: str) -> None:
    """Every command named is there, and where arguments are shown they are those it takes."""
    name, *words = shlex.split(line, comments=True)
    command: Any = typer.main.get_command(app)
    while hasattr(command, "commands"):
        name, *words = words
        if name.startswith("-"):  # an option of handsim itself
            assert any(name in option.opts for option in command.params)
            return
        command = command.commands[name]
    if words:
        context = command.make_context(name, words)
        assert context.params


def test_command_lines_are_found_over_several_lines() -> None:
    assert len(COMMANDS) > 30
    assert any("west-rtg" in line and "-o FOLDER" in line for line in COMMANDS)
    assert any(line.startswith("handsim evaluate") and "FOLDER" in line for line in COMMANDS)
