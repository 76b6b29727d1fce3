"""The help of each command as the command line itself shows it."""

from collections.abc import Iterator
from typing import Any

import typer

from handsim.cli import app

WIDTH = 84
"""Columns of the help: as many as a page shows without scrolling."""


def commands() -> Iterator[tuple[str, Any, Any]]:
    """Yield name, command and context of handsim, each command and each group, as listed."""
    whole: Any = typer.main.get_command(app)
    yield from _within(whole, "handsim", None)


def _within(command: Any, name: str, parent: Any) -> Iterator[tuple[str, Any, Any]]:
    context = command.make_context(
        name, [], parent, resilient_parsing=True, terminal_width=WIDTH, max_content_width=WIDTH
    )
    yield context.command_path, command, context
    if hasattr(command, "commands"):
        for each in command.list_commands(context):
            yield from _within(command.get_command(context, each), each, context)


def help_of_all() -> str:
    """Return the help of every command in Markdown, a heading each; a group precedes its own."""
    return "\n\n".join(
        f"## `{path}`\n\n```text\n{command.get_help(context).rstrip()}\n```"
        for path, command, context in commands()
    )
