"""`handsim hand inspect`: a picture to confirm, a map to correct, and one line where it fails."""

import sys
from pathlib import Path

import imageio.v3 as iio
import pytest

from handsim.cli import main

pytestmark = pytest.mark.usefixtures("rendering")

HAND = Path(__file__).parents[1] / "retargeting" / "data" / "four_finger_hand.xml"


def run(monkeypatch, *args: object) -> int:
    monkeypatch.setattr(sys, "argv", ["handsim", "hand", "inspect", *map(str, args)])
    with pytest.raises(SystemExit) as ended:
        main()
    return int(ended.value.code or 0)


def test_a_picture_and_a_map_are_written(tmp_path, monkeypatch, capsys):
    sheet = tmp_path / "sheet.png"
    assert run(monkeypatch, HAND, "-o", sheet) == 0
    said = capsys.readouterr()
    assert "16 coordinates move 16 joints" in said.out and "thumb: " in said.out
    assert "sheet.toml; correct it" in said.err
    picture = iio.imread(sheet)
    assert picture.ndim == 3 and min(picture.shape[:2]) > 600
    red = (picture[..., 0] > 180) & (picture[..., 1] < 90) & (picture[..., 2] < 90)
    assert red[: len(red) // 3].sum() > 50, "the frames' x are drawn"
    text = (tmp_path / "sheet.toml").read_text()
    (tmp_path / "sheet.toml").write_text(text.replace("[fingertips.ring]", "[fingertips.little]"))
    assert run(monkeypatch, HAND, "-o", sheet, "--map", tmp_path / "sheet.toml") == 0
    assert "little: " in capsys.readouterr().out
    assert "[fingertips.little]" in (tmp_path / "sheet.toml").read_text(), "not written over"


@pytest.mark.parametrize(
    ("file", "options", "said"),
    [
        ("none.xml", (), "no such file"),
        (HAND, ("--map", "none.toml"), "none.toml"),
        (HAND, ("--folder", "none"), "no such folder"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(tmp_path, monkeypatch, capsys, file, options, said):
    assert run(monkeypatch, file, "-o", tmp_path / "sheet.png", *options) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and said in error
    assert not list(tmp_path.iterdir())
