import json
import sys
from collections.abc import Callable
from dataclasses import dataclass

import pytest

from handsim.cli import main


@dataclass
class Result:
    code: int
    out: str
    err: str

    def json(self) -> dict:
        return json.loads(self.out)


@pytest.fixture
def run(monkeypatch, capsys) -> Callable[..., Result]:
    """Run the command line in this process."""

    def _run(*args: object) -> Result:
        monkeypatch.setattr(sys, "argv", ["handsim", *map(str, args)])
        with pytest.raises(SystemExit) as ended:
            main()
        captured = capsys.readouterr()
        code = ended.value.code
        return Result(0 if code is None else int(code), captured.out, captured.err)

    return _run
