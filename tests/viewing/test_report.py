"""The page is read as a program reads it, and opened in a browser where there is one."""

import base64
import dataclasses
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.demonstrator import demonstrate
from handsim.learning.controller import GraspController
from handsim.learning.learn import learn_controller
from handsim.learning.scores import evaluate
from handsim.recordings.folder import read_recordings
from handsim.recordings.recording import RecordingSet
from handsim.tasks.table_one import task_by_name
from handsim.viewing import html as page
from handsim.viewing.report import write_report

pytestmark = [pytest.mark.ci, pytest.mark.slow]

HOSTILE = "<script>alert('&')</script>"
SECTIONS = [
    *("verdict", "grasps", "figures", "scores", "forces", "data", "certificate", "subspace"),
    "making",
]


class Reader(HTMLParser):
    """Tags with their attributes, and the text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.words = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in ("meta", "link", "img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words += data

    def attributes(self, name: str) -> list[str]:
        return [
            value or "" for _, found in self.tags for key, value in found.items() if key == name
        ]


@pytest.fixture(scope="module")
def recordings() -> RecordingSet:
    few = list(read_recordings(data_folder("assets") / "experiments"))[:2]
    return RecordingSet((dataclasses.replace(few[0], object=HOSTILE), few[1]))


@pytest.fixture(scope="module")
def controller(recordings: RecordingSet) -> GraspController:
    return learn_controller(recordings, n_components=2).controller


@pytest.fixture(scope="module")
def written(
    rendering: str,
    recordings: RecordingSet,
    controller: GraspController,
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    held = demonstrate(task_by_name("cube-raise"), Conditions())
    failed = dataclasses.replace(
        held,
        task="jar-move",
        outcome=dataclasses.replace(held.outcome, success=False, reason="slipped"),
    )
    path = tmp_path_factory.mktemp("report") / "report.html"
    done: list[float] = []
    write_report(path, controller, recordings, (held, failed), ("handsim a 'b'",), done.append)
    assert done == sorted(done)
    assert done[-1] == pytest.approx(1.0)
    assert [p.name for p in path.parent.iterdir()] == ["report.html"]
    return path


@pytest.fixture(scope="module")
def read(written: Path) -> Reader:
    return Reader(written.read_text())


def test_nothing_is_fetched_from_elsewhere(read: Reader, written: Path) -> None:
    addresses = [a for name in ("src", "href", "poster") for a in read.attributes(name)]
    assert len(addresses) > 15
    assert all(a.startswith(("data:", "#")) for a in addresses)
    style = written.read_text().partition("</style>")[0]
    assert "url(" not in style
    assert "@import" not in style
    assert not {"script", "iframe", "object", "embed"} & {tag for tag, _ in read.tags}
    assert 0.3e6 < written.stat().st_size < 6e6


def test_every_tag_is_closed_and_every_section_is_there_and_linked(read: Reader) -> None:
    assert read.open == []
    assert [a["id"] for tag, a in read.tags if tag == "section"] == SECTIONS
    assert [a["href"] for tag, a in read.tags if tag == "a"] == [f"#{s}" for s in SECTIONS]


def test_verdict_videos_and_figures_come_before_tables(read: Reader) -> None:
    tags = [tag for tag, _ in read.tags]
    pictures = [i for i, (tag, found) in enumerate(read.tags) if tag == "img" and found["alt"]]
    videos = [i for i, tag in enumerate(tags) if tag == "video"]
    assert tags.index("ul") < min(videos)
    assert max(videos) < min(pictures)
    assert max(pictures) < tags.index("table")
    assert ("Proven: from everywhere" in read.words) != ("Not proven: " in read.words)


def test_what_comes_from_files_is_text(read: Reader) -> None:
    assert HOSTILE in read.words
    assert "handsim a 'b'" in read.words


def test_numbers_are_those_of_the_evaluation(
    read: Reader, controller: GraspController, recordings: RecordingSet
) -> None:
    scores = evaluate(controller, recordings)
    assert f"{scores.path_error_deg:.1f}°" in read.words
    for row in scores.per_recording:
        assert f"{row['name']}yes{row['path_error_deg']:.1f}" in read.words
    assert "cube-raiseyes" in read.words
    assert "jar-movenoslipped" in read.words
    assert "learned from 2 of these 2 recordings." in read.words
    assert "cube-raise: success" in read.words
    assert "jar-move: failed, slipped" in read.words
    assert "1 of 2grasps succeed" in read.words


def test_videos_decode_and_figures_are_svg(
    read: Reader, read_video: Callable, tmp_path: Path
) -> None:
    videos = [a["src"] for tag, a in read.tags if tag == "video"]
    assert len(videos) == 2
    for i, address in enumerate(videos):
        kind, _, content = address.partition(";base64,")
        assert kind == "data:video/mp4"
        path = tmp_path / f"{i}.mp4"
        path.write_bytes(base64.b64decode(content, validate=True))
        _, frames = read_video(path)
        assert len(frames) > 50
        assert frames[0].shape == (270, 360, 3)
        assert np.ptp(frames[-1]) > 100
    figures = [a["src"] for tag, a in read.tags if tag == "img" and a["alt"]]
    assert len(figures) == 8
    for address in figures:
        kind, _, content = address.partition(";base64,")
        assert kind == "data:image/svg+xml"
        assert b"<svg" in base64.b64decode(content)[:500]


def test_a_page_without_grasps_says_so(
    rendering: str, controller: GraspController, recordings: RecordingSet, tmp_path: Path
) -> None:
    line = learn_controller(recordings, n_components=1).controller  # has no planes to slice
    path = tmp_path / "line.html"
    write_report(path, line, recordings)
    read = Reader(path.read_text())
    assert "No grasp was simulated" in read.words and "Grasps in numbers" not in read.words
    assert len([a for tag, a in read.tags if tag == "img"]) == 6


def test_table_aligns_text_and_escapes() -> None:
    made = page.table(("a", "b"), [("<x>", True), ("y", "1")])
    assert '<td class="text">&lt;x&gt;</td><td class="good">yes</td>' in made
    assert '<td class="text">y</td><td>1</td>' in made


def test_a_browser_shows_it_whole_wide_and_narrow(written: Path, browser, tmp_path: Path) -> None:
    browser.visit(written.as_uri())
    for width in (1200, 390):
        browser.resize(width, 900)
        assert browser.evaluate("document.documentElement.scrollWidth") <= width
        picture = browser.screenshot(tmp_path / f"{width}.png")
        assert picture.shape[1] == width
        assert np.ptp(picture) > 200
    tiles = "[...document.querySelectorAll('.tiles li')]"
    assert browser.evaluate(f"{tiles}.every(one => one.scrollWidth <= one.clientWidth)")
    shown = "[...document.images].every(one => one.complete && one.naturalWidth > 0)"
    assert browser.evaluate(shown)
    playing = (
        "[...document.querySelectorAll('video')].map(one => one.play().then(() => one.videoWidth))"
    )
    assert browser.evaluate(f"Promise.all({playing})") == [360, 360]
    assert browser.requests() == [written.as_uri()]
    assert browser.complaints() == []
