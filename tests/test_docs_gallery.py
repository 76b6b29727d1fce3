"""The gallery shows each task as it went, with a stand-in for grasps and films."""

import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import typer

from handsim.cli import app as command_line
from handsim.cli.listing.rule_words import rule_in_words
from handsim.errors import MissingToolError
from handsim.tasks.table_one import TASKS
from handsim.tasks.task import Task

DOCS = Path(__file__).parents[1] / "docs"
pytestmark = pytest.mark.skipif(not DOCS.is_dir(), reason="no docs beside the tests")


@pytest.fixture
def extension(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Any]:
    pytest.importorskip("sphinx")
    monkeypatch.syspath_prepend(str(DOCS / "_ext"))
    return importlib.import_module


def grasp(task: Task) -> Any:
    """A cup that is crushed; all else is held."""
    failed = task.name == "cup-drink"
    reason, detail = ("crushed", "held with <too> much") if failed else (None, "")
    return SimpleNamespace(
        task=task.name, outcome=SimpleNamespace(success=not failed, reason=reason, detail=detail)
    )


def draw(rollout: Any, path: Path, still: Path) -> None:
    path.write_text(f"film of {rollout.task}")
    still.write_text(f"still of {rollout.task}")


def no_renderer(rollout: Any, path: Path, still: Path) -> None:
    raise MissingToolError("no OpenGL backend renders; run: apt-get install libosmesa6")


def test_every_task_is_filmed_and_none_that_fails_is_left_out(
    extension: Callable[[str], Any], tmp_path: Path
) -> None:
    films = extension("gallery_films")
    (tmp_path / "gone.mp4").write_text("a task that is no more")
    made = films.make_gallery(tmp_path, TASKS, grasp, draw)
    assert list(made["tasks"]) == [task.name for task in TASKS]
    assert [name for name, each in made["tasks"].items() if not each["held"]] == ["cup-drink"]
    assert {path.stem for path in tmp_path.glob("*.mp4")} == set(made["tasks"])
    assert films.read_gallery(tmp_path) == made


def test_films_are_kept_until_what_they_hang_on_changes(
    extension: Callable[[str], Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    films = extension("gallery_films")
    assert films.read_gallery(tmp_path) is None
    films.make_gallery(tmp_path, TASKS[:2], grasp, draw)
    monkeypatch.setattr(films, "make_gallery", lambda *_: pytest.fail("made again"))
    films.main(tmp_path)
    with monkeypatch.context() as changed:
        changed.setattr(films, "content_digest", lambda: "another")
        assert films.read_gallery(tmp_path) is None
    (tmp_path / f"{TASKS[1].name}.png").unlink()
    assert films.read_gallery(tmp_path) is None


def test_where_nothing_rendered_it_is_tried_again(
    extension: Callable[[str], Any], tmp_path: Path
) -> None:
    films = extension("gallery_films")
    made = films.make_gallery(tmp_path, TASKS[:2], grasp, no_renderer)
    assert len(made["tasks"]) == 2 and "libosmesa6" in made["no_films"]
    assert films.read_gallery(tmp_path) is None


def test_the_digest_is_of_code_and_models_but_not_of_the_command_line(
    extension: Callable[[str], Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    films = extension("gallery_films")
    package = tmp_path / "handsim"
    code = {name: package / f"{name}.py" for name in ("__init__", "cli/grasping", "tasks/rules")}
    model = tmp_path / "models" / "hand.xml"
    for path in (*code.values(), model, tmp_path / "assets" / "plan.json"):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("before")
    monkeypatch.setattr(films, "handsim", SimpleNamespace(__file__=str(code["__init__"])))
    monkeypatch.setattr(films, "data_folder", lambda name: tmp_path / name)
    digests = [films.content_digest()]
    for path in (code["cli/grasping"], code["tasks/rules"], model):
        path.write_text("after")
        digests.append(films.content_digest())
    assert digests[0] == digests[1]
    assert len(set(digests)) == 3


def test_a_card_says_rule_verdict_and_command(extension: Callable[[str], Any]) -> None:
    cards = extension("task_gallery")
    task = next(task for task in TASKS if task.name == "cup-drink")
    failed = {"held": False, "reason": "crushed", "detail": "held with too much"}
    said = cards.card_of(task, failed)
    assert "8 cup-drink" in said
    assert "failed: crushed (held with too much)" in said
    assert rule_in_words(task) in said
    assert "handsim grasp --task cup-drink\n" in said
    assert ": held" in cards.card_of(task, {"held": True, "reason": None, "detail": ""})


@pytest.mark.parametrize("drawing", [draw, no_renderer])
def test_the_page_is_built_with_films_and_without_a_renderer(
    extension: Callable[[str], Any],
    drawing: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without a warning either way, and with all tasks."""
    pytest.importorskip("myst_parser")
    from sphinx.application import Sphinx
    from sphinx.util.docutils import docutils_namespace, patch_docutils

    cards, films = extension("task_gallery"), extension("gallery_films")

    def run(command: list[Any], check: bool) -> None:
        assert check and command[0] == sys.executable and Path(command[1]).is_file()
        films.make_gallery(Path(command[2]), TASKS, grasp, drawing)

    monkeypatch.setattr(cards.subprocess, "run", run)
    source, built = tmp_path / "source", tmp_path / "out" / "pages"
    source.mkdir()
    (source / "index.md").write_text("# Gallery\n\n```{task-gallery}\n```\n")
    settings = {"extensions": ["myst_parser", "task_gallery"], "project": "tasks"}
    folders = (source, None, built, built / ".doctrees")
    with patch_docutils(), docutils_namespace():
        site = Sphinx(*folders, "html", settings, status=None, warningiserror=True)
        site.build()
    assert site.statuscode == 0
    page = (built / "index.html").read_text()
    filmed = drawing is draw
    assert f"{len(TASKS) - 1} of {len(TASKS)} tasks held." in page
    assert ("apt-get install libosmesa6" in page) is not filmed
    assert page.count("<video") == (len(TASKS) if filmed else 0)
    assert all(f'id="{task.name}"' in page for task in TASKS)
    assert page.count('class="task failed') == 1
    assert "held with &lt;too&gt; much" in page
    there = {path.name for path in (built / cards.FILMS).iterdir()}
    files = {f"{task.name}.{end}" for task in TASKS for end in ("mp4", "png")}
    assert there == (files if filmed else set())


def test_the_help_of_every_command_is_on_its_page(extension: Callable[[str], Any]) -> None:
    text = extension("command_help").help_of_all()
    waiting = [("handsim", typer.main.get_command(command_line))]
    n = 0
    while waiting:
        path, command = waiting.pop()
        n += 1
        part = text.split(f"## `{path}`\n", 1)[1].split("\n## `", 1)[0]
        assert f"Usage: {path} " in part
        for parameter in command.params:
            for option in getattr(parameter, "opts", []):
                assert not option.startswith("--") or option in part, (path, option)
        waiting += [(f"{path} {k}", v) for k, v in getattr(command, "commands", {}).items()]
    assert text.count("\n## `") + 1 == n > 25
    assert max(map(len, text.splitlines())) <= 84
