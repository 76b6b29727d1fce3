"""Run the quick tests with each version of Python that the project states and that is found here.

    python tests/packaging/pythons.py [arguments for pytest, instead of all quick tests]

Each version has an environment of its own under ``out/pythons``, with the packages of
``requirements.lock``. Exit code 1: the tests failed with a version, or none was found. What is not
found is said; ``uv python install 3.12`` or pyenv bring it.
"""

import os
import subprocess
import sys
from pathlib import Path

from interpreters import ROOT, find_interpreter, stated_versions

QUICK = ("-m", "not slow", "--numprocesses", "auto", "--maxprocesses", "8", "--benchmark-disable")


def environment(version: str, interpreter: str) -> Path:
    """Make the environment of a version where there is none; return its Python."""
    folder = ROOT / "out" / "pythons" / version
    python, done = folder / "bin" / "python", folder / ".installed"
    lock = ROOT / "requirements.lock"
    if not done.exists() or done.stat().st_mtime < lock.stat().st_mtime:
        pip = (python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check")
        call(interpreter, "-m", "venv", "--clear", folder)
        call(*pip, "--require-hashes", "-r", lock)
        call(*pip, "--no-deps", "--no-build-isolation", "--editable", ROOT)
        done.touch()
    return python


def call(*command: object) -> None:
    subprocess.run([*map(str, command)], cwd=ROOT, check=True)


def main(arguments: list[str]) -> int:
    tests = arguments or [*QUICK, "tests"]
    found: dict[str, str] = {}
    for version in stated_versions():
        interpreter = find_interpreter(version)
        if interpreter is None:
            found[version] = "not found"
            continue
        python = environment(version, interpreter)
        threads = {"OPENBLAS_NUM_THREADS": os.environ.get("OPENBLAS_NUM_THREADS", "1")}
        command = [str(python), "-m", "pytest", *tests]
        code = subprocess.run(command, cwd=ROOT, env=os.environ | threads, check=False).returncode
        found[version] = "passed" if code == 0 else f"failed, pytest's exit code {code}"
    for version, verdict in found.items():
        print(f"Python {version}: {verdict}")
    tried = [verdict for verdict in found.values() if verdict != "not found"]
    return 0 if tried and all(verdict == "passed" for verdict in tried) else 1


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
