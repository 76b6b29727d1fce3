"""Recordings and their CSV files: round trips, and every rejection with file, row and column."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from handsim.errors import FileError, InputError
from handsim.joints import JOINT_NAMES, N_JOINTS
from handsim.recordings.folder import read_recordings, write_recordings
from handsim.recordings.posture_file import read_posture_table, read_postures, write_postures
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import HandSize


def recording(name: str = "cube", n: int = 12, seed: int = 0) -> Recording:
    q = np.random.default_rng(seed).uniform(-1.0, 1.0, (n, N_JOINTS))
    return Recording(
        name, np.arange(n) / 100, q, 14, "someone", "cube", "cube-raise", HandSize(0.19, 0.085)
    )


@pytest.fixture
def csv(tmp_path: Path) -> Path:
    path = tmp_path / "postures.csv"
    one = recording()
    write_postures(one.time, one.q, path)
    return path


def edit(path: Path, row: int, column: str, value: str) -> None:
    """Replace one cell; rows are counted as in messages, the header being row 1."""
    lines = path.read_text().splitlines()
    cells = lines[row - 1].split(",")
    cells[lines[0].split(",").index(column)] = value
    lines[row - 1] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")


def test_a_folder_comes_back_as_it_was_written(tmp_path: Path) -> None:
    written = RecordingSet((recording("a", seed=1), recording("b", n=30, seed=2)))
    write_recordings(written, tmp_path / "R")
    read = read_recordings(tmp_path / "R")
    assert [r.name for r in read] == ["a", "b"]
    for before, after in zip(written, read, strict=True):
        np.testing.assert_allclose(after.q, before.q, rtol=0, atol=1e-8)
        np.testing.assert_allclose(after.time, before.time, rtol=0, atol=1e-6)
        for field in ("number", "subject", "object", "task", "hand"):
            assert getattr(after, field) == getattr(before, field)


def test_files_hold_degrees_in_glove_order(csv: Path) -> None:
    header, first = (line.split(",") for line in csv.read_text().splitlines()[:2])
    assert header == ["time_s", *(f"{name}_deg" for name in JOINT_NAMES)]
    np.testing.assert_allclose(
        [float(cell) for cell in first[1:]], np.rad2deg(recording().q[0]), rtol=0, atol=1e-6
    )


def test_columns_may_be_in_any_order(csv: Path) -> None:
    _, q = read_postures(csv)
    rows = [line.split(",")[::-1] for line in csv.read_text().splitlines()]
    csv.write_text("\n".join(",".join(row) for row in rows))
    np.testing.assert_array_equal(read_postures(csv)[1], q)


@pytest.mark.parametrize(
    ("row", "column", "value", "words"),
    [
        (4, "index_pip_deg", "nan", ("row 4", "index_pip_deg", "nan")),
        (5, "thumb_ip_deg", "twelve", ("row 5", "thumb_ip_deg", "twelve")),
        (6, "time_s", "inf", ("row 6", "time_s", "inf")),
        (7, "time_s", "0.01", ("row 7", "time_s", "increase")),
        (8, "palm_arch_deg", "181", ("row 8", "palm_arch_deg", "181", "180")),
        (1, "ring_dip_deg", "ring_dlp_deg", ("row 1", "ring_dip_deg", "missing")),
        (1, "ring_dip_deg", "ring_pip_deg", ("row 1", "ring_pip_deg", "twice")),
    ],
)
def test_a_bad_cell_is_named(
    csv: Path, row: int, column: str, value: str, words: tuple[str, ...]
) -> None:
    edit(csv, row, column, value)
    with pytest.raises(FileError) as caught:
        read_postures(csv)
    message = str(caught.value)
    assert "\n" not in message
    for word in (csv.name, *words):
        assert word in message


def test_other_bad_files(csv: Path, tmp_path: Path) -> None:
    whole = csv.read_text().splitlines()
    for text, word in (
        ("", "empty"),
        ("\n".join(whole[:10]), "9 frames"),
        ("\n".join([*whole[:3], whole[3] + ",0", *whole[4:]]), "row 4"),
    ):
        csv.write_text(text)
        with pytest.raises(FileError, match=word):
            read_postures(csv)
    csv.write_bytes(b"time_s\x00\x01\x02")
    with pytest.raises(FileError, match="text"):
        read_postures(csv)
    with pytest.raises(FileError, match="no such file"):
        read_postures(tmp_path / "absent.csv")


def test_bad_folders(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="no such folder"):
        read_recordings(tmp_path / "absent")
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileError, match=r"experiments\.csv"):
        read_recordings(tmp_path / "empty")
    folder = tmp_path / "R"
    write_recordings(RecordingSet((recording("a"), recording("b"))), folder)
    index = folder / "experiments.csv"
    good = index.read_text()
    for before, after, word in (
        ("b.csv", "c.csv", "c.csv"),
        ("b.csv", "../b.csv", "same folder"),
        ("b.csv", "a.csv", "two recordings"),
        (",14,", ",fourteen,", "number"),
        ("0.085", "-1", "hand_breadth"),
    ):
        index.write_text(good.replace(before, after))
        with pytest.raises(FileError, match=word):
            read_recordings(folder)
    index.write_text(good.splitlines()[0] + "\n")
    with pytest.raises(FileError, match="no recording"):
        read_recordings(folder)


def test_writing_replaces_recordings_and_nothing_else(tmp_path: Path) -> None:
    folder = tmp_path / "R"
    write_recordings(RecordingSet((recording("a"), recording("b"))), folder)
    write_recordings(RecordingSet((recording("c"),)), folder)
    assert sorted(p.name for p in folder.iterdir()) == ["c.csv", "experiments.csv"]
    (folder / "thesis.txt").write_text("mine")
    with pytest.raises(FileError, match=r"thesis\.txt"):
        write_recordings(RecordingSet((recording("d"),)), folder)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["R"]  # nothing temporary is left
    assert (folder / "c.csv").is_file()


def test_a_failed_write_leaves_the_folder_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "R"
    write_recordings(RecordingSet((recording("a"),)), folder)
    real = Path.rename

    def fails_for_new(self: Path, target: Path) -> Path:
        if self.name == "new":
            raise OSError("disk full")
        return real(self, target)

    monkeypatch.setattr(Path, "rename", fails_for_new)
    with pytest.raises(OSError, match="disk full"):
        write_recordings(RecordingSet((recording("b"),)), folder)
    assert read_recordings(folder)[0].name == "a"


def test_recordings_are_checked_and_read_only() -> None:
    good = recording()
    assert not good.q.flags.writeable and not good.time.flags.writeable
    assert good.duration == pytest.approx(0.11)
    with pytest.raises(InputError, match="hand_length"):
        Recording("a", good.time, good.q, 1, "", "", "", HandSize(19.0, 0.08))
    with pytest.raises(InputError, match="shapes"):
        Recording("a", good.time, good.q[:, :21], 1, "", "", "", HandSize(0.19, 0.08))
    with pytest.raises(InputError, match="increase"):
        Recording("a", good.time[::-1], good.q, 1, "", "", "", HandSize(0.19, 0.08))
    with pytest.raises(InputError, match="cannot name"):
        Recording("../a", good.time, good.q, 1, "", "", "", HandSize(0.19, 0.08))
    with pytest.raises(InputError, match="0 recordings"):
        RecordingSet(())
    with pytest.raises(InputError, match="two recordings"):
        RecordingSet((good, good))


def test_channels_session_extra_columns_and_notes_come_back(tmp_path: Path) -> None:
    one = recording("a")
    channel = np.linspace(0, 1, len(one.time))
    channel[3] = np.nan
    written = replace(
        one,
        hand=HandSize(0.18, 0.08, "left"),
        session="tuesday, morning",
        channels={"palm_x_m": channel, "label": np.ones(len(one.time))},
        extra={"rate_hz": "100", "lab": "a, b"},
        notes=("bridged 4 frames of index_mcp", "cut out, a, b", "from 1 to 2 s"),
    )
    write_recordings(RecordingSet((written, recording("b", seed=3))), tmp_path / "R")
    header = (tmp_path / "R" / "a.csv").read_text().splitlines()[0]
    assert header.endswith(",channel:palm_x_m,channel:label")
    read = read_recordings(tmp_path / "R")
    for name in ("session", "extra", "notes", "hand"):
        assert getattr(read[0], name) == getattr(written, name)
    np.testing.assert_allclose(read[0].channels["palm_x_m"], channel, atol=1e-6)
    assert set(read[0].channels) == {"palm_x_m", "label"}
    assert read[1].session == "" and read[1].notes == () and not read[1].channels
    assert read[1].extra == {"rate_hz": "", "lab": ""}


def test_a_folder_of_before_is_read_as_of_right_hands(tmp_path: Path) -> None:
    write_recordings(RecordingSet((recording("a"),)), tmp_path / "R")
    index = tmp_path / "R" / "experiments.csv"
    lines = [line.rpartition(",")[0] for line in index.read_text().splitlines()]
    index.write_text("\n".join(lines))
    assert "side" not in index.read_text()
    assert read_recordings(tmp_path / "R")[0].hand.side == "right"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda lines: ["", "", *lines], None),
        (lambda lines: ["# a glove, 90 Hz", *lines], None),
        (lambda lines: [line.replace(",", "\t") for line in lines], "separated by tab"),
        (
            lambda lines: [line.replace(",", ";").replace(".", ",") for line in lines],
            "separated by semicolon and with decimal commas",
        ),
        (lambda lines: [lines[0], ",".join(["s", *22 * ["deg"]]), *lines[1:]], None),
    ],
)
def test_tables_of_other_countries_are_read(
    csv: Path, tmp_path: Path, change: Callable[[list[str]], list[str]], said: str | None
) -> None:
    time, q = read_postures(csv)
    changed = tmp_path / "changed.csv"
    for encoding in ("utf-8", "utf-8-sig", "utf-16"):
        text = "\r\n".join(change(csv.read_text().splitlines()))
        changed.write_bytes(text.encode(encoding))
        again, q_again = read_postures(changed)
        np.testing.assert_array_equal(again, time)
        np.testing.assert_array_equal(q_again, q)
    assert read_posture_table(changed).notes == (() if said is None else (f"changed.csv: {said}",))


def test_rows_are_counted_as_in_the_file(csv: Path) -> None:
    lines = csv.read_text().splitlines()
    lines[5] = lines[5].replace(",", ",x", 1)
    csv.write_text("\n".join(["# a", "", lines[0], "", *lines[1:]]))
    with pytest.raises(FileError, match="row 9, column thumb_rotation_deg: 'x"):
        read_postures(csv)


def test_units_in_the_row_under_the_header_must_be_those_of_the_header(csv: Path) -> None:
    header, *rows = csv.read_text().splitlines()
    csv.write_text("\n".join([header, ",".join(["s", *22 * ["rad"]]), *rows]))
    with pytest.raises(FileError, match="row 2, column thumb_rotation_deg: unit 'rad'"):
        read_postures(csv)
    csv.write_text("\n".join([header, ",".join(["ms", *22 * ["deg"]]), *rows]))
    with pytest.raises(FileError, match="column time_s: unit 'ms'"):
        read_postures(csv)


def test_a_glove_without_distal_sensors_is_filled(csv: Path) -> None:
    _, q = read_postures(csv)
    header, *rows = (line.split(",") for line in csv.read_text().splitlines())
    kept = [i for i, name in enumerate(header) if not name.endswith("_dip_deg")]
    csv.write_text("\n".join(",".join(row[i] for i in kept) for row in [header, *rows]))
    content = read_posture_table(csv)
    index_pip, index_dip = (JOINT_NAMES.index(f"index_{name}") for name in ("pip", "dip"))
    np.testing.assert_allclose(content.angles[:, index_dip], 0.67 * np.rad2deg(q[:, index_pip]))
    assert "index_dip, middle_dip, ring_dip, little_dip filled as 0.67" in content.notes[0]
    # One of them alone missing is a mistake.
    csv.write_text("\n".join(",".join(row[i] for i in range(22)) for row in [header, *rows]))
    with pytest.raises(FileError, match="wrist_deviation_deg is missing"):
        read_postures(csv)


def test_short_gaps_are_bridged_where_it_is_asked(tmp_path: Path) -> None:
    write_recordings(RecordingSet((recording("a", n=30),)), tmp_path / "R")
    path = tmp_path / "R" / "a.csv"
    for row in (10, 11, 12):
        edit(path, row, "index_mcp_deg", "")
    with pytest.raises(FileError, match=r"row 10, column index_mcp_deg: '' is not.*--bridge"):
        read_recordings(tmp_path / "R")
    with pytest.raises(FileError, match="row 10"):
        read_recordings(tmp_path / "R", bridge_s=0.03)
    read = read_recordings(tmp_path / "R", bridge_s=0.04)[0]
    assert read.notes == ("bridged 3 frames of index_mcp",)
    between = recording("a", n=30).q[[8, 12], JOINT_NAMES.index("index_mcp")]
    inside = read.q[8:11, JOINT_NAMES.index("index_mcp")]
    assert (between.min() - 1e-9 <= inside).all() and (inside <= between.max() + 1e-9).all()


def test_reading_shows_how_far_it_is(tmp_path: Path) -> None:
    write_recordings(RecordingSet((recording("a"), recording("b"))), tmp_path / "R")
    told: list[float] = []
    read_recordings(tmp_path / "R", told.append)
    assert told == [0.5, 1.0]
