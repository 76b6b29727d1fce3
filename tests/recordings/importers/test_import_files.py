"""Layouts by name: handsim's own, and those of other packages."""

from pathlib import Path

import numpy as np
import pytest

from handsim.errors import InputError, UnknownNameError
from handsim.recordings.importers import import_files
from handsim.recordings.importers.import_files import FORMATS, import_recordings, layouts
from handsim.recordings.importers.layout import ImportOptions

MODULE = """
from handsim import HandSize, ImportOptions, Layout, Recording, RecordingSet
import numpy as np

def read(files, options):
    time = np.arange(20) / 100
    q = np.full((20, 22), 0.25)
    made = [Recording(f.stem, time, q, 1, "1", options.object, "t", HandSize()) for f in files]
    return RecordingSet(tuple(made))

LAYOUT = Layout("plain-text", "made for a test", read, frozenset({"object"}))
WRONG = "no layout"
"""


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another package, as an installer leaves it."""
    (tmp_path / "other_package.py").write_text(MODULE)
    info = tmp_path / "other_package-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: other-package\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        f"[{import_files.ENTRY_POINTS}]\n"
        "plain-text = other_package:LAYOUT\n"
        "wrong = other_package:WRONG\n"
        "table = other_package:LAYOUT\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))


@pytest.mark.usefixtures("package")
def test_a_layout_of_another_package_reads() -> None:
    assert tuple(layouts()) == (*FORMATS, "plain-text", "wrong")
    made = import_recordings([Path("a.txt")], "plain-text", options=ImportOptions(object="cup"))
    assert made[0].object == "cup"
    assert np.all(made[0].q == 0.25)


@pytest.mark.usefixtures("package")
def test_it_replaces_none_of_handsims_own_and_must_be_a_layout() -> None:
    assert import_files.layout_named("table").name == "table"
    with pytest.raises(InputError, match=r"wrong of group handsim.importers leads to a str"):
        import_files.layout_named("wrong")


def test_names_that_are_not_known_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="plain-text"):
        import_recordings([Path("a.txt")], "plain-text")


def test_names_of_files_may_be_text() -> None:
    options = ImportOptions(column_map="map.toml", calibration="glove.toml")  # pyright: ignore[reportArgumentType]
    assert options.column_map == Path("map.toml")
    assert options.calibration == Path("glove.toml")
    assert options.said == {"column_map", "calibration"}
