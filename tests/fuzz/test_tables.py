"""Recordings and postures: CSV files of strangers."""

import shutil

from hypothesis import strategies as st

from handsim.files import data_folder

from .conftest import Sandbox, damaged_bytes, damaged_table, search

EXPERIMENTS = data_folder("assets") / "experiments"
NAME = "cube-raise.csv"
POSTURES = "\n".join((EXPERIMENTS / NAME).read_text().splitlines()[:40]) + "\n"
INDEX = (EXPERIMENTS / "experiments.csv").read_text()
ONE = next(line for line in INDEX.splitlines() if line.startswith(NAME))
INDEX_OF_ONE = "\n".join([INDEX.splitlines()[0], ONE]) + "\n"


def write(sandbox: Sandbox, postures: str | bytes, index: str | bytes) -> None:
    sandbox.fresh()
    for name, content in ((NAME, postures), ("experiments.csv", index)):
        data = content.encode() if isinstance(content, str) else content
        (sandbox.inputs / name).write_bytes(data)


def test_postures_with_damaged_cells(sandbox):
    def check(postures: bytes) -> None:
        write(sandbox, postures, INDEX_OF_ONE)
        sandbox.run("recordings", "info", sandbox.inputs, "--json")

    search(check, damaged_table(POSTURES), 60 * sandbox.cases)
    assert {0, 2} <= set(sandbox.codes)


def test_postures_with_damaged_bytes(sandbox):
    def check(postures: bytes) -> None:
        write(sandbox, postures, INDEX_OF_ONE)
        goal = sandbox.inputs / NAME
        sandbox.run("postures", "--goal", goal, "-o", sandbox.outputs / "p.csv")

    search(check, damaged_bytes(POSTURES.encode()), 40 * sandbox.cases)
    assert {0, 2} <= set(sandbox.codes)


def test_damaged_index(sandbox):
    def check(index: bytes) -> None:
        write(sandbox, POSTURES, index)
        sandbox.run("recordings", "info", sandbox.inputs)

    search(check, damaged_table(INDEX_OF_ONE), 60 * sandbox.cases)
    assert {0, 2} <= set(sandbox.codes)


def test_learning_from_what_is_left(sandbox):
    """Values that pass the reader must not trip the learner."""

    def check(postures: bytes) -> None:
        write(sandbox, postures, INDEX_OF_ONE)
        sandbox.run("learn", sandbox.inputs, "-o", sandbox.outputs / "c.npz", "--components", 2)

    search(check, damaged_table(POSTURES), 6 * sandbox.cases)


def test_folders_and_links_in_place_of_files(sandbox):
    def check(kinds: tuple[str, str]) -> None:
        write(sandbox, POSTURES, INDEX_OF_ONE)
        for name, kind in zip((NAME, "experiments.csv"), kinds, strict=True):
            path = sandbox.inputs / name
            if kind == "kept":
                continue
            path.unlink()
            if kind == "folder":
                path.mkdir()
            elif kind == "loop":
                path.symlink_to(path)
            elif kind == "dangling":
                path.symlink_to("nowhere")
            elif kind == "device":
                path.symlink_to("/dev/zero")
        sandbox.run("recordings", "info", sandbox.inputs)

    kinds = st.sampled_from(["kept", "gone", "folder", "loop", "dangling", "device"])
    search(check, st.tuples(kinds, kinds), 20)
    shutil.rmtree(sandbox.inputs)
