"""`handsim sweep`: many grasps into one table."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from handsim.cli.console import (
    MAX_JOBS,
    JsonFlag,
    check_gl,
    fraction_done,
    note,
    say,
    say_json,
    writable,
)

if TYPE_CHECKING:
    from handsim.simulation.conditions import Conditions
    from handsim.simulation.grasping import Grasper
    from handsim.simulation.pool import Pool
    from handsim.simulation.sweep_plans import Source


def sweep(
    file: Annotated[Path, typer.Argument(help="What to go through, .toml.", metavar="SWEEP.toml")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Table of results, .csv.")],
    jobs: Annotated[
        int | None,
        typer.Option(min=1, max=MAX_JOBS, help="Processes at once; by default one per processor."),
    ] = None,
    dask: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Dask scheduler whose workers do it instead."),
    ] = None,
    json: JsonFlag = False,
) -> None:
    """Grasp with tasks, controllers, hands and conditions in all combinations.

    A table that is there already is gone on with. SWEEP.toml holds tasks
    (names, or "all") and, where the usual will not do, controllers (built-in,
    demonstrator, files), hands (presets, or {length, breadth} in m),
    population ({sex, count, seed}), sides, frictions, mass_scales and seeds
    (a number, or a list; 0 is the nominal run).
    """
    check_gl()

    from handsim.errors import InputError
    from handsim.simulation import sweep as sweeping
    from handsim.simulation.sweep_file import read_sweep
    from handsim.simulation.sweep_plans import SweepGraspers, check_plans
    from handsim.simulation.sweep_summary import rates, results_table
    from handsim.simulation.sweep_table import open_table

    if jobs is not None and dask is not None:
        raise InputError("--jobs and --dask exclude each other; the cluster decides how many")
    spec = read_sweep(file)
    writable(output, ".csv")
    sources = {name: _source(name, file) for name in spec.controllers}
    check_plans(spec, sources)
    key = sweeping.sweep_key(spec, sources)
    started = perf_counter()
    with (
        _pool(jobs, dask) as pool,
        open_table(output, key, sweeping.COLUMNS, spec.n_runs) as table,
    ):
        before = len(table)
        note(f"{before} of {spec.n_runs} runs are in {output}")
        graspers = SweepGraspers(spec, sources, table)
        if graspers.unplanned:
            note(f"planning {len(graspers.unplanned)} grasps, which takes a while and is kept")
            with fraction_done("planning") as done:
                graspers.plan(pool, done)
        with fraction_done("grasping") as done:
            sweeping.sweep(spec, graspers, table, pool, done)
        rows = list(table.rows())
    if not json:
        say(results_table(rows).rstrip("\n"))
        return
    say_json(
        {
            "sweep": key,
            "runs": spec.n_runs,
            "runs_before": before,
            "seconds": perf_counter() - started,
            "controllers": [
                {
                    "controller": controller,
                    **of_task["all"].as_json(),
                    "per_task": [
                        {"task": task, **each.as_json()}
                        for task, each in of_task.items()
                        if task != "all"
                    ],
                }
                for controller, of_task in rates(rows).items()
            ],
        }
    )


def _source(name: str, file: Path) -> "Source":
    """Return a controller by its name in the sweep's file."""
    from handsim.cli.defaults import controller_or_built_in, planning_grasper
    from handsim.simulation.sweep_plans import Source
    from handsim.simulation.sweep_spec import BUILT_IN, DEMONSTRATOR

    if name == DEMONSTRATOR:
        return _script()
    path = None if name == BUILT_IN else file.parent / name
    return Source(controller_or_built_in(path).digest, partial(planning_grasper, path))


def _script() -> "Source":
    from hashlib import sha256

    from handsim.simulation.adjustment import adjustments_file
    from handsim.simulation.demonstrator import demonstrate
    from handsim.simulation.sweep_plans import Source

    def scripted(conditions: "Conditions") -> "Grasper":
        return demonstrate

    return Source(sha256(adjustments_file().read_bytes()).hexdigest(), scripted)


@contextmanager
def _pool(jobs: int | None, dask: str | None) -> "Iterator[Pool]":
    from handsim.simulation.pool import dask_cluster, processes

    if dask is None:
        from joblib import cpu_count

        yield processes(jobs or cpu_count())
        return
    with dask_cluster(dask) as pool:
        yield pool
