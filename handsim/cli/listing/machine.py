"""`handsim doctor` and `--version`: what this machine offers."""

import platform
from dataclasses import asdict
from typing import Annotated

import typer

from handsim.cli.console import JsonFlag, say, say_json


def doctor(
    rendering_only: Annotated[
        bool, typer.Option("--rendering-only", help="Check nothing but off-screen rendering.")
    ] = False,
    json: JsonFlag = False,
) -> None:
    """Show versions, GL backends that render, and the video encoder.

    Exit code 1 where no backend renders; the table names the command that installs one.
    """
    from handsim.viewing.doctor import can_render, doctor

    findings = doctor()
    if json:
        say_json({"findings": [asdict(finding) for finding in findings]})
    elif not (rendering_only and can_render(findings)):
        for finding in findings:
            say(f"{finding.name:<16}{'ok' if finding.ok else 'missing':<9}{finding.detail}")
            if finding.remedy:
                say(f"{'':<16}remedy: {finding.remedy}")
    if not can_render(findings):
        raise typer.Exit(1)


def say_version(asked: bool) -> None:
    """Say which versions of handsim, MuJoCo and Python these are, where ``asked``, and end."""
    if asked:
        mujoco, python = _version("mujoco"), platform.python_version()
        say(f"handsim {_version('handsim')} (MuJoCo {mujoco}, Python {python})")
        raise typer.Exit


def _version(package: str) -> str:
    """Return the version of a package without importing it."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(package)
    except PackageNotFoundError:  # a checkout on the path of modules, not installed
        return "not installed"
