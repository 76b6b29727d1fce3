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

    from handsim.cli.defaults import hand_size
    from handsim.hand.export import write_hand

    size = hand_size(hand_length, hand_breadth, side)
    note(f"wrote {write_hand(size, output)}")


@app.callback()
def _group() -> None:
    """Build hand models."""
