"""`handsim doctor`: what this machine offers."""

from typing import Annotated

import typer

from handsim.cli.console import JsonFlag, say_json, say_table


def doctor(
    rendering_only: Annotated[
        bool, typer.Option("--rendering-only", help="Check nothing but off-screen rendering.")
    ] = False,
    json: JsonFlag = False,
) -> None:
    """Show versions, GL backends that really render, and the video encoder.

    Exit code 1 where no backend renders; the table names the command that installs one.
    """
    from handsim.viewing.doctor import can_render, doctor

    findings = doctor()
    if json:
        say_json({"findings": [vars(finding) for finding in findings]})
    elif not rendering_only or not can_render(findings):
        say_table(("", "outcome", "remedy"), [tuple(vars(f).values()) for f in findings])
    if not can_render(findings):
        raise typer.Exit(1)
