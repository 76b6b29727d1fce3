"""Arithmetic of single roundings: what it is worth, and that no fit escapes from it."""

import ast
from fractions import Fraction
from math import fsum
from pathlib import Path

import numpy as np
import pytest

import handsim
from handsim.reproducible import (
    dot,
    dots,
    exact_product,
    exp,
    log,
    lower_solved,
    mean,
    norms,
    powers,
    product,
    total,
    total_of,
    totals_of,
    units,
    upper_solved,
)

RNG = np.random.default_rng(0)
ULP = np.finfo(float).eps


@pytest.mark.parametrize("n", [0, 1, 2, 3, 7, 64, 1000, 4097])
def test_totals_are_sums(n: int) -> None:
    x = RNG.normal(size=n)
    assert float(total(x)) == pytest.approx(fsum(x), abs=1e-13)
    table = RNG.normal(size=(3, n, 2))
    np.testing.assert_allclose(total(table, 1), table.sum(axis=1), atol=1e-12)
    np.testing.assert_allclose(total(table, -1), table.sum(axis=2), atol=1e-12)


@pytest.mark.parametrize("n", [0, 1, 2, 3, 5, 7, 22, 64])
def test_totals_of_numbers_have_the_same_bits(n: int) -> None:
    x = RNG.normal(size=n) * 10.0 ** RNG.uniform(-8, 8, n)
    kept = x.tolist()
    assert total_of(kept) == float(total(x))
    assert kept == x.tolist()
    table = np.outer(x, [1.0, -3.0])
    np.testing.assert_array_equal(total_of(list(table)), total(table))


@pytest.mark.parametrize("n", [1, 2, 3, 5, 7, 22, 64])
@pytest.mark.parametrize("width", [1, 3, 5])
def test_totals_of_rows_of_numbers_have_the_same_bits(n: int, width: int) -> None:
    table = RNG.normal(size=(n, width)) * 10.0 ** RNG.uniform(-8, 8, (n, width))
    kept = table.ravel().tolist()
    np.testing.assert_array_equal(totals_of(kept, width), total(table))
    assert kept == table.ravel().tolist()


def test_totals_leave_their_input_alone_and_have_a_written_order() -> None:
    x = np.array([1.0, 2.0, 4.0, 1e16, 3.0])
    kept = x.copy()
    assert float(total(x)) == ((1.0 + 4.0) + 3.0) + (2.0 + 1e16)
    np.testing.assert_array_equal(x, kept)


@pytest.mark.parametrize("n", [0, 1, 2, 3, 7, 15, 16, 17, 31, 33, 64, 1000, 1573, 4097])
def test_scalar_products_add_as_totals_do(n: int) -> None:
    a, b = RNG.normal(size=(2, n))
    kept = a.copy(), b.copy()
    assert dot(a, b) == float(total(a * b))
    np.testing.assert_array_equal((a, b), kept)


def test_products_of_vectors_and_matrices() -> None:
    a, b = RNG.normal(size=(5, 3, 4)), RNG.normal(size=(5, 4, 2))
    np.testing.assert_allclose(product(a, b), a @ b, atol=1e-14)
    x, y = RNG.normal(size=(6, 3)), RNG.normal(size=(6, 3))
    np.testing.assert_allclose(dots(x, y), np.einsum("ij,ij->i", x, y), atol=1e-14)
    np.testing.assert_allclose(norms(x)[:, 0], np.linalg.norm(x, axis=1), rtol=1e-15)
    assert dot(x[0], y[0]) == pytest.approx(float(x[0] @ y[0]), abs=1e-14)
    np.testing.assert_allclose(mean(x), x.mean(axis=0), atol=1e-15)
    x[2] = 0.0
    lengths = np.linalg.norm(units(x), axis=1)
    assert lengths[2] == 0 and np.delete(lengths, 2) == pytest.approx(1.0, abs=1e-15)


def test_triangles_are_solved() -> None:
    lower = np.tril(RNG.normal(size=(6, 6))) + 3 * np.eye(6)
    b = RNG.normal(size=(6, 2))
    np.testing.assert_allclose(lower @ lower_solved(lower, b), b, atol=1e-13)
    np.testing.assert_allclose(lower.T @ upper_solved(lower.T, b), b, atol=1e-13)


def test_exp_and_log_are_right_to_two_units_in_the_last_place() -> None:
    x = np.concatenate([RNG.uniform(-700, 700, 2000), RNG.uniform(-2, 2, 2000), [0.0, 1.0, -1.0]])
    np.testing.assert_allclose(exp(x), np.exp(x), rtol=2 * ULP)
    assert exp(np.array([0.0]))[0] == 1.0
    assert exp(np.array([-1e4]))[0] == pytest.approx(0.0, abs=1e-300)
    y = np.concatenate([np.exp(RNG.uniform(-700, 700, 2000)), RNG.uniform(0.5, 2, 2000), [1.0]])
    np.testing.assert_allclose(log(y), np.log(y), rtol=2 * ULP, atol=ULP)
    assert log(np.array([1.0]))[0] == 0.0
    np.testing.assert_allclose(powers(y[2000:], 1.7), y[2000:] ** 1.7, rtol=1e-12)
    assert powers(np.array([0.0, 4.0]), 0.5) == pytest.approx([0.0, 2.0], rel=1e-15)


