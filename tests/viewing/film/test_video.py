import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import pytest

from handsim.errors import FileError, InputError, MissingToolError
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
    write_video(frames, target / "a.gif", fps)
    with iio.imopen(target / "a.gif", "r", plugin="pillow") as file:
        shown = file.read(index=..., mode="RGB")
        about = [file.metadata(index=i) for i in range(len(shown))]
    assert shown.shape == (len(frames), 64, 96, 3)
    for given, got in zip(frames, shown, strict=True):
        assert np.abs(got.astype(int) - given).mean() < 3
    assert about[0]["loop"] == 0, "for ever"
    durations = [each["duration"] for each in about]
    assert sum(durations) == pytest.approx(1000 * len(frames) / fps, abs=1000 / fps)
    assert capfd.readouterr() == ("", "")


def test_fractional_rate_is_kept(target: Path, frames: list[Frame], read_video: ReadVideo) -> None:
    write_video(frames, target / "a.mp4", 29.97)
    assert read_video(target / "a.mp4")[0]["fps"] == pytest.approx(29.97, abs=0.01)


def test_key_frames_are_as_close_as_asked_for(target: Path, frames: list[Frame]) -> None:
    write_video(frames, target / "a.mp4", 25, key_frame_every=2)
    content = (target / "a.mp4").read_bytes()
    table = content.index(b"stss") + 8  # the table of key frames, after its version
    assert int.from_bytes(content[table : table + 4], "big") == (len(frames) + 1) // 2


def test_a_size_that_16_does_not_divide_is_kept(
    target: Path, frames: list[Frame], read_video: ReadVideo
) -> None:
    cut = [frame[:50, :90] for frame in frames]
    write_video(cut, target / "a.mp4", 25)
    metadata, found = read_video(target / "a.mp4")
    assert metadata["size"] == (90, 50)
    assert np.abs(found[0].astype(int) - cut[0]).mean() < 6


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


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
@pytest.mark.parametrize("error", [RuntimeError, OSError, KeyboardInterrupt])
def test_failure_half_way_keeps_the_old_file(
    target: Path, frames: list[Frame], suffix: str, error: type[BaseException]
) -> None:
    def failing() -> Iterator[Frame]:
        yield from frames[:5]
        raise error("half way")

    path = target / f"a{suffix}"
    path.write_text("old")
    with pytest.raises(error, match="half way"):
        write_video(failing(), path, 10)
    assert path.read_text() == "old"
    assert len(list(target.iterdir())) == 1


ENDLESS = """
import sys
from itertools import repeat
import numpy as np
from handsim.viewing.film.video import write_video
frame = np.random.default_rng(0).integers(0, 255, (240, 320, 3), np.uint8)
write_video(repeat(frame), sys.argv[1], 25)
"""


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_interrupt_from_the_keyboard_leaves_no_file_and_no_encoder(
    target: Path, suffix: str
) -> None:
    command = [sys.executable, "-c", ENDLESS, str(target / f"a{suffix}")]
    child = subprocess.Popen(command, stderr=subprocess.PIPE, start_new_session=True)
    end = time.monotonic() + 30
    while not list(target.iterdir()):
        assert time.monotonic() < end, "it never began to write"
        time.sleep(0.05)
    time.sleep(0.5)
    os.killpg(child.pid, signal.SIGINT)  # as a terminal does: to all that run in it
    _, said = child.communicate(timeout=30)  # it ends when the last holder of the pipe has gone
    assert b"KeyboardInterrupt" in said
    assert not list(target.iterdir())


def test_encoder_shares_the_process_group_so_that_an_interrupt_reaches_it(
    target: Path, frames: list[Frame], monkeypatch: pytest.MonkeyPatch
) -> None:
    fake, said = target / "ffmpeg", target / "said"
    fake.write_text(
        f"#!{sys.executable}\nimport os, sys\n"
        f"open({str(said)!r}, 'w').write(str(os.getpgrp()))\nsys.stdin.buffer.read()\n"
    )
    fake.chmod(0o755)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(fake))
    monkeypatch.delenv("IMAGEIO_FFMPEG_NO_PREVENT_SIGINT", raising=False)
    with pytest.raises(FileError, match="stopped before the file was whole"):
        write_video(frames, target / "a.mp4", 10)
    assert int(said.read_text()) == os.getpgrp()


def test_frames_of_two_sizes(target: Path, frames: list[Frame]) -> None:
    with pytest.raises(InputError, match="frame 1 has shape"):
        write_video([frames[0], frames[0][:32]], target / "a.mp4", 10)
    assert not list(target.iterdir())


# imageio-ffmpeg leaves the broken pipe to the garbage collector.
@pytest.mark.filterwarnings("ignore:unclosed file:ResourceWarning")
@pytest.mark.parametrize("reads", [True, False])
def test_encoder_that_stops_is_an_error_of_the_file(
    target: Path, frames: list[Frame], monkeypatch: pytest.MonkeyPatch, reads: bool
) -> None:
    fake = target / "ffmpeg"
    fake.write_text(f"#!/bin/sh\n{'cat >/dev/null' * reads}\nexit 1\n")
    fake.chmod(0o755)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(fake))
    many = (frame for _ in range(200) for frame in frames)
    with pytest.raises(FileError, match=r"a\.mp4: the encoder .*ffmpeg stopped") as raised:
        write_video(many, target / "a.mp4", 10)
    assert "handsim doctor" in str(raised.value) and "\n" not in str(raised.value)
    assert [path.name for path in target.iterdir()] == ["ffmpeg"]


@pytest.mark.parametrize("suffix", [".mp4", ".gif"])
def test_encoder_that_is_ended_before_it_has_written_all(
    target: Path, frames: list[Frame], monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    """It has read all frames and left a part of the file, without a word."""
    write_video(frames, target / f"whole{suffix}", 10)
    part = (target / f"whole{suffix}").read_bytes()[:-1]
    (target / "part").write_bytes(part.replace(b"moov", b"free"))
    fake = target / "ffmpeg"
    last = "for last; do :; done"
    fake.write_text(f'#!/bin/sh\n{last}\ncat >/dev/null\ncp {target}/part "$last"\n')
    fake.chmod(0o755)
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(fake))
    with pytest.raises(FileError, match="stopped before the file was whole, after 10 frames"):
        write_video(frames, target / f"a{suffix}", 10)
    assert not (target / f"a{suffix}").exists()


def test_missing_encoder_names_what_to_install(
    target: Path, frames: list[Frame], monkeypatch: pytest.MonkeyPatch
) -> None:
    def none() -> str:
        raise RuntimeError("No ffmpeg exe could be found. ...")

    monkeypatch.setattr("imageio.plugins.ffmpeg.get_exe", none)
    with pytest.raises(MissingToolError, match="no ffmpeg to encode with; run: pip install"):
        write_video(frames, target / "a.mp4", 10)
    assert not list(target.iterdir())


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
    write_image(frames[0], target / "a.png")
    np.testing.assert_array_equal(iio.imread(target / "a.png"), frames[0])
    with pytest.raises(InputError, match=r"\.png"):
        write_image(frames[0], target / "a.jpg")
