"""`handsim sweep`: many grasps into one table."""

from collections.abc import Generator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated

import typer

from handsim.cli.console import MAX_JOBS, JsonFlag, check_gl, note, say, say_json, writable
from handsim.cli.waiting import fraction_done, keeping
from handsim.wording import number_of

if TYPE_CHECKING:
    from handsim.grasping.conditions import Conditions
    from handsim.grasping.planning.grasper import Grasper
    from handsim.grasping.pool import Pool
    from handsim.grasping.sweep.graspers import Source


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
    """Grasp in all combinations of tasks, hands and conditions.

    A table that is there already is gone on with. SWEEP.toml holds tasks
    (names, or "all") and, where the usual will not do, controllers (built-in,
    demonstrator, files), hands (presets, or {length, breadth} in m),
    population ({sex, count, seed}), sides, frictions, mass_scales and seeds
    (a number, or a list; 0 is the nominal run).
    """
    check_gl()

    from handsim.errors import InputError
    from handsim.grasping.sweep import runner as sweeping
    from handsim.grasping.sweep.file import read_sweep
    from handsim.grasping.sweep.graspers import SweepGraspers, check_plans
    from handsim.grasping.sweep.summary import rates, results_table
    from handsim.grasping.sweep.table import open_table

    if jobs is not None and dask is not None:
        raise InputError("--jobs and --dask exclude each other; the cluster decides how many")
    writable(output, ".csv")
    spec = read_sweep(file)
    with fraction_done("reading"):
        sources = {name: _source(name, file) for name in spec.controllers}
        check_plans(spec, sources)
        key = sweeping.sweep_key(spec, sources)
    started = perf_counter()
    with (
        keeping(f"the runs that ended are in {output}; the same command goes on with them"),
        _pool(jobs, dask) as pool,
        open_table(output, key, sweeping.COLUMNS, spec.n_runs) as table,
    ):
        before = len(table)
        if before:
            note(f"{before} of {number_of(spec.n_runs, 'run')} already in {output}")
        graspers = SweepGraspers(spec, sources, table)
        if graspers.n_unplanned:
            note(
                f"planning {number_of(graspers.n_unplanned, 'grasp')}, "
                "which takes a while and is kept"
            )
            with fraction_done("planning") as done:
                graspers.plan(pool, done)
        with fraction_done("grasping") as done:
            sweeping.sweep(spec, graspers, table, pool, done)
        rows = list(table.rows())
    if before < spec.n_runs:
        note(f"wrote {number_of(spec.n_runs - before, 'run')} to {output}")
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
                    **of_task["all"].as_dict(),
                    "per_task": [
                        {"task": task, **each.as_dict()}
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
    from handsim.grasping.sweep.graspers import Source
    from handsim.grasping.sweep.spec import BUILT_IN, DEMONSTRATOR

    if name == DEMONSTRATOR:
        return _demonstrator()
    path = None if name == BUILT_IN else file.parent / name
    return Source(controller_or_built_in(path).digest, partial(planning_grasper, path))


def _demonstrator() -> "Source":
    from hashlib import sha256

    from handsim.grasping.planning.demonstrator import demonstrate
    from handsim.grasping.planning.demonstrator_offsets import demonstrator_offsets_file
    from handsim.grasping.sweep.graspers import Source

    def scripted(conditions: "Conditions") -> "Grasper":
        return demonstrate

    return Source(sha256(demonstrator_offsets_file().read_bytes()).hexdigest(), scripted)


@contextmanager
def _pool(jobs: int | None, dask: str | None) -> "Generator[Pool, None, None]":
    from handsim.grasping.pool import dask_cluster, processes

    if dask is None:
        from joblib import cpu_count

        yield processes(jobs or cpu_count())
        return
    with dask_cluster(dask) as pool:
        yield pool