def test_exact_products_are_exact_whatever_the_order() -> None:
    weights, values = RNG.uniform(0, 1, (4, 3000)), RNG.normal(size=(3000, 5))
    result = exact_product(weights, values)
    assert np.abs(result - weights @ values).max() < 3000 * 2.0**-15
    order = RNG.permutation(3000)
    np.testing.assert_array_equal(exact_product(weights[:, order], values[order]), result)
    # Exactly: the sum of the rounded terms as fractions.
    a = np.rint(weights[0] * 2.0**16) / 2.0**16
    exponent = int(np.frexp(np.abs(values).max())[1])
    b = np.rint(np.ldexp(values[:, 0], 22 - exponent))
    whole = sum(Fraction(float(p)) * int(q) for p, q in zip(a, b, strict=True))
    assert Fraction(float(result[0, 0])) == whole * Fraction(2) ** (exponent - 22)


OURS = (
    "navigation/_bernstein", "navigation/certificate", "navigation/metric", "navigation/paths",
    "navigation/flow", "learning/fit/designs", "learning/fit/direction_cost",
    "learning/direction/change_bounds", "learning/guide/choice", "learning/guide/gaussian_process",
    "learning/fit/field_samples", "learning/fit/history", "learning/fit/lbfgs",
    "learning/fit/smoothness", "learning/direction/averaging", "learning/direction/descent",
    "learning/direction/learner", "learning/direction/metric_model", "learning/direction/samples",
    "learning/fit/level", "learning/general/band", "learning/general/candidates",
    "learning/general/refinement", "learning/general/potential", "navigation/proof/destination",
    "navigation/proof/polynomials", "navigation/proof/separation",
    "learning/pde/learner", "learning/pde/problem", "reproducible",
)  # fmt: skip
"""Modules that a fit goes through."""
ELSEWHERE = {"linalg", "einsum", "dot", "matmul", "tensordot", "inner", "vdot", "exp", "log",
             "log1p", "expm1", "sinh", "cosh", "tanh", "sin", "cos", "tan", "power", "hypot",
             "interp", "optimize", "sparse"}  # fmt: skip
"""Names under numpy and scipy whose last bit is the processor's."""
REDUCTIONS = {"sum", "mean", "var", "std", "prod", "trace", "cumprod"}
"""Functions and methods that add in an order of their own."""


def rounds_once(power: ast.BinOp) -> bool:
    """Say whether a power is a square, or one of whole numbers or fractions by their names."""
    square = isinstance(power.right, ast.Constant) and power.right.value == 2
    parts = [node for node in ast.walk(power.left) if not isinstance(node, ast.Load)]
    numbers = all(isinstance(node.value, int) for node in parts if isinstance(node, ast.Constant))
    names = {node.attr for node in parts if isinstance(node, ast.Attribute)}
    owners = [node.value for node in parts if isinstance(node, ast.Attribute)]
    names |= {node.id for node in parts if isinstance(node, ast.Name) and node not in owners}
    return square or (numbers and names <= {"degree", "exact_number"})


def escapes(source: str) -> list[str]:
    """Return what in a module may round otherwise on another processor, with its line."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
            found.append(f"@ in line {node.lineno}")
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow) and not rounds_once(node):
            found.append(f"** in line {node.lineno}")
        if isinstance(node, ast.Attribute):
            of_numpy = isinstance(node.value, ast.Name) and node.value.id in ("np", "scipy")
            if node.attr in REDUCTIONS or (of_numpy and node.attr in ELSEWHERE):
                found.append(f"{node.attr} in line {node.lineno}")
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("scipy"):
            found += [f"{a.name} in line {node.lineno}" for a in node.names if a.name in ELSEWHERE]
    return found


@pytest.mark.parametrize("module", OURS)
def test_fits_stay_inside_reproducible_arithmetic(module: str) -> None:
    allowed = {"@"} if module == "reproducible" else set()  # there of integers, exact
    source = (Path(handsim.__file__).parent / f"{module}.py").read_text()
    found = [escape for escape in escapes(source) if escape.partition(" ")[0] not in allowed]
    assert not found


def test_what_would_escape_is_seen() -> None:
    seen = escapes(
        "from scipy import sparse\nx = np.exp(a) @ b\ny = np.linalg.norm(x)\nz = y.sum()\n"
        "v = x**2 + (basis.degree + 1) ** i\nw = x**i\n"
    )
    names = [one.partition(" ")[0] for one in seen]
    assert set(names) == {"@", "sparse", "exp", "linalg", "sum", "**"}
    assert "** in line 6" in seen
    assert names.count("**") == 1
