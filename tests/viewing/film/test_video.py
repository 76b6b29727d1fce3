from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handsim.errors import FileError, InputError
from handsim.types import Frame
from handsim.viewing.film.video import contact_sheet, tile, write_image, write_video

ReadVideo = Callable[[Path], tuple[dict[str, Any], list[Frame]]]


def test_mp4_plays_in_browsers_and_holds_what_was_given(
    target: Path, frames: list[Frame], capfd: pytest.CaptureFixture[str], read_video: ReadVideo
) -> None:
    assert write_video(iter(frames), target / "a.mp4", 25) == len(frames)
    metadata, found = read_video(target / "a.mp4")
    assert metadata["codec"] == "h264"
    assert str(metadata["pix_fmt"]).startswith("yuv420p")
    assert metadata["size"] == (96, 64)
    assert metadata["fps"] == pytest.approx(25)
    assert metadata["duration"] == pytest.approx(len(frames) / 25, abs=0.011)
    assert len(found) == len(frames)
    for given, got in zip(frames, found, strict=True):
        assert np.abs(given.astype(int) - got).mean() < 6
    content = (target / "a.mp4").read_bytes()
    assert content.index(b"moov") < content.index(b"mdat"), "starts before it is all loaded"
    assert [path.name for path in target.iterdir()] == ["a.mp4"]
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("fps", [12.5, 30, 50])
def test_gif_keeps_time_and_pictures(
    target: Path, frames: list[Frame], fps: float, capfd: pytest.CaptureFixture[str]
) -> None:
    from PIL import Image

    write_video(frames, target / "a.gif", fps)
    with Image.open(target / "a.gif") as image:
        assert image.size == (96, 64)
        assert image.n_frames == len(frames)
        assert image.info["loop"] == 0, "for ever"
        durations = []
        for i, given in enumerate(frames):
            image.seek(i)
            durations.append(image.info["duration"])
            assert np.abs(np.asarray(image.convert("RGB")).astype(int) - given).mean() < 3
    assert sum(durations) == pytest.approx(1000 * len(frames) / fps, abs=1000 / fps)
    assert capfd.readouterr() == ("", "")


def test_fractional_rate_is_kept(target: Path, frames: list[Frame], read_video: ReadVideo) -> None:
    write_video(frames, target / "a.mp4", 29.97)
    assert read_video(target / "a.mp4")[0]["fps"] == pytest.approx(29.97, abs=0.01)


def test_odd_size_is_fine_for_gif_but_not_for_mp4(target: Path) -> None:
    odd = [np.zeros((33, 47, 3), np.uint8)]
    with pytest.raises(InputError, match=r"size 47x33; H\.264 takes even sizes, give 48x34"):
        write_video(odd, target / "a.mp4", 10)
    assert write_video(odd, target / "a.gif", 10) == 1


def test_other_formats_are_refused(target: Path, frames: list[Frame]) -> None:
    with pytest.raises(InputError, match=r"'.avi' is not a video format; use .mp4 or .gif"):
        write_video(frames, target / "a.avi", 10)


def test_gif_cannot_be_faster_than_browsers_show(target: Path, frames: list[Frame]) -> None:
    with pytest.raises(InputError, match="60 frames a second in a GIF; give 50"):
        write_video(frames, target / "a.gif", 60)


def test_no_frames(target: Path) -> None:
    with pytest.raises(InputError, match="no frames"):
        write_video([], target / "a.mp4", 10)
    assert not list(target.iterdir())


def test_failure_half_way_keeps_the_old_file(target: Path, frames: list[Frame]) -> None:
    def failing() -> Iterator[Frame]:
        yield from frames[:5]
        raise RuntimeError("half way")

    (target / "a.mp4").write_text("old")
    with pytest.raises(RuntimeError, match="half way"):
        write_video(failing(), target / "a.mp4", 10)
    assert (target / "a.mp4").read_text() == "old"
    assert len(list(target.iterdir())) == 1


def test_frames_of_two_sizes(target: Path, frames: list[Frame]) -> None:
    with pytest.raises(InputError, match="frame 1 has shape"):
        write_video([frames[0], frames[0][:32]], target / "a.mp4", 10)
    assert not list(target.iterdir())


@pytest.mark.parametrize("reads", [True, False])
def test_encoder_that_stops_is_an_error_of_the_file(
    target: Path, frames: list[Frame], monkeypatch: pytest.MonkeyPatch, reads: bool
) -> None:
    fake = target / "ffmpeg"
    fake.write_text(f"#!/bin/sh\n{'cat >/dev/null' * reads}\necho disk full >&2\nexit 1\n")
    fake.chmod(0o755)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(fake))
    many = (frame for _ in range(200) for frame in frames)
    with pytest.raises(FileError, match=r"a\.mp4: the encoder stopped \(disk full\)"):
        write_video(many, target / "a.mp4", 10)
    assert [path.name for path in target.iterdir()] == ["ffmpeg"]


def test_missing_folder(target: Path, frames: list[Frame]) -> None:
    with pytest.raises(FileError, match="does not exist"):
        write_video(frames, target / "no" / "a.mp4", 10)


def test_tiles_lie_row_after_row() -> None:
    cells = [np.full((2, 3, 3), i, np.uint8) for i in range(5)]
    sheet = tile(cells, 3, gap=1, fill=99)
    assert sheet.shape == (5, 11, 3)
    expected = np.full((5, 11), 99)
    for i, (row, column) in enumerate([(0, 0), (0, 4), (0, 8), (3, 0), (3, 4)]):
        expected[row : row + 2, column : column + 3] = i
    np.testing.assert_array_equal(sheet[..., 0], expected)


def test_contact_sheet_labels_lower_left_and_leaves_frames_alone(frames: list[Frame]) -> None:
    before = [frame.copy() for frame in frames]
    plain = contact_sheet(frames, columns=5)
    labelled = contact_sheet(frames, [f"{i} s" for i in range(10)], columns=5)
    assert plain.shape == labelled.shape == (2 * 64 + 2, 5 * 96 + 4 * 2, 3)
    rows, columns = np.nonzero((plain != labelled).any(axis=-1))
    assert set(rows // 66) == {0, 1}
    assert (rows % 66).min() > 32
    assert (columns % 98).max() < 48
    for frame, copy in zip(frames, before, strict=True):
        np.testing.assert_array_equal(frame, copy)


def test_contact_sheet_is_wider_than_high() -> None:
    assert contact_sheet([np.zeros((10, 10, 3), np.uint8)] * 8).shape == (22, 46, 3)


def test_contact_sheet_of_nothing_or_with_labels_missing(frames: list[Frame]) -> None:
    with pytest.raises(InputError, match="no frames"):
        contact_sheet([])
    with pytest.raises(InputError, match="2 labels for 10 frames"):
        contact_sheet(frames, ["a", "b"])


def test_image_is_written_without_loss(target: Path, frames: list[Frame]) -> None:
    from PIL import Image

    write_image(frames[0], target / "a.png")
    with Image.open(target / "a.png") as image:
        np.testing.assert_array_equal(np.asarray(image), frames[0])
    with pytest.raises(InputError, match=r"\.png"):
        write_image(frames[0], target / "a.jpg")
