"""The fixture for test suites of users, also with workers that ask for the same name at once."""

import subprocess
import sys
from pathlib import Path

import pytest

from handsim.baseline.check import record_baseline
from handsim.baseline.store import write_baseline
from handsim.baseline.tolerances import Tolerances
from handsim.errors import InputError
from handsim.learning.learn import learn_controller
from handsim.testing import assert_as_baseline
from handsim.testing.fixture import page_name

TESTS = """
import pytest

@pytest.mark.parametrize("name", ["same", "same"], ids=["one", "two"])
def test_it_does_what_it_did(as_baseline, name):
    as_baseline("other.npz", "baseline.npz")

def test_within_a_wide_tolerance(as_baseline):
    as_baseline("other.npz", "baseline.npz", tolerance_deg=400.0, ignore_inputs=True)
"""


@pytest.fixture(scope="module")
def folder(recordings, tmp_path_factory):
    made = tmp_path_factory.mktemp("suite")
    few = recordings[11:15]
    controller = learn_controller(few, n_components=2).controller
    controller.save(made / "controller.npz")
    write_baseline(record_baseline(controller), made / "baseline.npz")
    learn_controller(few, n_components=2, guided=False).controller.save(made / "other.npz")
    for place in (made, made / "more"):
        place.mkdir(exist_ok=True)
        (place / "test_it.py").write_text(TESTS)
    return made


def suite(folder: Path, *options: str) -> str:
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-p", "no:handsim",
               "-p", "handsim.testing.fixture", "--import-mode=importlib", *options]  # fmt: skip
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return done.stdout + done.stderr


@pytest.mark.parametrize("workers", [(), ("-n", "2")], ids=["alone", "two workers"])
def test_pages_are_kept_on_failure_and_each_test_has_its_own(folder, tmp_path, workers):
    pages = tmp_path / "pages"
    said = suite(folder, "--baseline-pages", str(pages), *workers)
    assert "4 failed, 2 passed" in said, said
    kept = sorted(pages.iterdir())
    assert len(kept) == 4 and all(page.suffix == ".html" for page in kept)
    assert all(page.read_text().rstrip().endswith("</html>") for page in kept)
    assert f"curves: {kept[0]}" in said


def test_without_a_folder_the_page_lies_with_the_tests_files(folder, tmp_path):
    said = suite(folder, "more/test_it.py", f"--basetemp={tmp_path / 'base'}")
    assert "2 failed, 1 passed" in said, said
    assert len(list((tmp_path / "base").rglob("test_it*.html"))) == 2


def test_options_are_named_as_on_the_command_line(folder, monkeypatch, tmp_path):
    monkeypatch.chdir(folder)
    page = tmp_path / "made" / "page.html"
    with pytest.raises(AssertionError, match=r"deg at .*\ncurves: .*page.html"):
        assert_as_baseline("other.npz", "baseline.npz", html=page)
    page.unlink()
    wide = {"tolerance_deg": 400.0, "ignore_inputs": True}
    assert assert_as_baseline("other.npz", "baseline.npz", html=page, **wide).ok
    assert not page.exists()
    with pytest.raises(InputError, match="give one of them"):
        assert_as_baseline("other.npz", "baseline.npz", tolerances=Tolerances(), tolerance_deg=1.0)


def test_a_page_that_cannot_be_written_hides_nothing(folder, monkeypatch):
    monkeypatch.chdir(folder)
    with pytest.raises(AssertionError, match=r"findings in[\s\S]*curves: none, .*is a folder"):
        assert_as_baseline("other.npz", "baseline.npz", html=folder / "more")


def test_names_of_pages_are_readable_and_of_one_test():
    names = [page_name(node, n) for node in ("a/test_x.py::test_y[q/1]", "b/test_x.py::test_y[q/1]")
             for n in (0, 1)]  # fmt: skip
    assert len(set(names)) == 4
    assert all("/" not in name and name.endswith(".html") for name in names)
