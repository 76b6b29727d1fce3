"""The package stays a house of small rooms: what a stranger may rely on when looking for a line."""

import ast
from pathlib import Path

import pytest

import handsim

PACKAGE = Path(handsim.__file__).parent
ROOMS = sorted(path.parent for path in PACKAGE.rglob("__init__.py"))
MODULES = sorted(PACKAGE.rglob("*.py"))
MOST_MODULES = 12
MOST_LINES = 350


def named(path: Path) -> str:
    return str(path.relative_to(PACKAGE.parent))


def imported(path: Path) -> set[str]:
    """Full names of all modules and names of this package that a module imports."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return {name for name in found if name.startswith("handsim")}


@pytest.mark.parametrize("room", ROOMS, ids=named)
def test_no_room_is_crowded(room: Path) -> None:
    modules = [path.name for path in room.glob("*.py") if path.name != "__init__.py"]
    assert len(modules) <= MOST_MODULES, modules


@pytest.mark.parametrize("module", MODULES, ids=named)
def test_no_module_is_long(module: Path) -> None:
    assert len(module.read_text(encoding="utf-8").splitlines()) <= MOST_LINES


@pytest.mark.parametrize("room", [room for room in ROOMS if room != PACKAGE], ids=named)
def test_every_room_says_what_it_is_for(room: Path) -> None:
    said = ast.get_docstring(ast.parse((room / "__init__.py").read_text(encoding="utf-8")))
    assert said and len(said.split()) >= 8


@pytest.mark.parametrize("module", MODULES, ids=named)
def test_what_begins_with_an_underscore_is_its_own_rooms(module: Path) -> None:
    for name in imported(module):
        parts = name.split(".")
        private = [i for i, part in enumerate(parts) if part.startswith("_")]
        for i in private:
            owner = PACKAGE.parent.joinpath(*parts[:i])
            is_module = (owner / f"{parts[i]}.py").is_file()
            assert not is_module or owner in module.parents, f"{named(module)} imports {name}"


def test_names_of_modules_do_not_repeat_but_where_rooms_are_of_one_plan() -> None:
    """``learner`` is in both learners' rooms; other names say which module is meant."""
    names = [path.stem for path in MODULES if path.stem != "__init__"]
    twice = {name for name in names if names.count(name) > 1}
    assert twice <= {"learner", "mjcf"}, twice


def test_no_two_classes_share_a_name() -> None:
    names = [
        node.name
        for module in MODULES
        for node in ast.parse(module.read_text(encoding="utf-8")).body
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    ]
    assert sorted({name for name in names if names.count(name) > 1}) == []
