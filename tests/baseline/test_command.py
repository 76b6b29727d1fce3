"""`handsim baseline check` says what is wrong in one line and overwrites nothing."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from handsim.baseline.environment import Environment
from handsim.baseline.store import SCHEMA, read_baseline, write_baseline
from handsim.files import read_archive, write_archive


@pytest.fixture
def run(monkeypatch, capsys):
    """Run the command line in this process; return its code and what it said."""
    from handsim.cli import main

    def _run(*args: object) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["handsim", *map(str, args)])
        with pytest.raises(SystemExit) as ended:
            main()
        said = capsys.readouterr()
        return int(ended.value.code or 0), said.out, said.err

    return _run


@pytest.fixture
def files(movements, controller, tmp_path) -> tuple[Path, Path]:
    """A baseline of two movements, and its controller."""
    names = list(movements.cases.starts)[:2]
    cases = replace(
        movements.cases,
        starts={name: movements.cases.starts[name] for name in names},
        goals={name: movements.cases.goals[name] for name in names},
    )
    traces = {f"movement/{n}": movements.results.traces[f"movement/{n}"] for n in names}
    small = replace(movements, cases=cases, results=replace(movements.results, traces=traces))
    write_baseline(small, tmp_path / "b.npz")
    controller.save(tmp_path / "c.npz")
    return tmp_path / "b.npz", tmp_path / "c.npz"


def test_as_it_was(run, files):
    code, out, _ = run("baseline", "check", files[0], "--controller", files[1])
    assert (code, out) == (0, "2 answers as in the baseline\n")


def test_another_environment_is_said_first(run, files):
    path, controller = files
    kept = read_baseline(path)
    name, trace = next(iter(kept.results.traces.items()))
    traces = kept.results.traces | {name: replace(trace, q=trace.q + np.deg2rad(0.01))}
    elsewhere = replace(Environment.here(), blas_kernel="Z80")
    write_baseline(
        replace(kept, environment=elsewhere, results=replace(kept.results, traces=traces)), path
    )
    code, out, _ = run("baseline", "check", path, "--controller", controller)
    first, second, third = out.splitlines()
    assert code == 1
    assert first.startswith("environment: BLAS kernel Z80 in the baseline, ")
    assert second == "1 finding in 2 answers, worst first"
    assert third.startswith(f"environment {name}  a difference of environment: BLAS kernel Z80 in")
    code, out, _ = run("baseline", "check", path, "--controller", controller, "--json")
    said = json.loads(out)
    assert set(said) == {"ok", "environment", "findings", "causes", "notes", "answers"}
    assert said["environment"]["before"]["blas_kernel"] == "Z80"
    assert len(said["environment"]["differences"]) == 1
    assert said["findings"][0]["kind"] == "environment"
    loose = ("--tolerance-deg", "0.02")
    assert run("baseline", "check", path, "--controller", controller, *loose)[0] == 0


@pytest.mark.parametrize("option", ["--tolerance-deg", "--grasp-tolerance-deg"])
@pytest.mark.parametrize("value", ["-1", "nan", "inf"])
def test_tolerances_that_are_none(run, files, option, value):
    code, out, err = run("baseline", "check", files[0], option, value)
    assert (code, out) == (2, "")
    assert err.startswith("handsim: tolerance ")
    assert err.count("\n") == 1


@pytest.mark.parametrize("what", ["posture", "time", "measures", "plans"])
@pytest.mark.parametrize("update", [(), ("--update", "it is better")])
def test_a_baseline_that_cannot_be_compared_with(run, files, what, update):
    path, controller = files
    metadata, arrays = read_archive(path, "baseline", SCHEMA)
    del metadata["kind"], metadata["schema"]
    if what == "posture":
        arrays["q_1"][3, 4] = np.nan
    elif what == "time":
        arrays["time_1"][-1] = np.inf
    elif what == "measures":
        del metadata["traces"][1]["measures"]
    else:
        metadata["plans"] = [{}]
    write_archive(path, "baseline", SCHEMA, metadata, arrays)
    kept = path.read_bytes()
    code, out, err = run("baseline", "check", path, "--controller", controller, *update)
    assert (code, out) == (2, "")
    assert err.startswith(f"handsim: {path}: not a whole baseline (")
    assert err.count("\n") == 1
    assert path.read_bytes() == kept


def test_answers_that_are_no_numbers_do_not_become_right(run, files, monkeypatch):
    path, controller = files
    kept = path.read_bytes()
    real = read_baseline(path).results

    def answers(*_, **__):
        name, trace = next(iter(real.traces.items()))
        return replace(real, traces=real.traces | {name: replace(trace, q=trace.q * np.nan)})

    monkeypatch.setattr("handsim.baseline.check.run_cases", answers)
    code, out, err = run("baseline", "check", path, "--controller", controller, "--update", "new")
    assert code == 1
    assert "number " in out
    assert err.startswith("handsim: movement/")
    assert err.endswith(f"{path} stays as it was\n")
    assert err.count("\n") == 1
    assert path.read_bytes() == kept


def test_an_update_is_kept_with_its_environment(run, files):
    path, controller = files
    write_baseline(replace(read_baseline(path), environment=Environment(), handsim="0.0.1"), path)
    code, out, err = run("baseline", "check", path, "--controller", controller, "--update", "new")
    assert (code, err) == (0, f"updated {path}\n")
    assert out.startswith("environment: the baseline does not say of which processor, ")
    after = read_baseline(path)
    assert after.environment == Environment.here()
    assert after.reasons == ("recorded", "new")
