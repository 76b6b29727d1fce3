"""Files that the how-tos offer for other programs can be read by those, and name what there is."""

import re
import shlex
import shutil
import subprocess
import tomllib
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import pytest
import typer

from handsim.cli import app
from handsim.viewing.opengl.backend import _PACKAGES

CHECKOUT = Path(__file__).parents[1]
HOWTO = CHECKOUT / "docs" / "howto"
pytestmark = pytest.mark.skipif(not HOWTO.is_dir(), reason="no docs beside the tests")


def blocks_of(page: str, kind: str) -> list[str]:
    text = (HOWTO / page).read_text(encoding="utf-8")
    found = re.findall(rf"^```{kind}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert found, f"{page} shows no {kind}"
    return found


def check_understood(line: str) -> None:
    """Fail where a line calls a command or option that handsim does not have."""
    name, *words = shlex.split(line, comments=True)
    assert name == "handsim"
    command: Any = typer.main.get_command(app)
    while hasattr(command, "commands"):
        name, *words = words
        command = command.commands[name]
    command.make_context(name, words)


def test_the_workflow_is_read_and_its_command_understood() -> None:
    yaml = pytest.importorskip("yaml")
    (block,) = blocks_of("baseline.md", "yaml")
    flow = yaml.safe_load(block)
    assert flow[True] == ["push", "pull_request"]  # YAML 1.1 takes `on` for a truth value
    (job,) = flow["jobs"].values()
    assert job["env"] == {"OPENBLAS_NUM_THREADS": "1"}
    steps = job["steps"]
    assert all(("uses" in step) != ("run" in step) for step in steps)
    runs = [step["run"] for step in steps if "run" in step]
    check_understood(runs[-1])
    kept = next(step for step in steps if step.get("if") == "failure()")
    assert kept["with"]["path"] in shlex.split(runs[-1])
    version = next(s["with"]["python-version"] for s in steps if "setup-python" in s["uses"] + "")
    assert isinstance(version, str)  # 3.10 as a number would be 3.1


def instructions_of(dockerfile: str) -> list[tuple[str, str]]:
    joined = re.sub(r"\\\n\s*", " ", dockerfile)
    lines = [line.strip() for line in joined.splitlines() if line.strip()]
    return [(name, rest) for name, _, rest in (line.partition(" ") for line in lines)]


def test_the_image_installs_what_renders_and_the_wheel_that_is_built() -> None:
    (block,) = blocks_of("servers.md", "dockerfile")
    found = instructions_of(block)
    known = {"FROM", "RUN", "COPY", "USER", "ENV", "WORKDIR", "ENTRYPOINT", "CMD"}
    assert {name for name, _ in found} <= known
    assert found[0][0] == "FROM"
    runs = [rest for name, rest in found if name == "RUN"]
    assert _PACKAGES["apt-get"]["osmesa"] in shlex.split(runs[0])
    (environment,) = [rest for name, rest in found if name == "ENV"]
    assert "MUJOCO_GL=osmesa" in environment.split()
    (copied,) = [rest.split()[0] for name, rest in found if name == "COPY"]
    project = tomllib.loads((CHECKOUT / "pyproject.toml").read_text())["project"]
    assert fnmatch(f"dist/handsim-{project['version']}-py3-none-any.whl", copied)
    checks = [run for run in runs if run.startswith("handsim")]
    assert len(checks) == 1
    check_understood(checks[0])
    text = (HOWTO / "servers.md").read_text(encoding="utf-8")
    in_image = re.findall(r"^docker run .* (handsim .*)$", text, re.MULTILINE)
    assert len(in_image) == 2
    for line in in_image:
        check_understood(line)


def test_the_batch_script_is_read_by_bash_and_its_command_understood() -> None:
    (block,) = blocks_of("cluster.md", "bash")
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("no bash")
    done = subprocess.run([bash, "-n"], input=block, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    check_understood(next(line for line in block.splitlines() if line.startswith("handsim")))


def test_the_lines_for_dask_have_its_options() -> None:
    pytest.importorskip("distributed")
    from distributed.cli.dask_scheduler import main as scheduler
    from distributed.cli.dask_worker import main as worker

    text = (HOWTO / "cluster.md").read_text(encoding="utf-8")
    lines = re.findall(r"dask (scheduler|worker) ([^&\n]*)", text)
    assert len(lines) == 4
    for name, rest in lines:
        command = {"scheduler": scheduler, "worker": worker}[name]
        command.make_context(name, shlex.split(rest))
