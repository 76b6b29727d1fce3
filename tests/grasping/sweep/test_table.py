"""The table of a sweep: cut off anywhere, it goes on to the same bytes."""

import os
import random

import pytest

from handsim.errors import FileError
from handsim.grasping.sweep import table as sweep_table
from handsim.grasping.sweep.table import open_table

COLUMNS = ("name", "value")
N = 5
ROWS = [("plain", 1.0), ("with, comma", 0.1), ('with "quotes"', 1e-9), ("", 2 / 3), ("é", 5)]


@pytest.fixture
def path(tmp_path):
    return tmp_path / "results.csv"


def table_at(path, sweep="abc", n_runs=N):
    return open_table(path, sweep, COLUMNS, n_runs)


def fill(path, order=range(N)):
    with table_at(path) as table:
        for number in order:
            table.add(number, ROWS[number])
        table.complete()
    return path.read_bytes()


@pytest.fixture
def whole(tmp_path):
    """An undisturbed table."""
    return fill(tmp_path / "undisturbed.csv")


def test_a_table_is_plain_csv_that_says_which_sweep_and_run_a_row_is_of(whole):
    lines = whole.decode().splitlines()
    assert lines[0] == "sweep,run,name,value"
    assert lines[1] == "abc,0,plain,1"
    assert lines[2] == 'abc,1,"with, comma",0.1'
    assert lines[4] == "abc,3,,0.666667"
    assert len(lines) == 1 + N


def test_rows_are_on_the_disk_as_they_come(path):
    with table_at(path) as table:
        table.add(3, ROWS[3])
        assert path.read_text().splitlines()[1:] == ["abc,3,,0.666667"]
        table.add(0, ROWS[0])
        assert len(path.read_text().splitlines()) == 3


@pytest.mark.parametrize("seed", range(5))
def test_the_order_of_the_work_is_not_to_be_seen(path, whole, seed):
    order = random.Random(seed).sample(range(N), N)
    assert fill(path, order) == whole


def test_cut_off_at_any_byte_it_goes_on_to_the_same(path, whole):
    for length in range(len(whole) + 1):
        path.write_bytes(whole[:length])
        kept = max(0, whole[:length].count(b"\n") - 1)
        with table_at(path) as table:
            assert len(table) == kept
            assert [number in table for number in range(N)] == [i < kept for i in range(N)]
        assert fill(path) == whole


def test_a_row_that_is_there_is_not_added_again(path, whole):
    with table_at(path) as table:
        for number in (0, 1, 1, 0, 2, 3, 4, 4):
            table.add(number, ROWS[number])
    assert path.read_bytes() == whole


def test_an_incomplete_table_stays_in_the_order_of_the_work(path):
    content = fill(path, [4, 0])
    assert [line.split(b",")[1] for line in content.splitlines()[1:]] == [b"4", b"0"]


def test_rows_are_read_back_by_column(path):
    fill(path, [4, 1])
    with table_at(path) as table:
        first, second = table.rows()
    assert first == {"sweep": "abc", "run": "1", "name": "with, comma", "value": "0.1"}
    assert second["name"] == "é"


def test_rows_of_another_sweep_are_refused_and_kept(path, whole):
    path.write_bytes(whole)
    with pytest.raises(FileError, match=r"results.csv: holds rows of another sweep; .*delete it"):
        table_at(path, sweep="abd").__enter__()
    assert path.read_bytes() == whole


@pytest.mark.parametrize(
    "content",
    [b"time_s,thumb\n0,1\n", b"time_s", b"\xff\xfe", b"sweep,run,name,values\n", b"x" * 100_000],
)
def test_files_of_others_are_refused_and_kept(path, content):
    path.write_bytes(content)
    with pytest.raises(FileError, match="is not a table of a sweep; choose another output"):
        table_at(path).__enter__()
    assert path.read_bytes() == content


@pytest.mark.parametrize(
    "line",
    [
        b"abc,2,plain\n", b"abc,2,plain,1,2\n", b"abc,5,plain,1\n", b"abc,-1,plain,1\n",
        b"abc,two,plain,1\n", b"abc,0,plain,1\n", b'abc,2,"plain,1\n', b"\n", b"abc\n",
        b"abc,2,\xff,1\n", b"abc," + b"9" * 5000 + b",plain,1\n",
    ],
)  # fmt: skip
def test_damaged_rows_are_named(path, whole, line):
    path.write_bytes(b"".join(whole.splitlines(keepends=True)[:2]) + line)
    with pytest.raises(FileError, match=r"results.csv: row 3 is not as it was written; delete"):
        table_at(path).__enter__()


def test_two_sweeps_do_not_write_to_one_table(path, whole):
    with table_at(path) as table:
        table.add(0, ROWS[0])
        with pytest.raises(FileError, match="another sweep is writing to it; wait for it"):
            table_at(path).__enter__()
        for number in range(1, N):
            table.add(number, ROWS[number])
    assert path.read_bytes() == whole
    assert fill(path) == whole  # and the lock has gone


def test_the_table_put_in_place_of_a_locked_one_is_what_the_next_reads(path, whole):
    with table_at(path) as table:
        for number in reversed(range(N)):
            table.add(number, ROWS[number])
        table.complete()
        with table_at(path) as other:
            assert len(other) == N
    assert path.read_bytes() == whole


def test_a_table_replaced_before_it_is_locked_is_opened_anew(path, whole, monkeypatch):
    """Another sweep puts its complete table in place between opening and locking."""
    path.write_bytes(whole[:40])
    lock, replaced = sweep_table._lock, []

    def late(stream, path):
        if not replaced:
            replaced.append(path)
            other = path.with_name("complete.csv")
            other.write_bytes(whole)
            other.replace(path)
        lock(stream, path)

    monkeypatch.setattr(sweep_table, "_lock", late)
    with table_at(path) as table:
        assert len(table) == N
    assert path.read_bytes() == whole


def test_links_folders_and_devices_are_refused(path, tmp_path, whole):
    (tmp_path / "real.csv").write_bytes(whole)
    path.symlink_to(tmp_path / "real.csv")
    for odd in (path, tmp_path, tmp_path / "nowhere" / "results.csv"):
        with pytest.raises(FileError):
            table_at(odd).__enter__()
    fifo = tmp_path / "fifo.csv"
    os.mkfifo(fifo)
    with pytest.raises(FileError, match="not a plain file"):
        table_at(fifo).__enter__()
