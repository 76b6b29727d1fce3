"""The comparison of learning times: whom it learns from what, and that both versions learn."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from handsim.files import data_folder
from handsim.recordings.folder import read_recordings, write_recordings
from handsim.recordings.recording import RecordingSet
from tests.benchmarks import learning_time as bench


@pytest.fixture
def two_people(tmp_path: Path) -> Path:
    shipped = read_recordings(data_folder("assets") / "experiments").recordings[:4]
    people = (replace(each, subject=str(i % 2)) for i, each in enumerate(shipped))
    write_recordings(RecordingSet(tuple(people)), tmp_path / "mine")
    return tmp_path / "mine"


def test_each_person_is_copied_in_the_columns_of_all_versions(two_people, tmp_path) -> None:
    (tmp_path / "each").mkdir()
    found = dict(bench.of_each_person(two_people, tmp_path / "each"))
    assert list(found) == ["mine-0", "mine-1"]
    for name, folder in found.items():
        header = (folder / "experiments.csv").read_text(encoding="utf-8").splitlines()[0]
        assert "side" not in header and "object," in header
        assert {f"mine-{each.subject}" for each in read_recordings(folder)} == {name}
        assert len(read_recordings(folder)) == 2


@pytest.mark.slow
def test_a_version_beside_itself_takes_as_long(two_people, capsys) -> None:
    bench.main([str(bench.HERE), str(two_people), "--rounds", "1"])
    rows = capsys.readouterr().out.splitlines()[2:]
    assert len(rows) == 2
    for row in rows:
        ratio = float(re.search(r"\| (\d\.\d\d), certified", row)[1])
        assert 0.5 < ratio < 2.0
