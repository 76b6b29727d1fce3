"""The first hour of a new user: a fresh wheel in an empty folder, 41 commands, each as it comes."""

import json
import os
import shlex
import subprocess
import sys
import sysconfig
import tomllib
from pathlib import Path
from threading import Thread
from time import perf_counter

import numpy as np
import pytest
import trimesh

from handsim.joints import JOINTS

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
COMMANDS = tomllib.loads((HERE / "first_hour.toml").read_text())["command"]
LONGEST_SILENCE = 10.0
"""Between two signs of life [s], where the processors have nothing else to do."""
KEPT = ("PATH", "HOME", "XDG_CACHE_HOME", "OPENBLAS_NUM_THREADS")

pytestmark = [pytest.mark.slow, pytest.mark.timeout(3000)]


@pytest.fixture(scope="module")
def handsim(tmp_path_factory) -> Path:
    """The command of a fresh environment, which sees this one's libraries but no checkout."""
    folder = tmp_path_factory.mktemp("fresh")
    for command in (
        (sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", folder / "dist"),
        (sys.executable, "-m", "venv", "--without-pip", folder / "env"),
    ):
        subprocess.run([*map(str, command)], cwd=ROOT, check=True, capture_output=True)
    (wheel,) = (folder / "dist").glob("*.whl")
    python = folder / "env" / "bin" / "python"
    subprocess.run(
        [sys.executable, "-m", "pip", "--python", str(python), "install", "--no-deps",
         "--no-index", "--quiet", "--disable-pip-version-check", str(wheel)],
        check=True, capture_output=True,
    )  # fmt: skip
    (own,) = (folder / "env" / "lib").glob("python*/site-packages")
    (own / "shared.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return python.with_name("handsim")


def bring(folder: Path) -> None:
    """Make the files that the user brings."""
    trimesh.creation.box((0.05, 0.05, 0.05)).export(folder / "cube.stl")
    time = np.arange(0.0, 1.2, 0.01)
    way = np.clip(time / 1.0, 0.0, 1.0)
    way = way**3 * (10 - 15 * way + 6 * way**2)
    ends = [0.4 * min(joint.upper_deg, 60.0) for joint in JOINTS]
    table = np.column_stack([time, *(way * end for end in ends)])
    names = ",".join(["time_s", *(f"{joint.name}_deg" for joint in JOINTS)])
    np.savetxt(folder / "table.csv", table, "%.5f", ",", header=names, comments="")
    signal = np.column_stack([time, way])
    np.savetxt(folder / "signal.csv", signal, "%.4f", ",", header="time_s,value", comments="")
    hand = ROOT / "tests" / "retargeting" / "data" / "four_finger_hand.xml"
    (folder / "hand.xml").write_text(hand.read_text())
    (folder / "sweep.toml").write_text(
        'tasks = ["cube-raise"]\ncontrollers = ["demonstrator"]\nseeds = 2\n'
    )


def run(handsim: Path, line: str, folder: Path) -> tuple[int, str, str, float]:
    """Run a command; return code, output, errors and the longest silence [s]."""
    environment = {name: os.environ[name] for name in KEPT if name in os.environ}
    heard, said = [perf_counter()], ([], [])

    def listen(stream, lines) -> None:
        for each in stream:
            lines.append(each)
            heard.append(perf_counter())

    with subprocess.Popen(
        [handsim, *shlex.split(line)], cwd=folder, env=environment,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1,
    ) as process:  # fmt: skip
        streams = (process.stdout, process.stderr)
        listeners = [Thread(target=listen, args=each) for each in zip(streams, said, strict=True)]
        for each in listeners:
            each.start()
        for each in listeners:
            each.join()
        code = process.wait()
    heard.append(perf_counter())
    return code, "".join(said[0]), "".join(said[1]), float(np.diff(np.sort(heard)).max())


def first_hour(handsim: Path, folder: Path, commands: list[dict]) -> None:
    bring(folder)
    wrong: list[str] = []
    for command in commands:
        code, out, err, silence = run(handsim, command["line"], folder)
        wanted = command.get("code", 0)
        if code != wanted:
            wrong.append(f"{command['line']}: exit code {code}, not {wanted}: {err[-500:]}")
        if "Traceback" in out + err or "Warning" in err:
            wrong.append(f"{command['line']}: {err[-800:]}")
        if wanted == 2 and (out or err.count("\n") != 1):
            wrong.append(f"{command['line']}: more than one line: {out}{err}")
        busy = os.getloadavg()[0] / (os.cpu_count() or 1)
        if silence > LONGEST_SILENCE * max(1.0, busy):
            wrong.append(f"{command['line']}: {silence:.0f} s without a word")
        if command.get("json"):
            try:
                json.loads(out)
            except ValueError as error:
                wrong.append(f"{command['line']}: {error}")
    assert not wrong, "\n".join(wrong)


def test_there_are_forty_commands_and_each_kind_is_among_them() -> None:
    lines = [command["line"] for command in COMMANDS]
    assert len(lines) >= 40
    kinds = "doctor tasks objects hands learn evaluate certify postures drive grasp render sweep"
    of_two = ("hand build", "hand inspect", "object check", "recordings import", "baseline check")
    for word in (*kinds.split(), *of_two, "figures", "report", "baseline record"):
        assert any(line.startswith(word) for line in lines), word


@pytest.mark.ci
def test_the_first_minutes(handsim, tmp_path) -> None:
    first_hour(handsim, tmp_path, [command for command in COMMANDS if command.get("quick")])


def test_the_first_hour(handsim, tmp_path) -> None:
    first_hour(handsim, tmp_path, COMMANDS)
