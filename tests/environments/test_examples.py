"""The examples run, in a shortened form, and do what they say."""

import contextlib
import io
from pathlib import Path

import pytest

pytest.importorskip("gymnasium", reason="comes with handsim[gym]")


def test_a_residual_is_trained_in_at_most_sixty_lines(script, monkeypatch):
    example = script("notebooks/examples/residual_on_controller.py")
    assert len(Path(example.__file__).read_text().splitlines()) <= 60
    seeds = []
    usual = example.grasped

    def grasped(env, weights, seed):
        seeds.append((seed, bool(weights.any())))
        return usual(env, weights, seed)

    monkeypatch.setattr(example, "grasped", grasped)
    with contextlib.redirect_stdout(io.StringIO()) as said:
        best, alone, known = example.train("mouse-left-click", generations=1, n_seeds=1, popsize=3)
    assert seeds == [(1, False), *[(1, True)] * 3]
    assert best.shape == (3, 14)
    assert known >= alone > 0.0
    assert (known > alone) == bool(best.any())
    assert "generation 1: best" in said.getvalue()


def test_the_controller_is_evaluated_over_tasks_and_seeds(script):
    example = script("notebooks/examples/evaluate_controller.py")
    assert example.verdicts("cup-top-move", 1) == [(0, "held"), (1, "held")]
