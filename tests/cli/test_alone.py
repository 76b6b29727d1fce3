"""What `handsim` says where nothing is asked of it but who it is."""

import json
import platform
import subprocess
import sys
from importlib.metadata import version

import pytest

GROUPS = {"hand": "build", "object": "check", "recordings": "import", "baseline": "record"}


@pytest.mark.parametrize(
    ("words", "command"), [((), "grasp"), *(((g,), c) for g, c in GROUPS.items())]
)
def test_a_group_alone_shows_its_commands(run, words, command):
    result = run(*words)
    assert (result.code, result.err) == (0, "")
    assert result.out.startswith(" ".join(["Usage: handsim", *words, "[OPTIONS]"]))
    assert f"\n  {command} " in result.out
    assert result.out == run(*words, "--help").out


@pytest.mark.parametrize("group", ["", *GROUPS])
def test_what_commands_do_is_said_to_the_end_on_80_columns(run, monkeypatch, group):
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("TERMINAL_WIDTH", "80")
    listed = run(*group.split()).out.split("Commands:")[1]
    assert "..." not in listed
    assert max(map(len, listed.splitlines())) <= 80


@pytest.mark.parametrize("group", GROUPS)
def test_a_group_with_a_command_that_is_none_is_refused(run, group):
    result = run(group, "nonsense")
    assert (result.code, result.out) == (2, "")
    assert "No such command 'nonsense'" in result.err


def test_the_version_is_one_line(run):
    result = run("--version")
    assert (result.code, result.err) == (0, "")
    versions = f"(MuJoCo {version('mujoco')}, Python {platform.python_version()})"
    assert result.out == f"handsim {version('handsim')} {versions}\n"


def test_the_version_is_said_at_once():
    code = (
        "import sys; sys.argv = ['handsim', '--version']; import handsim.cli\n"
        "try: handsim.cli.main()\n"
        "except SystemExit: pass\n"
        "heavy = {'mujoco', 'numpy', 'sklearn', 'scipy', 'matplotlib', 'trimesh'}\n"
        "sys.exit(','.join(heavy & set(sys.modules)) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("handsim ")


def imported_by(code: str) -> set[str]:
    """What a process has imported when it has run some code."""
    code = f"import json, sys\n{code}\nsys.stderr.write(json.dumps(list(sys.modules)))"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(json.loads(ran.stderr.splitlines()[-1]))


@pytest.mark.parametrize(
    ("done", "not_needed"),
    [
        ("import handsim.cli.defaults", {"scipy", "handsim.learning", "handsim.recordings"}),
        (
            "import handsim\n"
            "handsim.read_recordings(handsim.data_folder('assets') / 'experiments')",
            {"scipy", "handsim.learning"},
        ),
    ],
)
def test_what_is_not_needed_is_not_imported(done: str, not_needed: set[str]):
    assert not not_needed & imported_by(done)


HEAVY = {"scipy", "mujoco", "sklearn", "matplotlib", "imageio", "joblib", "trimesh", "rich.table"}


@pytest.mark.parametrize(
    ("command", "more"),
    [
        ("tasks", set()),
        ("objects", set()),
        ("hands", set()),
        ("recordings info", {"handsim.learning"}),
        ("recordings info --json", {"handsim.learning"}),
        ("evaluate", set()),
        ("postures --task cube-raise -o postures.csv", set()),
        ("drive --help", {"numpy"}),
        ("learn", {"numpy"}),
    ],
)
def test_commands_that_should_answer_at_once_import_little(tmp_path, command, more):
    """`python -m tests.benchmarks.startup` measures their CPU time."""
    code = (
        f"import os; os.chdir({str(tmp_path)!r}); sys.argv = ['handsim', *{command!r}.split()]\n"
        "import handsim.cli\n"
        "try: handsim.cli.main()\n"
        "except SystemExit: pass"
    )
    assert not (HEAVY | more) & imported_by(code)
