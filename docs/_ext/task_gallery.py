"""The page that shows each task: its film, its rule, how it went and the command for it."""

import json
import re
import shutil
import subprocess
import sys
from html import escape
from pathlib import Path
from typing import Any

from docutils import nodes
from gallery_films import INDEX, SIZE
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from handsim.cli.listing.rule_words import rule_in_words
from handsim.tasks.table_one import TASKS
from handsim.tasks.task import Task

FILMS = "_films"
"""Folder of the films in the built pages."""


def make_films(app: Sphinx) -> None:
    """Make the films that are not there yet, beside the pages as executed notebooks are."""
    app.config.films = str(Path(app.outdir).parent / ".films")
    if app.builder.format == "html":
        script = Path(__file__).with_name("gallery_films.py")
        subprocess.run([sys.executable, script, app.config.films], check=True)


def copy_films(app: Sphinx, error: Exception | None) -> None:
    """Copy them to the pages."""
    if error is None and app.builder.format == "html":
        target = Path(app.outdir) / FILMS
        shutil.rmtree(target, ignore_errors=True)
        target.mkdir(parents=True)
        for path in Path(app.config.films).iterdir():
            if path.suffix in (".mp4", ".png"):
                shutil.copy(path, target)


def note_films(app: Sphinx, env: Any, added: Any, changed: Any, removed: Any) -> list[str]:
    """Have the page read again, since the films may be others."""
    return ["gallery"] if "gallery" in env.found_docs else []


class TaskGallery(SphinxDirective):
    """Put in the films of all tasks: ``{task-gallery}``."""

    def run(self) -> list[nodes.Node]:
        """Make a card a task, after a line that counts."""
        path = Path(self.config.films) / INDEX
        if not path.is_file():  # pages of another kind than HTML have no films
            return self.parse_text_to_nodes("The films are on the web pages.")
        made = json.loads(path.read_text(encoding="utf-8"))
        cards = nodes.container(classes=["tasks"])
        for task in TASKS:
            judged = made["tasks"][task.name]
            kind = "held" if judged["held"] else "failed"
            card = nodes.container(classes=["task", kind], ids=[task.name])
            if not made["no_films"]:
                card += nodes.raw("", film_of(task.name), format="html")
            card += self.parse_text_to_nodes(card_of(task, judged))
            cards += card
        return [*self.parse_text_to_nodes(summary_of_all(made)), cards]


def summary_of_all(made: dict[str, Any]) -> str:
    """Return how many held, and why there are no films where there are none."""
    judged = made["tasks"].values()
    said = f"**{sum(each['held'] for each in judged)} of {len(judged)} tasks held.**"
    if made["no_films"]:
        said += (
            f"\n\nThere are no films here, since nothing rendered: {as_it_is(made['no_films'])}."
        )
    return said


def film_of(name: str) -> str:
    """Return a film; `docs/_static/films.js` has it play while it is pointed at."""
    path = f"{FILMS}/{escape(name)}"
    return (
        f'<video src="{path}.mp4" poster="{path}.png" width="{SIZE[0]}" height="{SIZE[1]}" '
        f'aria-label="Film of the task {escape(name)}" muted loop playsinline controls '
        'preload="none"></video>'
    )


def card_of(task: Task, judged: dict[str, Any]) -> str:
    """Return what is said of a task, in Markdown."""
    verdict = "held" if judged["held"] else f"failed: {judged['reason']}"
    why = "" if judged["held"] or not judged["detail"] else f" ({as_it_is(judged['detail'])})"
    return (
        f"**{task.number} {task.name}**: {verdict}{why}\n\n{rule_in_words(task)}\n\n"
        f"```text\nhandsim grasp --task {task.name}\n```"
    )


def as_it_is(text: str) -> str:
    """Return text that Markdown shows as it is, whatever stands in it."""
    return re.sub(r"([\\`*_{}\[\]<>#|$])", r"\\\1", text)


def setup(app: Sphinx) -> dict[str, Any]:
    """Hand it all to Sphinx."""
    app.add_config_value("films", "", "")
    app.add_directive("task-gallery", TaskGallery)
    app.connect("builder-inited", make_films)
    app.connect("env-get-outdated", note_films)
    app.connect("build-finished", copy_films)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
