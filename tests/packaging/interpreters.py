"""Interpreters of the versions of Python that the project is for."""

import re
import shutil
import subprocess
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def stated_versions() -> list[str]:
    """The versions that ``pyproject.toml`` states, such as 3.12."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    text = "\n".join(project["classifiers"])
    return re.findall(r"^Programming Language :: Python :: (3\.\d+)$", text, re.MULTILINE)


def find_interpreter(version: str) -> str | None:
    """A Python of a version: on the path, among those of pyenv, or among those of uv."""
    home = Path.home()
    installed = [
        *sorted(home.glob(f".pyenv/versions/{version}.*/bin/python")),
        *sorted(home.glob(f".local/share/uv/python/cpython-{version}.*/bin/python3")),
    ]
    for candidate in (shutil.which(f"python{version}"), *map(str, installed)):
        if candidate is None:
            continue
        asked = (candidate, "-c", "import sys; print('%d.%d' % sys.version_info[:2])")
        done = subprocess.run(asked, capture_output=True, text=True, check=False)
        if done.stdout.strip() == version:
            return candidate
    return None
