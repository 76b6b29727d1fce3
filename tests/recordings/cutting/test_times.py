"""Tables of times given by hand: what is read, and every rejection with file, row and column."""

from pathlib import Path

import numpy as np
import pytest

from handsim.errors import FileError
from handsim.recordings.cutting.times import read_times
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import HandSize


@pytest.fixture
def recordings() -> RecordingSet:
    time = np.arange(1000) / 100
    return RecordingSet(
        tuple(
            Recording(name, time, np.zeros((1000, 22)), 1, "s", "cup", "t", HandSize())
            for name in ("a", "b")
        )
    )


@pytest.fixture
def table(tmp_path: Path):
    def write(text: str) -> Path:
        path = tmp_path / "times.csv"
        path.write_bytes(text.encode())
        return path

    return write


def test_rows_are_reaches(table, recordings) -> None:
    given = read_times(table("file,start_s,end_s\nb.csv,1.5,2.5\na,0,9.99\nb,2.5,4\n"), recordings)
    assert [(g.reach.recording, g.reach.start_s, g.reach.end_s) for g in given] == [
        ("b", 1.5, 2.5),
        ("a", 0.0, 9.99),
        ("b", 2.5, 4.0),
    ]
    assert all(g.reach.certain and g.object is None for g in given)


def test_words_other_columns_and_other_locales(table, recordings) -> None:
    text = "end_s;who;file;start_s;object;task\n2,5;me;a.csv;1,5;jar;\n"
    given = read_times(table(text), recordings)
    assert (given[0].reach.start_s, given[0].reach.end_s) == (1.5, 2.5)
    assert given[0].object == "jar" and given[0].task is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("file,start_s\na,1\n", "column end_s is missing"),
        ("file,file,start_s,end_s\na,a,1,2\n", "column file is twice"),
        ("file,start_s,end_s\n", "at least 1 row|names of columns"),
        ("file,start_s,end_s\na,1,2\nc,1,2\n", "row 3, column file: 'c' is none of the 2"),
        ("file,start_s,end_s\na,1,2\na,4,x\n", "row 3, column end_s: 'x' is not a time"),
        ("file,start_s,end_s\na,1,nan\n", "row 2, column end_s: 'nan'"),
        ("file,start_s,end_s\na,-1,2\n", "row 2, column start_s: -1 s is outside 'a'"),
        ("file,start_s,end_s\na,1,99\n", "row 2, column end_s: 99 s is outside 'a'.*9.99 s"),
        ("file,start_s,end_s\na,2,1\n", "row 2: a reach from 2 to 1 s; .*0.09 s after"),
        ("file,start_s,end_s\na,1,1.05\n", "row 2: a reach from 1 to 1.05 s"),
        ("file,start_s,end_s\na,1,3\na,2,4\n", "row 3: 2 to 4 s overlaps the reach from 1 to 3"),
        ("file,start_s,end_s\na,1,3,4\n", "row 2 has 4 values for 3 columns"),
        ("", "is empty"),
    ],
)
def test_rejections(table, recordings, text: str, message: str) -> None:
    with pytest.raises(FileError, match=message) as caught:
        read_times(table(text), recordings)
    assert "times.csv" in str(caught.value) and "\n" not in str(caught.value)


def test_a_missing_file(tmp_path: Path, recordings) -> None:
    with pytest.raises(FileError, match=r"no\.csv"):
        read_times(tmp_path / "no.csv", recordings)


def test_mutated_tables_are_read_or_refused(tmp_path: Path, recordings) -> None:
    rng = np.random.default_rng(0)
    whole = b"file,start_s,end_s,object\na.csv,1.50,2.50,jar\nb.csv,0.10,3.75,cup\na,4,5,jar\n"
    path = tmp_path / "times.csv"
    read = 0
    for _ in range(400):
        data = bytearray(whole[: rng.integers(len(whole) + 1)] if rng.random() < 0.3 else whole)
        for _ in range(rng.integers(0, 4)):
            if data:
                place = int(rng.integers(len(data)))
                data[place : place + int(rng.integers(0, 3))] = rng.bytes(int(rng.integers(0, 3)))
        path.write_bytes(bytes(data))
        try:
            given = read_times(path, recordings)
        except FileError as error:
            assert "\n" not in str(error)
            continue
        read += 1
        assert all(0 <= g.reach.start_s < g.reach.end_s <= 9.99 for g in given)
    assert 20 < read < 380
