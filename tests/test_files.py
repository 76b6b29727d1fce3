from pathlib import Path

import numpy as np
import pytest

from handsim import files
from handsim.errors import FileError


def _write(path: Path, schema: int = 1, kind: str = "thing") -> None:
    files.write_archive(path, kind, schema, {"note": "µ"}, {"a": np.arange(4.0)})


def test_archive_round_trip(tmp_path):
    path = tmp_path / "a.npz"
    _write(path)
    metadata, arrays = files.read_archive(path, "thing", 1)
    assert metadata["note"] == "µ"
    np.testing.assert_array_equal(arrays["a"], np.arange(4.0))


def test_same_content_same_bytes(tmp_path):
    _write(tmp_path / "a.npz")
    _write(tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda path: path.unlink(), "no such file"),
        (lambda path: path.write_bytes(path.read_bytes()[: path.stat().st_size // 2]), "cut off"),
        (lambda path: path.write_bytes(b""), "not a readable"),
        (lambda path: path.write_bytes(b"hello\n" * 50), "not a readable"),
        (lambda path: _write(path, kind="other"), "holds a 'other'"),
        (lambda path: _write(path, schema=2), "schema 2"),
        (lambda path: np.savez(path, header=np.array({"a": 1}, dtype=object)), "not a readable"),
    ],
)
def test_bad_archives_are_named(tmp_path, damage, message):
    path = tmp_path / "a.npz"
    _write(path)
    damage(path)
    with pytest.raises(FileError, match=message) as caught:
        files.read_archive(path, "thing", 1)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_huge_claims_are_refused_before_reading(tmp_path, monkeypatch):
    path = tmp_path / "a.npz"
    _write(path)
    monkeypatch.setattr(files, "MAX_ARCHIVE_BYTES", 100)
    with pytest.raises(FileError, match="more than the limit"):
        files.read_archive(path, "thing", 1)


def test_failed_write_leaves_the_old_file_and_no_litter(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def fail() -> None:
        with files.replacing(path) as temporary:
            temporary.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fail()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_takes_the_place_of_another_when_it_is_whole(tmp_path):
    folder = tmp_path / "made"
    for content in ("one", "two"):
        with files.replacing_folder(folder) as fresh:
            (fresh / content).touch()
        assert [path.name for path in folder.iterdir()] == [content]
    with pytest.raises(RuntimeError), files.replacing_folder(folder) as fresh:
        (fresh / "three").touch()
        raise RuntimeError
    assert [path.name for path in tmp_path.rglob("*")] == ["made", "two"]


def test_write_into_missing_folder_names_it(tmp_path):
    with pytest.raises(FileError, match="does not exist"):
        files.write_text(tmp_path / "no" / "a.txt", "x")


def test_arrays_of_anyone_are_read_and_large_or_foreign_ones_refused(tmp_path, monkeypatch):
    np.savez(tmp_path / "a.npz", x=np.arange(6.0).reshape(2, 3), names=np.array(["a"]))
    np.save(tmp_path / "b.npy", np.asfortranarray(np.arange(6.0).reshape(2, 3)))
    read = files.read_arrays(tmp_path / "a.npz")
    assert set(read) == {"x", "names"} and read["x"].tolist() == [[0, 1, 2], [3, 4, 5]]
    assert files.read_arrays(tmp_path / "b.npy")[""].tolist() == [[0, 1, 2], [3, 4, 5]]
    np.savez(tmp_path / "c.npz", x=np.array([None], dtype=object))
    with pytest.raises(FileError, match="only Python objects"):
        files.read_arrays(tmp_path / "c.npz")
    (tmp_path / "d.npz").write_bytes((tmp_path / "a.npz").read_bytes()[:-40])
    with pytest.raises(FileError, match="not a readable file of arrays"):
        files.read_arrays(tmp_path / "d.npz")
    monkeypatch.setattr(files, "MAX_ARCHIVE_BYTES", 100)
    for name in ("a.npz", "b.npy"):
        with pytest.raises(FileError, match="more than the limit of 100"):
            files.read_arrays(tmp_path / name)
