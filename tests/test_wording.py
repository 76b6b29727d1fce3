"""Numbers of things in messages: the singular for one, wherever a number is computed."""

import ast
import re
from pathlib import Path

import pytest

import handsim
from handsim.wording import number_of

PACKAGE = Path(handsim.__file__).parent
SAID = ("note", "say")
PLURAL = re.compile(r" (?:[a-z]+ )?[a-z]{2,}s\b")


@pytest.mark.parametrize(
    ("n", "words", "said"),
    [
        (1, ("recording",), "1 recording"),
        (0, ("recording",), "0 recordings"),
        (2, ("further recording",), "2 further recordings"),
        (1, ("mesh", "meshes"), "1 mesh"),
        (3, ("mesh", "meshes"), "3 meshes"),
    ],
)
def test_one_is_singular(n: int, words: tuple[str, ...], said: str) -> None:
    assert number_of(n, *words) == said


def is_counted(value: ast.expr) -> bool:
    """Whether an expression is a number of things: a length, a sum, a name that begins with n."""
    if isinstance(value, ast.Call):
        return isinstance(value.func, ast.Name) and value.func.id in ("len", "sum", "max")
    if isinstance(value, ast.Subscript) and isinstance(value.slice, ast.Constant):
        return str(value.slice.value).startswith("n_")
    name = getattr(value, "attr", None) or getattr(value, "id", "")
    return name == "n" or name.startswith("n_")


def always_plural(text: ast.JoinedStr) -> list[str]:
    """Return where a number of things is followed by their plural, whatever the number is.

    "1 of 24 tasks" is as it should be.
    """
    found, before = [], ""
    for part, following in zip(text.values, [*text.values[1:], None], strict=True):
        if (
            isinstance(part, ast.FormattedValue)
            and isinstance(following, ast.Constant)
            and is_counted(part.value)
            and not before.endswith(" of ")
            and PLURAL.match(str(following.value))
        ):
            found.append(ast.unparse(part.value) + str(following.value))
        before = str(part.value) if isinstance(part, ast.Constant) else ""
    return found


@pytest.mark.parametrize("module", sorted((PACKAGE / "cli").rglob("*.py")), ids=lambda p: p.stem)
def test_what_commands_say_agrees_with_its_number(module: Path) -> None:
    calls = [node for node in ast.walk(ast.parse(module.read_text())) if isinstance(node, ast.Call)]
    said = [call for call in calls if isinstance(call.func, ast.Name) and call.func.id in SAID]
    texts = [node for c in said for node in ast.walk(c) if isinstance(node, ast.JoinedStr)]
    assert [each for text in texts for each in always_plural(text)] == []
