"""`handsim hand`: models of the hand as files."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from handsim.cli.console import check_gl, note

app = typer.Typer()


@app.command()
def build(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the model.")],
    hand_length: Annotated[float | None, typer.Option(help="Hand length in m.")] = None,
    hand_breadth: Annotated[float | None, typer.Option(help="Hand breadth in m.")] = None,
    side: Annotated[Literal["right", "left"], typer.Option(help="Which hand.")] = "right",
) -> None:
    """Write the hand as MJCF that plain MuJoCo loads."""
    check_gl()

    from handsim.hand.anthropometry import HAND_BREADTH, HAND_LENGTH
    from handsim.hand.export import write_hand

    path = write_hand(
        output,
        hand_length=hand_length if hand_length is not None else HAND_LENGTH,
        hand_breadth=hand_breadth if hand_breadth is not None else HAND_BREADTH,
        side=side,
    )
    note(f"wrote {path}")


@app.callback()
def _group() -> None:
    """Build hand models."""
